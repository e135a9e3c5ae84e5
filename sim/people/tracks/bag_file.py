"""Tracks in ROS 2 bags, of either storage, and in MCAP files with Foxglove's schemas.

Topics are of poses, odometry, people and transforms. Times are those of the messages' headers,
counted from the first pose of all.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from dataclasses import field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from floorplan.files.dataclass import dataclass
from floorplan.files.fields import are_figures

from .tables import Samples, TrackError, Tracks

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
"""Last parts of a topic that name its content, not a body."""


@dataclass
class _BagTrack:
    """Poses of one body in a topic, in the order of messages."""

    topic: str
    frame: str
    messages: list[int] = field(default_factory=list)
    stamps: list[int] = field(default_factory=list)
    poses: list[tuple[float, float, float]] = field(default_factory=list)


Found = tuple[str, str, int, float, float, float]
"""Name of a body ("" if the topic has only one), its frame, time (ns), and pose."""

Message = tuple[str, int, Callable[[], Iterable[Found]]]
"""Topic of a message, time of its recording (ns), and decoder of its poses."""


def _of_pose(message: Any) -> Iterator[Found]:
    pose = message.pose
    yield "", *_head(message), pose.position.x, pose.position.y, _yaw(pose.orientation)


def _of_pose_with_covariance(message: Any) -> Iterator[Found]:
    pose = message.pose.pose
    yield "", *_head(message), pose.position.x, pose.position.y, _yaw(pose.orientation)


def _of_transforms(message: Any) -> Iterator[Found]:
    for one in message.transforms:
        at, turned = one.transform.translation, one.transform.rotation
        yield one.child_frame_id, *_head(one), at.x, at.y, _yaw(turned)


def _of_people(message: Any) -> Iterator[Found]:
    for person in message.people:
        yield person.name, *_head(message), person.position.x, person.position.y, np.nan


def _head(message: Any) -> tuple[str, int]:
    """Return the frame of a message of ROS, and its time."""
    stamp = message.header.stamp
    return message.header.frame_id, stamp.sec * 10**9 + stamp.nanosec


def _of_foxglove(message: Any) -> Iterator[Found]:
    pose, stamp = message.pose, message.timestamp
    time = stamp.seconds * 10**9 + stamp.nanos
    yield "", message.frame_id, time, pose.position.x, pose.position.y, _yaw(pose.orientation)


KINDS: dict[str, Callable[[Any], Iterator[Found]]] = {
    "geometry_msgs/msg/PoseStamped": _of_pose,
    "geometry_msgs/msg/PoseWithCovarianceStamped": _of_pose_with_covariance,
    "nav_msgs/msg/Odometry": _of_pose_with_covariance,
    "people_msgs/msg/People": _of_people,
    "tf2_msgs/msg/TFMessage": _of_transforms,
}
"""Readers of ROS messages with poses of bodies, by type."""

FOXGLOVE = "foxglove.PoseInFrame"
"""Foxglove's schema of poses."""


def read(path: Path) -> Tracks:
    """Return the bodies in the file or bag at `path`.

    `TrackError` with topic and message if one is unfit.

    A topic of poses or of odometry is one body: it is called after the topic, whole or without
    the slash and a last part such as `/pose`. In transforms bodies are frames, in `people_msgs`
    people by their names.
    """
    is_foxglove = path.suffix.lower() == ".mcap" and not _is_of_ros(path)
    try:
        tracks = _tracks(path, _in_foxglove(path) if is_foxglove else _in_bag(path))
    except (TrackError, ModuleNotFoundError):
        raise
    except Exception as why:  # the libraries raise many errors for damaged files
        kind = "MCAP file" if is_foxglove else "ROS 2 bag"
        raise TrackError.of(path, f"is no {kind} that can be read: {why}") from None
    if not tracks:
        kinds = FOXGLOVE if is_foxglove else ", ".join(KINDS)
        raise TrackError.of(path, f"has no topic of a type with poses: {kinds}")
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


def _is_of_ros(path: Path) -> bool:
    """Return True if the header of an MCAP file has the profile of ROS 2, or can't be read."""
    with path.open("rb") as file:
        start = file.read(32)
    # Magic, the operation code 1 and the length of the header are 17 bytes. Then come its texts,
    # each after its length.
    return not start.startswith(b"\x89MCAP0\r\n\x01") or start[17:25] == b"\x04\0\0\0ros2"


