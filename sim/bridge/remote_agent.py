"""An AgentSpeak agent that drives a person at the other end of a rosbridge."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import bdi

from ..core.scenario import PersonEntry, Scenario
from ..people.minds import make_agent
from ..people.programs import EXTERNAL
from .connection import ConnectError, Connection, LostError, ServiceError
from .remote_person import RemotePerson
from .workcell import ENDED, BridgeError

FOREVER = 1e12
"""Seconds. The next wakeup of an agent that waits for nothing."""

FIRST_RETRY, LAST_RETRY = 0.5, 5.0
"""Seconds of the wall clock before a lost connection is tried anew: at first, and at the most."""


class RemoteAgent:
    """Runs a person's program against a live rosbridge, until the trial there is over.

    Where the server lets it, agent and simulation go step by step, and nothing depends on how
    fast either is. Else time is that of /clock, or without one the wall's. `did(t, action)` is
    called with every action of the agent, `said(t, text)` with what it prints, `notice(text)`
    with what the user should know.
    """

    def __init__(
        self,
        url: str,
        trial: Scenario,
        entry: PersonEntry,
        *,
        waypoints: bool = False,
        did: Callable[[float, bdi.Literal], None] = lambda t, action: None,
        said: Callable[[float, str], None] = lambda t, text: None,
        notice: Callable[[str], None] = lambda text: None,
    ) -> None:
        if entry.personality == EXTERNAL:
            raise BridgeError(f"{entry.name} is external; say with --personality who it is")
        self._url = url
        self._notice = notice
        self._did = did
        self._now = 0.0
        self._ended = False
        self._in_steps = False
        self._is_thinking = False
        self._clock_ahead = 0.0
        self._has_clock = False
        self._agent = make_agent(
            entry,
            trial,
            act=self._act,
            print=lambda text: said(self._now, text),
            on_event=self._pass_on_warning,
        )
        self._person = RemotePerson(
            trial,
            entry,
            self._agent,
            waypoints=waypoints,
            now=lambda: self._now,
            perceived=self._think,
            notice=notice,
        )

    async def run(self) -> None:
        """Drive the person; `ConnectError` where nobody answers to begin with."""
        delay, connected = FIRST_RETRY, False
        while not self._ended:
            try:
                async with Connection(self._url, complained=self._complain) as connection:
                    connected, delay = True, FIRST_RETRY
                    self._notice(f"connected to {self._url}")
                    await self._drive(connection)
            except LostError as why:
                if not self._ended:
                    self._notice(f"{why}; trying again")
            except ConnectError:
                if not connected:
                    raise
            if not self._ended:
                await asyncio.sleep(delay)
                delay = min(2 * delay, LAST_RETRY)

    async def _drive(self, connection: Connection) -> None:
        topics = await _listed(connection, "topics")
        services = await _listed(connection, "services")
        self._in_steps = "/floorwalker/advance" in services and await self._may_step(connection)
        self._has_clock = "/clock" in topics
        connection.subscribe("/ariac/competition_state", "ariac_msgs/CompetitionState", self._enter)
        if self._has_clock and not self._in_steps:
            connection.subscribe("/clock", "rosgraph_msgs/Clock", self._tick)
        self._person.connect(connection, topics, repeats=not self._in_steps)
        if self._in_steps:
            await self._go_in_steps(connection)
        else:
            await self._go_along(connection)

    async def _may_step(self, connection: Connection) -> bool:
        """Whether the server lets us decide when its time goes on; then it waits from now on."""
        with suppress(ServiceError):
            await connection.call("/floorwalker/advance", {"until": -1.0})
            return True
        return False

    async def _go_in_steps(self, connection: Connection) -> None:
        while not self._ended:
            wakeup = self._agent.next_wakeup
            until = FOREVER if wakeup is None else wakeup
            answer = await connection.call("/floorwalker/advance", {"until": until}, None)
            self._now = float(answer["time"])
            self._ended = bool(answer["ended"])
            if not self._ended:
                self._agent.advance(self._now)

    async def _go_along(self, connection: Connection) -> None:
        loop = asyncio.get_running_loop()
        begin = loop.time() - self._now
        self._think()
        while not self._ended:
            if self._has_clock:
                await connection.wait(1.0)
                continue
            wakeup = self._agent.next_wakeup
            await connection.wait(0.1 if wakeup is None else min(max(wakeup - self._now, 0.0), 0.1))
            self._now = max(self._now, loop.time() - begin)
            self._think()

    def _tick(self, message: dict[str, Any]) -> None:
        stamp = message["clock"]
        time = stamp["sec"] + stamp["nanosec"] / 1e9 + self._clock_ahead
        # Where the simulation has begun anew, the agent's time goes on from where it was.
        self._clock_ahead += max(self._now - time, 0.0)
        self._now = max(self._now, time)
        self._think()

    def _think(self) -> None:
        """Let the agent think about new percepts; in steps that is done while time stands."""
        if self._in_steps or self._is_thinking:
            return
        self._is_thinking = True
        try:
            self._agent.advance(self._now)
        finally:
            self._is_thinking = False

    def _act(self, action: bdi.Literal) -> bool:
        self._did(self._now, action)
        return self._person.act(action)

    def _enter(self, message: dict[str, Any]) -> None:
        self._ended = self._ended or message["competition_state"] == ENDED

    def _pass_on_warning(self, entry: bdi.Entry) -> None:
        if entry.kind == "warning":
            self._notice(f"{self._person.name}: {entry.text}")

    def _complain(self, text: str) -> None:
        self._notice(f"{self._url} says: {text}")


async def _listed(connection: Connection, what: str) -> list[str]:
    """The names that a service of rosapi lists; none where there is no rosapi."""
    try:
        names = (await connection.call(f"/rosapi/{what}", {})).get(what)
    except ServiceError:
        return []
    return [str(name) for name in names] if isinstance(names, list) else []
