"""ROS 2 messages, by the definitions of Humble, out of times, poses and shapes."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from rosbags.typesys.stores import ros2_humble as ros

from . import log
from .drawing import ROOT_FRAME
from .shapes import Shape, Thing
from .track import Pose, WalkedPath, nanoseconds

LEVELS = {
    "info": ros.rcl_interfaces__msg__Log.INFO,
    "warning": ros.rcl_interfaces__msg__Log.WARN,
    "error": ros.rcl_interfaces__msg__Log.ERROR,
}

_Marker = ros.visualization_msgs__msg__Marker

_KINDS = {
    "cube": _Marker.CUBE,
    "cylinder": _Marker.CYLINDER,
    "arrow": _Marker.ARROW,
    "line": _Marker.LINE_STRIP,
    "triangles": _Marker.TRIANGLE_LIST,
    "label": _Marker.TEXT_VIEW_FACING,
}

_NOTHING = np.empty(0, np.uint8)


def transforms(
    t: float, frames: Iterable[tuple[str, float, float, float]]
) -> ros.tf2_msgs__msg__TFMessage:
    """Return where frames are at `t` (seconds), each given as (name, x, y, rotation)."""
    return ros.tf2_msgs__msg__TFMessage(
        [
            ros.geometry_msgs__msg__TransformStamped(
                _header(t),
                frame,
                ros.geometry_msgs__msg__Transform(_vector(x, y, 0.0), _turned(rotation)),
            )
            for frame, x, y, rotation in frames
        ]
    )


def pose(t: float, pose: Pose) -> ros.geometry_msgs__msg__PoseStamped:
    """Return the pose of a body at `t` (seconds)."""
    return ros.geometry_msgs__msg__PoseStamped(
        _header(t), _pose(pose.x, pose.y, 0.0, pose.rotation)
    )


def velocity(t: float, pose: Pose) -> ros.geometry_msgs__msg__TwistStamped:
    """Return the velocity of a body at `t` (seconds), along the axes of the floor."""
    twist = ros.geometry_msgs__msg__Twist(_vector(pose.vx, pose.vy, 0.0), _vector(0.0, 0.0, 0.0))
    return ros.geometry_msgs__msg__TwistStamped(_header(t), twist)


def path(walked: WalkedPath) -> ros.nav_msgs__msg__Path:
    """Return the path of a person from one goal to the next."""
    header = _header(walked.t)
    poses = [
        ros.geometry_msgs__msg__PoseStamped(header, _pose(x, y, 0.0, rotation))
        for x, y, rotation in walked.points
    ]
    return ros.nav_msgs__msg__Path(header, poses)


def log_line(line: log.Line) -> ros.rcl_interfaces__msg__Log:
    """Return a line of the log."""
    level = LEVELS[line.level]
    return ros.rcl_interfaces__msg__Log(_stamp(line.t), level, line.name, line.text, "", "", 0)


def markers(
    t: float, things: Iterable[Thing], lifetime: float = 0.0
) -> ros.visualization_msgs__msg__MarkerArray:
    """Return things to draw from `t` on; `lifetime` in seconds, 0 for ever."""
    return ros.visualization_msgs__msg__MarkerArray(
        [
            _marker(t, thing, number, shape, lifetime)
            for thing in things
            for number, shape in enumerate(thing.shapes)
        ]
    )


def _marker(t: float, thing: Thing, number: int, shape: Shape, lifetime: float) -> Any:
    length, width, height = shape.size
    return _Marker(
        header=_header(t, thing.frame),
        ns=thing.name,
        id=number,
        type=_KINDS[shape.kind],
        action=_Marker.ADD,
        pose=_pose(*shape.at, shape.yaw),
        scale=_vector(length, width, width if shape.kind == "arrow" else height),
        color=ros.std_msgs__msg__ColorRGBA(*shape.color),
        lifetime=ros.builtin_interfaces__msg__Duration(int(lifetime), round(lifetime % 1 * 1e9)),
        frame_locked=True,
        points=[ros.geometry_msgs__msg__Point(*point) for point in shape.points],
        colors=[],
        texture_resource="",
        texture=ros.sensor_msgs__msg__CompressedImage(_header(0.0, ""), "", _NOTHING),
        uv_coordinates=[],
        text=shape.text,
        mesh_resource="",
        mesh_file=ros.visualization_msgs__msg__MeshFile("", _NOTHING),
        mesh_use_embedded_materials=False,
    )


def _header(t: float, frame: str = ROOT_FRAME) -> ros.std_msgs__msg__Header:
    return ros.std_msgs__msg__Header(_stamp(t), frame)


def _stamp(t: float) -> ros.builtin_interfaces__msg__Time:
    return ros.builtin_interfaces__msg__Time(*divmod(nanoseconds(t), 10**9))


def _pose(x: float, y: float, z: float, rotation: float) -> ros.geometry_msgs__msg__Pose:
    return ros.geometry_msgs__msg__Pose(ros.geometry_msgs__msg__Point(x, y, z), _turned(rotation))


def _vector(x: float, y: float, z: float) -> ros.geometry_msgs__msg__Vector3:
    return ros.geometry_msgs__msg__Vector3(x, y, z)


def _turned(rotation: float) -> ros.geometry_msgs__msg__Quaternion:
    z, w = math.sin(rotation / 2), math.cos(rotation / 2)
    return ros.geometry_msgs__msg__Quaternion(0.0, 0.0, z, w)
