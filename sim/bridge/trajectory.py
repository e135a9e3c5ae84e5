"""Joint trajectories: from a trajectory_msgs/JointTrajectory to a motion of the gantry.

As ros2_control's joint_trajectory_controller interpolates one that has positions and velocities:
a cubic from point to point.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from floorplan import Axis, Gantry
from navigation import Cubic, Motion, Piece, State

from .readings import JOINTS, joint_values, pose_of

TOLERANCE = 0.01
"""Share of a limit by which a trajectory may exceed it; metres or radians it may begin off."""


class TrajectoryError(ValueError):
    """A trajectory that the gantry can't follow; says where and why."""


@dataclass(frozen=True)
class Knot:
    """Where the joints are at `time` (seconds from the start), and how fast (m/s, rad/s)."""

    time: float
    positions: tuple[float, ...]
    velocities: tuple[float, ...]


def target_of(gantry: Gantry, message: dict[str, Any]) -> tuple[float, float, float] | None:
    """Where a trajectory of one point without a time wants the gantry: x, y, rotation."""
    points, order = message["points"], _order(message["joint_names"])
    if len(points) != 1 or _seconds(points[0]) or points[0]["velocities"]:
        return None
    return pose_of(gantry, _ordered(points[0]["positions"], order, "positions", 0))


def trajectory_motion(
    gantry: Gantry, current: State, now: float, message: dict[str, Any]
) -> Motion:
    """The motion along a trajectory that begins at `now` (seconds) in the state `current`.

    `TrajectoryError` where it asks for other joints, jumps, leaves the gantry's range, is faster or
    accelerates more than the gantry can, or does not end at rest.
    """
    pieces = []
    for a, b in itertools.pairwise(_knots(gantry, current, message)):
        cubics = [_cubic(a, b, joint) for joint in range(len(JOINTS))]
        for name, axis, cubic in zip(JOINTS, gantry.axes, cubics, strict=True):
            _require_possible(name, axis, cubic, a.time, b.time)
        pieces.append(Piece(now + a.time, now + b.time, *_in_the_world(gantry, cubics)))
        _require_in_range(gantry, pieces[-1])
    return Motion(tuple(pieces))


def _knots(gantry: Gantry, current: State, message: dict[str, Any]) -> list[Knot]:
    """The start, and the points that come after it."""
    order, points = _order(message["joint_names"]), message["points"]
    if not points:
        raise TrajectoryError("a trajectory without points")
    times = [_seconds(point) for point in points]
    positions = [
        _ordered(point["positions"], order, "positions", k) for k, point in enumerate(points)
    ]
    here = joint_values(gantry, current.position)
    speed = joint_values(gantry, current.velocity, origin=False)
    given = [
        _ordered(point["velocities"], order, "velocities", k) if point["velocities"] else None
        for k, point in enumerate(points)
    ]
    if times[0] == 0.0:
        off = max(abs(a - b) for a, b in zip(here, positions[0], strict=True))
        if off > TOLERANCE:
            raise TrajectoryError(
                f"it begins {off:.3f} m or rad from where the gantry is; give its first point a"
                " time_from_start to get there"
            )
        times, positions, given = times[1:], positions[1:], given[1:]
    if not times:
        raise TrajectoryError("a trajectory that ends where it begins")
    for k, (before, after) in enumerate(zip([0.0, *times], times, strict=False)):
        if not after > before:
            raise TrajectoryError(f"points[{k}] comes at {after:g} s, not after {before:g} s")
    velocities = _velocities([0.0, *times], [here, *positions], [speed, *given])
    if any(abs(v) > TOLERANCE for v in velocities[-1]):
        raise TrajectoryError("it does not end at rest")
    velocities[-1] = (0.0,) * len(JOINTS)
    return [Knot(*knot) for knot in zip([0.0, *times], [here, *positions], velocities, strict=True)]


def _velocities(
    times: Sequence[float],
    positions: Sequence[tuple[float, ...]],
    given: Sequence[tuple[float, ...] | None],
) -> list[tuple[float, ...]]:
    """Those given; else those towards the neighbours, and none at the end or where it turns."""
    found: list[tuple[float, ...]] = []
    for k, velocities in enumerate(given):
        if velocities is not None:
            found.append(velocities)
        elif k == len(given) - 1:
            found.append((0.0,) * len(JOINTS))
        else:
            before, at, after = positions[k - 1], positions[k], positions[k + 1]
            duration = times[k + 1] - times[k - 1]
            found.append(
                tuple(
                    (c - a) / duration if (b - a) * (c - b) > 0 else 0.0
                    for a, b, c in zip(before, at, after, strict=True)
                )
            )
    return found


