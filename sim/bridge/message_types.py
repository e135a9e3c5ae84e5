"""The ROS types that the bridge speaks, and messages checked against them.

The types are written as in .msg files: one line a type, its fields in their order. They are from
std_msgs, geometry_msgs, sensor_msgs, trajectory_msgs, tf2_msgs, rosgraph_msgs, builtin_interfaces
and std_srvs of ROS 2, from rosapi_msgs, and from the ariac_msgs of the ARIAC 2023 competition.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from floorplan import UserError, suggestion

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
geometry_msgs/PoseStamped: std_msgs/Header header, geometry_msgs/Pose pose
geometry_msgs/Transform: geometry_msgs/Vector3 translation, geometry_msgs/Quaternion rotation
geometry_msgs/TransformStamped: std_msgs/Header header, string child_frame_id, geometry_msgs/Transform transform
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
"""Elements. The longest array in a message."""


class UnknownTypeError(UserError):
    """A message type that the bridge does not speak."""


class MessageError(UserError):
    """A message that is not of its type, with the field that is wrong."""


@dataclass(frozen=True)
class MessageType:
    """A message type, or the request of a service type, by its name (`std_srvs/srv/Trigger`).

    `fields` gives the type of each field by the field's name; an array's type ends with `[]`.
    """

    name: str
    fields: dict[str, str]


def message_type(name: str) -> MessageType:
    """Return the message type of that name, in ROS 2's form (`std_msgs/msg/Bool`) or ROS 1's.

    `UnknownTypeError` names the nearest one there is.
    """
    found = MESSAGES.get(canonical(name, "msg"))
    if found is None:
        raise UnknownTypeError(f"unknown message type {name!r}; {suggestion(name, MESSAGES)}")
    return found


def canonical(name: str, kind: str) -> str:
    """Return a name in ROS 2's form: `std_msgs/Bool` is `std_msgs/msg/Bool`.

    `kind` is msg or srv.
    """
    package, _, short = name.partition("/")
    return name if "/" in short else f"{package}/{kind}/{short}"


def conform(type_: MessageType, message: Any, place: str = "") -> dict[str, Any]:
    """Return `message` with all fields of its type, those left out being zero or empty.

    `MessageError` names the field that is wrong; `place` is the field that `message` stands in.
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
    if type_.endswith("[]"):
        inner = type_.removesuffix("[]")
        if not isinstance(value, list):
            raise MessageError(f"{place} should be a list of {inner}, not {_shown(value)}")
        if len(value) > _LONGEST_ARRAY:
            raise MessageError(f"{place} has {len(value)} elements; {_LONGEST_ARRAY} is the most")
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
            raise MessageError(f"{place} is not a finite number")
        return number
    low, high = _INTEGERS[type_]
    if isinstance(value, float) and not value.is_integer():
        raise MessageError(f"{place} should be a whole number, not {_shown(value)}")
    if not low <= value <= high:
        raise MessageError(f"{place} = {_shown(value)} is outside {low} … {high}")
    return int(value)


def _blank(type_: str) -> Any:
    """The value of a field that is left out."""
    if type_.endswith("[]"):
        return []
    if "/" in type_:
        return conform(MESSAGES[type_], {})
    if type_ in _OTHERS:
        return _OTHERS[type_]()
    return 0.0 if type_.startswith("float") else 0


def _shown(value: Any) -> str:
    """A value in an error: short, whatever it is."""
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
