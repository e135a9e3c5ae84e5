"""States of the workcell, and orders of the competition, as ROS messages."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

from floorplan import Gantry, Lane
from navigation import State, lane_state

from ..core.body import Body
from ..orders import AssemblyTask, KittingTask, Order, Part
from .message_types import conform, message_type

Message = dict[str, Any]
Values = tuple[float, float, float]

LOCATIONS = ("kitting", "assembly_front", "assembly_back", "warehouse")
"""The AGV locations of ariac_msgs/AGVStatus, by number."""

UNKNOWN_LOCATION = 99
"""The location of an AGV that drives, or stands elsewhere."""

JOINTS = ("gantry_x_axis_joint", "gantry_y_axis_joint", "gantry_rotation_joint")
"""The joints of the competition's ceiling robot that the gantry has."""

NOWHERE = {"x": 1e6, "y": 1e6, "z": 0.0}
"""The position of the robot on a floor without one: too far from anybody to matter."""

_AT_REST = 1e-6
"""Metres and metres a second. An AGV that is nearer to a location, and slower, stands there."""

_KINDS = ("kitting", "assembly", "combined")
_COLORS = ("red", "green", "blue", "orange", "purple")
_TYPES = {"battery": 10, "pump": 11, "sensor": 12, "regulator": 13}


def seconds(t: float) -> Message:
    """Return a time or a duration (builtin_interfaces)."""
    whole, nanoseconds = divmod(round(t * 1e9), 1_000_000_000)
    return {"sec": whole, "nanosec": nanoseconds}


def human_state(person: State, robot: State | None, robot_height: float) -> Message:
    """Return ariac_msgs/HumanState: positions (m) and velocities (m/s) of person and gantry."""
    return {
        "human_position": _vector(person.position),
        "robot_position": _vector(robot.position, robot_height) if robot else NOWHERE,
        "human_velocity": _vector(person.velocity),
        "robot_velocity": _vector(robot.velocity) if robot else _vector((0.0, 0.0, 0.0)),
    }


def transforms(t: float, frames: Iterable[tuple[str, Body, float]]) -> Message:
    """Return tf2_msgs/TFMessage, from the world to each frame: name, body, height in metres."""
    header = {"stamp": seconds(t), "frame_id": "world"}
    return {
        "transforms": [
            {
                "header": header,
                "child_frame_id": name,
                "transform": {
                    "translation": _vector(body.state.position, height),
                    "rotation": _about_z(body.state.position[2]),
                },
            }
            for name, body, height in frames
        ]
    }


def agv_status(lane: Lane, state: State) -> Message:
    """Return ariac_msgs/AGVStatus: location, position on the lane (m), and speed (m/s)."""
    q = lane_state(lane, state)
    location = UNKNOWN_LOCATION
    for number, name in enumerate(LOCATIONS):
        place = lane.locations.get(name)
        if place is not None and abs(place - q.position) < _AT_REST and abs(q.velocity) < _AT_REST:
            location = number
    return {"location": location, "position": q.position, "velocity": q.velocity}


def joint_state(t: float, gantry: Gantry, state: State) -> Message:
    """Return sensor_msgs/JointState of the gantry's joints (m, rad, and m/s, rad/s)."""
    return {
        "header": {"stamp": seconds(t), "frame_id": ""},
        "name": list(JOINTS),
        "position": list(joint_values(gantry, state.position)),
        "velocity": list(joint_values(gantry, state.velocity, origin=False)),
        "effort": [],
    }


def joint_values(gantry: Gantry, pose: Sequence[float], *, origin: bool = True) -> Values:
    """Return the gantry's joints at x, y, rotation in the world, as the competition has them.

    They are zero in the middle of the rails, and the y axis points along the world's −y. Without
    `origin`, `pose` is a velocity.
    """
    middle_x, middle_y = _middle(gantry) if origin else (0.0, 0.0)
    x, y, rotation = pose
    return (x - middle_x, middle_y - y, rotation)


def pose_of(gantry: Gantry, joints: Sequence[float], *, origin: bool = True) -> Values:
    """Return x, y, rotation in the world at these joints: the inverse of `joint_values`."""
    middle_x, middle_y = _middle(gantry) if origin else (0.0, 0.0)
    x, y, rotation = joints
    return (x + middle_x, middle_y - y, rotation)


def order_message(order: Order) -> Message:
    """Return ariac_msgs/Order. A trial has no poses of assembled parts: they are left blank."""
    message: Message = {
        "id": order.id,
        "type": _KINDS.index(order.kind),
        "priority": order.priority,
    }
    task = order.task
    if isinstance(task, KittingTask):
        message["kitting_task"] = {
            "agv_number": _number(task.agv),
            "tray_id": task.tray,
            "destination": LOCATIONS.index(task.destination),
            "parts": [
                {"part": _part(part), "quadrant": quadrant}
                for quadrant, part in sorted(task.products.items())
            ],
        }
    else:
        parts = [{"part": _part(part)} for part in task.products]
        work: Message = {"station": _number(task.station), "parts": parts}
        if isinstance(task, AssemblyTask):
            work["agv_numbers"] = [_number(agv) for agv in task.agvs]
        message[f"{order.kind}_task"] = work
    return conform(message_type("ariac_msgs/Order"), message)


def _part(part: Part) -> dict[str, int]:
    return {"color": _COLORS.index(part.color), "type": _TYPES[part.type]}


def _number(name: str) -> int:
    """The number in a name: agv3 is 3, as2 is 2."""
    return int("".join(filter(str.isdigit, name)))


def _middle(gantry: Gantry) -> tuple[float, float]:
    return ((gantry.x.low + gantry.x.high) / 2, (gantry.y.low + gantry.y.high) / 2)


def _vector(xyz: tuple[float, float, float], z: float = 0.0) -> Message:
    return {"x": xyz[0], "y": xyz[1], "z": z}


def _about_z(angle: float) -> Message:
    return {"x": 0.0, "y": 0.0, "z": math.sin(angle / 2), "w": math.cos(angle / 2)}
