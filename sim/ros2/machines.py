"""Topics of vehicles, as Nav2 has them, and the action of a gantry, as ros2_control has it."""

from __future__ import annotations

import array
import math
from typing import Any

from ..cell import Cell, Pose, Running
from ..cell.signals import SCANS
from ..competition.machine_topics import trajectory_of
from ..competition.messages import joint_state
from ..exports.scene import ROOT_FRAME
from ..machines.gantry.robot import GantryRobot
from .actions import Action
from .messages import pose_of, set_header, set_pose, set_twist, within
from .node import CellNode
from .transport import values_of

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


INVALID_GOAL = -1
"""Error code of FollowJointTrajectory."""


def gantry_action(ros: CellNode, cell: Cell, name: str) -> Action:
    """Provide the action in which a gantry follows a trajectory."""

    def fill(feedback: Any, _: Running) -> None:
        machine = cell.simulation.machines[name]
        assert isinstance(machine, GantryRobot)
        actual = joint_state(cell.now, machine.gantry, machine.state)
        set_header(feedback.header, cell.now, "")
        feedback.joint_names, feedback.actual.positions = actual["name"], actual["position"]
        feedback.actual.velocities = actual["velocity"]

    return Action(
        ros,
        "gantry_controller/follow_joint_trajectory",
        "control_msgs/action/FollowJointTrajectory",
        start=lambda goal: cell.tasks[f"machines/{name}/trajectory"].start(
            trajectory_of(values_of(goal.trajectory))
        ),
        fill=fill,
        failed=INVALID_GOAL,
    )
