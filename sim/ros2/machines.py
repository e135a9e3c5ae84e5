"""Topics of vehicles, as Nav2 has them, and of gantries, as ros2_control has them."""

from __future__ import annotations

import array
import math
from typing import Any

from ..cell import Cell, JointPoint, JointTrajectory, Pose, Running
from ..cell.signals import SCANS
from ..cell.trajectories import JOINTS, joint_values
from ..exports.scene import ROOT_FRAME
from ..machines.gantry.robot import GantryRobot
from .actions import Action
from .messages import pose_of, seconds, set_header, set_pose, set_twist, within
from .node import CellNode

STAMPED, PLAIN = "geometry_msgs/msg/TwistStamped", "geometry_msgs/msg/Twist"
"""Types of velocity commands: of Nav2 since Kilted, and before."""

Frame = tuple[str, str, Pose]
"""Parent, child, and pose of the child in the parent."""


class VehicleTopics:
    """Topics of a vehicle. Topics and frames begin with `prefix`.

    Odometry is exact, and begins at 0 where the vehicle starts. So an initial pose only confirms
    where the vehicle is.
    """

    def __init__(self, ros: CellNode, cell: Cell, name: str, prefix: str) -> None:
        self._ros = ros
        self._cell = cell
        self._pose = cell.signals[f"machines/{name}/pose"]
        self._velocity = cell.signals[f"machines/{name}/velocity"]
        self._scan = cell.signals.get(f"machines/{name}/scan")
        self._odom, self._base = f"{prefix}odom", f"{prefix}base_link"
        self._laser, self._commands = f"{prefix}base_scan", f"{prefix}cmd_vel"
        self._origin: Pose = self._pose.read()
        self._odometry = ros.publish_on(f"{prefix}odom", "nav_msgs/msg/Odometry")
        self._scans = ros.publish_on(f"{prefix}scan", "sensor_msgs/msg/LaserScan")
        self._drive = cell.commands.get(f"machines/{name}/twist")
        self._listening = ("", None)
        self.listen()
        if (locate := cell.commands.get(f"machines/{name}/pose")) is not None:
            located = "geometry_msgs/msg/PoseWithCovarianceStamped"
            ros.subscribe(
                f"{prefix}initialpose",
                located,
                lambda message: locate.take(pose_of(message.pose.pose, message.header.frame_id)),
            )

    def listen(self) -> None:
        """Subscribe to velocity commands, in the type of their publisher.

        Call it again and again, because publishers come and go. A node cannot have two types for
        one topic.
        """
        if self._drive is None:
            return
        publishers = self._ros.node.get_publishers_info_by_topic(self._commands)
        if len(publishers) > 1:
            self._ros.warn(self._commands, "several publishers, the last message counts")
        message_type = PLAIN if {one.topic_type for one in publishers} == {PLAIN} else STAMPED
        type_, subscription = self._listening
        if message_type == type_:
            return
        if subscription is None:
            self._listening = (
                message_type,
                self._ros.subscribe(self._commands, message_type, self._take),
            )
        else:
            # The executor releases the old subscription before the next call.
            self._ros.node.destroy_subscription(subscription)
            self._listening = ("", None)

    def _take(self, message: Any) -> None:
        twist = getattr(message, "twist", message)
        assert self._drive is not None
        self._drive.take((twist.linear.x, twist.linear.y, twist.angular.z))

    @property
    def fixed_frames(self) -> list[Frame]:
        """Frame of the scanner."""
        return [(self._base, self._laser, Pose(0.0, 0.0, 0.0))]

    @property
    def moving_frames(self) -> list[Frame]:
        """Frames of odometry and vehicle."""
        moved = within(self._origin, self._pose.read())
        return [(ROOT_FRAME, self._odom, self._origin), (self._odom, self._base, moved)]

    def publish_odometry(self) -> None:
        """Publish pose and velocity."""
        if self._odometry.is_needed:
            message = self._odometry.new(child_frame_id=self._base)
            set_header(message.header, self._cell.now, self._odom)
            pose = self._pose.read()
            set_pose(message.pose.pose, within(self._origin, pose))
            set_twist(message.twist.twist, self._velocity.read().seen_at(pose.heading))
            self._odometry.publish(message)

    def publish_scan(self) -> None:
        """Publish what the scanner sees: infinity beyond its reach (REP 117)."""
        if self._scan is None or not self._scans.is_needed:
            return
        scan = self._scan.read()
        message = self._scans.new()
        set_header(message.header, self._cell.now, self._laser)
        message.angle_min, message.angle_increment = scan.first, scan.step
        message.angle_max = scan.first + math.tau - scan.step
        message.scan_time = 1 / SCANS
        message.range_max = scan.reach
        ranges = scan.distances.astype("f")
        ranges[scan.distances >= scan.reach] = math.inf
        message.ranges = array.array("f", ranges.tobytes())
        self._scans.publish(message)


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
                failed=INVALID_GOAL,
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
