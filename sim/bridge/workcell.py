"""Simulation of a trial as ROS topics and services, with the topics of its people.

Topics and types are those of the ARIAC 2023 competition. `/ariac_human/gantry_detected`,
`/ariac_human/blocked` and `/ariac_human/action` are ours.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import shapely

import bdi
from floorplan import UserError

from ..core.body import Body
from ..core.recorder import Event, Listener
from ..people.actions import MindError
from ..people.minds import Outside
from ..people.person import Person
from ..people.programs import EXTERNAL
from ..simulation import Simulation
from ..trials.trial import Trial
from .client import Client
from .exchange import Admit, Exchange, RefusedError, Values
from .machine_topics import AgvTopics, GantryTopics
from .messages import human_state, order_message, seconds, transforms

START = "/ariac/start_human"
REACHED = "/ariac_human/position_reached"
UNSAFE = "/ariac_human/unsafe_distance"
DETECTED = "/ariac_human/gantry_detected"
BLOCKED = "/ariac_human/blocked"
GOAL = "/ariac_human/goal_position"
STOP = "/ariac_human/stop"
GO_HOME = "/ariac_human/go_home"
GO_HOME_AGV = "/ariac_human/go_home_agv"
ACTION = "/ariac_human/action"

BOOL, POINT, STRING = "std_msgs/Bool", "geometry_msgs/Point", "std_msgs/String"

COMMANDS: dict[str, tuple[str, Callable[[Values], bdi.Literal | None]]] = {
    GOAL: (POINT, lambda point: bdi.Literal("move", (point["x"], point["y"], 0.0))),
    STOP: (BOOL, lambda message: bdi.Literal("stop_movement") if message["data"] else None),
    GO_HOME: (
        BOOL,
        lambda message: bdi.Literal("teleport_safe" if message["data"] else "teleport_agv"),
    ),
    GO_HOME_AGV: (BOOL, lambda message: bdi.Literal("teleport_agv") if message["data"] else None),
    ACTION: (STRING, lambda message: bdi.parse_literal(message["data"])),
}
"""The topics that an agent publishes on: their types, and the action of a message, if any."""

PERCEPTS: dict[str, tuple[str, bool | str]] = {
    "human_start": (START, True),
    "work_completed": (REACHED, True),
    "gantry_detected": (DETECTED, True),
    "gantry_disabled": (UNSAFE, True),
    "agv_danger": (UNSAFE, False),
    "path_blocked": (BLOCKED, "path_blocked"),
    "goal_blocked": (BLOCKED, "goal_blocked"),
}
"""The topic of a percept, and the data that stands for it there."""

_ANSWERS = frozenset({GOAL, STOP, GO_HOME, GO_HOME_AGV})
"""The topics on which an agent answers a violation."""

_HAPPENINGS = {
    "human_started": "human_start",
    "arrived": "work_completed",
    "gantry_detected": "gantry_detected",
    "path_blocked": "path_blocked",
}
"""The percept that an event is for its person."""


_TOLERANCE = 0.5
"""Metres. A goal without room is moved by so much at most, as Nav2's planners do by default."""


