"""Session of the bridge: its clients, and the pace of its time."""

from __future__ import annotations

import asyncio
import math
import socket
from collections.abc import Callable
from typing import Any

from ..cell.admission import Notices
from ..competition import RefusedError
from ..competition.machine_topics import TRAJECTORY
from ..competition.topics import ENDED, STARTED
from ..live.live_run import LiveRun
from ..live.page_server import Origins
from .client import Client, done_within
from .exchange import Exchange
from .rosapi import provide_rosapi
from .server import RosbridgeServer, listen_at
from .uplink import Uplink
from .workcell import BridgeError, Workcell

PERIOD = 0.1
"""Seconds of real time between two requests of the page that are carried out."""

PAUSED = "it is paused on its page"


LONGEST = 1.0
"""Simulated seconds until the event loop serves clients again."""

LONGEST_NAP = 0.1
"""Seconds of real time. How soon the session notices that a client has gone."""

GRACE = 3.0
"""Seconds of real time. How long an agent may get ready before the trial begins."""

PATIENCE = 1.0
"""Seconds of real time. How long time waits for a client that does not read, without a speed."""


class Session:
    """Server of one workcell until its trial is over, which also keeps its time.

    Parameters
    ----------
    workcell : Workcell
        The workcell.
    exchange : Exchange
        Its topics and services.
    speed : float, optional
        Simulated seconds per second of real time. At 0, time advances as soon as all clients have
        read the last messages and acted on them.
    hold : bool, optional
        Whether the trial begins when a client calls /ariac/start_competition.
    grace : float, optional
        Real time in seconds for agents to get ready before the trial begins, if there is a speed.
    notice : callable, optional
        Function for lines that the user should read.
    origins : Origins, optional
        Origins of web pages that are accepted. By default those of this machine.
    viewer : LiveRun, optional
        Page that shows the run.

    Raises
    ------
    BridgeError
        If the speed or the grace is invalid.
    """

    def __init__(
        self,
        workcell: Workcell,
        exchange: Exchange,
        *,
        speed: float = 1.0,
        hold: bool = False,
        grace: float = GRACE,
        notice: Callable[[str], None] = lambda _: None,
        origins: Origins | None = None,
        viewer: LiveRun | None = None,
    ) -> None:
        if not (math.isfinite(speed) and speed >= 0):
            raise BridgeError(f"speed must be 0 or more, not {speed:g}")
        if not (math.isfinite(grace) and grace >= 0):
            raise BridgeError(f"grace must be 0 or more seconds, not {grace:g}")
        self._exchange = exchange
        self.server: RosbridgeServer | Uplink = RosbridgeServer(
            exchange, left=self._left, failed=self._fail, origins=origins, notice=notice
        )
        self._workcell = workcell
        self._viewer = viewer
        self._attends_at = 0.0
        """Real time at which the page is answered again."""
        self._notice = workcell.notice = notice
        self._notices = Notices(notice)
        self._hold = hold
        self._grace = grace if speed else 0.0
        self._agent_since: float | None = None
        """Real time at which an agent came, until the trial begins."""
        self._stepping: Client | None = None
        self._said = ""
        self._changed = asyncio.Event()
        exchange.changed = self._changed.set
        self._pace = pace = workcell.cell.pace
        if speed:
            pace.keep_time(speed, _real_time)
        pace.changed = self._changed.set
        pace.held = "it has not begun"
        workcell.cell.admission.catch_up = self._catch_up
        # At speed 0 nothing is lost, because time waits until the agent has read all messages.
        workcell.repeats = speed > 0
        exchange.provide("/ariac/start_competition", "std_srvs/Trigger", self._start)
        exchange.provide(
            "/floorwalker/advance", "floorwalker_msgs/Advance", self._advance, {"until": "float64"}
        )
        provide_rosapi(exchange, lambda: workcell.now)

    async def open(
        self, host: str = "127.0.0.1", port: int = 9090, *, at: socket.socket | None = None
    ) -> int:
        """Accept clients from now on, and return the port.

        Parameters
        ----------
        host : str, optional
            Address.
        port : int, optional
            Port, or 0 for any that is free.
        at : socket, optional
            Socket that listens already.

        Raises
        ------
        AddressError
            If the address is not available.
        """
        at = at or listen_at(host, port)
        assert isinstance(self.server, RosbridgeServer)
        await self.server.open(at)
        name, port = at.getsockname()[:2]
        self._notice(f"serving ws://{f'[{name}]' if ':' in name else name}:{port}")
        return int(port)

    async def connect(self, url: str) -> None:
        """Serve through a rosbridge server from now on, instead of accepting clients.

        Parameters
        ----------
        url : str
            Address of the server.

        Raises
        ------
        ConnectError
            If nobody answers.
        """
        if not self._pace.speed:
            raise BridgeError("speed must be more than 0 through another rosbridge server")
        self.server = uplink = Uplink(
            self._exchange, url, notice=self._notice, changed=self._changed.set, failed=self._fail
        )
        await uplink.open()

    async def run(self) -> None:
        """Advance until the trial is over.

        Raises
        ------
        Exception
            Whatever custom programs of the trial raise.
        """
        viewer, simulation = self._viewer, self._workcell.simulation
        if viewer is not None:
            viewer.follow(simulation, self._pace)
        try:
            while not self._pace.over:
                if viewer is not None and _real_time() >= self._attends_at:
                    self._attends_at = _real_time() + PERIOD
                    viewer.attend(simulation)
                await self._continue_run()
            self._pace.check()
            self._workcell.cell.update()
            self._workcell.publish()
            self._workcell.competition.enter(ENDED)
        finally:
            if viewer is not None:
                viewer.leave()
            await self.server.close()

    async def _continue_run(self) -> None:
        if await self._is_held():
            return
        if self._pace.speed:
            await self._keep_pace()
        elif self._stepping is not None:
            await self._change()
        else:
            await self._step()

    async def _keep_pace(self) -> None:
        pace = self._pace
        self._catch_up()
        if self._pace.over:
            return
        delay = pace.delay()
        if pace.give_up():
            self._notices.add(f"this machine is too slow for --speed {pace.speed:g}", "slow")
        await asyncio.sleep(min(max(delay, 0.0), LONGEST_NAP))

    async def _step(self) -> None:
        """Advance to the next tick or decision, and wait until all clients have acted on it."""
        self._pace.advance(self._pace.next_tick)
        await self.server.flush(PATIENCE)
        drivers = [client for client in self.server.clients if self._drives(client)]
        # Twice, because a client may answer a ping before it sends its reaction to the messages.
        for _ in range(2):
            for client in drivers:
                await self.server.reached(client, PATIENCE)
        await asyncio.sleep(0)

    def _catch_up(self) -> None:
        """Advance to the present, unless the run is held."""
        if not self._missing():
            self._pace.catch_up(LONGEST)

    def _fail(self, failure: Exception) -> None:
        self._pace.failure = self._pace.failure or failure
        self._changed.set()

    def _missing(self) -> str:
        """Return the reason for which simulated time is paused, or an empty text."""
        clients = self.server.clients
        if self._pace.paused:
            return PAUSED
        if self._hold:
            return "nobody has called /ariac/start_competition"
        if isinstance(self.server, Uplink):
            return "" if clients else f"there is no connection to {self.server.url}"
        for person in self._workcell.external:
            if not any(self._is_agent(client, person.name) for client in clients):
                self._agent_since = None
                first = person is self._workcell.person
                return "there is no agent" + ("" if first else f" of {person.name}")
        if self._workcell.external and self._time_to_get_ready() > 0:
            return "the agent makes ready"
        if self._workcell.needs_controller and not any(map(_is_controller, clients)):
            return "there is no gantry controller"
        return ""

    def _time_to_get_ready(self) -> float:
        """Return the real time (s) in which the agent may still get ready."""
        if not self._grace:
            return 0.0
        now = _real_time()
        if self._agent_since is None:
            self._agent_since = now
        return self._agent_since + self._grace - now

    def _is_agent(self, client: Client, person: str = "") -> bool:
        """Return whether a client drives a person, by default any."""
        agents = self._workcell.agents
        return client is self._stepping or any(
            not heard.isdisjoint(client.subscriptions)
            or not commanded.isdisjoint(client.advertised)
            for heard, commanded in ([agents[person]] if person else agents.values())
        )

    def _drives(self, client: Client) -> bool:
        return self._is_agent(client) or _is_controller(client)

    def _left(self, client: Client) -> None:
        if client is self._stepping:
            self._stepping = None
        self._changed.set()

    async def _is_held(self) -> bool:
        """Wait for a change if a client is missing, otherwise begin or continue the run.

        Return whether one is missing.
        """
        missing, now = self._missing(), self._workcell.now
        if missing:
            self._pace.hold(missing)
            self._say(f"stands still at t = {now:.1f} s: {missing}")
            await self._change()
        elif self._pace.release():
            self._grace, self._agent_since = 0.0, None
            if not now:
                self._workcell.competition.enter(STARTED)
            self._say(f"goes on at t = {now:.1f} s" if now else "the trial begins")
        return bool(missing)

    def _say(self, text: str) -> None:
        """Notify the user and all clients, once."""
        if text != self._said:
            self._said = text
            self._notice(text)
            for client in tuple(self.server.clients):
                client.report("warning", text)

    async def _change(self) -> None:
        """Wait for a change, for at most `LONGEST_NAP`."""
        # The limit is needed because Ctrl-C does not wake a loop that was just about to wait.
        self._changed.clear()
        await done_within(self._changed.wait(), LONGEST_NAP)

    def _start(self, _: Client, __: dict[str, Any]) -> dict[str, Any]:
        began, self._hold = self._hold or self._time_to_get_ready() > 0, False
        self._grace = 0.0
        self._changed.set()
        return {"success": True, "message": "started" if began else "it has been started already"}

    async def _advance(self, client: Client, request: dict[str, Any]) -> dict[str, Any]:
        """Advance to the next decision of a person outside, or to `until`.

        From the first call on, time advances in these calls only. A call with a time that is past
        has no other effect.
        """
        workcell, pace = self._workcell, self._pace
        if pace.speed:
            raise RefusedError(f"time is paced at speed {pace.speed:g} here")
        if not workcell.external:
            raise RefusedError("no person is driven from outside")
        if self._stepping not in (None, client):
            raise RefusedError("another client steps through time")
        if not self._pace.over:
            workcell.cell.admission.admit("/floorwalker/advance", None)
        self._stepping = client
        self._changed.set()
        if request["until"] >= workcell.now:
            workcell.external[0].decide_by(request["until"])
            while not self._pace.over:
                if await self._is_held():
                    continue
                if pace.advance(pace.next_tick):
                    break
                await self.server.flush(PATIENCE)
                await asyncio.sleep(0)
        return {"time": workcell.now, "ended": self._pace.over}


def _real_time() -> float:
    return asyncio.get_running_loop().time()


def _is_controller(client: Client) -> bool:
    return f"/{TRAJECTORY}" in client.advertised
