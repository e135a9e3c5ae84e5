"""Joint trajectories of a gantry.

Points are joined by cubics, as ros2_control's joint_trajectory_controller does for a trajectory
that has positions and velocities.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence

from simpy.events import Event

from floorplan import Gantry, UserError
from floorplan.files.dataclass import dataclass
from navigation import Motion, Piece
from navigation.motion import Cubic, State

from ..machines.gantry.robot import GantryRobot

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
        motion = motion_along(gantry.gantry, gantry.state, gantry.now, trajectory)
        return gantry.follow(motion)
    except TrajectoryError:
        raise
    except ValueError as why:
        raise TrajectoryError(f"out of range: {why}") from None


def target_in(gantry: Gantry, trajectory: JointTrajectory) -> tuple[float, float, float] | None:
    """Return the target (x, y, rotation) of a trajectory of one point without a time, or None."""
    points, order = trajectory.points, _order(trajectory.names)
    if len(points) != 1 or points[0].time or points[0].velocities:
        return None
    return pose_of(gantry, _ordered("positions", points[0].positions, order, 0))


def motion_along(gantry: Gantry, current: State, now: float, trajectory: JointTrajectory) -> Motion:
    """Return the motion along a trajectory that begins at `now` (s) in the state `current`.

    `TrajectoryError` if it names other joints, jumps, leaves the range of the gantry, exceeds its
    limits, or does not end at rest.
    """
    pieces = []
    times, positions, velocities = _knots(gantry, current, trajectory)
    for a, b in itertools.pairwise(range(len(times))):
        cubics = [
            _cubic(times[b] - times[a], *ends)
            for ends in zip(positions[a], velocities[a], positions[b], velocities[b], strict=True)
        ]
        piece = Piece(now + times[a], now + times[b], *_in_the_world(gantry, cubics))
        _require_possible(gantry, piece, times[a])
        pieces.append(piece)
    return Motion(tuple(pieces))


def _knots(
    gantry: Gantry, current: State, trajectory: JointTrajectory
) -> tuple[list[float], list[JointValues], list[JointValues]]:
    """Return times, positions and velocities of the start and of the points after it."""
    order, points = _order(trajectory.names), trajectory.points
    if not points:
        raise TrajectoryError("a trajectory without points")
    times: list[float] = [0.0]
    positions: list[JointValues] = [joint_values(gantry, current.position)]
    specified: list[JointValues | None] = [joint_values(gantry, current.velocity, origin=False)]
    for k, point in enumerate(points):
        time, at = point.time, _ordered("positions", point.positions, order, k)
        speeds = _ordered("velocities", point.velocities, order, k) if point.velocities else None
        if k == 0 and time == 0.0:
            # A controller that repeats where the gantry is means no jump, but knows the place only
            # nearly.
            off = max(abs(a - b) for a, b in zip(positions[0], at, strict=True))
            if off > TOLERANCE:
                raise TrajectoryError(
                    f"it begins {off:.3f} m or rad from where the gantry is; give its first point"
                    " a time_from_start to get there"
                )
            continue
        if not time > times[-1]:
            raise TrajectoryError(f"points[{k}] comes at {time:g} s, not after {times[-1]:g} s")
        times.append(time)
        positions.append(at)
        specified.append(speeds)
    if len(times) == 1:
        raise TrajectoryError("a trajectory that ends where it begins")
    if any(abs(v) > TOLERANCE for v in specified[-1] or ()):
        raise TrajectoryError("it does not end at rest")
    specified[-1] = (0.0,) * len(JOINTS)
    velocities = [
        _towards_neighbours(times, positions, k) if velocity is None else velocity
        for k, velocity in enumerate(specified)
    ]
    return times, positions, velocities


def _towards_neighbours(
    times: Sequence[float], positions: Sequence[JointValues], k: int
) -> JointValues:
    """Velocities from the point before to the point after, none for a joint that turns round."""
    duration = times[k + 1] - times[k - 1]
    return tuple(
        (c - a) / duration if (b - a) * (c - b) > 0 else 0.0
        for a, b, c in zip(*positions[k - 1 : k + 2], strict=True)
    )


def _order(names: Sequence[str]) -> list[int]:
    """Return the index in a message of each joint of the gantry."""
    if sorted(names) != sorted(JOINTS):
        raise TrajectoryError(f"joint_names should be {', '.join(JOINTS)}, in any order")
    return [names.index(name) for name in JOINTS]


def _ordered(field: str, values: JointValues, order: list[int], k: int) -> JointValues:
    if len(values) != len(order):
        raise TrajectoryError(f"points[{k}] has {len(values)} {field} for {len(order)} joints")
    return tuple(values[j] for j in order)


def _cubic(duration: float, p: float, v: float, q: float, w: float) -> Cubic:
    """Return the Hermite cubic from position `p` and velocity `v` to `q` and `w`."""
    slope = (q - p) / duration
    return (p, v, (3 * slope - 2 * v - w) / duration, (v + w - 2 * slope) / duration**2)


def _in_the_world(gantry: Gantry, cubics: Sequence[Cubic]) -> tuple[Cubic, Cubic, Cubic]:
    """x, y and rotation in the world from those of the joints."""
    starts = pose_of(gantry, [cubic[0] for cubic in cubics])
    signs = pose_of(gantry, (1.0, 1.0, 1.0), origin=False)
    x, y, rotation = (
        (start, sign * cubic[1], sign * cubic[2], sign * cubic[3])
        for start, sign, cubic in zip(starts, signs, cubics, strict=True)
    )
    return x, y, rotation


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
                if abs(_value(rate, u)) > limit * (1 + TOLERANCE):
                    raise TrajectoryError(
                        f"{name} would {verb} {abs(_value(rate, u)):.3g} {per} at"
                        f" {begin + u:.3g} s; {limit:.3g} {per} is the most"
                    )
    for u in (u for cubic in cubics for u in _extremes(cubic, duration)):
        x, y, rotation = (_value(cubic, u) for cubic in cubics)
        faults = gantry.faults((x, y, rotation))
        if faults:
            raise TrajectoryError(faults[0])


def _value(c: Cubic, u: float) -> float:
    return c[0] + u * (c[1] + u * (c[2] + u * c[3]))


def _derivative(c: Cubic) -> Cubic:
    return (c[1], 2 * c[2], 3 * c[3], 0.0)


def _extremes(cubic: Cubic, duration: float) -> Iterator[float]:
    """Yield the times at which a cubic may have an extremum: its ends and its stationary points."""
    yield 0.0
    yield duration
    _, b, c, d = cubic
    turns: list[float] = []
    if d:
        # Zeros of b + 2 c u + 3 d u²: (-c ± √(c² - 3 b d)) / (3 d).
        root = c * c - 3 * b * d
        turns = [(-c + sign * math.sqrt(root)) / (3 * d) for sign in (1, -1) if root >= 0]
    elif c:
        turns = [-b / (2 * c)]
    yield from (u for u in turns if 0 < u < duration)


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
