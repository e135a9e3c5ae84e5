"""Session of the bridge: its clients, and the pace of its time."""

from __future__ import annotations

import asyncio
import math
import socket
from collections.abc import Callable
from contextlib import suppress
from typing import Any, Protocol

from floorplan import UserError

from ..cell.pace import Tempo, checked_speed
from ..live.page_server import Origins
from ..people.programs import EXTERNAL
from ..simulation import Simulation
from .client import Client
from .exchange import Exchange, RefusedError, provide_rosapi
from .machine_topics import TRAJECTORY
from .server import RosbridgeServer, listen_at
from .waiting import done_within
from .workcell import COMMANDS, ENDED, START, STARTED, BridgeError, Workcell

PERIOD = 0.1
"""Seconds of the wall clock between two looks at what the page wants."""

PAUSED = "it is paused on its page"


class Viewer(Protocol):
    """A page that shows a run under way; what is wanted there is carried out in `attend`."""

    def follow(self, simulation: Simulation, pace: Tempo) -> None:
        """Show a run that has started, and let the page change its tempo."""

    def attend(self, simulation: Simulation) -> None:
        """Carry out what the page wants, and send it what has changed."""

    def leave(self) -> None:
        """Carry out no more: the run is over."""


class BridgeTempo:
    """The speed and the pauses of a session: `changed()` is called after each change."""

    def __init__(self, speed: float) -> None:
        self.speed = speed
        self.paused = False
        self.changed: Callable[[], None] = lambda: None

    def change(self, *, speed: float | None = None, paused: bool | None = None) -> None:
        """Go on with another speed, pause, or go on; a run without a speed gets none."""
        if speed is not None and not self.speed:
            raise UserError("the pace depends on the clients, so it has no speed")
        if speed is not None:
            self.speed = checked_speed(speed)
        if paused is not None:
            self.paused = paused
        self.changed()


async def attend(viewer: Viewer, simulation: Simulation) -> None:
    """Do what a page wants, and show it what happens, until this is cancelled."""
    try:
        while True:
            viewer.attend(simulation)
            await asyncio.sleep(PERIOD)
    finally:
        viewer.leave()


RATE = 10
"""Hz, in simulated time: the rate at which the state is published."""

MOST_TICKS = 10
"""How many times the state is published before the event loop serves clients again."""

BEHIND = 1.0
"""Seconds of the wall clock. Further behind than this, the session gives up catching up."""

LONGEST_NAP = 0.1
"""Seconds of the wall clock. How soon the session sees that a client has gone."""

GRACE = 3.0
"""Seconds of the wall clock. How long an agent may make ready before the trial begins."""

PATIENCE = 1.0
"""Seconds. How long time waits for a client that doesn't read, when it isn't paced."""


