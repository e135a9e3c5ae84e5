"""A run as a ROS 2 bag: transforms, poses, velocities, paths, markers and the log.

The bag's storage is SQLite and its version 8, which every ROS 2 reads from Humble on. The shapes
of bodies are written once, each in a frame of its own; `/tf` moves the frames.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, Literal

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

from ..core.recorder import Event
from ..record.outcome import Outcome
from . import drawing, log, track
from . import ros_messages as messages
from .track import nanoseconds

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
"""Later subscribers get the last message too."""

Topic = Callable[[float, Any], None]
"""Writes a message for an instant (seconds)."""


def write(run: Outcome, path: Path, rate: float) -> None:
    """Write `run` into the folder `path` with `rate` poses a second of every body."""
    with Writer(path, version=VERSION, storage_plugin=StoragePlugin.SQLITE3) as bag:
        _Topics(run, bag).write(rate)


def topic_names(names: Iterable[str]) -> dict[str, str]:
    """Return for each name one that ROS allows in a topic: letters, digits and _, all different."""
    found: dict[str, str] = {}
    for name in names:
        plain = re.sub(r"[^A-Za-z0-9_]", "_", name)
        plain = plain if plain[:1].isalpha() else f"body_{plain}"
        taken, free, number = set(found.values()), plain, 2
        while free in taken:
            free, number = f"{plain}_{number}", number + 1
        found[name] = free
    return found


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
        """Write everything, in order of time."""
        things = [*drawing.floor(self._run), *drawing.bodies(self._run)]
        self._markers(0.0, messages.markers(0.0, things))
        for moment in track.moments(self._run, rate):
            if moment.event is not None:
                self._write_event(moment.event)
            if moment.path is not None:
                self._paths[moment.path.person](moment.t, messages.path(moment.path))
            if moment.poses:
                frames = drawing.frames(self._run, moment.poses)
                self._frames(moment.t, messages.transforms(moment.t, frames))
            for pose in moment.poses:
                self._poses[pose.body](moment.t, messages.pose(moment.t, pose))
                self._velocities[pose.body](moment.t, messages.velocity(moment.t, pose))

    def _write_event(self, event: Event) -> None:
        line = log.line(event)
        self._events(line.t, messages.log_line(line))
        if event["kind"] == "violation":
            mark = drawing.violation(self._run, event)
            self._violations(line.t, messages.markers(line.t, [mark], drawing.ALARM_TIME))

    def _topic(self, name: str, kind: str, *qualities: Qos) -> Topic:
        connection = self._bag.add_connection(
            name, kind, typestore=self._store, offered_qos_profiles=qualities
        )

        def write(t: float, message: Any) -> None:
            data = self._store.serialize_cdr(message, kind)
            self._bag.write(connection, nanoseconds(t), data)

        return write
