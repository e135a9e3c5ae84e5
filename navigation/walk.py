"""Motions of people along paths, slowed at corners."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from math import isfinite
from typing import TypeGuard

import numpy as np
from numpy.typing import ArrayLike

from .kernels.pieces import along_legs
from .motion import Motion, Piece, State, TablePieces, standing, value
from .profiles import NOWHERE, AxisLimits, Phases, along_line

MAX_SPEED = 1.0
"""m/s. A person's top speed where nothing else is said."""

MAX_ACCELERATION = 2.5
"""m/s². A person's acceleration where nothing else is said."""

CORNER_DEVIATION = 0.05
"""Metres. How far a rounded corner may leave the path when its top speed is worked out."""

_HAIR = 1e-6
"""Speeds are planned with this share less of the acceleration, so that rounding can't make a
profile infeasible."""

Corner = tuple[float, float]


def walk(
    points: ArrayLike,
    start: float = 0.0,
    *,
    max_speed: float = MAX_SPEED,
    max_acceleration: float = MAX_ACCELERATION,
    initial_speed: float = 0.0,
) -> Motion:
    """Return a walk along `points` ((N, 2), metres) that begins at `start` (seconds).

    It sets out at `initial_speed` (m/s) along the path and ends at rest; its speed never exceeds
    `max_speed` nor changes faster than `max_acceleration`, and at every corner it is at most
    `corner_speed`. The rotation is the heading. `ValueError` if the points are not finite, or if
    the path is too short to come to rest from `initial_speed`.
    """
    corners = _corners(points)
    limits = AxisLimits(max_speed, max_acceleration)
    if len(corners) == 1:
        if initial_speed > 0:
            raise ValueError("a path of no length is too short to come to rest on")
        return standing(corners[0], start=start)
    lengths = [math.dist(a, b) for a, b in itertools.pairwise(corners)]
    speeds = _corner_speeds(corners, lengths, limits, initial_speed)
    flat = [c for corner in corners for c in corner]
    table = along_legs(flat, lengths, speeds, max_speed, max_acceleration, float(start))
    return Motion(TablePieces(table))


def stop_walking(motion: Motion, t: float, *, max_acceleration: float = MAX_ACCELERATION) -> Motion:
    """Return the walk `motion` broken off at `t` (seconds).

    It brakes at `max_acceleration` (m/s²) along its own path.
    """
    t = float(t)
    state = motion.state(t)
    # v² / (2 a): on a straight line that is all it takes, and corners ahead were taken slower.
    braking = state.speed**2 / (2 * max_acceleration * (1 - _HAIR))
    corners = _first(remaining_path(motion, t), braking)
    if braking < NOWHERE or len(corners) < 2:
        x, y, heading = state.position
        return standing((x, y), heading=heading, start=t)
    lengths = [math.dist(a, b) for a, b in itertools.pairwise(corners)]
    # What the legs' rounded lengths leave: it comes to rest at their end, neither before nor after.
    deceleration = state.speed**2 / (2 * sum(lengths))
    pieces: list[Piece] = []
    speed, left = state.speed, sum(lengths)
    for (a, b), length in zip(itertools.pairwise(corners), lengths, strict=True):
        left -= length
        slower = math.sqrt(max(2 * deceleration * left, 0.0)) if b is not corners[-1] else 0.0
        phase = ((speed - slower) / deceleration, (0.0, speed, -deceleration / 2, 0.0))
        pieces += _on_leg(a, b, [phase], pieces[-1].end if pieces else t)
        speed = slower
    return Motion(tuple(pieces))


def remaining_path(motion: Motion, t: float) -> list[Corner]:
    """Return the corners of the walk `motion` still to come at `t` (s), after where it is then."""
    ahead = [piece for piece in motion.pieces if piece.end > t]
    corners = [motion.state(t).at]
    corners += [
        (value(piece.x, u), value(piece.y, u))
        for piece in ahead
        for u in (piece.end - piece.begin,)
    ]
    return _corners(corners)


