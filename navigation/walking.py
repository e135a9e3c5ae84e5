"""Motions of people: walks along paths with limited speed at corners, and conflicts between walks.

Both follow motions that end in a standing which counts for ever. Where they go is kept in tables
of plain numbers, in which the kernel of `discs` looks.

A person among others weighs many courses before taking one, and slows down to speeds below the
one they have. Courses that are weighed are swaths; the one taken becomes a motion.
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .kernels import discs, walks
from .kernels.candidates import bound
from .kernels.discs import ROW, distance_travelled, swept
from .kernels.numbers import flat, numbers, room
from .kernels.pacing import turned, walk_table
from .kernels.pieces import along_legs
from .machines import AxisLimits
from .motion import Motion, State, TablePieces, motion_of, standing

Corner = tuple[float, float]

_NONE = numbers(())


class Swath(NamedTuple):
    """The floor that a disc's centre takes from an instant on: its table, and the bounds of it.

    The `table` is one of `discs`; `rests` is when the final standing begins (seconds); `box` bounds
    the whole: least x and y, greatest x and y (metres).
    """

    table: MutableSequence[float]
    rests: float
    box: MutableSequence[float]

    @staticmethod
    def of(table: MutableSequence[float], box: MutableSequence[float]) -> Swath:
        """Return the swath of a table within bounds."""
        return Swath(table, table[-ROW], box)

    @staticmethod
    def along(
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
        """Return where the `walk` along `corners` goes that keeps to `top_speed`, from `start` on.

        It follows on the walk `lead`, if there is one, or on standing from `since` (seconds) on.
        None where it can't come to rest, or slow down enough for a corner.
        """
        places, before, bounds = flat([*corners]), _NONE, _NONE
        if lead is not None:
            before, bounds, since = lead.walk, lead.box, lead.rests
        table = walk_table(
            places,
            numbers((top_speed,) if isinstance(top_speed, float | int) else top_speed),
            start if since is None else since,
            start,
            initial_speed,
            max_speed,
            max_acceleration,
            before,
        )
        if not table:
            return None
        box = room(4)
        bound(places, len(places), bounds, box)
        return Swath.of(table, box)

    def motion(self, heading: float) -> Motion:
        """Return the motion along it: turned to where it goes, at first by `heading` (radians)."""
        return motion_of(turned(self.table, heading))

    @property
    def walk(self) -> MutableSequence[float]:
        """Its table without the final standing."""
        return self.table[:-ROW]

    @property
    def place(self) -> tuple[float, float]:
        """Where it comes to stand."""
        return (self.table[2 - ROW], self.table[6 - ROW])

    def gone(self, since: float, t: float) -> float:
        """Return the metres that a walk along straight legs goes from `since` to `t` (seconds)."""
        return distance_travelled(self.table, since, t)


def swath(motion: Motion, begin: float) -> Swath:
    """Return the swath of `motion` from `begin` (seconds) on."""
    since = max(begin, motion.end)
    box = room(4)
    return Swath.of(swept(motion.table, begin, since, *motion.state(since).at, box), box)


def first_conflict(one: Swath, other: Swath, least: float, begin: float) -> float | None:
    """Return the first instant from `begin` on at which two centres are closer than `least`.

    Seconds and metres; None if there is none. The swaths of `one` and of the `other` reach back to
    `begin`. Never misses one; finds one too many only where the two stay within rounding of
    `least`.
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
"""m/s. A person's top speed where nothing else is said."""

MAX_ACCELERATION = 2.5
"""m/s². A person's acceleration where nothing else is said."""


def walk(
    points: ArrayLike,
    start: float = 0.0,
    *,
    max_speed: float = MAX_SPEED,
    max_acceleration: float = MAX_ACCELERATION,
    initial_speed: float = 0.0,
    top_speed: float | Sequence[float] | None = None,
) -> Motion:
    """Return a walk along `points` ((N, 2), metres) that begins at `start` (seconds).

    It sets out at `initial_speed` (m/s) along the path and ends at rest; its speed never exceeds
    `max_speed` nor changes faster than `max_acceleration`, and at every corner it is at most
    `corner_speed`. The rotation is the heading. `ValueError` if the points are not finite, or if
    the path is too short to come to rest from `initial_speed`.

    With a `top_speed`, or one for each leg between `points`, the walk slows down to it as soon as
    `max_acceleration` lets it: `initial_speed` may be higher.
    """
    _check_limits(max_speed, max_acceleration)
    if top_speed is not None:
        swath = Swath.along(
            [(x, y) for x, y in _checked(points).tolist()],
            float(start),
            initial_speed=initial_speed,
            top_speed=top_speed,
            max_speed=max_speed,
            max_acceleration=max_acceleration,
        )
        if swath is None:
            raise ValueError(f"the path is too short to slow down from {initial_speed:g} m/s")
        return swath.motion(0.0)
    corners = _corners(points)
    if len(corners) == 1:
        if initial_speed > 0:
            raise ValueError("a path of no length is too short to come to rest on")
        return standing(corners[0], start=start)
    lengths = walks.lengths_of(corners)
    speeds = walks.corner_speeds(corners, lengths, max_speed, max_acceleration, initial_speed)
    if not speeds:
        raise ValueError(
            f"the path is too short to slow down from {initial_speed:g} m/s"
            f" at {max_acceleration:g} m/s²"
        )
    flat = [c for corner in corners for c in corner]
    table = along_legs(flat, lengths, speeds, max_speed, max_acceleration, float(start))
    return Motion(TablePieces(table))