class Session:
    """Serves one workcell until its trial is over, and keeps its time.

    `speed` is simulated seconds a second; with 0 time goes on as soon as all clients have read and
    acted on what was last published. With `hold` nothing happens before a client has called
    /ariac/start_competition. With a speed, an agent is given `grace` seconds of the wall clock to
    make ready before the trial begins, unless that is called earlier. `notice(text)` notifies the
    user of the command. Web pages of `origins` may take part; left out, those of this machine.
    A `viewer` shows the run meanwhile; its page may pause it, and change its speed.
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
        viewer: Viewer | None = None,
    ) -> None:
        if not (math.isfinite(speed) and speed >= 0):
            raise BridgeError(f"speed must be 0 or more, not {speed:g}")
        if not (math.isfinite(grace) and grace >= 0):
            raise BridgeError(f"grace must be 0 or more seconds, not {grace:g}")
        trial = workcell.simulation.trial
        self.server = RosbridgeServer(
            exchange, left=self._left, failed=self._fail, origins=origins, notice=notice
        )
        self._workcell = workcell
        self._tempo = BridgeTempo(speed)
        self._tempo.changed = self._change_tempo
        self._viewer = viewer
        self._resumed = (0.0, 0.0)
        """A simulated time, and the wall's at that instant."""
        self._notice = notice
        self._hold = hold
        self._grace = grace if speed else 0.0
        self._agent_since: float | None = None
        """Time of the wall's clock at which an agent came, until the trial begins."""
        self._ended_early = False
        self._failure: Exception | None = None
        self._needs_agent = workcell.outside is not None
        self._needs_controller = trial.gantry.controller == EXTERNAL
        self._stepping: Client | None = None
        self._ticks = 0
        self._published_at = -1.0
        self._standing = True
        self._said = ""
        self._is_slow = False
        self._changed = asyncio.Event()
        exchange.changed = self._changed.set
        # At speed 0 nothing is lost: time waits until the agent has read what there is.
        workcell.repeats = speed > 0
        workcell.catch_up = self._catch_up
        workcell.is_open = lambda: not self._is_over
        exchange.provide("/ariac/start_competition", "std_srvs/Trigger", self._start)
        exchange.provide("/ariac/end_competition", "std_srvs/Trigger", self._end)
        exchange.provide(
            "/floorwalker/advance", "floorwalker_msgs/Advance", self._advance, {"until": "float64"}
        )
        provide_rosapi(exchange, lambda: workcell.now)

    async def open(
        self, host: str = "127.0.0.1", port: int = 9090, *, at: socket.socket | None = None
    ) -> int:
        """Take clients from now on; return the port (that given, or with 0 a free one).

        `at` is a socket that listens already. `AddressError` where the address is not available.
        """
        at = at or listen_at(host, port)
        await self.server.open(at)
        name, port = at.getsockname()[:2]
        self._notice(f"serving ws://{f'[{name}]' if ':' in name else name}:{port}")
        return int(port)

    async def run(self) -> None:
        """Keep time until the trial is over; raise whatever the user's own programs raise."""
        showing = self._show()
        try:
            while not self._is_over:
                await self._go_on()
            if self._failure is not None:
                raise self._failure
            self._publish()
            self._workcell.enter(ENDED)
        finally:
            if showing is not None:
                showing.cancel()
                with suppress(asyncio.CancelledError):
                    await showing
            await self.server.close()

    def _show(self) -> asyncio.Task[None] | None:
        """Let the viewer follow from now on."""
        if self._viewer is None:
            return None
        simulation = self._workcell.simulation
        self._viewer.follow(simulation, self._tempo)
        return asyncio.create_task(attend(self._viewer, simulation))

    def _change_tempo(self) -> None:
        """Go on from here as the page wants it."""
        self._resume()
        self._changed.set()

    @property
    def _speed(self) -> float:
        return self._tempo.speed

    @property
    def _is_over(self) -> bool:
        return self._workcell.simulation.over or self._ended_early or self._failure is not None

    async def _go_on(self) -> None:
        if await self._stood_still():
            return
        if self._speed:
            await self._keep_pace()
        elif self._stepping is not None:
            await self._change()
        else:
            await self._step()

    async def _keep_pace(self) -> None:
        loop = asyncio.get_running_loop()
        self._continue()
        self._catch_up()
        if self._is_over:
            return
        happens = min(self._next_tick, self._workcell.simulation.clock.peek())
        simulated, wall = self._resumed
        delay = wall + (happens - simulated) / self._speed - loop.time()
        if delay < -BEHIND:
            self._resume()
            if not self._is_slow:
                self._is_slow = True
                self._notice(f"this machine is too slow for --speed {self._speed:g}")
        await asyncio.sleep(min(max(delay, 0.0), LONGEST_NAP))

    async def _step(self) -> None:
        """Go on to the next tick or decision, and let all clients act on it."""
        self._continue()
        self._advance_to(self._next_tick)
        await self.server.flush(PATIENCE)
        drivers = [client for client in self.server.clients if self._drives(client)]
        # Twice: a client may answer a ping before it sends what the messages before made it say.
        for _ in range(2):
            for client in drivers:
                await self.server.reached(client, PATIENCE)
        await asyncio.sleep(0)

    def _catch_up(self) -> None:
        """Bring simulated time up to the wall clock, if time goes on at all."""
        if not self._speed or self._standing or self._missing():
            return
        simulated, wall = self._resumed
        target = simulated + (asyncio.get_running_loop().time() - wall) * self._speed
        target = min(target, self._workcell.now + MOST_TICKS / RATE)
        while self._workcell.now < target and not self._is_over:
            self._advance_to(min(target, self._next_tick))

    def _advance_to(self, until: float) -> bool:
        """Go on to `until`, the next tick at the most, and publish what there is to publish.

        Return whether a decision came before.
        """
        workcell = self._workcell
        try:
            asked = workcell.advance(until)
        except Exception as failure:
            self._fail(failure)
            return False
        is_tick = workcell.now >= self._next_tick
        self._ticks += is_tick
        if is_tick or asked:
            self._publish()
        workcell.publish_percepts()
        return asked

    def _fail(self, failure: Exception) -> None:
        self._failure = self._failure or failure
        self._changed.set()

    def _publish(self) -> None:
        """Publish the state, unless it has been at this instant."""
        if self._published_at != self._workcell.now:
            self._published_at = self._workcell.now
            self._workcell.publish()

    @property
    def _next_tick(self) -> float:
        return (self._ticks + 1) / RATE

    def _missing(self) -> str:
        """Return the reason for which simulated time is paused, or an empty text."""
        clients = self.server.clients
        if self._tempo.paused:
            return PAUSED
        if self._hold:
            return "nobody has called /ariac/start_competition"
        if self._needs_agent and not any(map(self._is_agent, clients)):
            self._agent_since = None
            return "there is no agent"
        if self._needs_agent and self._readying() > 0:
            return "the agent makes ready"
        if self._needs_controller and not any(map(_is_controller, clients)):
            return "there is no gantry controller"
        return ""

    def _readying(self) -> float:
        """Return for how long (s, of the wall's clock) the agent may still make ready."""
        if not self._grace:
            return 0.0
        now = asyncio.get_running_loop().time()
        if self._agent_since is None:
            self._agent_since = now
        return self._agent_since + self._grace - now

    def _is_agent(self, client: Client) -> bool:
        return (
            client is self._stepping
            or START in client.subscriptions
            or not client.advertised.isdisjoint(COMMANDS)
        )

    def _drives(self, client: Client) -> bool:
        return self._is_agent(client) or _is_controller(client)

    def _left(self, client: Client) -> None:
        if client is self._stepping:
            self._stepping = None
        self._changed.set()

    async def _stood_still(self) -> bool:
        """Wait for a change if a client is missing; return whether one was."""
        missing = self._missing()
        if missing:
            self._standing = True
            self._say(f"stands still at t = {self._workcell.now:.1f} s: {missing}")
            await self._change()
        return bool(missing)

    def _resume(self) -> None:
        self._resumed = (self._workcell.now, asyncio.get_running_loop().time())

    def _continue(self) -> None:
        if not self._standing:
            return
        self._standing = False
        self._grace, self._agent_since = 0.0, None
        now = self._workcell.now
        self._resume()
        if not now:
            self._workcell.enter(STARTED)
        self._say(f"goes on at t = {now:.1f} s" if now else "the trial begins")

    def _say(self, text: str) -> None:
        """Notify the user and all clients, once."""
        if text != self._said:
            self._said = text
            self._notice(text)
            for client in tuple(self.server.clients):
                client.report("warning", text)

    async def _change(self) -> None:
        """Wait for a change, for `LONGEST_NAP` at the longest."""
        # Not for ever: Ctrl-C does not wake a loop that was just about to wait.
        self._changed.clear()
        await done_within(self._changed.wait(), LONGEST_NAP)

    def _start(self, _: Client, __: dict[str, Any]) -> dict[str, Any]:
        began, self._hold = self._hold or self._readying() > 0, False
        self._grace = 0.0
        self._changed.set()
        return {"success": True, "message": "started" if began else "it has been started already"}

    def _end(self, _: Client, __: dict[str, Any]) -> dict[str, Any]:
        self._workcell.admit("end_competition")
        self._ended_early = True
        self._changed.set()
        return {"success": True, "message": f"ended at t = {self._workcell.now:g} s"}

    async def _advance(self, client: Client, request: dict[str, Any]) -> dict[str, Any]:
        """Let time go on until the person outside has something to decide on, or to `until`.

        From now on time goes on in these calls alone; `until` in the past does no more than that.
        """
        workcell, outside = self._workcell, self._workcell.outside
        if self._speed:
            raise RefusedError(f"time is paced at speed {self._speed:g} here")
        if outside is None or workcell.person is None:
            raise RefusedError("no person is driven from outside")
        if self._stepping not in (None, client):
            raise RefusedError("another client steps through time")
        if not self._is_over:
            workcell.admit("advance")
        self._stepping = client
        self._changed.set()
        if request["until"] < workcell.now:
            return {"time": workcell.now, "ended": self._is_over}
        workcell.person.decide_by(request["until"])
        while not self._is_over:
            if await self._stood_still():
                continue
            self._continue()
            if self._advance_to(self._next_tick):
                break
            await self.server.flush(PATIENCE)
            await asyncio.sleep(0)
        return {"time": workcell.now, "ended": self._is_over}


def _is_controller(client: Client) -> bool:
    return TRAJECTORY in client.advertised
