"""Conversions between values of the cell and fields of ROS messages."""

from __future__ import annotations

import math
from typing import Any

from ..cell import Pose, Rejected
from ..exports.scene import ROOT_FRAME


def set_time(stamp: Any, t: float) -> None:
    """Set a Time or Duration to `t` seconds."""
    stamp.sec, stamp.nanosec = divmod(round(t * 1e9), 10**9)


def seconds(stamp: Any) -> float:
    """Return a Time or Duration in seconds."""
    return float(stamp.sec + stamp.nanosec * 1e-9)


def set_header(header: Any, t: float, frame: str = ROOT_FRAME) -> None:
    """Set time (s) and frame of a header."""
    set_time(header.stamp, t)
    header.frame_id = frame


def set_turn(quaternion: Any, heading: float) -> None:
    """Set a quaternion to a rotation about z (rad)."""
    quaternion.z, quaternion.w = math.sin(heading / 2), math.cos(heading / 2)


def set_pose(message: Any, pose: Pose) -> None:
    """Set a geometry_msgs/Pose."""
    message.position.x, message.position.y = pose.x, pose.y
    set_turn(message.orientation, pose.heading)


def set_twist(message: Any, velocity: Any) -> None:
    """Set a geometry_msgs/Twist."""
    message.linear.x, message.linear.y = velocity.x, velocity.y
    message.angular.z = velocity.turn


def pose_of(message: Any, frame: str = ROOT_FRAME) -> Pose:
    """Return a geometry_msgs/Pose. `Rejected` unless it is in the frame of the map."""
    if frame.lstrip("/") not in ("", ROOT_FRAME):
        raise Rejected("frame", frame, f"a pose must be in the frame {ROOT_FRAME}")
    x, y, z, w = (getattr(message.orientation, part) for part in "xyzw")
    norm = math.hypot(x, y, z, w)
    if not 0 < norm < math.inf:
        raise Rejected("orientation", (x, y, z, w), "must be a rotation")
    heading = math.atan2(2 * (w * z + x * y), norm * norm - 2 * (y * y + z * z))
    return Pose(message.position.x, message.position.y, heading)


def within(origin: Pose, pose: Pose) -> Pose:
    """Return a pose of the map in the frame at `origin`."""
    dx, dy = pose.x - origin.x, pose.y - origin.y
    c, s = math.cos(origin.heading), math.sin(origin.heading)
    turn = math.remainder(pose.heading - origin.heading, math.tau)
    return Pose(c * dx + s * dy, c * dy - s * dx, turn)
