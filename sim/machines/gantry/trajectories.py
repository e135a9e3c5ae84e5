"""Joint trajectories of a gantry.

Points are joined by cubics, as ros2_control's joint_trajectory_controller does for a trajectory
that has positions and velocities.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

from simpy.events import Event

from floorplan import Gantry, UserError
from floorplan.files.dataclass import dataclass
from navigation import Motion, Piece
from navigation.motion import Cubic, State, value

from .robot import GantryRobot

JOINTS = ("gantry_x_axis_joint", "gantry_y_axis_joint", "gantry_rotation_joint")
"""Joints of the ceiling robot of ARIAC 2023 that the gantry has."""

TOLERANCE = 0.01
"""Share by which a trajectory may exceed a limit, and distance (m or rad) of its start."""

JointValues = tuple[float, ...]
"""A value of each joint: m, rad, or m/s, rad/s."""


class TrajectoryError(UserError):
    """Trajectory that the gantry cannot follow, with the joint or point and the reason."""


@dataclass(frozen=True)
class JointPoint:
    """Point of a joint trajectory.

    Parameters
    ----------
    positions : tuple of float
        Position of each joint in m or rad.
    velocities : tuple of float, optional
        Velocity of each joint in m/s or rad/s. Without velocities, they follow from the points.
    time : float, optional
        Time since the start in seconds.
    """

    positions: JointValues
    velocities: JointValues = ()
    time: float = 0.0


@dataclass(frozen=True)
class JointTrajectory:
    """Joint trajectory of a gantry, which ends at rest.

    Parameters
    ----------
    names : tuple of str
        Names of the joints.
    points : tuple of JointPoint
        Points. A single point without a time is a target, reached as fast as possible.
    """

    names: tuple[str, ...]
    points: tuple[JointPoint, ...]


def follow(gantry: GantryRobot, trajectory: JointTrajectory) -> Event:
    """Follow a trajectory, and return the event of its end. `TrajectoryError` if it is invalid."""
    if not isinstance(trajectory, JointTrajectory):
        raise TrajectoryError("expected a JointTrajectory")
    if gantry.disabled:
        raise TrajectoryError("the gantry is disabled")
    target = target_in(gantry.gantry, trajectory)
    try:
        if target is not None:
            return gantry.move_to(*target, resume=False)
        return gantry.follow(motion_along(gantry.gantry, gantry.state, gantry.now, trajectory))
    except TrajectoryError:
        raise
    except ValueError as why:
        raise TrajectoryError(f"out of range: {why}") from None


def target_in(gantry: Gantry, trajectory: JointTrajectory) -> tuple[float, float, float] | None:
    """Return the target (x, y, rotation) of a trajectory of one point without a time, or None."""
    points = trajectory.points
    if len(points) != 1 or points[0].time or points[0].velocities:
        return None
    return pose_of(gantry, _ordered(trajectory.names, "positions", points[0].positions, 0))


def motion_along(gantry: Gantry, current: State, now: float, trajectory: JointTrajectory) -> Motion:
    """Return the motion along a trajectory that begins at `now` (s) in the state `current`.

    `TrajectoryError` if it names other joints, jumps, leaves the range of the gantry, exceeds its
    limits, or does not end at rest.
    """
    pieces = []
    for a, b in itertools.pairwise(_knots(gantry, current, trajectory)):
        x, y, rotation = (
            _cubic(b.time - a.time, *ends)
            for ends in zip(a.position, a.velocity, b.position, b.velocity, strict=True)
        )
        piece = Piece(now + a.time, now + b.time, x, y, rotation)
        _require_possible(gantry, piece, a.time)
        pieces.append(piece)
    return Motion(tuple(pieces))


class _Knot(NamedTuple):
    """Time since the start (s), pose and velocity of the gantry in the world."""

    time: float
    position: JointValues
    velocity: JointValues


def _knots(gantry: Gantry, current: State, trajectory: JointTrajectory) -> list[_Knot]:
    """Return the start of a motion, and the points after it."""
    names, points = trajectory.names, trajectory.points
    if not points:
        raise TrajectoryError("a trajectory without points")
    times, positions = [0.0], [current.position]
    velocities: list[JointValues | None] = [current.velocity]
    for k, point in enumerate(points):
        position = pose_of(gantry, _ordered(names, "positions", point.positions, k))
        velocity = None
        if point.velocities:
            speeds = _ordered(names, "velocities", point.velocities, k)
            velocity = pose_of(gantry, speeds, origin=False)
        if k == 0 and point.time == 0.0:
            # A controller that repeats the pose of the gantry knows it only approximately.
            off = max(abs(a - b) for a, b in zip(positions[0], position, strict=True))
            if off > TOLERANCE:
                raise TrajectoryError(
                    f"it begins {off:.3f} m or rad from where the gantry is; give its first point"
                    " a time_from_start to get there"
                )
            continue
        if not point.time > times[-1]:
            raise TrajectoryError(
                f"points[{k}] comes at {point.time:g} s, not after {times[-1]:g} s"
            )
        times.append(point.time)
        positions.append(position)
        velocities.append(velocity)
    if len(times) == 1:
        raise TrajectoryError("a trajectory that ends where it begins")
    if any(abs(v) > TOLERANCE for v in velocities[-1] or ()):
        raise TrajectoryError("it does not end at rest")
    velocities[-1] = (0.0,) * len(JOINTS)
    return [
        _Knot(times[k], positions[k], velocity or _towards_neighbours(times, positions, k))
        for k, velocity in enumerate(velocities)
    ]


def _towards_neighbours(
    times: Sequence[float], positions: Sequence[JointValues], k: int
) -> JointValues:
    """Velocities from the point before to the point after, none for a joint that turns round."""
    duration = times[k + 1] - times[k - 1]
    return tuple(
        (c - a) / duration if (b - a) * (c - b) > 0 else 0.0
        for a, b, c in zip(*positions[k - 1 : k + 2], strict=True)
    )


def _ordered(names: Sequence[str], field: str, values: JointValues, k: int) -> JointValues:
    """Return values of joints with `names` in the order of the gantry's joints."""
    if sorted(names) != sorted(JOINTS):
        raise TrajectoryError(f"joint_names should be {', '.join(JOINTS)}, in any order")
    if len(values) != len(JOINTS):
        raise TrajectoryError(f"points[{k}] has {len(values)} {field} for {len(JOINTS)} joints")
    return tuple(values[names.index(name)] for name in JOINTS)


