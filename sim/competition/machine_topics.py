"""Topics and services of the competition's machines: the gantry and AGVs."""

from __future__ import annotations

from functools import partial

from floorplan import Lane

from ..cell import Cell, JointPoint, JointTrajectory
from ..machines.agv.agv import Agv
from ..machines.gantry.robot import GantryRobot
from ..people.programs import EXTERNAL
from .messages import LOCATIONS, agv_status, joint_state, seconds_of
from .transport import Caller, RefusedError, Transport, Values, take


def trajectory_of(message: Values) -> JointTrajectory:
    """Return the trajectory of a trajectory_msgs/JointTrajectory."""
    points = [
        JointPoint(
            tuple(point["positions"]),
            tuple(point["velocities"]),
            seconds_of(point["time_from_start"]),
        )
        for point in message["points"]
    ]
    return JointTrajectory(tuple(message["joint_names"]), tuple(points))


TRAJECTORY = "gantry_controller/joint_trajectory"
"""Topic on which a controller publishes."""


class GantryTopics:
    """Topics of the first gantry. Their names begin with `root`.

    If its controller is external, the gantry follows the trajectories that clients publish.
    """

    def __init__(self, cell: Cell, transport: Transport, root: str = "/") -> None:
        self._cell = cell
        self._trajectory = f"{root}{TRAJECTORY}"
        transport.advertise(f"{root}joint_states", "sensor_msgs/JointState", self._read)
        if cell.simulation.trial.gantry.controller == EXTERNAL:
            type_ = "trajectory_msgs/JointTrajectory"
            transport.listen(self._trajectory, type_, self._follow)

    @property
    def _gantry(self) -> GantryRobot:
        gantry = self._cell.simulation.gantry
        assert gantry is not None
        return gantry

    def _read(self) -> Values:
        return joint_state(self._cell.now, self._gantry.gantry, self._gantry.state)

    def _follow(self, message: Values, source: str = "") -> None:
        gantry = self._gantry
        if gantry.disabled:
            raise RefusedError("the gantry is disabled")
        command = self._cell.commands[f"machines/{gantry.name}/joints"]
        take(self._trajectory, command, trajectory_of(message), source)


def add_agv_topics(cell: Cell, transport: Transport) -> None:
    """Publish the states of AGVs, and send them to the locations that clients request."""
    for agv in cell.simulation.agvs:
        status, service = f"/ariac/{agv.lane.name}_status", f"/ariac/move_{agv.lane.name}"
        read, move = partial(_status, cell, agv.name), partial(_move, cell, agv.lane)
        transport.advertise(status, "ariac_msgs/AGVStatus", read)
        transport.provide(service, "ariac_msgs/MoveAGV", move, {"location": "int8"})


def _status(cell: Cell, name: str) -> Values:
    agv = cell.simulation.machines[name]
    assert isinstance(agv, Agv)
    return agv_status(agv.lane, agv.body.state)


def _move(cell: Cell, lane: Lane, client: Caller | None, request: Values) -> Values:
    name, number = lane.name, request["location"]
    numbered = {k: place for k, place in enumerate(LOCATIONS) if place in lane.locations}
    if number not in numbered:
        there = ", ".join(f"{k} {place}" for k, place in numbered.items())
        message = f"{name} has no location {number} (there are: {there})"
        return {"success": False, "message": message}
    drive = cell.commands[f"machines/{name}/drive"]
    take(f"/ariac/move_{name}", drive, numbered[number], client.name if client else "")
    return {"success": True, "message": f"on its way to {numbered[number]}"}