def corner_speed(
    before: tuple[float, float],
    corner: tuple[float, float],
    after: tuple[float, float],
    max_acceleration: float = MAX_ACCELERATION,
) -> float:
    """The speed (m/s) at which a person turns at `corner` on the path from `before` to `after`.

    The corner is taken as an arc that leaves it by at most `CORNER_DEVIATION` and is no longer
    than half of each leg; on an arc of radius r, the speed is √(a r), where a is
    `max_acceleration` (m/s²). This is the junction
    deviation of machine tool controllers (S. K. Jeon, "Improving Grbl: Cornering Algorithm",
    2011). Infinite where the path goes straight on, 0 where it turns back.
    """
    ux, uy = corner[0] - before[0], corner[1] - before[1]
    wx, wy = after[0] - corner[0], after[1] - corner[1]
    turn = abs(math.atan2(ux * wy - uy * wx, ux * wx + uy * wy))
    if turn < 1e-9:
        return math.inf
    if turn > math.pi - 1e-9:
        return 0.0
    half = math.cos(turn / 2)
    # An arc of radius r inside a corner leaves it by r (1 / cos(turn / 2) − 1), and takes r
    # tan(turn / 2) of both legs; 1 − cos φ is 2 sin² (φ / 2), which loses nothing for small φ.
    by_deviation = CORNER_DEVIATION * half / (2 * math.sin(turn / 4) ** 2)
    by_length = min(math.hypot(ux, uy), math.hypot(wx, wy)) / 2 / math.tan(turn / 2)
    return math.sqrt(max_acceleration * min(by_deviation, by_length))


def can_go_on(state: State, towards: tuple[float, float], max_acceleration: float) -> bool:
    """Return whether a person in `state` may turn `towards` a point without slowing down first.

    That is so where the turn takes no more than `max_acceleration` (m/s²).
    """
    if state.speed == 0.0:
        return True
    x, y = state.at
    before = (x - state.velocity[0], y - state.velocity[1])
    return state.speed <= corner_speed(before, (x, y), towards, max_acceleration)


def _corner_speeds(
    corners: list[Corner], lengths: list[float], limits: AxisLimits, initial_speed: float
) -> list[float]:
    """Return the speed at every corner: as fast as its own limit and the acceleration allow."""
    acceleration = limits.max_acceleration
    speeds = [initial_speed]
    for k in range(1, len(corners) - 1):
        top = corner_speed(corners[k - 1], corners[k], corners[k + 1], acceleration)
        speeds.append(min(top, limits.max_speed))
    speeds.append(0.0)
    gain = 2 * acceleration * (1 - _HAIR)
    # Backwards for slowing down, forwards for speeding up; together the fastest that is feasible.
    for k in range(len(lengths) - 1, -1, -1):
        speeds[k] = min(speeds[k], math.sqrt(speeds[k + 1] ** 2 + gain * lengths[k]))
    if speeds[0] < initial_speed * (1 - _HAIR):
        raise ValueError(
            f"the path is too short to slow down from {initial_speed:g} m/s"
            f" at {acceleration:g} m/s²"
        )
    for k, length in enumerate(lengths):
        speeds[k + 1] = min(speeds[k + 1], math.sqrt(speeds[k] ** 2 + gain * length))
    return speeds


def _on_leg(a: Corner, b: Corner, phases: Phases, start: float) -> list[Piece]:
    """Return the pieces from `a` to `b`, with the metres gone in phases of time."""
    length = math.dist(a, b)
    direction = ((b[0] - a[0]) / length, (b[1] - a[1]) / length)
    heading = math.atan2(b[1] - a[1], b[0] - a[0])
    return along_line(a, direction, heading, phases, start)


def _corners(points: ArrayLike) -> list[Corner]:
    """Return `points` without repetitions and without those on the straight line between others."""
    if isinstance(points, list) and points and all(map(is_place, points)):
        return _bends(points)
    array = np.asarray(points, dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != 2 or len(array) == 0:
        raise ValueError(f"a path needs points of shape (N, 2), not {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError("a path needs finite points")
    return _bends([(x, y) for x, y in array.tolist()])


def is_place(point: object) -> TypeGuard[Corner]:
    """Return whether `point` is a tuple of two finite floats, as most places are."""
    if not isinstance(point, tuple) or len(point) != 2:
        return False
    x, y = point
    return x.__class__ is y.__class__ is float and isfinite(x) and isfinite(y)


def _bends(points: list[Corner]) -> list[Corner]:
    corners: list[Corner] = []
    for point in points:
        if corners and math.dist(corners[-1], point) < NOWHERE:
            continue
        if len(corners) > 1 and _straight(corners[-2], corners[-1], point):
            corners.pop()
        corners.append(point)
    return corners


def _straight(a: Corner, b: Corner, c: Corner) -> bool:
    ux, uy, wx, wy = b[0] - a[0], b[1] - a[1], c[0] - b[0], c[1] - b[1]
    return ux * wx + uy * wy > 0 and abs(ux * wy - uy * wx) < 1e-9 * math.hypot(wx, wy)


def _first(corners: Sequence[Corner], length: float) -> list[Corner]:
    """Return the first `length` metres of a path, or all of it; right to `NOWHERE`."""
    kept = [corners[0]]
    for a, b in itertools.pairwise(corners):
        leg = math.dist(a, b)
        if leg >= length + NOWHERE:
            share = length / leg
            kept.append((a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])))
            break
        kept.append(b)
        length -= leg
        if length <= NOWHERE:
            break
    return kept
