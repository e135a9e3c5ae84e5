"""Motions of people: walks along paths with limited speed at corners, and conflicts between walks.

Walks end with a stop of unlimited duration. Tables of plain numbers hold their positions for the
kernel of `discs`.

A person in a crowd compares many candidate paths, also with lower speeds. Candidates are swaths.
The chosen one becomes a motion.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .kernels import discs, walks
from .kernels.discs import Swath, swept
from .kernels.numbers import flat, numbers
from .kernels.pieces import along_legs
from .machines import AxisLimits
from .motion import Motion, State, TablePieces, motion_of, standing

Corner = tuple[float, float]


def swath_along(
    corners: Sequence[Corner],
    start: float,
    *,
    initial_speed: float = 0.0,
    top_speed: float | Sequence[float],
    max_speed: float,
    max_acceleration: float,
    lead: Swath | None = None,
    since: float | None = None,
) -> Swath | None:
    """Return the swath of the `walk` along `corners` at `top_speed`, from `start` on.

    It follows the walk `lead`, or a rest from `since` (s) on. None if the person cannot come to
    rest, or slow down enough for a corner.
    """
    return walks.walk_swath(
        flat([*corners]),
        numbers((top_speed,) if isinstance(top_speed, float | int) else top_speed),
        start if since is None else since,
        start,
        initial_speed,
        max_speed,
        max_acceleration,
        lead,
    )


def motion_along(swath: Swath, heading: float) -> Motion:
    """Return the motion of a walk, turned to its direction, at first by `heading` (radians)."""
    return motion_of(walks.turned(swath.table, heading))


def swath(motion: Motion, begin: float) -> Swath:
    """Return the swath of `motion` from `begin` (seconds) on."""
    since = max(begin, motion.end)
    return swept(motion.table, begin, since, *motion.state(since).at)


def first_conflict(one: Swath, other: Swath, least: float, begin: float) -> float | None:
    """Return the first time from `begin` on at which two centres are closer than `least`.

    Both swaths reach back to `begin`. Units are seconds and metres. Return None if there is no such
    time. Distances that equal `least` within rounding may count as closer.
    """
    low_x, low_y, high_x, high_y = other.box
    a = one.box
    if (
        a[0] - high_x >= least
        or low_x - a[2] >= least
        or a[1] - high_y >= least
        or low_y - a[3] >= least
    ):
        return None
    t = discs.first_conflict(one.table, other.table, least, begin, math.inf)
    return None if t == math.inf else t


MAX_SPEED = 1.0
"""Default maximum speed of a person in m/s."""

MAX_ACCELERATION = 2.5
"""Default acceleration of a person in m/s²."""


def walk(
    points: ArrayLike,
    start: float = 0.0,
    *,
    max_speed: float = MAX_SPEED,
    max_acceleration: float = MAX_ACCELERATION,
    initial_speed: float = 0.0,
    top_speed: float | Sequence[float] | None = None,
) -> Motion:
    """Return the motion of a person who walks along a path and stops at its end.

    The rotation of the motion is the heading.

    Parameters
    ----------
    points : array_like
        Waypoints, shape (N, 2), in metres.
    start : float, optional
        Start time in seconds.
    max_speed, max_acceleration : float, optional
        Limits in m/s and m/s².
    initial_speed : float, optional
        Speed along the path at the start in m/s.
    top_speed : float or sequence of float, optional
        Speed limit in m/s, one for all segments or one for each. The person slows down to it as
        soon as `max_acceleration` permits, so `initial_speed` may exceed it.

    Returns
    -------
    Motion
        Motion that is stationary after the path.

    Raises
    ------
    ValueError
        If the points are not finite, a limit is not positive, or the path is too short to stop.

    Notes
    -----
    A corner is taken as an arc that leaves it by at most 0.05 m and is no longer than half of each
    segment. The speed on an arc of radius r is at most √(a r) with a the maximum acceleration. This
    is the junction deviation of machine tools (S. K. Jeon, "Improving Grbl: Cornering Algorithm",
    2011).

    Examples
    --------
    >>> from navigation import walk
    >>> motion = walk([(0.0, 0.0), (4.0, 0.0), (4.0, 3.0)], start=10.0)
    >>> motion.position(12.0)
    array([1.8, 0. ])
    """
    _check_limits(max_speed, max_acceleration)
    if top_speed is not None:
        swath = swath_along(
            [(x, y) for x, y in _checked(points).tolist()],
            float(start),
            initial_speed=initial_speed,
            top_speed=top_speed,
            max_speed=max_speed,
            max_acceleration=max_acceleration,
        )
        if swath is None:
            raise ValueError(f"the path is too short to slow down from {initial_speed:g} m/s")
        return motion_along(swath, 0.0)
    corners = _corners(points)
    if len(corners) == 1:
        if initial_speed > 0:
            raise ValueError("a path of no length is too short to come to rest on")
        return standing(corners[0], start=start)
    return _started(corners, max_speed, max_acceleration, initial_speed)(float(start))


def walk_at(
    points: ArrayLike, *, max_speed: float, max_acceleration: float
) -> Callable[[float], Motion]:
    """Return the walk along a path as a function of its start (seconds): see `walk`."""
    _check_limits(max_speed, max_acceleration)
    corners = _corners(points)
    if len(corners) == 1:
        return lambda start: standing(corners[0], start=start)
    return _started(corners, max_speed, max_acceleration, 0.0)


def _started(
    corners: list[Corner], max_speed: float, max_acceleration: float, initial_speed: float
) -> Callable[[float], Motion]:
    """Return the walk around corners as a function of its start."""
    lengths = walks.lengths_of(corners)
    speeds = walks.corner_speeds(corners, lengths, max_speed, max_acceleration, initial_speed)
    if not speeds:
        raise ValueError(
            f"the path is too short to slow down from {initial_speed:g} m/s"
            f" at {max_acceleration:g} m/s²"
        )

    def started(start: float) -> Motion:
        table = along_legs(corners, lengths, speeds, max_speed, max_acceleration, start)
        return Motion(TablePieces(table))

    return started


@lru_cache
def _check_limits(max_speed: float, max_acceleration: float) -> None:
    """Raise `ValueError` for invalid limits. Most people have the default ones."""
    AxisLimits(max_speed, max_acceleration)


def stop_walking(motion: Motion, t: float, *, max_acceleration: float = MAX_ACCELERATION) -> Motion:
    """Return the motion of a person who stops walking.

    Parameters
    ----------
    motion : Motion
        Walk.
    t : float
        Time in seconds at which braking begins.
    max_acceleration : float, optional
        Braking in m/s².

    Returns
    -------
    Motion
        Motion from `t` on along the path of `motion`.
    """
    t = float(t)
    state = motion.state(t)
    # v² / (2 a) suffices on a straight line, and the speed at corners ahead is lower.
    braking = state.speed**2 / (2 * max_acceleration * (1 - walks.HAIR))
    corners = walks.first_metres(remaining_path(motion, t), braking)
    if braking < walks.NOWHERE or len(corners) < 2:
        x, y, heading = state.position
        return standing((x, y), heading=heading, start=t)
    lengths = walks.lengths_of(corners)
    return Motion(TablePieces(walks.braking(corners, lengths, state.speed, t)))


def remaining_path(motion: Motion, t: float) -> list[Corner]:
    """Return the path that a walk still has to follow.

    Parameters
    ----------
    motion : Motion
        Walk.
    t : float
        Time in seconds.

    Returns
    -------
    list of tuple of float
        Position at `t` and later waypoints (x, y) in metres.
    """
    return _corners([motion.state(t).at, *walks.ends_after(motion.table, t)])


def corner_speed(
    before: tuple[float, float],
    corner: tuple[float, float],
    after: tuple[float, float],
    max_acceleration: float = MAX_ACCELERATION,
) -> float:
    """Return the maximum speed (m/s) at `corner` on the path from `before` to `after`.

    It is inf on a straight path and 0 at a reversal. See the notes of `walk`.
    """
    return walks.corner_speed(before, corner, after, max_acceleration)


def leg_to(
    motion: Motion, since: float, t: float, before: tuple[float, float] = (0.0, 0.0)
) -> tuple[float, float]:
    """Return the straight segment on which a person arrives at their position at `t` (x, y in m).

    It begins at their last turn since `since`, and is at most as long as one second of their
    velocity. `before` is the segment on which they came at `since`. At a corner it is the segment
    before it.
    """
    return walks.leg_before(motion.table, since, t, *before)


def can_go_on(
    state: State,
    towards: tuple[float, float],
    max_acceleration: float,
    leg: tuple[float, float] | None = None,
) -> bool:
    """Return whether a person in `state` can turn `towards` a point without slowing down first.

    The turn then needs at most `max_acceleration` (m/s²). `leg` is the segment on which they come
    (x, y in metres), by default one second of their velocity.
    """
    if state.speed == 0.0:
        return True
    x, y = state.at
    dx, dy = state.velocity[:2] if leg is None else leg
    before = (x - dx, y - dy)
    return state.speed <= corner_speed(before, (x, y), towards, max_acceleration)


def _corners(points: ArrayLike) -> list[Corner]:
    """Return `points` without repetitions and without points on a straight line between others."""
    if isinstance(points, list) and points:
        corners = walks.bends(points)
        if corners is not None:
            return corners
    corners = walks.bends([(x, y) for x, y in _checked(points).tolist()])
    assert corners is not None
    return corners


def _checked(points: ArrayLike) -> NDArray[np.float64]:
    """Return `points` as finite numbers of shape (N, 2)."""
    array = np.asarray(points, dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != 2 or len(array) == 0:
        raise ValueError(f"a path needs points of shape (N, 2), not {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError("a path needs finite points")
    return array
