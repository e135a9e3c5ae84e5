"""ROS messages: their types, and validation.

Types are written as in .msg files: one line per type, with its fields in order. They are from
std_msgs, geometry_msgs, nav_msgs, sensor_msgs, trajectory_msgs, tf2_msgs, rosgraph_msgs,
builtin_interfaces and std_srvs of ROS 2, from rosapi_msgs, and from the ariac_msgs of ARIAC 2023.
"""

from __future__ import annotations

import math
from typing import Any

from floorplan.files.dataclass import dataclass
from floorplan.files.problems import suggestion

from ..competition.transport import RefusedError

_MESSAGES = """
builtin_interfaces/Time: int32 sec, uint32 nanosec
builtin_interfaces/Duration: int32 sec, uint32 nanosec
rosgraph_msgs/Clock: builtin_interfaces/Time clock
std_msgs/Bool: bool data
std_msgs/Empty:
std_msgs/Float64: float64 data
std_msgs/Header: builtin_interfaces/Time stamp, string frame_id
std_msgs/Int32: int32 data
std_msgs/String: string data
geometry_msgs/Point: float64 x, float64 y, float64 z
geometry_msgs/Vector3: float64 x, float64 y, float64 z
geometry_msgs/Quaternion: float64 x, float64 y, float64 z, float64 w
geometry_msgs/Pose: geometry_msgs/Point position, geometry_msgs/Quaternion orientation
geometry_msgs/PoseArray: std_msgs/Header header, geometry_msgs/Pose[] poses
geometry_msgs/PoseStamped: std_msgs/Header header, geometry_msgs/Pose pose
geometry_msgs/Transform: geometry_msgs/Vector3 translation, geometry_msgs/Quaternion rotation
geometry_msgs/TransformStamped: std_msgs/Header header, string child_frame_id, geometry_msgs/Transform transform
geometry_msgs/PoseWithCovariance: geometry_msgs/Pose pose, float64[36] covariance
geometry_msgs/TwistWithCovariance: geometry_msgs/Twist twist, float64[36] covariance
geometry_msgs/TwistStamped: std_msgs/Header header, geometry_msgs/Twist twist
nav_msgs/Odometry: std_msgs/Header header, string child_frame_id, geometry_msgs/PoseWithCovariance pose, geometry_msgs/TwistWithCovariance twist
sensor_msgs/LaserScan: std_msgs/Header header, float32 angle_min, float32 angle_max, float32 angle_increment, float32 time_increment, float32 scan_time, float32 range_min, float32 range_max, float32[] ranges, float32[] intensities
geometry_msgs/Twist: geometry_msgs/Vector3 linear, geometry_msgs/Vector3 angular
tf2_msgs/TFMessage: geometry_msgs/TransformStamped[] transforms
sensor_msgs/JointState: std_msgs/Header header, string[] name, float64[] position, float64[] velocity, float64[] effort
trajectory_msgs/JointTrajectoryPoint: float64[] positions, float64[] velocities, float64[] accelerations, float64[] effort, builtin_interfaces/Duration time_from_start
trajectory_msgs/JointTrajectory: std_msgs/Header header, string[] joint_names, trajectory_msgs/JointTrajectoryPoint[] points
ariac_msgs/AGVStatus: int8 location, float64 position, float64 velocity
ariac_msgs/AssemblyPart: ariac_msgs/Part part, geometry_msgs/PoseStamped assembled_pose, geometry_msgs/Vector3 install_direction
ariac_msgs/AssemblyTask: uint8[] agv_numbers, uint8 station, ariac_msgs/AssemblyPart[] parts
ariac_msgs/CombinedTask: uint8 station, ariac_msgs/AssemblyPart[] parts
ariac_msgs/CompetitionState: uint8 competition_state
ariac_msgs/HumanState: geometry_msgs/Point human_position, geometry_msgs/Point robot_position, geometry_msgs/Vector3 human_velocity, geometry_msgs/Vector3 robot_velocity
ariac_msgs/KittingPart: ariac_msgs/Part part, uint8 quadrant
ariac_msgs/KittingTask: uint8 agv_number, int8 tray_id, uint8 destination, ariac_msgs/KittingPart[] parts
ariac_msgs/Order: string id, uint8 type, bool priority, ariac_msgs/KittingTask kitting_task, ariac_msgs/AssemblyTask assembly_task, ariac_msgs/CombinedTask combined_task
ariac_msgs/Part: uint8 color, uint8 type
ariac_msgs/Robots: bool floor_robot, bool ceiling_robot
"""  # noqa: E501

_INTEGERS = {
    f"{sign}int{bits}": ((0, 2**bits - 1) if sign else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1))
    for sign in ("", "u")
    for bits in (8, 16, 32, 64)
}
_OTHERS = {"bool": bool, "string": str}
_LONGEST_ARRAY = 10_000
"""Maximum number of elements of an array in a message."""


