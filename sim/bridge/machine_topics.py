"""Topics and services of the competition's machines: the gantry and AGVs."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

from ..cell import Cell, JointPoint, JointTrajectory
from ..machines.agv.agv import Agv
from ..machines.gantry.robot import GantryRobot
from .client import Client
from .exchange import Exchange, RefusedError, Values, take
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


TRAJECTORY = "/gantry_controller/joint_trajectory"
"""The topic that a controller publishes on."""


class GantryTopics:
    """Publishes the joints of `gantry` and whether it may move.

    If it is `driven` from outside, it follows the trajectories that clients publish.
    """

    def __init__(
        self, gantry: GantryRobot, cell: Cell, exchange: Exchange, *, driven: bool
    ) -> None:
        self._gantry = gantry
        self._exchange = exchange
        self._command = cell.commands[f"machines/{gantry.name}/joints"]
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

    def _follow(self, message: Values, source: str = "") -> None:
        if self._gantry.disabled:
            raise RefusedError("the gantry is disabled")
        take(TRAJECTORY, self._command, trajectory_of(message), source)


class AgvTopics:
    """Publishes the states of AGVs, and sends them to the locations that clients request."""

    def __init__(self, agvs: Iterable[Agv], cell: Cell, exchange: Exchange) -> None:
        self._cell = cell
        self._exchange = exchange
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

    def _move(self, agv: Agv, client: Client | None, request: Values) -> Values:
        name, number = agv.lane.name, request["location"]
        known = {k: place for k, place in enumerate(LOCATIONS) if place in agv.lane.locations}
        if number not in known:
            there = ", ".join(f"{k} {place}" for k, place in known.items())
            message = f"{name} has no location {number} (there are: {there})"
            return {"success": False, "message": message}
        drive = self._cell.commands[f"machines/{name}/drive"]
        take(f"/ariac/move_{name}", drive, known[number], client.name if client else "")
        return {"success": True, "message": f"on its way to {known[number]}"}