class HumanTopics:
    """Publishes the percepts of `person`, and carries out commands from outside."""

    def __init__(
        self, person: Person, simulation: Simulation, exchange: Exchange, admit: Admit
    ) -> None:
        self.outside = person.mind if isinstance(person.mind, Outside) else None
        """The mind of the person, if it is outside."""
        self._person = person
        self._clock = simulation.clock
        self._boundary = simulation.trial.floorplan.boundary
        self._simulation = simulation
        self._referee = simulation.referee
        self._exchange = exchange
        self._admit = admit
        self._unanswered: tuple[str, float] | None = None
        """The violation that the agent has not answered yet, and its time (s)."""
        self._topics = {
            START: exchange.advertise(START, BOOL, heard=self._start, latched=1),
            REACHED: exchange.advertise(REACHED, BOOL),
            UNSAFE: exchange.advertise(UNSAFE, BOOL),
            DETECTED: exchange.advertise(DETECTED, BOOL),
            BLOCKED: exchange.advertise(BLOCKED, STRING),
        }
        for topic, (type_, _) in COMMANDS.items():
            exchange.listen(topic, type_, partial(self._command, topic))
        exchange.provide("/ariac_human/teleport", "std_srvs/Trigger", self._teleport)
        exchange.provide("/ariac/set_human_safe_zone_penalty", "std_srvs/Trigger", self._penalise)

    def publish(self, percept: str) -> None:
        """Publish a percept, where there is a topic for it."""
        if percept in PERCEPTS:
            topic, data = PERCEPTS[percept]
            self._exchange.publish(self._topics[topic], {"data": data})
            if topic == UNSAFE and self.outside is not None:
                self._unanswered = (percept, self._clock.now)

    def repeat(self) -> None:
        """Publish a violation again that the agent has not answered.

        The competition's own agent drops what comes too soon after its start or the violation
        before, and relies on hearing it again.
        """
        if self._unanswered is not None:
            topic, data = PERCEPTS[self._unanswered[0]]
            self._exchange.publish(self._topics[topic], {"data": data})

    def event(self, event: Event) -> None:
        """Publish the percept of an event, for a person with a mind of their own."""
        if self.outside is not None or event.get("person") != self._person.name:
            return
        if event["kind"] == "violation":
            machine = self._simulation.machines[event["with"]]
            is_robot = machine.shape.category == "robot"
            self.publish("gantry_disabled" if is_robot else "agv_danger")
        elif event["kind"] in _HAPPENINGS:
            self.publish(_HAPPENINGS[event["kind"]])

    def _command(self, topic: str, message: Values) -> None:
        _, action_of = COMMANDS[topic]
        try:
            action = action_of(message)
        except bdi.ProgramError as why:
            raise RefusedError(f"{message['data'][:60]!r} is no action: {why}") from None
        if topic == GOAL:
            self._require_on_floor(message["x"], message["y"])
            action = self._with_room(message["x"], message["y"])
        if action is not None and not self._is_done(topic):
            self._act(action)
        if action is not None and topic in _ANSWERS:
            self._unanswered = None

    def _is_done(self, topic: str) -> bool:
        """Return True for the wish to be sent home of a person who has been, for that violation."""
        put_home_at = self._person.put_home_at
        if topic not in (GO_HOME, GO_HOME_AGV) or self._unanswered is None or put_home_at is None:
            return False
        # At the instant of the violation itself the agent comes first (`Person.warn`).
        return self._unanswered[1] <= put_home_at and self._clock.now > put_home_at

    def _require_on_floor(self, x: float, y: float) -> None:
        if not self._boundary.covers(shapely.Point(x, y)):
            low_x, low_y, high_x, high_y = self._boundary.bounds
            raise RefusedError(
                f"the goal ({x:g}, {y:g}) is outside the floor"
                f" (x {low_x:g} … {high_x:g}, y {low_y:g} … {high_y:g})"
            )

    def _with_room(self, x: float, y: float) -> bdi.Literal:
        """Return the action that leads to a goal, or close to it if something fixed is there.

        A goal on which only a vehicle stands is left: people wait for it to be free.
        """
        world, radius = self._person.walker.world, self._person.walker.human.radius
        if world.fixed_space(radius).nearest((x, y)) != (x, y):
            for agv in self._simulation.agvs:
                agv.stand_in(world)
            near = world.nearest_free((x, y), radius)
            if near is not None and math.dist(near, (x, y)) <= _TOLERANCE:
                x, y = near
        return bdi.Literal("move", (x, y))

    def _start(self, message: Values) -> None:
        if message["data"]:
            self._admit(START)
            self._person.start()

    def _act(self, action: bdi.Literal) -> None:
        if self.outside is None:
            raise RefusedError(
                f"{self._person.name} has a mind of their own;"
                " give them the personality external to command them"
            )
        self._admit(action.functor)
        try:
            self._person.act(action)
        except MindError as why:
            raise RefusedError(str(why)) from None

    def _teleport(self, _: Client, __: Values) -> Values:
        self._act(bdi.Literal("teleport_agv"))
        return {"success": True, "message": f"{self._person.name} is in the safe zone"}

    def _penalise(self, _: Client, __: Values) -> Values:
        self._admit("penalty")
        counted = self._person.penalise()
        effect = "a penalty, and the gantry is disabled" if counted else "counted already"
        return {"success": True, "message": f"{effect}; penalties: {self._referee.penalties}"}


READY, STARTED, ANNOUNCED, ENDED = 1, 2, 3, 4
"""Phases of ariac_msgs/CompetitionState; ANNOUNCED: started, and all orders are announced."""

MOST_COMMANDS = 300
"""How many commands are taken at one instant of simulated time."""

_MOST_ORDERS = 1000


class BridgeError(UserError):
    """A trial that can't be bridged, or a wrong setting of a bridge."""


