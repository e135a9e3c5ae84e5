"""What the sensors of the workcell read, as ROS messages."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

from floorplan import Gantry, Lane
from navigation import State, lane_state

from ..core.body import Body

Message = dict[str, Any]
Values = tuple[float, float, float]

LOCATIONS = ("kitting", "assembly_front", "assembly_back", "warehouse")
"""The AGV locations of ariac_msgs/AGVStatus, by number."""

UNKNOWN_LOCATION = 99
"""An AGV that drives, or stands somewhere else."""

JOINTS = ("gantry_x_axis_joint", "gantry_y_axis_joint", "gantry_rotation_joint")
"""The joints of the competition's ceiling robot that we move."""

NOWHERE = {"x": 1e6, "y": 1e6, "z": 0.0}
"""Where the robot of a floor without one is: too far from anybody to matter."""

_AT_REST = 1e-6
"""Metres and metres a second. An AGV that is nearer to a location, and slower, stands there."""


def seconds(t: float) -> Message:
    """A time or a duration (builtin_interfaces)."""
    whole, nanoseconds = divmod(round(t * 1e9), 1_000_000_000)
    return {"sec": whole, "nanosec": nanoseconds}


def human_state(person: State, robot: State | None, robot_height: float) -> Message:
    """ariac_msgs/HumanState: positions (m) and velocities (m/s) of a person and the gantry."""
    return {
        "human_position": _vector(person.position),
        "robot_position": _vector(robot.position, robot_height) if robot else NOWHERE,
        "human_velocity": _vector(person.velocity),
        "robot_velocity": _vector(robot.velocity) if robot else _vector((0.0, 0.0, 0.0)),
    }


def transforms(t: float, frames: Iterable[tuple[str, Body, float]]) -> Message:
    """tf2_msgs/TFMessage: from the world to each frame, (name, body, height in metres)."""
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
    """ariac_msgs/AGVStatus: which location it stands at, its lane position (m) and speed (m/s)."""
    q = lane_state(lane, state)
    location = UNKNOWN_LOCATION
    for number, name in enumerate(LOCATIONS):
        place = lane.locations.get(name)
        if place is not None and abs(place - q.position) < _AT_REST and abs(q.velocity) < _AT_REST:
            location = number
    return {"location": location, "position": q.position, "velocity": q.velocity}


def joint_state(t: float, gantry: Gantry, state: State) -> Message:
    """sensor_msgs/JointState of the gantry's joints (m, rad, and m/s, rad/s)."""
    return {
        "header": {"stamp": seconds(t), "frame_id": ""},
        "name": list(JOINTS),
        "position": list(joint_values(gantry, state.position)),
        "velocity": list(joint_values(gantry, state.velocity, origin=False)),
        "effort": [],
    }


def joint_values(gantry: Gantry, pose: Sequence[float], *, origin: bool = True) -> Values:
    """The gantry's joints at x, y, rotation in the world, as the competition has them.

    They are zero in the middle of the rails, and that for y points along the world's −y. Without
    `origin`, a velocity is taken for a velocity.
    """
    middle_x, middle_y = _middle(gantry) if origin else (0.0, 0.0)
    x, y, rotation = pose
    return (x - middle_x, middle_y - y, rotation)


def pose_of(gantry: Gantry, joints: Sequence[float], *, origin: bool = True) -> Values:
    """x, y, rotation in the world where the joints are so: the inverse of `joint_values`."""
    middle_x, middle_y = _middle(gantry) if origin else (0.0, 0.0)
    x, y, rotation = joints
    return (x + middle_x, middle_y - y, rotation)


def _middle(gantry: Gantry) -> tuple[float, float]:
    return ((gantry.x.low + gantry.x.high) / 2, (gantry.y.low + gantry.y.high) / 2)


def _vector(xyz: tuple[float, float, float], z: float = 0.0) -> Message:
    return {"x": xyz[0], "y": xyz[1], "z": z}


def _about_z(angle: float) -> Message:
    return {"x": 0.0, "y": 0.0, "z": math.sin(angle / 2), "w": math.cos(angle / 2)}
