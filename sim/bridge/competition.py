"""Topics and services of ARIAC 2023: its person, gantry, AGVs, orders and phases.

`/ariac_human/gantry_detected`, `/ariac_human/blocked` and `/ariac_human/action` are additions.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from floorplan import Floorplan, Gantry, Lane
from navigation.machines import lane_state
from navigation.motion import State

from ..cell import Cell, JointPoint, JointTrajectory
from ..cell.trajectories import JOINTS, joint_values
from ..core.recorder import Event
from ..machines.agv.agv import Agv
from ..machines.gantry.robot import GantryRobot
from ..orders.workload import AssemblyTask, KittingTask, Order, PartType, Workload
from ..people.person import Person
from .client import Client
from .exchange import Exchange
from .messages import Message, conform, header, message_type, vector
from .protocol import RefusedError

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

COMMANDS: dict[str, tuple[str, Callable[[Message], str | None]]] = {
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
    topic: BOOL if isinstance(data, bool) else STRING for topic, data in PERCEPTS.values()
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

    def __init__(self, person: Person, cell: Cell, exchange: Exchange) -> None:
        name = f"people/{person.name}"
        self._person = person
        self._cell = cell
        self._exchange = exchange
        self._act = cell.commands.get(f"{name}/act")
        self._goal = cell.commands.get(f"{name}/goal")
        self._start = cell.commands[f"{name}/start"]
        self._unanswered: tuple[str, float] | None = None
        """Violation that the agent has not answered yet, and its time (s)."""
        exchange.advertise("/ariac_human/state", "ariac_msgs/HumanState", self._state)
        self._topics = {
            topic: exchange.advertise(
                topic,
                type_,
                heard=self._hear_start if topic == START else None,
                latched=int(topic == START),
            )
            for topic, type_ in PERCEPT_TOPICS.items()
        }
        for topic, (type_, _) in COMMANDS.items():
            exchange.listen(topic, type_, partial(self._command, topic))
        exchange.provide("/ariac_human/teleport", "std_srvs/Trigger", self._teleport)
        exchange.provide("/ariac/set_human_safe_zone_penalty", "std_srvs/Trigger", self._penalise)
        if self._act is None:
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
            self._exchange.publish(self._topics[topic], {"data": data})

    def _state(self) -> Message:
        gantry = self._cell.simulation.gantry
        height = gantry.gantry.rail_height if gantry else 0.0
        return human_state(self._person.body.state, gantry.state if gantry else None, height)

    def _publish(self, percept: str) -> None:
        """Publish a percept if there is a topic for it."""
        if percept in PERCEPTS:
            topic, data = PERCEPTS[percept]
            self._exchange.publish(self._topics[topic], {"data": data})
            if topic == UNSAFE and self._act is not None:
                self._unanswered = (percept, self._cell.now)

    def _see(self, event: Event) -> None:
        """Publish the percept of an event of a person with a program."""
        if event.get("person") != self._person.name:
            return
        if event["kind"] == "violation":
            machine = self._cell.simulation.machines[event["with"]]
            is_robot = machine.shape.category == "robot"
            self._publish("gantry_disabled" if is_robot else "agv_danger")
        elif event["kind"] in _PERCEPT_OF_EVENT:
            self._publish(_PERCEPT_OF_EVENT[event["kind"]])

    def _command(self, topic: str, message: Message, source: str) -> None:
        action = COMMANDS[topic][1](message)
        if action is None:
            return
        if self._act is None or self._goal is None:
            raise RefusedError(
                f"{self._person.name} has a mind of their own;"
                " give them the personality external to command them"
            )
        if topic == GOAL:
            self._goal.take((message["x"], message["y"]), source)
        elif not self._is_done(topic):
            self._act.take(action, source)
        if topic in _ANSWERS:
            self._unanswered = None

    def _is_done(self, topic: str) -> bool:
        """Return whether the person was already sent home for the violation."""
        put_home_at = self._person.put_home_at
        if topic not in (GO_HOME, GO_HOME_AGV) or self._unanswered is None or put_home_at is None:
            return False
        # At the time of the violation itself the agent comes first (`Person.warn`).
        return self._unanswered[1] <= put_home_at and self._cell.now > put_home_at

    def _hear_start(self, message: Message, source: str) -> None:
        if message["data"]:
            self._start.take(None, source)

    def _teleport(self, client: Client, _: Message) -> Message:
        self._command(GO_HOME_AGV, {"data": True}, client.name)
        return {"success": True, "message": f"{self._person.name} is in the safe zone"}

    def _penalise(self, _: Client, __: Message) -> Message:
        self._cell.admission.admit("penalty", None)
        is_counted = self._person.penalise()
        effect = "a penalty, and the gantry is disabled" if is_counted else "counted already"
        penalties = self._cell.simulation.referee.penalties
        return {"success": True, "message": f"{effect}; penalties: {penalties}"}


NOWHERE = {"x": 1e6, "y": 1e6, "z": 0.0}
"""Position of the robot on a floor without one, far from all people."""


def human_state(person: State, robot: State | None, robot_height: float) -> Message:
    """Return ariac_msgs/HumanState: positions (m) and velocities (m/s) of person and gantry."""
    return {
        "human_position": vector(person.position),
        "robot_position": vector(robot.position, robot_height) if robot else NOWHERE,
        "human_velocity": vector(person.velocity),
        "robot_velocity": vector(robot.velocity if robot else (0.0, 0.0)),
    }


TRAJECTORY = "/gantry_controller/joint_trajectory"
"""The topic that a controller publishes on."""


def add_gantry(gantry: GantryRobot, cell: Cell, exchange: Exchange, *, driven: bool) -> None:
    """Add topics of the joints of `gantry` and of whether it may move.

    If it is `driven` from outside, it follows the trajectories that clients publish.
    """
    command = cell.commands[f"machines/{gantry.name}/joints"]

    def follow(message: Message, source: str) -> None:
        if gantry.disabled:
            raise RefusedError("the gantry is disabled")
        command.take(trajectory_of(message), source)

    exchange.advertise(
        "/joint_states",
        "sensor_msgs/JointState",
        lambda: joint_state(cell.now, gantry.gantry, gantry.state),
    )
    exchange.advertise(
        "/ariac/robot_health",
        "ariac_msgs/Robots",
        lambda: {"floor_robot": True, "ceiling_robot": not gantry.disabled},
    )
    if driven:
        exchange.listen(TRAJECTORY, "trajectory_msgs/JointTrajectory", follow)


def joint_state(t: float, gantry: Gantry, state: State) -> Message:
    """Return sensor_msgs/JointState of the gantry's joints (m, rad, and m/s, rad/s)."""
    return {
        "header": header(t, ""),
        "name": list(JOINTS),
        "position": list(joint_values(gantry, state.position)),
        "velocity": list(joint_values(gantry, state.velocity, origin=False)),
        "effort": [],
    }


