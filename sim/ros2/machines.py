"""Topics of vehicles, as Nav2 has them, and the action of a gantry, as ros2_control has it."""

from __future__ import annotations

import array
import math
from functools import partial
from typing import Any

from ..cell import Cell, CellCommand, Pose, Running, Scan, Signal
from ..cell.signals import POSES, SCANS
from ..competition import Values
from ..competition.machine_topics import trajectory_of
from ..competition.messages import joint_state, laser_scan, odometry, stamped_pose_of
from ..exports.scene import ROOT_FRAME
from ..machines.gantry.robot import GantryRobot
from .actions import Action
from .messages import values_of
from .node import CellNode

STAMPED, PLAIN = "geometry_msgs/TwistStamped", "geometry_msgs/Twist"
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
        self._odom, self._base = f"{prefix}odom", f"{prefix}base_link"
        self._laser, self._commands = f"{prefix}base_scan", f"{prefix}cmd_vel"
        self._origin: Pose = self._pose.read()
        ros.advertise(self._odom, "nav_msgs/Odometry", self._odometry, rate=POSES)
        if (scan := cell.signals.get(f"machines/{name}/scan")) is not None:
            read = partial(self._laser_scan, scan)
            ros.advertise(f"{prefix}scan", "sensor_msgs/LaserScan", read, rate=SCANS)
        self._drive = cell.commands.get(f"machines/{name}/twist")
        self._listening = ("", None)
        self.listen()
        if (locate := cell.commands.get(f"machines/{name}/pose")) is not None:
            located = "geometry_msgs/PoseWithCovarianceStamped"
            ros.listen(f"{prefix}initialpose", located, partial(_confirm, locate))

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
        types = {one.topic_type for one in publishers}
        message_type = PLAIN if types == {PLAIN.replace("/", "/msg/")} else STAMPED
        type_, subscription = self._listening
        if message_type == type_:
            return
        if subscription is None:
            drive = partial(_drive, self._drive)
            subscription = self._ros.listen(self._commands, message_type, drive)
            self._listening = (message_type, subscription)
        else:
            # The executor releases the old subscription before the next call.
            self._ros.node.destroy_subscription(subscription)
            self._listening = ("", None)

    @property
    def fixed_frame(self) -> Frame:
        """Frame of the scanner."""
        return (self._base, self._laser, Pose(0.0, 0.0, 0.0))

    @property
    def moving_frames(self) -> list[Frame]:
        """Frames of odometry and vehicle."""
        moved = _within(self._origin, self._pose.read())
        return [(ROOT_FRAME, self._odom, self._origin), (self._odom, self._base, moved)]

    def _odometry(self) -> Values:
        """Return pose and velocity."""
        pose: Pose = self._pose.read()
        moved, velocity = _within(self._origin, pose), self._velocity.read().seen_at(pose.heading)
        return odometry(self._cell.now, self._odom, self._base, moved, velocity)

    def _laser_scan(self, signal: Signal) -> Values:
        """Return what the scanner sees: infinity beyond its reach (REP 117)."""
        scan: Scan = signal.read()
        ranges = scan.distances.astype("f")
        ranges[scan.distances >= scan.reach] = math.inf
        message = laser_scan(self._cell.now, self._laser, scan)
        return message | {"ranges": array.array("f", ranges.tobytes())}


def _drive(command: CellCommand, message: Values, _: str) -> None:
    twist = message.get("twist", message)
    command.take((twist["linear"]["x"], twist["linear"]["y"], twist["angular"]["z"]))


def _confirm(command: CellCommand, message: Values, _: str) -> None:
    command.take(stamped_pose_of(message["pose"] | {"header": message["header"]}))


def _within(origin: Pose, pose: Pose) -> Pose:
    """Return a pose of the map in the frame at `origin`."""
    dx, dy = pose.x - origin.x, pose.y - origin.y
    c, s = math.cos(origin.heading), math.sin(origin.heading)
    turn = math.remainder(pose.heading - origin.heading, math.tau)
    return Pose(c * dx + s * dy, c * dy - s * dx, turn)


INVALID_GOAL = -1
"""Error code of FollowJointTrajectory."""


def gantry_action(ros: CellNode, cell: Cell, name: str) -> Action:
    """Provide the action in which a gantry follows a trajectory."""

    def feedback(_: Running) -> Values:
        machine = cell.simulation.machines[name]
        assert isinstance(machine, GantryRobot)
        actual = joint_state(cell.now, machine.gantry, machine.state)
        point = {"positions": actual["position"], "velocities": actual["velocity"]}
        return {"header": actual["header"], "joint_names": actual["name"], "actual": point}

    def start(goal: Any) -> Running:
        task = cell.tasks[f"machines/{name}/trajectory"]
        return task.start(trajectory_of(values_of(goal.trajectory)))

    action = "gantry_controller/follow_joint_trajectory"
    type_ = "control_msgs/FollowJointTrajectory"
    return Action(
        ros=ros, name=action, type_=type_, start=start, feedback=feedback, failed=INVALID_GOAL
    )