def _cubic(duration: float, p: float, v: float, q: float, w: float) -> Cubic:
    """Return the Hermite cubic from position `p` and velocity `v` to `q` and `w`."""
    slope = (q - p) / duration
    return (p, v, (3 * slope - 2 * v - w) / duration, (v + w - 2 * slope) / duration**2)


def _require_possible(gantry: Gantry, piece: Piece, begin: float) -> None:
    """Check speeds, accelerations and the range, at the points and between them."""
    duration = piece.end - piece.begin
    cubics = (piece.x, piece.y, piece.rotation)
    for name, axis, cubic in zip(JOINTS, gantry.axes, cubics, strict=True):
        unit = "rad" if name.endswith("rotation_joint") else "m"
        speed = _derivative(cubic)
        for rate, limit, verb, per in (
            (speed, axis.max_speed, "move at", f"{unit}/s"),
            (_derivative(speed), axis.max_acceleration, "accelerate by", f"{unit}/s²"),
        ):
            for u in _extremes(rate, duration):
                if abs(value(rate, u)) > limit * (1 + TOLERANCE):
                    raise TrajectoryError(
                        f"{name} would {verb} {abs(value(rate, u)):.3g} {per} at"
                        f" {begin + u:.3g} s; {limit:.3g} {per} is the most"
                    )
    for u in (u for cubic in cubics for u in _extremes(cubic, duration)):
        x, y, rotation = (value(cubic, u) for cubic in cubics)
        if faults := gantry.faults((x, y, rotation)):
            raise TrajectoryError(faults[0])


def _derivative(c: Cubic) -> Cubic:
    return (c[1], 2 * c[2], 3 * c[3], 0.0)


def _extremes(cubic: Cubic, duration: float) -> list[float]:
    """Return the times at which a cubic may have an extremum: its ends and stationary points."""
    _, b, c, d = cubic
    turns: list[float] = []
    if d:
        # Zeros of b + 2 c u + 3 d u²: (-c ± √(c² - 3 b d)) / (3 d).
        root = c * c - 3 * b * d
        turns = [(-c + sign * math.sqrt(root)) / (3 * d) for sign in (1, -1) if root >= 0]
    elif c:
        turns = [-b / (2 * c)]
    return [0.0, duration, *(u for u in turns if 0 < u < duration)]


def joint_values(
    gantry: Gantry, pose: Sequence[float], *, origin: bool = True
) -> tuple[float, float, float]:
    """Return the gantry's joints at x, y, rotation in the world, as the competition has them.

    They are zero in the middle of the rails, and the y axis points along the world's −y. Without
    `origin`, `pose` is a velocity.
    """
    middle_x, middle_y = _middle(gantry) if origin else (0.0, 0.0)
    x, y, rotation = pose
    return (x - middle_x, middle_y - y, rotation)


def pose_of(
    gantry: Gantry, joints: Sequence[float], *, origin: bool = True
) -> tuple[float, float, float]:
    """Return x, y, rotation in the world at these joints: the inverse of `joint_values`."""
    middle_x, middle_y = _middle(gantry) if origin else (0.0, 0.0)
    x, y, rotation = joints
    return (x + middle_x, middle_y - y, rotation)


def _middle(gantry: Gantry) -> tuple[float, float]:
    return ((gantry.x.low + gantry.x.high) / 2, (gantry.y.low + gantry.y.high) / 2)