def trajectory_of(message: Message) -> JointTrajectory:
    """Return the trajectory of a trajectory_msgs/JointTrajectory."""
    points = [
        JointPoint(
            tuple(point["positions"]),
            tuple(point["velocities"]),
            point["time_from_start"]["sec"] + point["time_from_start"]["nanosec"] / 1e9,
        )
        for point in message["points"]
    ]
    return JointTrajectory(tuple(message["joint_names"]), tuple(points))


LOCATIONS = ("kitting", "assembly_front", "assembly_back", "warehouse")
"""AGV locations of ariac_msgs/AGVStatus, by number."""

UNKNOWN_LOCATION = 99
"""Location of an AGV that drives or is elsewhere."""

_AT_REST = 1e-6
"""Metres and m/s. An AGV this near to a location, and this slow, is there."""


def add_agv(agv: Agv, cell: Cell, exchange: Exchange) -> None:
    """Add the status of an AGV, and the service that sends it to a location."""
    name, drive = agv.lane.name, cell.commands[f"machines/{agv.name}/drive"]
    places = {k: place for k, place in enumerate(LOCATIONS) if place in agv.lane.locations}

    def move(client: Client, request: Message) -> Message:
        number = request["location"]
        if number not in places:
            there = ", ".join(f"{k} {place}" for k, place in places.items())
            message = f"{name} has no location {number} (there are: {there})"
            return {"success": False, "message": message}
        drive.take(places[number], client.name)
        return {"success": True, "message": f"on its way to {places[number]}"}

    def status() -> Message:
        return agv_status(agv.lane, agv.body.state)

    exchange.advertise(f"/ariac/{name}_status", "ariac_msgs/AGVStatus", status)
    exchange.provide(f"/ariac/move_{name}", "ariac_msgs/MoveAGV", move, {"location": "int8"})