def _in_bag(path: Path) -> Iterator[Message]:
    with AnyReader([path], default_typestore=_typestore()) as reader:
        wanted = [one for one in reader.connections if one.msgtype in KINDS]
        for connection, stamp, data in reader.messages(wanted) if wanted else ():

            def poses(kind: str = connection.msgtype, data: bytes = data) -> Iterator[Found]:
                return KINDS[kind](reader.deserialize(data, kind))

            yield connection.topic, stamp, poses


def _in_foxglove(path: Path) -> Iterator[Message]:
    from mcap.reader import make_reader
    from mcap_protobuf.decoder import DecoderFactory

    decoders = DecoderFactory()
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            if schema is None or schema.name != FOXGLOVE:
                continue
            decode = decoders.decoder_for(channel.message_encoding, schema)
            if decode is not None:
                yield channel.topic, message.log_time, partial(_decoded_pose, decode, message.data)


def _decoded_pose(decode: Callable[[bytes], Any], data: bytes) -> Iterator[Found]:
    return _of_foxglove(decode(data))


def _tracks(path: Path, messages: Iterable[Message]) -> dict[str, _BagTrack]:
    """Return the tracks by topic, or by name if a topic has several bodies."""
    tracks: dict[str, _BagTrack] = {}
    counts: dict[str, int] = defaultdict(int)
    for topic, stamp, poses in messages:
        number = counts[topic]
        counts[topic] += 1
        try:
            decoded = list(poses())
        except Exception as why:  # the libraries raise many errors for damaged messages
            message = f"topic {topic}, message {number}: can't be decoded: {why}"
            raise TrackError.of(path, message) from None
        for name, frame, time, x, y, yaw in decoded:
            track = tracks.setdefault(name or topic, _BagTrack(topic, frame))
            fault = _fault(track, topic, frame, (x, y))
            if fault:
                raise TrackError.of(path, f"topic {topic}, message {number}: {fault}")
            track.messages.append(number)
            # Headers without a time are common. The time of the recording replaces it.
            track.stamps.append(time or stamp)
            track.poses.append((x, y, yaw))
    return tracks


def _fault(track: _BagTrack, topic: str, frame: str, place: tuple[float, float]) -> str:
    """Return the message about an invalid pose, or an empty string."""
    if not are_figures(place).all():
        return f"({place[0]:g}, {place[1]:g}) is not a place"
    if topic != track.topic:
        return f"the topic {track.topic} has a body of that name as well"
    if frame != track.frame:
        return f"is in the frame {frame!r}, those before in {track.frame!r}"
    return ""


def _check_frames(path: Path, tracks: dict[str, _BagTrack]) -> None:
    """Raise a `TrackError` if the frame of a body is that of another body, which moves."""
    for name, track in tracks.items():
        if track.frame in tracks and track.frame != name:
            moving = {pose[:2] for pose in tracks[track.frame].poses}
            if len(moving) > 1:
                raise TrackError.of(
                    path,
                    f"topic {track.topic}, message {track.messages[0]}: {name!r} is in the frame"
                    f" {track.frame!r}, which moves itself; give its poses in the floor's frame",
                )


def _samples(track: _BagTrack, first: int) -> Samples:
    stamps = np.array([stamp - first for stamp in track.stamps], dtype=float) / 1e9
    x, y, yaw = np.array(track.poses).T
    turned = None if np.isnan(yaw).any() else yaw
    rows = np.array(track.messages)
    return Samples(rows=rows, t=stamps, x=x, y=y, rotation=turned, place=f"topic {track.topic}")


def _short(name: str) -> str:
    """Return the body of a topic, such as eve for /eve/pose. Names are returned unchanged."""
    parts = name.strip("/").split("/")
    return "/".join(parts[:-1] if len(parts) > 1 and parts[-1] in _LAST else parts)


def _yaw(turned: Any) -> float:
    """Return the heading of a quaternion (rad), or NaN for an invalid one."""
    x, y, z, w = turned.x, turned.y, turned.z, turned.w
    if x == y == z == w == 0.0:
        return float("nan")
    # The rotation about z in the order z-y-x is the heading on the floor.
    return float(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))