def _order(names: list[str]) -> list[int]:
    """Where each of our joints is in a message."""
    if sorted(names) != sorted(JOINTS):
        raise TrajectoryError(f"joint_names should be {', '.join(JOINTS)}, in any order")
    return [names.index(name) for name in JOINTS]


def _ordered(values: list[float], order: list[int], what: str, k: int) -> tuple[float, ...]:
    if len(values) != len(order):
        raise TrajectoryError(f"points[{k}] has {len(values)} {what} for {len(order)} joints")
    return tuple(values[j] for j in order)


def _seconds(point: dict[str, Any]) -> float:
    duration = point["time_from_start"]
    return float(duration["sec"] + duration["nanosec"] / 1e9)


def _cubic(a: Knot, b: Knot, joint: int) -> Cubic:
    """The cubic of one joint from knot to knot."""
    duration = b.time - a.time
    p, v, w = a.positions[joint], a.velocities[joint], b.velocities[joint]
    slope = (b.positions[joint] - p) / duration
    return (p, v, (3 * slope - 2 * v - w) / duration, (v + w - 2 * slope) / duration**2)


def _require_possible(name: str, axis: Axis, cubic: Cubic, begin: float, end: float) -> None:
    unit = "rad" if name.endswith("rotation_joint") else "m"
    for u in _critical(cubic[1:], end - begin):
        speed = abs(cubic[1] + u * (2 * cubic[2] + u * 3 * cubic[3]))
        if speed > axis.max_speed * (1 + TOLERANCE):
            raise TrajectoryError(
                f"{name} would move at {speed:.3g} {unit}/s at {begin + u:.3g} s;"
                f" {axis.max_speed:.3g} {unit}/s is the most"
            )
    for u in (0.0, end - begin):
        acceleration = abs(2 * cubic[2] + 6 * cubic[3] * u)
        if acceleration > axis.max_acceleration * (1 + TOLERANCE):
            raise TrajectoryError(
                f"{name} would accelerate by {acceleration:.3g} {unit}/s² at {begin + u:.3g} s;"
                f" {axis.max_acceleration:.3g} {unit}/s² is the most"
            )


def _critical(derivative: tuple[float, float, float], duration: float) -> Iterator[float]:
    """Where the speed of a cubic may be greatest: its ends, and where it does not accelerate."""
    yield 0.0
    yield duration
    _, second, third = derivative
    if third:
        turning = -second / (3 * third)
        if 0 < turning < duration:
            yield turning


def _require_in_range(gantry: Gantry, piece: Piece) -> None:
    """See that the gantry stays within its rails, between the points as well."""
    duration = piece.end - piece.begin
    for u in (0.0, duration, *_turns(piece, duration)):
        x, y, rotation = (
            c[0] + u * (c[1] + u * (c[2] + u * c[3])) for c in (piece.x, piece.y, piece.rotation)
        )
        faults = gantry.faults((x, y, rotation))
        if faults:
            raise TrajectoryError(faults[0])


def _turns(piece: Piece, duration: float) -> Iterator[float]:
    """Where one of the axes turns round."""
    for _, b, c, d in (piece.x, piece.y, piece.rotation):
        if d:
            root = c * c - 3 * b * d
            for sign in (1, -1) if root >= 0 else ():
                u = (-c + sign * math.sqrt(root)) / (3 * d)
                if 0 < u < duration:
                    yield u
        elif c:
            u = -b / (2 * c)
            if 0 < u < duration:
                yield u


def _in_the_world(gantry: Gantry, cubics: Sequence[Cubic]) -> tuple[Cubic, Cubic, Cubic]:
    """x, y and rotation in the world from those of the joints."""
    starts = pose_of(gantry, [cubic[0] for cubic in cubics])
    signs = pose_of(gantry, (1.0, 1.0, 1.0), origin=False)
    x, y, rotation = (
        (start, sign * cubic[1], sign * cubic[2], sign * cubic[3])
        for start, sign, cubic in zip(starts, signs, cubics, strict=True)
    )
    return x, y, rotation
