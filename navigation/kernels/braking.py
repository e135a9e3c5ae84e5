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

    from .numbers import Doubles, Numbers, at, cut, numbers, room
    from .odometer import row_at
    from .pieces import bend_at, merge_axes, rate_at, rest, value_at
else:
    from cython.cimports.libc.math import sqrt
    from cython.cimports.navigation.kernels.numbers import Doubles, Numbers, at, cut, numbers, room
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
) -> Numbers:
    """Return the phases of the fastest stop of an axis: a duration and four coefficients of each.

    Its acceleration is at most `top`, and changes by at most `jerk` in a second (inf: at once).

    Without an end to the acceleration, one at full jerk to a peak p and back to none is the fastest
    change of velocity: by p² / j less what the acceleration b at the beginning has gained already,
    b² / (2 j). Where p is more than `top`, it is kept at that for as long as the rest takes. See
    L. Biagiotti and C. Melchiorri, "Trajectory Planning for Automatic Machines and Robots", 2008,
    section 3.4.
    """
    rows: Numbers = room(15)
    row: Doubles = at(rows)
    sign: float
    if stands(velocity, acceleration):
        cut(rows, _set(row, 0, 0.0, position, 0.0, 0.0, 0.0))
        return rows
    if jerk == _INFINITE:
        sign = -1.0 if velocity > 0.0 else 1.0
        cut(rows, _set(row, 0, abs(velocity) / top, position, velocity, sign * top, 0.0))
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
    o: cython.Py_ssize_t = 0
    k: cython.Py_ssize_t
    for k in range(3):
        duration: float = rising if k == 0 else steady if k == 1 else peak / jerk
        if duration > 0.0:
            # Coefficients of the cubic of a phase: a / 2 and j / 6.
            bend: float = sign * (slope if k == 0 else peak) / 2
            twist: float = sign * (change if k == 0 else 0.0 if k == 1 else -jerk) / 6
            o = _set(row, o, duration, place, pace, 2 * bend, 6 * twist)
            place += duration * (pace + duration * (bend + duration * twist))
            pace += duration * (2 * bend + duration * 3 * twist)
    if o == 0:
        o = _set(row, 0, 0.0, position, 0.0, 0.0, 0.0)
    cut(rows, o)
    return rows


def _set(
    row: Doubles,
    o: cython.Py_ssize_t,
    duration: float,
    position: float,
    velocity: float,
    acceleration: float,
    jerk: float,
) -> cython.Py_ssize_t:
    """Set the phase at `o`; return where the next one is."""
    row[o] = duration
    row[o + 1] = position
    row[o + 2] = velocity
    row[o + 3] = acceleration / 2
    row[o + 4] = jerk / 6
    return o + 5


class Stops:
    """How a machine stops: as fast as it can."""

    def table(self, motion: Numbers, t: float) -> Numbers:
        """Return the table of the stop from a motion at `t` (seconds)."""
        raise NotImplementedError


class AxisStops(Stops):
    """Each of three axes by itself; `limits` are acceleration and jerk of each."""

    def __init__(self, limits: list[float]) -> None:
        self.limits = numbers(limits)

    def table(self, motion: Numbers, t: float) -> Numbers:
        """Return the table of the stop from a motion at `t` (seconds)."""
        found: Numbers = room(9)
        state: Doubles = at(found)
        row: Doubles = at(motion)
        rows: cython.Py_ssize_t = len(motion) // _WIDTH
        o: cython.Py_ssize_t = _WIDTH * max(row_at(row, rows, _WIDTH, t), 0) + 2
        moves: cython.bint = row[0] <= t and t < row[len(motion) - _WIDTH + 1]
        k: cython.Py_ssize_t
        for k in range(3):
            state[k] = value_at(row, o + 4 * k, t)
            state[3 + k] = rate_at(row, o + 4 * k, t) if moves else 0.0
            state[6 + k] = bend_at(row, o + 4 * k, t) if moves else 0.0
        return self.after(found, t)

    def after(self, state: Numbers, t: float) -> Numbers:
        """Return the table of the stop at `t` from position, velocity and acceleration."""
        s: Doubles = at(state)
        limits: Doubles = at(self.limits)
        axes = [
            braking(s[k], s[3 + k], s[6 + k], limits[2 * k], limits[2 * k + 1]) for k in range(3)
        ]
        table: Numbers = merge_axes(axes, t)
        # All axes stand: a motion has one piece at least, here of no length.
        if len(table) == 0:
            return rest(t, t, s[0], s[1], s[2])
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
        rows: cython.Py_ssize_t = len(motion) // _WIDTH
        o: cython.Py_ssize_t = _WIDTH * max(row_at(row, rows, _WIDTH, t), 0) + 2
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
        phase: Numbers = braking(q, v, a, self.top, _INFINITE)
        duration: float = at(phase)[0]
        place: float = at(phase)[1]
        pace: float = at(phase)[2]
        bend: float = at(phase)[3]
        c: float = self.c
        s: float = self.s
        table: Numbers = rest(t, t + duration, self.x + place * c, self.y + place * s, self.heading)
        row: Doubles = at(table)
        row[3] = pace * c
        row[4] = bend * c
        row[7] = pace * s
        row[8] = bend * s
        return table
