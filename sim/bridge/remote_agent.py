"""AgentSpeak agent that controls a person at a remote rosbridge server."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Collection
from contextlib import suppress
from functools import partial
from typing import Any

import bdi
from floorplan import Point
from navigation import CollisionWorld, PathPlanner, PlanningError

from ..competition.human_topics import (
    ACTION,
    BLOCKED,
    COMMANDS,
    DETECTED,
    GO_HOME,
    GOAL,
    PERCEPT_TOPICS,
    PERCEPTS,
    STOP,
)
from ..competition.messages import NOWHERE
from ..competition.topics import ENDED
from ..competition.transport import Values
from ..core.rules import Notice
from ..core.scenario import PersonEntry, Scenario
from ..people.actions import MindError
from ..people.minds import Mind, make_agent
from ..people.perception import Percepts
from ..people.programs import EXTERNAL
from .exchange import Exchange
from .uplink import LostError, ServerLink, ServiceError, connected_to, connections
from .workcell import BridgeError

_REPETITION = 0.5
"""Seconds. A violation that is repeated within this time is the same one."""

_PERCEPT_OF = {heard: percept for percept, heard in PERCEPTS.items()}


class RemotePerson:
    """Body of an agent at another rosbridge server.

    Its percepts go to `mind`, and `act` carries out actions. The floor is that of `trial`. With
    `waypoints`, it plans paths and sends their waypoints one by one, instead of a goal for the
    navigation at the other end. `now` is the time there (s).
    """

    def __init__(
        self,
        trial: Scenario,
        entry: PersonEntry,
        mind: Mind,
        *,
        waypoints: bool,
        notice: Callable[[str], None],
    ) -> None:
        self.name = entry.name
        self._rules = trial.rules
        self.now = 0.0
        self._notice = notice
        self._waypoints = waypoints
        self._radius = entry.radius or trial.floorplan.human.radius
        self._world = CollisionWorld(trial.floorplan)
        self._lanes = {lane.name: lane for lane in trial.floorplan.lanes}
        self._planner = PathPlanner(self._world, self._radius)
        self._percepts = Percepts(mind)
        self._noticing = SampledNotice(trial.rules.notice)
        self._offered: Collection[str] = ()
        self._at: Point = (0.0, 0.0)
        self._gantry: Point | None = None
        self._ahead: list[Point] = []
        """Waypoints that are left."""
        self._started = False
        self._quiet_until = -math.inf
        self._repeats = False
        self._unsafe_at: dict[str, float] = {}
        """Time of the last message about each kind of violation (s)."""
        self._unavailable: set[str] = set()

    def connect(
        self, exchange: Exchange, offered: Collection[str], *, repeats: bool = True
    ) -> None:
        """Perceive and act through an exchange with a server that has the topics `offered`.

        With `repeats`, the server repeats violations until they are answered.
        """
        self._exchange = exchange
        self._repeats = repeats
        self._offered = offered
        for name in self._lanes:
            place = partial(self._place_agv, name)
            exchange.listen(f"/ariac/{name}_status", "ariac_msgs/AGVStatus", place)
        exchange.listen("/ariac_human/state", "ariac_msgs/HumanState", self._see)
        for topic, type_ in PERCEPT_TOPICS.items():
            if topic in offered or topic not in (DETECTED, BLOCKED):
                exchange.listen(topic, type_, partial(self._hear, topic))
        self._topics = {
            topic: exchange.advertise(topic, COMMANDS[topic][0])
            for topic in (GOAL, STOP, GO_HOME, ACTION)
            if topic in offered or topic != ACTION
        }

    def _hear(self, topic: str, message: Values, _: str) -> None:
        percept = _PERCEPT_OF.get((topic, message["data"]))
        if percept == "human_start":
            self._start()
        elif percept is not None and self._started:
            self._take(percept)

    def _start(self) -> None:
        if not self._started:
            self._started = True
            self._noticing.start_over(self.now)
            self._percepts.see("human_start")

    def _take(self, percept: str) -> None:
        """Pass a percept of a topic to the mind."""
        if percept == "work_completed":
            if self._ahead:
                self._send_goal(self._ahead.pop(0))
                return
            self._percepts.see("at", *self._at)
        elif percept in ("path_blocked", "goal_blocked"):
            self._ahead.clear()
        elif percept in ("gantry_disabled", "agv_danger") and self._is_repeated(percept):
            return
        if percept.startswith("gantry") and self._gantry is not None:
            self._percepts.see("gantry_at", *self._gantry)
        self._percepts.count(percept)

    def _is_repeated(self, percept: str) -> bool:
        """Return whether a violation has been perceived. The original reports it at 10 Hz."""
        now = self.now
        if now < self._quiet_until:
            return True
        if DETECTED in self._offered:
            # Floorwalker repeats it until it is answered. The last repetition arrives later.
            before = self._unsafe_at.get(percept, -math.inf)
            self._unsafe_at[percept] = now
            return self._repeats and now - before < _REPETITION
        pause = self._rules.pause_after_agv
        if percept == "gantry_disabled":
            pause = self._rules.gantry_disabled + self._rules.grace
        self._quiet_until = now + (self._rules.report_every or pause)
        return False

    def _see(self, state: Values, _: str) -> None:
        self._at = _place(state["human_position"])
        gantry = _place(state["robot_position"])
        self._gantry = None if gantry == _place(NOWHERE) else gantry
        if self._gantry is None or DETECTED in self._offered or not self._started:
            return
        distance = math.dist(self._at, self._gantry)
        speeds = (math.hypot(*_place(state[f"{one}_velocity"])) for one in ("human", "robot"))
        if self._noticing.see(self.now, distance, *speeds):
            self._take("gantry_detected")

    def _place_agv(self, name: str, status: Values, _: str) -> None:
        low, high = self._lanes[name].limits
        self._world.move_agv(name, min(max(status["position"], low), high))

    def act(self, action: bdi.Literal) -> bool:
        """Carry out an external action of the agent, and return whether that was possible.

        `MindError` if its arguments are no position.
        """
        name = action.functor
        if name == "move":
            return self._move(action)
        if name == "stop_movement":
            return self._stop()
        if name == "move_to_gantry":
            return self._move_to_gantry()
        if name in ("teleport_safe", "teleport_agv"):
            self._ahead.clear()
            self._noticing.start_over(self.now)
            return self._send(GO_HOME, data=name == "teleport_safe")
        if ACTION in self._topics:
            return self._send(ACTION, data=str(action))
        if name not in self._unavailable:
            self._unavailable.add(name)
            self._notice(f"{self.name}: the other end offers no topic for {name}")
        return False

    def _move(self, action: bdi.Literal) -> bool:
        numbers = [argument for argument in action.args if isinstance(argument, float)]
        if len(numbers) != len(action.args) or len(numbers) not in (2, 3):
            raise MindError(f"{self.name}: the action {action} should be move(x, y, z)")
        return self._go((numbers[0], numbers[1]))

    def _move_to_gantry(self) -> bool:
        if self._gantry is None:
            return False
        self._stop()
        free = self._world.nearest_free(self._gantry, self._radius)
        return free is not None and self._go(free)

    def _stop(self) -> bool:
        self._ahead.clear()
        return self._send(STOP, data=True)

    def _go(self, goal: Point) -> bool:
        if not self._waypoints:
            return self._send_goal(goal)
        try:
            path = self._planner.plan(self._at, goal)
        except PlanningError as why:
            self._percepts.count("goal_blocked" if why.reason == "goal_blocked" else "path_blocked")
            return False
        self._ahead = [(float(x), float(y)) for x, y in path.points[1:]] or [goal]
        return self._send_goal(self._ahead.pop(0))

    def _send_goal(self, goal: Point) -> bool:
        return self._send(GOAL, x=goal[0], y=goal[1], z=0.0)

    def _send(self, topic: str, **message: Any) -> bool:
        self._exchange.publish(self._topics[topic], message)
        return True


class SampledNotice:
    """Notices the gantry once per approach, as the referee does, from samples.

    An approach is over when the distance is `rule.parting` metres more than its minimum, or
    `rule.every` seconds after the noticing.
    """

    def __init__(self, rule: Notice) -> None:
        self._rule = rule
        self._nearest: float | None = None
        """Minimum distance since the gantry was noticed, until the approach is over."""
        self._silent_until = -math.inf
        self._before = math.inf

    def see(self, t: float, distance: float, human_speed: float, robot_speed: float) -> bool:
        """Return whether the gantry is noticed at `t` (s), at a distance (m) and speeds (m/s)."""
        approaching, self._before = distance < self._before, distance
        if self._nearest is None:
            inside = distance < self._rule.law.distance(human_speed, robot_speed)
            if not (inside and approaching and t >= self._silent_until):
                return False
            if self._rule.every is None:
                self._nearest = distance
            else:
                self._silent_until = t + self._rule.every
            return True
        has_parted = distance > self._nearest + self._rule.parting
        self._nearest = None if has_parted else min(distance, self._nearest)
        return False

    def start_over(self, t: float) -> None:
        """Restart at `t` (s) after `rule.silent` seconds, when the person starts or was moved."""
        self._nearest = None
        self._silent_until = max(self._silent_until, t + self._rule.silent)
        self._before = math.inf


def _place(point: Values) -> Point:
    return (point["x"], point["y"])


FOREVER = 1e12
"""Seconds. Next wakeup of an agent that waits for nothing."""


class RemoteAgent:
    """Runs the program of a person against a rosbridge server, until the trial there is over.

    If the server allows it, agent and simulation advance step by step, so that nothing depends on
    their speed. Otherwise time is that of /clock, or real time without one. `did(t, action)` is
    called with every action of the agent, `said(t, text)` with every text that it prints, and
    `notice(text)` with lines for the user.
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
        self._ended = False
        self._goes_along = False
        """Whether the agent follows the time of the server, or real time."""
        self._clock_ahead = 0.0
        self._has_clock = False
        self._agent = make_agent(
            entry,
            trial,
            act=self._act,
            print=lambda text: said(self._person.now, text),
            settings=bdi.AgentSettings(on_event=self._pass_on_warning, kinds=("warning",)),
        )
        self._person = RemotePerson(
            trial,
            entry,
            self._agent,
            waypoints=waypoints,
            notice=notice,
        )

    async def run(self) -> None:
        """Drive the person. `ConnectError` if there is no answer at the start."""
        first = await connected_to(self._url)
        async for socket in connections(first, self._url, self._notice):
            exchange = Exchange()
            with suppress(LostError):
                async with ServerLink(socket, exchange, self._complain, self._think) as link:
                    await self._drive(link, exchange)
            if self._ended:
                return

    async def _drive(self, link: ServerLink, exchange: Exchange) -> None:
        self._goes_along = False
        topics = await _listed(link, "topics")
        services = await _listed(link, "services")
        in_steps = "/floorwalker/advance" in services and await self._may_step(link)
        self._has_clock = "/clock" in topics
        exchange.listen("/ariac/competition_state", "ariac_msgs/CompetitionState", self._enter)
        if self._has_clock and not in_steps:
            exchange.listen("/clock", "rosgraph_msgs/Clock", self._tick)
        self._person.connect(exchange, topics, repeats=not in_steps)
        link.offer()
        if in_steps:
            await self._go_in_steps(link)
        else:
            await self._go_along(link)

    async def _may_step(self, link: ServerLink) -> bool:
        """Return whether the server advances on request. If so, it waits from now on."""
        with suppress(ServiceError):
            await link.call("/floorwalker/advance", {"until": -1.0})
            return True
        return False

    async def _go_in_steps(self, link: ServerLink) -> None:
        while not self._ended:
            wakeup = self._agent.next_wakeup
            until = FOREVER if wakeup is None else wakeup
            answer = await link.call("/floorwalker/advance", {"until": until}, None)
            self._person.now = float(answer["time"])
            self._ended = bool(answer["ended"])
            if not self._ended:
                self._agent.advance(self._person.now)

    async def _go_along(self, link: ServerLink) -> None:
        loop = asyncio.get_running_loop()
        begin = loop.time() - self._person.now
        self._goes_along = True
        self._think()
        while not self._ended:
            if self._has_clock:
                await link.wait(1.0)
                continue
            wakeup = self._agent.next_wakeup
            await link.wait(
                0.1 if wakeup is None else min(max(wakeup - self._person.now, 0.0), 0.1)
            )
            self._person.now = max(self._person.now, loop.time() - begin)
            self._think()

    def _tick(self, message: Values, _: str = "") -> None:
        stamp = message["clock"]
        time = stamp["sec"] + stamp["nanosec"] / 1e9 + self._clock_ahead
        if time < self._person.now:
            # A simulation that has started again. The agent's time continues.
            self._notice(f"/clock goes back from {self._person.now:g} s to {time:g} s")
            self._clock_ahead += self._person.now - time
        self._person.now = max(self._person.now, time)

    def _think(self) -> None:
        """Advance the agent, after each message. In steps, `_go_in_steps` does this."""
        if self._goes_along:
            self._agent.advance(self._person.now)

    def _act(self, action: bdi.Literal) -> bool:
        self._did(self._person.now, action)
        return self._person.act(action)

    def _enter(self, message: Values, _: str) -> None:
        self._ended = self._ended or message["competition_state"] == ENDED

    def _pass_on_warning(self, entry: bdi.Entry) -> None:
        if entry.kind == "warning":
            self._notice(f"{self._person.name}: {entry.text}")

    def _complain(self, _: object, text: str, __: object) -> None:
        self._notice(f"{self._url} says: {text}")


async def _listed(link: ServerLink, what: str) -> list[str]:
    """Return the names that a service of rosapi lists, none without rosapi."""
    try:
        names = (await link.call(f"/rosapi/{what}", {})).get(what)
    except ServiceError:
        return []
    return [str(name) for name in names] if isinstance(names, list) else []
