"""The ROS message and service types that the bridge speaks, field by field.

Written as in .msg files: one line a type, its fields in their order. From std_msgs, geometry_msgs,
sensor_msgs, trajectory_msgs, tf2_msgs, rosgraph_msgs, builtin_interfaces and std_srvs of ROS 2,
from rosapi_msgs, and from the ariac_msgs of the ARIAC 2023 competition.
"""

from __future__ import annotations

from dataclasses import dataclass

from floorplan import suggestion

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

_SERVICES = """
std_srvs/Trigger: -> bool success, string message
ariac_msgs/MoveAGV: int8 location -> bool success, string message
floorwalker_msgs/Advance: float64 until -> float64 time, bool ended
rosapi_msgs/GetActionServers: -> string[] action_servers
rosapi_msgs/GetParamNames: -> string[] names
rosapi_msgs/GetTime: -> builtin_interfaces/Time time
rosapi_msgs/MessageDetails: string type -> rosapi_msgs/TypeDef[] typedefs
rosapi_msgs/Nodes: -> string[] nodes
rosapi_msgs/Publishers: string topic -> string[] publishers
rosapi_msgs/ServiceType: string service -> string type
rosapi_msgs/Services: -> string[] services
rosapi_msgs/ServicesForType: string type -> string[] services
rosapi_msgs/Subscribers: string topic -> string[] subscribers
rosapi_msgs/TopicType: string topic -> string type
rosapi_msgs/Topics: -> string[] topics, string[] types
rosapi_msgs/TopicsForType: string type -> string[] topics
"""


class UnknownTypeError(ValueError):
    """A message or service type that nobody here knows."""


@dataclass(frozen=True)
class Field:
    """One field of a message: a primitive or a message type, or an array of them."""

    name: str
    type: str
    is_array: bool = False


@dataclass(frozen=True)
class MessageType:
    """A message type by its name (`std_msgs/msg/Bool`), and its fields."""

    name: str
    fields: tuple[Field, ...]


@dataclass(frozen=True)
class ServiceType:
    """A service type by its name (`std_srvs/srv/Trigger`), its request and its response."""

    name: str
    request: MessageType
    response: MessageType


def message_type(name: str) -> MessageType:
    """The message type of that name, in ROS 2's form (`std_msgs/msg/Bool`) or ROS 1's.

    `UnknownTypeError` names the nearest one there is.
    """
    found = MESSAGES.get(canonical(name, "msg"))
    if found is None:
        raise UnknownTypeError(f"unknown message type {name!r}; {suggestion(name, MESSAGES)}")
    return found


def canonical(name: str, kind: str) -> str:
    """The name in ROS 2's form: `std_msgs/Bool` is `std_msgs/msg/Bool`; `kind` is msg or srv."""
    package, _, short = name.partition("/")
    return name if "/" in short else f"{package}/{kind}/{short}"


def _fields(text: str) -> tuple[Field, ...]:
    fields = []
    for declaration in filter(None, text.strip().split(", ")):
        kind, name = declaration.split()
        base = kind.removesuffix("[]")
        if "/" in base:
            base = canonical(base, "msg")
        fields.append(Field(name, base, is_array=kind != base and kind.endswith("[]")))
    return tuple(fields)


def _messages() -> dict[str, MessageType]:
    types = {}
    for line in _MESSAGES.strip().splitlines():
        name, _, fields = line.partition(":")
        full = canonical(name, "msg")
        types[full] = MessageType(full, _fields(fields))
    return types


def _services() -> dict[str, ServiceType]:
    types = {}
    for line in _SERVICES.strip().splitlines():
        name, _, fields = line.partition(":")
        full = canonical(name, "srv")
        request, _, response = fields.partition("->")
        types[full] = ServiceType(
            full,
            MessageType(f"{full}_Request", _fields(request)),
            MessageType(f"{full}_Response", _fields(response)),
        )
    return types


MESSAGES = _messages()
SERVICES = _services()
