"""A person at the other end of a rosbridge: what they perceive there, and what they do."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from functools import partial
from typing import Any

import bdi
from navigation import CollisionWorld, PathPlanner, PlanningError

from ..core.scenario import PersonEntry
from ..people.minds import Mind, Percepts
from ..people.person import MindError
from ..trials.trial import Trial
from .connection import Connection
from .human_topics import (
    ACTION,
    BLOCKED,
    DETECTED,
    GO_HOME,
    GOAL,
    REACHED,
    START,
    STOP,
    UNSAFE,
)
from .readings import NOWHERE
from .sampled_notice import SampledNotice

_BOOL, _STRING = "std_msgs/Bool", "std_msgs/String"

Place = tuple[float, float]


class RemotePerson:
    """The body of an agent elsewhere.

    Its percepts go to `mind`, whose actions are to be `act`. The floor is that of `trial`. With
    `waypoints` it plans its ways itself and sends them corner by corner, instead of leaving that
    to a navigation stack at the other end. `now()` is the time there, seconds.
    """

    def __init__(
        self,
        trial: Trial,
        entry: PersonEntry,
        *,
        waypoints: bool,
        now: Callable[[], float],
        perceived: Callable[[], None],
        notice: Callable[[str], None],
    ) -> None:
        self.name = entry.name
        self._rules = trial.rules
        self._now = now
        self._perceived = perceived
        self._notice = notice
        self._waypoints = waypoints
        self._radius = entry.radius or trial.floorplan.human.radius
        self._world = CollisionWorld(trial.floorplan)
        self._lanes = {lane.name: lane for lane in trial.floorplan.lanes}
        self._planner = PathPlanner(self._world, self._radius)
        self._connection: Connection | None = None
        self._percepts: Percepts | None = None
        self._offered: Collection[str] = ()
        self._noticing = SampledNotice(trial.rules.notice)
        self._at: Place = (0.0, 0.0)
        self._gantry: Place | None = None
        self._way: list[Place] = []
        self._started = False
        self._quiet_until = -math.inf
        self._cannot: set[str] = set()

    def think_with(self, mind: Mind) -> None:
        """Let `mind` decide from now on."""
        self._percepts = Percepts(mind)

    def connect(self, connection: Connection, offered: Collection[str]) -> None:
        """Hear and act through `connection`, whose server has the topics `offered`."""
        self._connection = connection
        self._offered = offered
        for name in self._lanes:
            connection.subscribe(
                f"/ariac/{name}_status", "ariac_msgs/AGVStatus", partial(self._agv_is, name)
            )
        connection.subscribe("/ariac_human/state", "ariac_msgs/HumanState", self._see)
        connection.subscribe(REACHED, _BOOL, self._reached)
        connection.subscribe(UNSAFE, _BOOL, self._unsafe)
        if DETECTED in offered:
            connection.subscribe(DETECTED, _BOOL, lambda _: self._detect())
        if BLOCKED in offered:
            connection.subscribe(BLOCKED, _STRING, self._blocked)
        connection.subscribe(START, _BOOL, self._start)

    # What is perceived.

    def _start(self, message: dict[str, Any]) -> None:
        if message["data"] and not self._started:
            self._started = True
            self._noticing.start_over(self._now())
            self._see_that("human_start")

    def _see(self, state: dict[str, Any]) -> None:
        self._at = _place(state["human_position"])
        gantry = _place(state["robot_position"])
        self._gantry = None if gantry == _place(NOWHERE) else gantry
        if self._gantry is None or DETECTED in self._offered or not self._started:
            return
        distance = math.dist(self._at, self._gantry)
        speeds = (_speed(state["human_velocity"]), _speed(state["robot_velocity"]))
        if self._noticing.see(self._now(), distance, *speeds):
            self._detect()

    def _detect(self) -> None:
        self._see_gantry()
        self._count("gantry_detected")

    def _unsafe(self, message: dict[str, Any]) -> None:
        """Too close: to the gantry (true) or to an AGV. The original says so ten times a second."""
        if not self._started or self._now() < self._quiet_until:
            return
        gantry: bool = message["data"]
        if DETECTED not in self._offered:
            rules = self._rules
            pause = rules.gantry_disabled + rules.grace if gantry else rules.pause_after_agv
            self._quiet_until = self._now() + (rules.report_every or pause)
        if gantry:
            self._see_gantry()
        self._count("gantry_disabled" if gantry else "agv_danger")

    def _reached(self, message: dict[str, Any]) -> None:
        if not message["data"] or not self._started:
            return
        if self._way:
            self._send_goal(self._way.pop(0))
            return
        if self._percepts is not None:
            self._percepts.see("at", *self._at)
        self._count("work_completed")

    def _blocked(self, message: dict[str, Any]) -> None:
        self._way.clear()
        self._count("goal_blocked" if message["data"] == "goal_blocked" else "path_blocked")

    def _agv_is(self, name: str, status: dict[str, Any]) -> None:
        low, high = self._lanes[name].limits
        self._world.move_agv(name, min(max(status["position"], low), high))

    def _see_gantry(self) -> None:
        if self._gantry is not None and self._percepts is not None:
            self._percepts.see("gantry_at", *self._gantry)

    def _see_that(self, percept: str) -> None:
        if self._percepts is not None:
            self._percepts.see(percept)
            self._perceived()

    def _count(self, percept: str) -> None:
        if self._percepts is not None:
            self._percepts.count(percept)
            self._perceived()

    # What is done.

    def act(self, action: bdi.Literal) -> bool:
        """Carry out an external action of the agent; whether it could be.

        `MindError` where it is given something that is no place.
        """
        if action.functor == "move":
            return self._move(action)
        if action.functor == "stop_movement":
            return self._stop()
        if action.functor == "move_to_gantry":
            return self._move_to_gantry()
        if action.functor in ("teleport_safe", "teleport_agv"):
            self._way.clear()
            self._noticing.start_over(self._now())
            return self._publish(GO_HOME, action.functor == "teleport_safe")
        if ACTION in self._offered and self._connection is not None:
            self._connection.publish(ACTION, _STRING, {"data": str(action)})
            return True
        if action.functor not in self._cannot:
            self._cannot.add(action.functor)
            self._notice(f"{self.name}: nobody can do {action.functor} at the other end")
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
        self._way.clear()
        return self._publish(STOP, True)

    def _go(self, goal: Place) -> bool:
        if not self._waypoints:
            return self._send_goal(goal)
        try:
            path = self._planner.plan(self._at, goal)
        except PlanningError as why:
            self._count("goal_blocked" if why.reason == "goal_blocked" else "path_blocked")
            return False
        self._way = [(float(x), float(y)) for x, y in path.points[1:]] or [goal]
        return self._send_goal(self._way.pop(0))

    def _send_goal(self, goal: Place) -> bool:
        if self._connection is None:
            return False
        point = {"x": goal[0], "y": goal[1], "z": 0.0}
        self._connection.publish(GOAL, "geometry_msgs/Point", point)
        return True

    def _publish(self, topic: str, value: bool) -> bool:
        if self._connection is None:
            return False
        self._connection.publish(topic, _BOOL, {"data": value})
        return True


def _place(point: dict[str, Any]) -> Place:
    return (point["x"], point["y"])


def _speed(vector: dict[str, Any]) -> float:
    return math.hypot(vector["x"], vector["y"])