class UnknownTypeError(RefusedError):
    """Message type that the bridge does not know."""


class MessageError(RefusedError):
    """Message that does not conform to its type, with the wrong field."""


@dataclass(frozen=True)
class MessageType:
    """Message type, or request of a service type, by name (`std_srvs/srv/Trigger`).

    `fields` maps the name of each field to its type. Types of arrays end with `[]`, or with `[N]`
    for N elements.
    """

    name: str
    fields: dict[str, str]


def message_type(name: str) -> MessageType:
    """Return a message type by name, in the form of ROS 2 (`std_msgs/msg/Bool`) or ROS 1.

    `UnknownTypeError` suggests a known one.
    """
    type_ = MESSAGES.get(canonical(name, "msg"))
    if type_ is None:
        raise UnknownTypeError(f"unknown message type {name!r}; {suggestion(name, MESSAGES)}")
    return type_


def canonical(name: str, kind: str) -> str:
    """Return a name in the form of ROS 2: `std_msgs/Bool` is `std_msgs/msg/Bool`.

    `kind` is msg or srv.
    """
    package, _, short = name.partition("/")
    return name if "/" in short else f"{package}/{kind}/{short}"


def conform(type_: MessageType, message: Any, place: str = "") -> dict[str, Any]:
    """Return `message` with all fields of its type. Missing ones are zero or empty.

    `MessageError` names the wrong field. `place` is the field that contains `message`.
    """
    if not isinstance(message, dict):
        raise MessageError(
            f"{place or 'the message'} should be a {type_.name}, not {_shown(message)}"
        )
    for name in message:
        if name not in type_.fields:
            has = ", ".join(sorted(type_.fields)) or "none"
            where = f" at {place}" if place else ""
            raise MessageError(
                f"{type_.name} has no field {_shown(name)}{where} (there are: {has})"
            )
    return {
        name: _field(kind, message[name], f"{place}.{name}" if place else name)
        if name in message
        else _blank(kind)
        for name, kind in type_.fields.items()
    }


def _field(type_: str, value: Any, place: str) -> Any:
    if type_.endswith("]"):
        inner, _, count = type_[:-1].partition("[")
        if not isinstance(value, list) or (count and len(value) != int(count)):
            raise MessageError(
                f"{place} should be a list of {f'{count} {inner}'.strip()}, not {_shown(value)}"
            )
        if len(value) > _LONGEST_ARRAY:
            raise MessageError(
                f"{place} has {len(value)} elements; {_LONGEST_ARRAY} is the maximum"
            )
        return [_field(inner, one, f"{place}[{k}]") for k, one in enumerate(value)]
    if "/" in type_:
        return conform(MESSAGES[type_], value, place)
    if type_ in _OTHERS:
        if isinstance(value, _OTHERS[type_]):
            return value
    elif isinstance(value, int | float) and not isinstance(value, bool):
        return _number(type_, value, place)
    raise MessageError(f"{place} should be a {type_}, not {_shown(value)}")


def _number(type_: str, value: int | float, place: str) -> int | float:
    if type_ in ("float32", "float64"):
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise MessageError(f"{place} is not a finite number, but {_shown(value)}")
        return number
    low, high = _INTEGERS[type_]
    if isinstance(value, float) and not value.is_integer():
        raise MessageError(f"{place} should be a whole number, not {_shown(value)}")
    if not low <= value <= high:
        raise MessageError(f"{place} = {_shown(value)} is outside {low} … {high}")
    return int(value)


def _blank(type_: str) -> Any:
    """Return the default value of a field."""
    if type_.endswith("]"):
        inner, _, count = type_[:-1].partition("[")
        return [_blank(inner) for _ in range(int(count or 0))]
    if "/" in type_:
        return conform(MESSAGES[type_], {})
    if type_ in _OTHERS:
        return _OTHERS[type_]()
    return 0.0 if type_.startswith("float") else 0


def _shown(value: Any) -> str:
    """Return a value in short form for an error."""
    if isinstance(value, dict):
        return "an object"
    if isinstance(value, list):
        return "a list"
    text = repr(value) if not isinstance(value, int) or abs(value) < 10**20 else "a huge number"
    return text if len(text) <= 60 else f"{text[:57]}…"


def _types(text: str) -> dict[str, MessageType]:
    types = {}
    for line in text.strip().splitlines():
        name, _, declarations = line.partition(":")
        fields = {}
        for declaration in filter(None, declarations.strip().split(", ")):
            type_, field = declaration.split()
            fields[field] = canonical(type_, "msg") if "/" in type_ else type_
        types[canonical(name, "msg")] = MessageType(canonical(name, "msg"), fields)
    return types


MESSAGES = _types(_MESSAGES)
