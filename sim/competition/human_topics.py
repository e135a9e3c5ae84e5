"""Topics and services of the competition's person.

Topics and types are those of ARIAC 2023. `/ariac_human/gantry_detected`, `/ariac_human/blocked`
and `/ariac_human/action` are additions.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from ..cell import Cell
from ..core.recorder import Event
from .transport import Caller, RefusedError, Transport, Values

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

COMMANDS: dict[str, tuple[str, Callable[[Values], str | None]]] = {
    GOAL: (POINT, lambda point: "move"),
    STOP: (BOOL, lambda message: "stop_movement" if message["data"] else None),
    GO_HOME: (BOOL, lambda message: "teleport_safe" if message["data"] else "teleport_agv"),
    GO_HOME_AGV: (BOOL, lambda message: "teleport_agv" if message["data"] else None),
    ACTION: (STRING, lambda message: message["data"]),
}
"""Topics on which an agent publishes: their types, and the action of a message, if any."""

PERCEPTS: dict[str, tuple[str, bool | str]] = {
    "work_completed": (REACHED, True),
    "gantry_detected": (DETECTED, True),
    "gantry_disabled": (UNSAFE, True),
    "agv_danger": (UNSAFE, False),
    "path_blocked": (BLOCKED, "path_blocked"),
    "goal_blocked": (BLOCKED, "goal_blocked"),
    "human_start": (START, True),
}
"""Topic of a percept, and the data that stands for it there."""

PERCEPT_TOPICS = {
    topic: STRING if isinstance(data, str) else BOOL for topic, data in PERCEPTS.values()
}
"""Topics of percepts with their types. The start of the person is the last one."""

_ANSWERS = frozenset({GOAL, STOP, GO_HOME, GO_HOME_AGV})
"""Topics on which an agent answers a violation."""

_PERCEPT_OF_EVENT = {
    "human_started": "human_start",
    "arrived": "work_completed",
    "gantry_detected": "gantry_detected",
    "path_blocked": "path_blocked",
}


class HumanTopics:
    """Topics and services of one person, who is driven by an agent if they are external."""

    def __init__(self, person: str, cell: Cell, transport: Transport) -> None:
        name = f"people/{person}"
        self._person = person
        self._cell = cell
        self._transport = transport
        self._act_command = cell.commands.get(f"{name}/act")
        self._goal = cell.commands.get(f"{name}/goal")
        self._unanswered: tuple[str, float] | None = None
        """Violation that the agent has not answered yet, and its time (s)."""
        self._topics = {
            topic: transport.advertise(topic, type_)
            for topic, type_ in PERCEPT_TOPICS.items()
            if topic != START
        }
        self._topics[START] = transport.advertise(START, BOOL, heard=self._start, latched=1)
        for topic, (type_, _) in COMMANDS.items():
            transport.listen(topic, type_, partial(self._command, topic))
        transport.provide("/ariac_human/teleport", "std_srvs/Trigger", self._teleport)
        transport.provide("/ariac/set_human_safe_zone_penalty", "std_srvs/Trigger", self._penalise)
        if self._act_command is None:
            cell.signals["events"].watch(self._see)
        else:
            cell.signals[f"{name}/percept"].watch(self._publish)

    def repeat(self) -> None:
        """Publish a violation again that the agent has not answered.

        The competition's own agent drops violations soon after its start or the previous violation,
        and relies on the repetition.
        """
        if self._unanswered is not None:
            topic, data = PERCEPTS[self._unanswered[0]]
            self._transport.publish(self._topics[topic], {"data": data})

    def _publish(self, percept: str) -> None:
        """Publish a percept if there is a topic for it."""
        if percept in PERCEPTS:
            topic, data = PERCEPTS[percept]
            self._transport.publish(self._topics[topic], {"data": data})
            if topic == UNSAFE and self._act_command is not None:
                self._unanswered = (percept, self._cell.now)

    def _see(self, event: Event) -> None:
        """Publish the percept of an event of a person with a program."""
        if event.get("person") != self._person:
            return
        if event["kind"] == "violation":
            machine = self._cell.simulation.machines[event["with"]]
            is_robot = machine.shape.category == "robot"
            self._publish("gantry_disabled" if is_robot else "agv_danger")
        elif event["kind"] in _PERCEPT_OF_EVENT:
            self._publish(_PERCEPT_OF_EVENT[event["kind"]])

    def _command(self, topic: str, message: Values, source: str = "") -> None:
        action = COMMANDS[topic][1](message)
        if action is None:
            return
        if self._act_command is None or self._goal is None:
            raise RefusedError(
                f"{self._person} has a mind of their own;"
                " give them the personality external to command them"
            )
        if topic == GOAL:
            self._goal.take((message["x"], message["y"]), source)
        elif not self._is_done(topic):
            self._act_command.take(action, source)
        if topic in _ANSWERS:
            self._unanswered = None

    def _is_done(self, topic: str) -> bool:
        """Return whether the person was already sent home for the violation."""
        put_home_at = self._cell.simulation.person(self._person).put_home_at
        if topic not in (GO_HOME, GO_HOME_AGV) or self._unanswered is None or put_home_at is None:
            return False
        # At the time of the violation itself the agent comes first (`Person.warn`).
        return self._unanswered[1] <= put_home_at and self._cell.now > put_home_at

    def _start(self, message: Values, source: str = "") -> None:
        # A transport may return what the simulation publishes.
        if message["data"] and self._cell.simulation.person(self._person).started_at is None:
            self._cell.commands[f"people/{self._person}/start"].take(None, source)

    def _teleport(self, client: Caller, __: Values) -> Values:
        self._command(GO_HOME_AGV, {"data": True}, client.name)
        return {"success": True, "message": f"{self._person} is in the safe zone"}

    def _penalise(self, _: Caller, __: Values) -> Values:
        self._cell.admission.admit("penalty", None)
        is_counted = self._cell.simulation.person(self._person).penalise()
        effect = "a penalty, and the gantry is disabled" if is_counted else "counted already"
        penalties = self._cell.simulation.referee.penalties
        return {"success": True, "message": f"{effect}; penalties: {penalties}"}
