"""Tracks in ROS 2 bags, of either storage: topics of poses, odometry, people and transforms.

Times are those of the messages' headers, counted from the first pose of all.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.highlevel import AnyReader
from rosbags.interfaces import Connection
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from floorplan import are_figures

from .samples import Samples, TrackError, Tracks

_PERSON = """\
string name
geometry_msgs/Point position
geometry_msgs/Point velocity
float64 reliability
string[] tagnames
string[] tags
"""

_PEOPLE = """\
std_msgs/Header header
people_msgs/Person[] people
"""

_LAST = ("pose", "odom", "odometry")
"""Last parts of a topic that say what it is, not whose."""


@dataclass
class _Track:
    """The poses of one body in a topic, as they come."""

    topic: str
    frame: str
    messages: list[int] = field(default_factory=list)
    stamps: list[int] = field(default_factory=list)
    poses: list[tuple[float, float, float]] = field(default_factory=list)


Found = tuple[str, Any, float, float, float]
"""The name of a body in a message ("" where the topic is the body's), its header, and a pose."""


def _of_pose(message: Any) -> Iterator[Found]:
    pose = message.pose
    yield "", message.header, pose.position.x, pose.position.y, _yaw(pose.orientation)


def _of_pose_with_covariance(message: Any) -> Iterator[Found]:
    pose = message.pose.pose
    yield "", message.header, pose.position.x, pose.position.y, _yaw(pose.orientation)


def _of_transforms(message: Any) -> Iterator[Found]:
    for one in message.transforms:
        at, turned = one.transform.translation, one.transform.rotation
        yield one.child_frame_id, one.header, at.x, at.y, _yaw(turned)


def _of_people(message: Any) -> Iterator[Found]:
    for person in message.people:
        yield person.name, message.header, person.position.x, person.position.y, np.nan


KINDS: dict[str, Callable[[Any], Iterator[Found]]] = {
    "geometry_msgs/msg/PoseStamped": _of_pose,
    "geometry_msgs/msg/PoseWithCovarianceStamped": _of_pose_with_covariance,
    "nav_msgs/msg/Odometry": _of_pose_with_covariance,
    "people_msgs/msg/People": _of_people,
    "tf2_msgs/msg/TFMessage": _of_transforms,
}
"""Readers of messages that say where bodies are, by type."""


def read(path: Path) -> Tracks:
    """Return the bodies in the bag at `path`; `TrackError` with topic and message if one is unfit.

    A topic of poses or of odometry is one body: it is called after the topic, whole or without
    the slash and a last part such as `/pose`. In transforms bodies are frames, in `people_msgs`
    people by their names.
    """
    try:
        reader = AnyReader([path], default_typestore=_typestore())
        with reader:
            tracks = _tracks(path, reader)
    except TrackError:
        raise
    except Exception as why:  # rosbags raises many things of what is damaged
        raise TrackError.of(path, f"is no ROS 2 bag that can be read: {why}") from None
    if not tracks:
        raise TrackError.of(path, f"has no topic of a type with poses: {', '.join(KINDS)}")
    _check_frames(path, tracks)
    first = min(track.stamps[0] for track in tracks.values())
    bodies = {name: _samples(track, first) for name, track in tracks.items()}
    short: dict[str, list[str]] = defaultdict(list)
    for name in bodies:
        short[_short(name)].append(name)
    bodies |= {
        brief: bodies[names[0]]
        for brief, names in short.items()
        if len(names) == 1 and brief not in bodies
    }
    return Tracks(bodies, row="message")


def _typestore() -> Any:
    """Return the types of Humble and of `people_msgs`, for bags that do not define their own."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    store.register(get_types_from_msg(_PERSON, "people_msgs/msg/Person"))
    store.register(get_types_from_msg(_PEOPLE, "people_msgs/msg/People"))
    return store


def _tracks(path: Path, reader: AnyReader) -> dict[str, _Track]:
    """Return the tracks by topic, or by name where a topic is about several bodies."""
    wanted = [one for one in reader.connections if one.msgtype in KINDS]
    tracks: dict[str, _Track] = {}
    counts: dict[str, int] = defaultdict(int)
    for connection, stamp, data in reader.messages(wanted) if wanted else ():
        number = counts[connection.topic]
        counts[connection.topic] += 1
        for name, header, x, y, yaw in _decoded(path, reader, connection, number, data):
            body = name or connection.topic
            track = tracks.setdefault(body, _Track(connection.topic, header.frame_id))
            time = header.stamp.sec * 10**9 + header.stamp.nanosec
            fault = _fault(track, connection.topic, header.frame_id, (x, y))
            if fault:
                raise TrackError.of(path, f"topic {connection.topic}, message {number}: {fault}")
            track.messages.append(number)
            # A header without a time is common: then the instant at which the message was recorded.
            track.stamps.append(time or stamp)
            track.poses.append((x, y, yaw))
    return tracks


def _decoded(
    path: Path, reader: AnyReader, connection: Connection, number: int, data: bytes
) -> Iterable[Found]:
    """Return the poses in a message; what rosbags raises of one that is damaged is many things."""
    try:
        message = reader.deserialize(data, connection.msgtype)
        return list(KINDS[connection.msgtype](message))
    except Exception as why:
        place = f"topic {connection.topic}, message {number}"
        raise TrackError.of(path, f"{place}: can't be decoded: {why}") from None


def _fault(track: _Track, topic: str, frame: str, place: tuple[float, float]) -> str:
    """Return what keeps a pose from being one of the track, if anything."""
    if not are_figures(place).all():
        return f"({place[0]:g}, {place[1]:g}) is no place"
    if topic != track.topic:
        return f"the topic {track.topic} has a body of that name as well"
    if frame != track.frame:
        return f"is in the frame {frame!r}, those before in {track.frame!r}"
    return ""


def _check_frames(path: Path, tracks: dict[str, _Track]) -> None:
    """Raise `TrackError` if a body is placed in the frame of another one, which moves."""
    for name, track in tracks.items():
        if track.frame in tracks and track.frame != name:
            moving = {pose[:2] for pose in tracks[track.frame].poses}
            if len(moving) > 1:
                raise TrackError.of(
                    path,
                    f"topic {track.topic}, message {track.messages[0]}: {name!r} is in the frame"
                    f" {track.frame!r}, which moves itself; give its poses in the floor's frame",
                )


def _samples(track: _Track, first: int) -> Samples:
    stamps = np.array([stamp - first for stamp in track.stamps], dtype=float) / 1e9
    x, y, yaw = np.array(track.poses).T
    turned = None if np.isnan(yaw).any() else yaw
    rows = np.array(track.messages)
    return Samples(rows, stamps, x, y, turned, place=f"topic {track.topic}")


def _short(name: str) -> str:
    """Return whose topic it is: eve of /eve/pose; a name as it is."""
    parts = name.strip("/").split("/")
    return "/".join(parts[:-1] if len(parts) > 1 and parts[-1] in _LAST else parts)


def _yaw(turned: Any) -> float:
    """Return the heading of a quaternion (radians), NaN where it is none."""
    x, y, z, w = turned.x, turned.y, turned.z, turned.w
    if x == y == z == w == 0.0:
        return float("nan")
    # The rotation about z of the order z-y-x, which is what is left of any attitude on the floor.
    return float(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))
