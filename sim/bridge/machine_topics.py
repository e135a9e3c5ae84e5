"""Topics and services of the competition's machines: the gantry and AGVs."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from typing import Any

from floorplan import Gantry
from navigation import Motion
from navigation.motion import State

from ..cell.trajectories import (
    JointPoint,
    JointTrajectory,
    TrajectoryError as TrajectoryError,
    follow,
    motion_along,
    target_in,
)
from ..machines.agv.agv import Agv
from ..machines.gantry.robot import GantryRobot
from .client import Client
from .exchange import Admit, Exchange, RefusedError, Values
from .messages import LOCATIONS, agv_status, joint_state


def trajectory_of(message: Values) -> JointTrajectory:
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


def target_of(gantry: Gantry, message: dict[str, Any]) -> tuple[float, float, float] | None:
    """Return the target (x, y, rotation) of a message with one point without a time, or None."""
    return target_in(gantry, trajectory_of(message))


def trajectory_motion(
    gantry: Gantry, current: State, now: float, message: dict[str, Any]
) -> Motion:
    """Return the motion along a trajectory message. See `motion_along`."""
    return motion_along(gantry, current, now, trajectory_of(message))


TRAJECTORY = "/gantry_controller/joint_trajectory"
"""The topic that a controller publishes on."""


class GantryTopics:
    """Publishes the joints of `gantry` and whether it may move.

    If it is `driven` from outside, it follows the trajectories that clients publish.
    """

    def __init__(
        self, gantry: GantryRobot, exchange: Exchange, admit: Admit, *, driven: bool
    ) -> None:
        self._gantry = gantry
        self._exchange = exchange
        self._admit = admit
        self._joints = exchange.advertise("/joint_states", "sensor_msgs/JointState")
        self._health = exchange.advertise("/ariac/robot_health", "ariac_msgs/Robots")
        if driven:
            exchange.listen(TRAJECTORY, "trajectory_msgs/JointTrajectory", self._follow)

    def publish(self, now: float) -> None:
        """Publish the state at `now` (seconds)."""
        gantry = self._gantry
        if self._joints.is_needed:
            self._exchange.publish(self._joints, joint_state(now, gantry.gantry, gantry.state))
        health = {"floor_robot": True, "ceiling_robot": not gantry.disabled}
        self._exchange.publish(self._health, health)

    def _follow(self, message: Values) -> None:
        self._admit(TRAJECTORY)
        try:
            follow(self._gantry, trajectory_of(message))
        except TrajectoryError as why:
            raise RefusedError(str(why)) from None


class AgvTopics:
    """Publishes the states of AGVs, and sends them to the locations that clients ask for."""

    def __init__(self, agvs: Iterable[Agv], exchange: Exchange, admit: Admit) -> None:
        self._exchange = exchange
        self._admit = admit
        self._status = {}
        for agv in agvs:
            name = agv.lane.name
            topic = exchange.advertise(f"/ariac/{name}_status", "ariac_msgs/AGVStatus")
            self._status[agv] = topic
            move, request = partial(self._move, agv), {"location": "int8"}
            exchange.provide(f"/ariac/move_{name}", "ariac_msgs/MoveAGV", move, request)

    def publish(self) -> None:
        """Publish the present state."""
        for agv, topic in self._status.items():
            if topic.is_needed:
                self._exchange.publish(topic, agv_status(agv.lane, agv.body.state))

    def _move(self, agv: Agv, _: Client, request: Values) -> Values:
        name, number = agv.lane.name, request["location"]
        known = {k: place for k, place in enumerate(LOCATIONS) if place in agv.lane.locations}
        if number not in known:
            there = ", ".join(f"{k} {place}" for k, place in known.items())
            message = f"{name} has no location {number} (there are: {there})"
            return {"success": False, "message": message}
        self._admit(f"move_{name}")
        agv.drive(known[number])
        return {"success": True, "message": f"on its way to {known[number]}"}
