"""Topics and services of the competition's machines: the gantry and AGVs."""

from __future__ import annotations

from functools import partial

from floorplan import Lane

from ..cell import Cell, JointPoint, JointTrajectory
from ..machines.gantry.robot import GantryRobot
from ..people.programs import EXTERNAL
from .messages import LOCATIONS, agv_status, joint_state
from .transport import Caller, RefusedError, Transport, Values, take


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


TRAJECTORY = "gantry_controller/joint_trajectory"
"""Topic on which a controller publishes."""


class GantryTopics:
    """Publishes the joints of the first gantry. Names of topics begin with `root`.

    If its controller is external, the gantry follows the trajectories that clients publish.
    """

    def __init__(self, cell: Cell, transport: Transport, root: str = "/") -> None:
        self._cell = cell
        self._transport = transport
        self._joints = transport.advertise(f"{root}joint_states", "sensor_msgs/JointState")
        self._trajectory = f"{root}{TRAJECTORY}"
        if cell.simulation.trial.gantry.controller == EXTERNAL:
            type_ = "trajectory_msgs/JointTrajectory"
            transport.listen(self._trajectory, type_, self._follow)

    def publish(self) -> None:
        """Publish the present state."""
        if self._joints.is_needed:
            gantry = self._gantry
            state = joint_state(self._cell.now, gantry.gantry, gantry.state)
            self._transport.publish(self._joints, state)

    @property
    def _gantry(self) -> GantryRobot:
        gantry = self._cell.simulation.gantry
        assert gantry is not None
        return gantry

    def _follow(self, message: Values, source: str = "") -> None:
        gantry = self._gantry
        if gantry.disabled:
            raise RefusedError("the gantry is disabled")
        command = self._cell.commands[f"machines/{gantry.name}/joints"]
        take(self._trajectory, command, trajectory_of(message), source)


class AgvTopics:
    """Publishes the states of AGVs, and sends them to the locations that clients request."""

    def __init__(self, cell: Cell, transport: Transport) -> None:
        self._cell = cell
        self._transport = transport
        self._status = {}
        for lane in (agv.lane for agv in cell.simulation.agvs):
            topic = transport.advertise(f"/ariac/{lane.name}_status", "ariac_msgs/AGVStatus")
            self._status[lane.name] = topic
            move, request = partial(self._move, lane), {"location": "int8"}
            transport.provide(f"/ariac/move_{lane.name}", "ariac_msgs/MoveAGV", move, request)

    def publish(self) -> None:
        """Publish the present state."""
        for agv in self._cell.simulation.agvs:
            topic = self._status[agv.lane.name]
            if topic.is_needed:
                self._transport.publish(topic, agv_status(agv.lane, agv.body.state))

    def _move(self, lane: Lane, client: Caller | None, request: Values) -> Values:
        name, number = lane.name, request["location"]
        numbered = {k: place for k, place in enumerate(LOCATIONS) if place in lane.locations}
        if number not in numbered:
            there = ", ".join(f"{k} {place}" for k, place in numbered.items())
            message = f"{name} has no location {number} (there are: {there})"
            return {"success": False, "message": message}
        drive = self._cell.commands[f"machines/{name}/drive"]
        take(f"/ariac/move_{name}", drive, numbered[number], client.name if client else "")
        return {"success": True, "message": f"on its way to {numbered[number]}"}