@lru_cache
def _check_limits(max_speed: float, max_acceleration: float) -> None:
    """Raise `ValueError` for limits that make no sense; most people have the usual ones."""
    AxisLimits(max_speed, max_acceleration)


def stop_walking(motion: Motion, t: float, *, max_acceleration: float = MAX_ACCELERATION) -> Motion:
    """Return the walk `motion` broken off at `t` (seconds).

    It brakes at `max_acceleration` (m/s²) along its own path.
    """
    t = float(t)
    state = motion.state(t)
    # v² / (2 a): on a straight line that is all it takes, and corners ahead were taken slower.
    braking = state.speed**2 / (2 * max_acceleration * (1 - walks.HAIR))
    corners = walks.first_metres(remaining_path(motion, t), braking)
    if braking < walks.NOWHERE or len(corners) < 2:
        x, y, heading = state.position
        return standing((x, y), heading=heading, start=t)
    lengths = walks.lengths_of(corners)
    return Motion(TablePieces(walks.braking(corners, lengths, state.speed, t)))


def remaining_path(motion: Motion, t: float) -> list[Corner]:
    """Return the corners of the walk `motion` still to come at `t` (s), after where it is then."""
    return _corners([motion.state(t).at, *walks.ends_after(motion.table, t)])


def corner_speed(
    before: tuple[float, float],
    corner: tuple[float, float],
    after: tuple[float, float],
    max_acceleration: float = MAX_ACCELERATION,
) -> float:
    """The speed (m/s) at which a person turns at `corner` on the path from `before` to `after`.

    The corner is taken as an arc that leaves it by at most 0.05 m and is no longer than half of
    each leg; on an arc of radius r, the speed is √(a r), where a is `max_acceleration` (m/s²). This
    is the junction deviation of machine tool controllers (S. K. Jeon, "Improving Grbl: Cornering
    Algorithm", 2011). Infinite where the path goes straight on, 0 where it turns back.
    """
    return walks.corner_speed(before, corner, after, max_acceleration)


def leg_to(
    motion: Motion, since: float, t: float, before: tuple[float, float] = (0.0, 0.0)
) -> tuple[float, float]:
    """Return the straight leg on which a person comes to where they are at `t` (s), metres.

    They follow `motion` since `since` (s), where they came on the leg `before`. It is from their
    last turn on, along x and y, and no longer than their velocity makes in a second.
    At a corner it is the leg that ends there.
    """
    return walks.leg_before(motion.table, since, t, *before)


def can_go_on(
    state: State,
    towards: tuple[float, float],
    max_acceleration: float,
    leg: tuple[float, float] | None = None,
) -> bool:
    """Return whether a person in `state` may turn `towards` a point without slowing down first.

    That is so where the turn takes no more than `max_acceleration` (m/s²). `leg` is the straight
    leg on which they come here, along x and y (metres); left out it is what their velocity makes
    in a second.
    """
    if state.speed == 0.0:
        return True
    x, y = state.at
    dx, dy = state.velocity[:2] if leg is None else leg
    before = (x - dx, y - dy)
    return state.speed <= corner_speed(before, (x, y), towards, max_acceleration)


def _corners(points: ArrayLike) -> list[Corner]:
    """Return `points` without repetitions and without those on the straight line between others."""
    if isinstance(points, list) and points:
        corners = walks.bends(points)
        if corners is not None:
            return corners
    found = walks.bends([(x, y) for x, y in _checked(points).tolist()])
    assert found is not None  # they are finite floats
    return found


def _checked(points: ArrayLike) -> NDArray[np.float64]:
    """Return `points` as finite numbers of shape (N, 2)."""
    array = np.asarray(points, dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != 2 or len(array) == 0:
        raise ValueError(f"a path needs points of shape (N, 2), not {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError("a path needs finite points")
    return array