def agv_status(lane: Lane, state: State) -> Message:
    """Return ariac_msgs/AGVStatus: location, position on the lane (m), and speed (m/s)."""
    q = lane_state(lane, state)
    location = UNKNOWN_LOCATION
    for number, name in enumerate(LOCATIONS):
        place = lane.locations.get(name)
        if place is not None and abs(place - q.position) < _AT_REST and abs(q.velocity) < _AT_REST:
            location = number
    return {"location": location, "position": q.position, "velocity": q.velocity}


READY, STARTED, ANNOUNCED, ENDED = 1, 2, 3, 4
"""Phases of ariac_msgs/CompetitionState. ANNOUNCED: started, and all orders are announced."""

_MOST_ORDERS = 1000

_KINDS = ("kitting", "assembly", "combined")
_COLORS = ("red", "green", "blue", "orange", "purple")
_TYPES = {"battery": 10, "pump": 11, "sensor": 12, "regulator": 13}


class PhaseTopics:
    """Publishes the phases of the competition, and orders when they are announced."""

    def __init__(self, cell: Cell, exchange: Exchange) -> None:
        trial = cell.simulation.trial
        self._exchange = exchange
        self._floor = trial.floorplan
        self._orders = exchange.advertise("/ariac/orders", "ariac_msgs/Order", latched=_MOST_ORDERS)
        self._phase = exchange.advertise(
            "/ariac/competition_state", "ariac_msgs/CompetitionState", latched=1
        )
        orders = trial.workload.orders if isinstance(trial.workload, Workload) else ()
        self._unannounced = {order.id: order for order in orders}
        cell.signals["events"].watch(self._announce)

    def enter(self, phase: int) -> None:
        """Publish that the competition enters a phase."""
        self._exchange.publish(self._phase, {"competition_state": phase})

    def _announce(self, event: Event) -> None:
        """Publish an order that is announced."""
        if event["kind"] == "order_announced":
            order = self._unannounced.pop(event["order"])
            self._exchange.publish(self._orders, order_message(order, self._floor))
            if not self._unannounced:
                self.enter(ANNOUNCED)


def order_message(order: Order, floor: Floorplan) -> Message:
    """Return ariac_msgs/Order. Poses of assembled parts are blank, because trials have none.

    The destination of a kit is a location of its AGV on this floor, or a station that it serves.
    """
    task = order.task
    parts: list[dict[str, Any]]
    if isinstance(task, KittingTask):
        location = floor.lane(task.agv).serves.get(task.destination, task.destination)
        parts = [{"part": _part(part), "quadrant": k} for k, part in sorted(task.products.items())]
        work: Message = {
            "agv_number": _number_in(task.agv),
            "tray_id": task.tray,
            "destination": LOCATIONS.index(location),
        }
    else:
        parts = [{"part": _part(part)} for part in task.products]
        work = {"station": _number_in(task.station)}
        if isinstance(task, AssemblyTask):
            work["agv_numbers"] = [_number_in(agv) for agv in task.agvs]
    message = {
        "id": order.id,
        "type": _KINDS.index(order.kind),
        "priority": order.priority,
        f"{order.kind}_task": {**work, "parts": parts},
    }
    return conform(message_type("ariac_msgs/Order"), message)


def _part(part: PartType) -> dict[str, int]:
    return {"color": _COLORS.index(part.color), "type": _TYPES[part.type]}


def _number_in(name: str) -> int:
    """Return the number in a name: agv3 is 3, as2 is 2."""
    return int("".join(filter(str.isdigit, name)))