class Workcell(Listener):
    """A trial's simulation, published to an exchange and commanded from there.

    `outside` is the mind of the person who is driven from outside, if the trial has one.
    `catch_up()` brings simulated time up to the present before a command is carried out, and
    `is_open()` tells whether commands are still taken.
    """

    def __init__(self, trial: Trial, exchange: Exchange, *listeners: Listener) -> None:
        driven = driven_person(trial)
        self.catch_up: Callable[[], None] = lambda: None
        self.is_open: Callable[[], bool] = lambda: True
        self.repeats = False
        """True to publish a violation with every state until the agent has answered it."""
        self.human: HumanTopics | None = None
        self._exchange = exchange
        self._floor = trial.floorplan
        self._orders = exchange.advertise("/ariac/orders", "ariac_msgs/Order", latched=_MOST_ORDERS)
        self._phase = exchange.advertise(
            "/ariac/competition_state", "ariac_msgs/CompetitionState", latched=1
        )
        orders = trial.workload.orders if trial.workload else ()
        self._unannounced = {order.id: order for order in orders}
        self.simulation = simulation = Simulation(trial, self, *listeners)
        for person in simulation.people:
            # So that no client has to wait for the planner once time goes on.
            person.walker.prepare()
        self.person = None if driven is None else simulation.people[driven]
        self._commands = (simulation.clock.now, 0)
        self._clock = exchange.advertise("/clock", "rosgraph_msgs/Clock")
        self._tf = exchange.advertise("/tf", "tf2_msgs/TFMessage")
        self._state = exchange.advertise("/ariac_human/state", "ariac_msgs/HumanState")
        self._agvs = AgvTopics(simulation.agvs, exchange, self.admit)
        self._gantry: GantryTopics | None = None
        if simulation.gantry is not None:
            is_driven = trial.gantry.controller == EXTERNAL
            self._gantry = GantryTopics(simulation.gantry, exchange, self.admit, driven=is_driven)
        self.outside: Outside | None = None
        self._asked = False
        if self.person is not None:
            self.human = HumanTopics(self.person, simulation, exchange, self.admit)
            self.outside = self.human.outside
        if self.outside is not None:
            self.outside.on_decision.append(self._ask)
        simulation.start()
        self._frames = self._named_frames()
        self.enter(READY)
        self.publish()

    @property
    def now(self) -> float:
        """The simulated time, seconds."""
        return self.simulation.clock.now

    def advance(self, until: float) -> bool:
        """Go on to `until` (seconds), or until the trial is over.

        Stop as soon as the person outside has something to decide on, and then return True; the
        percepts wait for `publish_percepts`.
        """
        simulation = self.simulation
        simulation.clock.begin_moment()
        simulation.advance(until, enough=lambda: self._asked or simulation.over)
        return self._asked

    def admit(self, command: str) -> None:
        """Admit a command at the present time.

        `RefusedError` where the run is over, or where there are too many at once.
        """
        if self.is_open():
            self.catch_up()
        if not self.is_open():
            raise RefusedError(f"{command}: the run is over")
        since, count = self._commands
        self._commands = (self.now, count + 1 if self.now == since else 1)
        if self._commands[1] > MOST_COMMANDS:
            raise RefusedError(
                f"{command}: more than {MOST_COMMANDS} commands at t = {self.now:g} s; not done"
            )

    def publish_percepts(self) -> None:
        """Publish what the person outside has perceived since the last time."""
        self._asked = False
        if self.outside is not None and self.human is not None:
            for percept in self.outside.take():
                self.human.publish(percept.functor)

    def publish(self) -> None:
        """Publish the present state."""
        exchange, simulation, now = self._exchange, self.simulation, self.now
        exchange.publish(self._clock, {"clock": seconds(now)})
        if self._state.is_needed and self.person is not None:
            gantry = simulation.gantry
            robot = gantry.state if gantry else None
            height = gantry.gantry.rail_height if gantry else 0.0
            exchange.publish(self._state, human_state(self.person.walker.body.state, robot, height))
        if self.repeats and self.human is not None:
            self.human.repeat()
        self._agvs.publish()
        if self._gantry is not None:
            self._gantry.publish(now)
        if self._tf.is_needed:
            exchange.publish(self._tf, transforms(now, self._frames))

    def enter(self, phase: int) -> None:
        """Publish that the competition enters a phase."""
        self._exchange.publish(self._phase, {"competition_state": phase})

    def event(self, event: Event) -> None:
        """Publish orders as they are announced, and the percepts of a person."""
        if event["kind"] == "order_announced":
            order = self._unannounced.pop(event["order"])
            self._exchange.publish(self._orders, order_message(order, self._floor))
            if not self._unannounced:
                self.enter(ANNOUNCED)
        if self.human is not None:
            self.human.event(event)

    def _ask(self) -> None:
        self._asked = True

    def _named_frames(self) -> list[tuple[str, Body, float]]:
        """Return the frames of the competition for person, gantry and AGVs (heights in m)."""
        simulation = self.simulation
        frames = [(f"{agv.lane.name}_base", agv.body, 0.0) for agv in simulation.agvs]
        if simulation.gantry is not None:
            height = simulation.gantry.gantry.rail_height
            frames.insert(0, ("torso_base", simulation.gantry.body, height))
        if self.person is not None:
            frames.insert(0, ("base_link", self.person.walker.body, 0.0))
        return frames


def driven_person(trial: Trial) -> int | None:
    """Return the index of the person of the topics: the one driven from outside, or the first."""
    external = [k for k, person in enumerate(trial.people) if person.personality == EXTERNAL]
    if len(external) > 1:
        names = ", ".join(trial.people[k].name for k in external)
        raise BridgeError(
            f"{trial.name}: a bridge has the topics of one person, and {names} are external;"
            " give all but one of them a personality"
        )
    return external[0] if external else (0 if trial.people else None)
