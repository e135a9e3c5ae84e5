"""Fastest stops in closed form: of an axis, of a gantry on its axes, of an AGV on its lane.

Tables of motions are those of `pieces`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .odometer import WIDTH

if not cython.compiled:
    from math import sqrt

    from .numbers import Doubles, Numbers, at
    from .odometer import row_at
    from .pieces import bend_at, merge_axes, rate_at, rest, value_at
else:
    from cython.cimports.libc.math import sqrt
    from cython.cimports.navigation.kernels.numbers import Doubles, Numbers, at
    from cython.cimports.navigation.kernels.odometer import row_at
    from cython.cimports.navigation.kernels.pieces import (
        bend_at,
        merge_axes,
        rate_at,
        rest,
        value_at,
    )

_INFINITE: float = float("inf")
_WIDTH: cython.Py_ssize_t = WIDTH
_STANDS: float = 1e-12  # m/s; an axis of less velocity and acceleration than these stands
_EASES: float = 1e-7  # m/s²


def stands(velocity: float, acceleration: float) -> bool:
    """Return whether an axis is at rest but for rounding."""
    return abs(velocity) < _STANDS and abs(acceleration) < _EASES


def braking(
    position: float, velocity: float, acceleration: float, top: float, jerk: float
) -> list[float]:
    """Return the phases of the fastest stop of an axis: a duration and four coefficients of each.

    Its acceleration is at most `top`, and changes by at most `jerk` in a second (inf: at once).

    Without an end to the acceleration, one at full jerk to a peak p and back to none is the fastest
    change of velocity: by p² / j less what the acceleration b at the beginning has gained already,
    b² / (2 j). Where p is more than `top`, it is kept at that for as long as the rest takes. See
    L. Biagiotti and C. Melchiorri, "Trajectory Planning for Automatic Machines and Robots", 2008,
    section 3.4.
    """
    rows: list[float] = []
    if stands(velocity, acceleration):
        _add(rows, 0.0, position, 0.0, 0.0, 0.0)
        return rows
    sign: float
    if jerk == _INFINITE:
        sign = -1.0 if velocity > 0.0 else 1.0
        _add(rows, abs(velocity) / top, position, velocity, sign * top, 0.0)
        return rows
    # The velocity that is left once the acceleration has been brought to none.
    left: float = velocity + acceleration * abs(acceleration) / (2 * jerk)
    sign = -1.0 if left > 0.0 else 1.0
    speed: float = sign * velocity  # counted so that the acceleration has to go up
    slope: float = sign * acceleration
    # From b up to p and down to none the velocity changes by (p² − b²) / (2 j) + p² / (2 j), which
    # is to be what there is of it: p² = b² / 2 − v j.
    square: float = slope * slope / 2 - speed * jerk
    peak: float = sqrt(square) if square > 0.0 else 0.0
    steady: float = 0.0
    change: float = jerk
    rising: float
    if peak > top:
        peak = top
        # On the way to the limit, and the same again less the slope on the way down; what is left
        # takes its time at the limit.
        gained: float = (top * top - slope * slope) / (2 * jerk)
        if slope > top:  # beyond its limit: that comes first
            gained = -gained
            change = -jerk
        steady = (-speed - gained - top * top / (2 * jerk)) / top
    rising = (peak - slope) / change
    place: float = position
    pace: float = velocity
    k: cython.Py_ssize_t
    for k in range(3):
        duration: float = rising if k == 0 else steady if k == 1 else peak / jerk
        if duration > 0.0:
            # Coefficients of the cubic of a phase: a / 2 and j / 6.
            bend: float = sign * (slope if k == 0 else peak) / 2
            twist: float = sign * (change if k == 0 else 0.0 if k == 1 else -jerk) / 6
            _add(rows, duration, place, pace, 2 * bend, 6 * twist)
            place += duration * (pace + duration * (bend + duration * twist))
            pace += duration * (2 * bend + duration * 3 * twist)
    if not rows:
        _add(rows, 0.0, position, 0.0, 0.0, 0.0)
    return rows


def _add(
    rows: list[float],
    duration: float,
    position: float,
    velocity: float,
    acceleration: float,
    jerk: float,
) -> cython.int:
    """Add a phase."""
    rows.append(duration)
    rows.append(position)
    rows.append(velocity)
    rows.append(acceleration / 2)
    rows.append(jerk / 6)
    return 0


class Stops:
    """How a machine stops: as fast as it can."""

    def table(self, motion: Numbers, t: float) -> Numbers:
        """Return the table of the stop from a motion at `t` (seconds)."""
        raise NotImplementedError


class AxisStops(Stops):
    """Each of three axes by itself; `limits` are acceleration and jerk of each."""

    def __init__(self, limits: list[float]) -> None:
        self.limits = limits

    def table(self, motion: Numbers, t: float) -> Numbers:
        """Return the table of the stop from a motion at `t` (seconds)."""
        state: list[float] = [0.0] * 9
        row: Doubles = at(motion)
        o: cython.Py_ssize_t = _WIDTH * max(row_at(motion, _WIDTH, t), 0) + 2
        moves: cython.bint = row[0] <= t and t < row[len(motion) - _WIDTH + 1]
        k: cython.Py_ssize_t
        for k in range(3):
            state[k] = value_at(row, o + 4 * k, t)
            if moves:
                state[3 + k] = rate_at(row, o + 4 * k, t)
                state[6 + k] = bend_at(row, o + 4 * k, t)
        return self.after(state, t)

    def after(self, state: list[float], t: float) -> Numbers:
        """Return the table of the stop at `t` from position, velocity and acceleration."""
        limits: list[float] = self.limits
        axes = [
            braking(state[k], state[3 + k], state[6 + k], limits[2 * k], limits[2 * k + 1])
            for k in range(3)
        ]
        table: Numbers = merge_axes(axes, t)
        # All axes stand: a motion has one piece at least, here of no length.
        if len(table) == 0:
            return rest(t, t, state[0], state[1], state[2])
        return table


class LaneStops(Stops):
    """Along a lane from x, y in the direction c, s, at lane positions from `low` to `high` (m)."""

    def __init__(
        self,
        x: float,
        y: float,
        c: float,
        s: float,
        heading: float,
        low: float,
        high: float,
        top: float,
    ) -> None:
        self.x = x
        self.y = y
        self.c = c
        self.s = s
        self.heading = heading
        self.low = low
        self.high = high
        self.top = top

    def table(self, motion: Numbers, t: float) -> Numbers:
        """Return the table of the stop from a motion at `t` (seconds)."""
        row: Doubles = at(motion)
        o: cython.Py_ssize_t = _WIDTH * max(row_at(motion, _WIDTH, t), 0) + 2
        x: float = value_at(row, o, t)
        y: float = value_at(row, o + 4, t)
        q: float = (x - self.x) * self.c + (y - self.y) * self.s
        v: float = 0.0
        a: float = 0.0
        if row[0] <= t and t < row[len(motion) - _WIDTH + 1]:
            v = rate_at(row, o, t) * self.c + rate_at(row, o + 4, t) * self.s
            a = bend_at(row, o, t) * self.c + bend_at(row, o + 4, t) * self.s
        return self.after(min(max(q, self.low), self.high), v, a, t)

    def after(self, q: float, v: float, a: float, t: float) -> Numbers:
        """Return the table of the stop at `t` from lane position, velocity and acceleration."""
        rows: list[float] = braking(q, v, a, self.top, _INFINITE)
        place: float = rows[1]
        pace: float = rows[2]
        bend: float = rows[3]
        c: float = self.c
        s: float = self.s
        table: Numbers = rest(t, t + rows[0], self.x + place * c, self.y + place * s, self.heading)
        row: Doubles = at(table)
        row[3] = pace * c
        row[4] = bend * c
        row[7] = pace * s
        row[8] = bend * s
        return table
