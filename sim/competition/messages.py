"""States of people, machines and orders as messages of ROS 2 and ARIAC 2023."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from floorplan import Floorplan, Gantry, Lane
from navigation.machines import lane_state
from navigation.motion import State

from ..cell import Pose, Rejected, Scan, Velocity
from ..cell.signals import SCANS
from ..exports.scene import ROOT_FRAME
from ..machines.gantry.trajectories import JOINTS, joint_values
from ..orders.workload import AssemblyTask, KittingTask, Order, PartType

Message = dict[str, Any]

WORLD = "world"
"""Frame of the floor in the competition."""

LOCATIONS = ("kitting", "assembly_front", "assembly_back", "warehouse")
"""AGV locations of ariac_msgs/AGVStatus, by number."""

UNKNOWN_LOCATION = 99
"""Location of an AGV that drives or is elsewhere."""

NOWHERE = {"x": 1e6, "y": 1e6, "z": 0.0}
"""Position of the robot on a floor without one, far from all people."""

_AT_REST = 1e-6
"""Metres and m/s. An AGV this near to a location, and this slow, is there."""

_KINDS = ("kitting", "assembly", "combined")
_COLORS = ("red", "green", "blue", "orange", "purple")
_TYPES = {"battery": 10, "pump": 11, "sensor": 12, "regulator": 13}


def seconds(t: float) -> Message:
    """Return a time or duration (builtin_interfaces)."""
    whole, nanoseconds = divmod(round(t * 1e9), 1_000_000_000)
    return {"sec": whole, "nanosec": nanoseconds}


def seconds_of(stamp: Message) -> float:
    """Return a time or duration (builtin_interfaces) in seconds."""
    return float(stamp["sec"] + stamp["nanosec"] * 1e-9)


def header(t: float, frame: str = WORLD) -> Message:
    """Return std_msgs/Header of a time (s) and a frame."""
    return {"stamp": seconds(t), "frame_id": frame}


def pose_message(pose: Pose) -> Message:
    """Return geometry_msgs/Pose."""
    return {"position": vector((pose.x, pose.y)), "orientation": about_z(pose.heading)}


def pose_of(message: Message) -> Pose:
    """Return a geometry_msgs/Pose. Its heading is 0 without an orientation."""
    x, y, z, w = (message["orientation"][part] for part in "xyzw")
    norm = math.hypot(x, y, z, w)
    if not norm < math.inf:
        raise Rejected("orientation", (x, y, z, w), "must be a rotation")
    heading = math.atan2(2 * (w * z + x * y), norm * norm - 2 * (y * y + z * z))
    return Pose(message["position"]["x"], message["position"]["y"], heading)


def stamped_pose_of(
    message: Message, frame: str = "", floor: Sequence[str] = (ROOT_FRAME,)
) -> Pose:
    """Return a geometry_msgs/PoseStamped. `frame` applies if it has none.

    `Rejected` unless it is in a frame of the `floor`.
    """
    frame = message["header"]["frame_id"] or frame
    if frame and frame.lstrip("/") not in floor:
        raise Rejected("frame", frame, f"a pose must be in the frame {' or '.join(floor)}")
    return pose_of(message["pose"])


def twist_message(velocity: Velocity) -> Message:
    """Return geometry_msgs/Twist."""
    return {
        "linear": vector((velocity.x, velocity.y)),
        "angular": vector((0.0, 0.0), velocity.turn),
    }


def transform(t: float, parent: str, child: str, pose: Pose, z: float = 0.0) -> Message:
    """Return geometry_msgs/TransformStamped of a pose at a height (m) in the frame `parent`."""
    return {
        "header": header(t, parent),
        "child_frame_id": child,
        "transform": {
            "translation": vector((pose.x, pose.y), z),
            "rotation": about_z(pose.heading),
        },
    }


def odometry(t: float, frame: str, child: str, pose: Pose, velocity: Velocity) -> Message:
    """Return nav_msgs/Odometry. The velocity is in the frame of the body, `child`."""
    return {
        "header": header(t, frame),
        "child_frame_id": child,
        "pose": {"pose": pose_message(pose), "covariance": [0.0] * 36},
        "twist": {"twist": twist_message(velocity), "covariance": [0.0] * 36},
    }


def laser_scan(t: float, frame: str, scan: Scan) -> Message:
    """Return sensor_msgs/LaserScan. Ranges are the maximum where nothing is."""
    return {
        "header": header(t, frame),
        "angle_min": scan.first,
        "angle_max": scan.first + math.tau - scan.step,
        "angle_increment": scan.step,
        "time_increment": 0.0,
        "scan_time": 1 / SCANS,
        "range_min": 0.0,
        "range_max": scan.reach,
        "ranges": scan.distances.tolist(),
        "intensities": [],
    }


def human_state(person: State, robot: State | None, robot_height: float) -> Message:
    """Return ariac_msgs/HumanState: positions (m) and velocities (m/s) of person and gantry."""
    return {
        "human_position": vector(person.position),
        "robot_position": vector(robot.position, robot_height) if robot else NOWHERE,
        "human_velocity": vector(person.velocity),
        "robot_velocity": vector(robot.velocity) if robot else vector((0.0, 0.0, 0.0)),
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
        "header": header(t, ""),
        "name": list(JOINTS),
        "position": list(joint_values(gantry, state.position)),
        "velocity": list(joint_values(gantry, state.velocity, origin=False)),
        "effort": [],
    }


def order_message(order: Order, floor: Floorplan) -> Message:
    """Return ariac_msgs/Order, without the fields that are blank.

    The destination of a kit is a location of its AGV on this floor, or a station that it serves.
    """
    message: Message = {
        "id": order.id,
        "type": _KINDS.index(order.kind),
        "priority": order.priority,
    }
    task = order.task
    if isinstance(task, KittingTask):
        location = floor.lane(task.agv).serves.get(task.destination, task.destination)
        message["kitting_task"] = {
            "agv_number": _number_in(task.agv),
            "tray_id": task.tray,
            "destination": LOCATIONS.index(location),
            "parts": [
                {"part": _part(part), "quadrant": quadrant}
                for quadrant, part in sorted(task.products.items())
            ],
        }
    else:
        parts = [{"part": _part(part)} for part in task.products]
        work: Message = {"station": _number_in(task.station), "parts": parts}
        if isinstance(task, AssemblyTask):
            work["agv_numbers"] = [_number_in(agv) for agv in task.agvs]
        message[f"{order.kind}_task"] = work
    return message


def _part(part: PartType) -> dict[str, int]:
    return {"color": _COLORS.index(part.color), "type": _TYPES[part.type]}


def _number_in(name: str) -> int:
    """Return the number in a name: agv3 is 3, as2 is 2."""
    return int("".join(filter(str.isdigit, name)))


def vector(xyz: Sequence[float], z: float = 0.0) -> Message:
    """Return geometry_msgs/Point or Vector3. `z` replaces the third number, a rotation."""
    return {"x": xyz[0], "y": xyz[1], "z": z}


def about_z(angle: float) -> Message:
    """Return geometry_msgs/Quaternion of a rotation about the z axis (rad)."""
    return {"x": 0.0, "y": 0.0, "z": math.sin(angle / 2), "w": math.cos(angle / 2)}
