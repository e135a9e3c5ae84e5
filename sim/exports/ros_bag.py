"""ROS 2 bag of a run, with its messages.

The storage of the bag is SQLite and its version 8, which every ROS 2 from Humble on reads. Each
body has a frame. Its shapes are written once, and `/tf` moves the frames.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, Literal

import numpy as np
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.stores import ros2_humble as ros

from ..core.recorder import Event
from ..record.outcome import Outcome
from . import scene
from .scene import ROOT_FRAME, BodyPose, LogLine, Shape, Thing, WalkedPath, nanoseconds

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
    """Return the positions of frames, each given as (name, x, y, rotation), at `t` (s)."""
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


def pose_message(t: float, pose: BodyPose) -> ros.geometry_msgs__msg__PoseStamped:
    """Return the pose of a body at `t` (s)."""
    return ros.geometry_msgs__msg__PoseStamped(
        _header(t), _pose(pose.x, pose.y, 0.0, pose.rotation)
    )


def velocity_message(t: float, pose: BodyPose) -> ros.geometry_msgs__msg__TwistStamped:
    """Return the velocity of a body at `t` (s), along the axes of the floor."""
    twist = ros.geometry_msgs__msg__Twist(_vector(pose.vx, pose.vy, 0.0), _vector(0.0, 0.0, 0.0))
    return ros.geometry_msgs__msg__TwistStamped(_header(t), twist)


def path_message(walked: WalkedPath) -> ros.nav_msgs__msg__Path:
    """Return the path of a person from one goal to the next."""
    header = _header(walked.t)
    poses = [
        ros.geometry_msgs__msg__PoseStamped(header, _pose(x, y, 0.0, rotation))
        for x, y, rotation in walked.points
    ]
    return ros.nav_msgs__msg__Path(header, poses)


def log_line(line: LogLine) -> ros.rcl_interfaces__msg__Log:
    """Return a line of the log."""
    level = LEVELS[line.level]
    return ros.rcl_interfaces__msg__Log(_stamp(line.t), level, line.name, line.text, "", "", 0)


def markers(
    t: float, things: Iterable[Thing], lifetime: float = 0.0
) -> ros.visualization_msgs__msg__MarkerArray:
    """Return shapes to draw from `t` on. `lifetime` is in seconds, 0 for unlimited."""
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


VERSION: Literal[8] = 8

LATCHED = Qos(
    history=QosHistory.KEEP_LAST,
    depth=1,
    reliability=QosReliability.RELIABLE,
    durability=QosDurability.TRANSIENT_LOCAL,
    deadline=QosTime(0, 0),
    lifespan=QosTime(0, 0),
    liveliness=QosLiveliness.SYSTEM_DEFAULT,
    liveliness_lease_duration=QosTime(0, 0),
    avoid_ros_namespace_conventions=False,
)
"""Quality of service by which later subscribers get the last message."""

Topic = Callable[[float, Any], None]
"""Function that writes a message for a time (s)."""


def write(run: Outcome, path: Path, rate: float) -> None:
    """Write `run` into the folder `path` with `rate` poses per second of every body."""
    with Writer(path, version=VERSION, storage_plugin=StoragePlugin.SQLITE3) as bag:
        _Topics(run, bag).write(rate)


def topic_names(names: Iterable[str]) -> dict[str, str]:
    """Return a unique topic name that ROS allows for each name: letters, digits and _."""
    topics: dict[str, str] = {}
    for name in names:
        plain = re.sub(r"[^A-Za-z0-9_]", "_", name)
        plain = plain if plain[:1].isalpha() else f"body_{plain}"
        taken, free, number = set(topics.values()), plain, 2
        while free in taken:
            free, number = f"{plain}_{number}", number + 1
        topics[name] = free
    return topics


class _Topics:
    """The topics of one bag."""

    def __init__(self, run: Outcome, bag: Writer) -> None:
        self._run = run
        self._bag = bag
        self._store = get_typestore(Stores.ROS2_HUMBLE)
        self._frames = self._topic("/tf", "tf2_msgs/msg/TFMessage")
        self._markers = self._topic("/markers", "visualization_msgs/msg/MarkerArray", LATCHED)
        self._violations = self._topic("/violations", "visualization_msgs/msg/MarkerArray")
        self._events = self._topic("/events", "rcl_interfaces/msg/Log")
        names = topic_names(run.motions)
        self._poses = {
            body: self._topic(f"/{name}/pose", "geometry_msgs/msg/PoseStamped")
            for body, name in names.items()
        }
        self._velocities = {
            body: self._topic(f"/{name}/velocity", "geometry_msgs/msg/TwistStamped")
            for body, name in names.items()
        }
        self._paths = {
            person.name: self._topic(f"/{names[person.name]}/way", "nav_msgs/msg/Path")
            for person in run.scene.people
        }

    def write(self, rate: float) -> None:
        """Write everything in order of time."""
        things = [*scene.floor(self._run), *scene.bodies(self._run)]
        self._markers(0.0, markers(0.0, things))
        for moment in scene.moments(self._run, rate):
            if moment.event is not None:
                self._write_event(moment.event)
            if moment.path is not None:
                self._paths[moment.path.person](moment.t, path_message(moment.path))
            if moment.poses:
                frames = scene.frames(self._run, moment.poses)
                self._frames(moment.t, transforms(moment.t, frames))
            for pose in moment.poses:
                self._poses[pose.body](moment.t, pose_message(moment.t, pose))
                self._velocities[pose.body](moment.t, velocity_message(moment.t, pose))

    def _write_event(self, event: Event) -> None:
        line = scene.line(event)
        self._events(line.t, log_line(line))
        if event["kind"] == "violation":
            mark = scene.violation(self._run, event)
            self._violations(line.t, markers(line.t, [mark], scene.ALARM_TIME))

    def _topic(self, name: str, kind: str, *qualities: Qos) -> Topic:
        connection = self._bag.add_connection(
            name, kind, typestore=self._store, offered_qos_profiles=qualities
        )

        def write(t: float, message: Any) -> None:
            data = self._store.serialize_cdr(message, kind)
            self._bag.write(connection, nanoseconds(t), data)

        return write
