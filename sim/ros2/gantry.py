"""Joint states and trajectories of the gantry, as a controller of ros2_control has them."""

from __future__ import annotations

from typing import Any

from ..cell import Cell, JointPoint, JointTrajectory, Running
from ..cell.trajectories import JOINTS, joint_values
from ..machines.gantry.robot import GantryRobot
from .actions import Action
from .messages import seconds, set_header
from .node import CellNode

CONTROLLER = "gantry_controller"
"""Name of the controller, which precedes its topic and its action."""

INVALID_GOAL = -1
"""Error code of FollowJointTrajectory."""


class GantryJoints:
    """Publisher of `joint_states`. Trajectories come from a topic or an action."""

    def __init__(self, ros: CellNode, cell: Cell, machine: GantryRobot) -> None:
        self._cell = cell
        self._machine, name = machine, machine.name
        self._states = ros.publish_on("joint_states", "sensor_msgs/msg/JointState")
        self.actions: list[Action] = []
        if (command := cell.commands.get(f"machines/{name}/joints")) is not None:
            ros.subscribe(
                f"{CONTROLLER}/joint_trajectory",
                "trajectory_msgs/msg/JointTrajectory",
                lambda message: command.take(_trajectory(message)),
            )
        if (task := cell.tasks.get(f"machines/{name}/trajectory")) is not None:
            action = Action(
                ros,
                f"{CONTROLLER}/follow_joint_trajectory",
                "control_msgs/action/FollowJointTrajectory",
                start=lambda goal: task.start(_trajectory(goal.trajectory)),
                fill=self._fill,
                finish=_finish,
            )
            self.actions.append(action)

    def publish(self) -> None:
        """Publish positions and velocities of the joints."""
        if self._states.is_needed:
            message = self._states.new(name=[*JOINTS])
            set_header(message.header, self._cell.now, "")
            message.position, message.velocity = self._read()
            self._states.publish(message)

    def _read(self) -> tuple[list[float], list[float]]:
        """Return positions and velocities."""
        gantry, state = self._machine.gantry, self._machine.state
        velocities = joint_values(gantry, state.velocity, origin=False)
        return [*joint_values(gantry, state.position)], [*velocities]

    def _fill(self, feedback: Any, _: Running) -> None:
        set_header(feedback.header, self._cell.now, "")
        feedback.joint_names = [*JOINTS]
        feedback.actual.positions, feedback.actual.velocities = self._read()


def _trajectory(message: Any) -> JointTrajectory:
    """Return a trajectory_msgs/JointTrajectory as the cell has it."""
    points = [
        JointPoint(tuple(point.positions), tuple(point.velocities), seconds(point.time_from_start))
        for point in message.points
    ]
    return JointTrajectory(tuple(message.joint_names), tuple(points))


def _finish(result: Any, failure: str) -> None:
    if failure:
        result.error_code, result.error_string = INVALID_GOAL, failure
