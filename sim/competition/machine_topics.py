"""Topics and services of the competition's machines: the gantry and AGVs."""

from __future__ import annotations

from functools import partial

from floorplan import Lane

from ..cell import Cell, JointPoint, JointTrajectory
from ..machines.gantry.robot import GantryRobot
from ..people.programs import EXTERNAL
from .messages import LOCATIONS, agv_status, joint_state, seconds_of
from .transport import Caller, RefusedError, Transport, Values

TRAJECTORY = "gantry_controller/joint_trajectory"
"""Topic on which a controller publishes."""


def add_gantry(cell: Cell, transport: Transport, root: str = "/") -> None:
    """Add topics of the first gantry, if there is one. Their names begin with `root`.

    If its controller is external, the gantry follows the trajectories that clients publish.
    """

    def gantry() -> GantryRobot:
        gantry = cell.simulation.gantry  # of a run that may have begun again
        assert gantry is not None
        return gantry

    def read_joints() -> Values:
        return joint_state(cell.now, gantry().gantry, gantry().state)

    def read_health() -> Values:
        return {"floor_robot": True, "ceiling_robot": not gantry().disabled}

    def follow(message: Values, source: str) -> None:
        if gantry().disabled:
            raise RefusedError("the gantry is disabled")
        cell.commands[f"machines/{gantry().name}/joints"].take(trajectory_of(message), source)

    if cell.simulation.gantry is not None:
        transport.advertise(f"{root}joint_states", "sensor_msgs/JointState", read_joints)
        transport.advertise("/ariac/robot_health", "ariac_msgs/Robots", read_health)
        if cell.simulation.trial.gantry.controller == EXTERNAL:
            type_ = "trajectory_msgs/JointTrajectory"
            transport.listen(f"{root}{TRAJECTORY}", type_, follow)


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


def add_agvs(cell: Cell, transport: Transport) -> None:
    """Add the status of each AGV, and the service that sends it to a location."""

    def read(lane: Lane) -> Values:
        return agv_status(lane, cell.simulation.machines[lane.name].body.state)

    def move(lane: Lane, client: Caller, request: Values) -> Values:
        name, number = lane.name, request["location"]
        numbered = {k: place for k, place in enumerate(LOCATIONS) if place in lane.locations}
        if number not in numbered:
            there = ", ".join(f"{k} {place}" for k, place in numbered.items())
            message = f"{name} has no location {number} (there are: {there})"
            return {"success": False, "message": message}
        cell.commands[f"machines/{name}/drive"].take(numbered[number], client.name)
        return {"success": True, "message": f"on its way to {numbered[number]}"}

    for lane in (agv.lane for agv in cell.simulation.agvs):
        status, service = f"/ariac/{lane.name}_status", f"/ariac/move_{lane.name}"
        transport.advertise(status, "ariac_msgs/AGVStatus", partial(read, lane))
        request = {"location": "int8"}
        transport.provide(service, "ariac_msgs/MoveAGV", partial(move, lane), request)
