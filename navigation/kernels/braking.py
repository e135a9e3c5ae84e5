"""Fastest stops in closed form: of an axis, of a gantry on its axes, of an AGV on its lane.

The profile of an axis has a limited acceleration and jerk: the double S of L. Biagiotti and C.
Melchiorri, "Trajectory Planning for Automatic Machines and Robots", 2008, section 3.4.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .numbers import numbers

if not cython.compiled:
    from math import sqrt

    from .cubics import *
    from .pieces import instant, merge_axes, rest

_STANDS: float = 1e-12  # m/s; an axis of less velocity and acceleration than these stands
_EASES: float = 1e-7  # m/s²


def stands(velocity: float, acceleration: float) -> bool:
    """Return whether an axis is at rest but for rounding."""
    return abs(velocity) < _STANDS and abs(acceleration) < _EASES


def braking(
    position: float, velocity: float, acceleration: float, top: float, jerk: float
) -> Numbers:
    """Return the phases of the fastest stop of an axis.

    Its acceleration is at most `top`, and changes by at most `jerk` in a second (inf: at once).

    Without an end to the acceleration, one at full jerk to a peak p and back to none is the fastest
    change of velocity: by p² / j less what the acceleration b at the beginning has gained already,
    b² / (2 j). Where p is more than `top`, it is kept at that for as long as the rest takes.
    """
    table: Numbers = phase_room(3)
    here: Cubic = Cubic(position, velocity, 0.0, 0.0)
    sign: float
    if stands(velocity, acceleration):
        phases(table)[0] = Phase(0.0, constant(position))
        phase_cut(table, 1)
        return table
    if jerk == INFINITY:
        sign = -1.0 if velocity > 0.0 else 1.0
        here = Cubic(position, velocity, sign * top / 2, 0.0)
        phases(table)[0] = Phase(abs(velocity) / top, here)
        phase_cut(table, 1)
        return table
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
    count: cython.Py_ssize_t = 0
    k: cython.Py_ssize_t
    for k in range(3):
        duration: float = rising if k == 0 else steady if k == 1 else peak / jerk
        if duration > 0.0:
            bend: float = sign * (slope if k == 0 else peak) / 2
            twist: float = sign * (change if k == 0 else 0.0 if k == 1 else -jerk) / 6
            here = Cubic(here.p, here.v, bend, twist)
            phases(table)[count] = Phase(duration, here)
            here = shift(here, duration)
            count += 1
    if count == 0:
        phases(table)[0] = Phase(0.0, constant(position))
        count = 1
    phase_cut(table, count)
    return table


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
        now: PosePiece = instant(motion, t)
        return self._stop(now.x, now.y, now.rotation, t)

    def after(self, state: list[float], t: float) -> Numbers:
        """Return the table of the stop at `t` from position, velocity and acceleration."""
        return self._stop(
            Cubic(state[0], state[3], state[6] / 2, 0.0),
            Cubic(state[1], state[4], state[7] / 2, 0.0),
            Cubic(state[2], state[5], state[8] / 2, 0.0),
            t,
        )

    def _stop(self, x: Cubic, y: Cubic, r: Cubic, t: float) -> Numbers:
        limits: Doubles = at(self.limits)
        table: Numbers = merge_axes(
            [
                braking(x.p, x.v, 2 * x.a, limits[0], limits[1]),
                braking(y.p, y.v, 2 * y.a, limits[2], limits[3]),
                braking(r.p, r.v, 2 * r.a, limits[4], limits[5]),
            ],
            t,
        )
        # All axes stand: a motion has one piece at least, here of no length.
        return table if len(table) > 0 else rest(t, t, x.p, y.p, r.p)


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
        now: PosePiece = instant(motion, t)
        q: float = (now.x.p - self.x) * self.c + (now.y.p - self.y) * self.s
        v: float = now.x.v * self.c + now.y.v * self.s
        a: float = 2 * (now.x.a * self.c + now.y.a * self.s)
        return self.after(min(max(q, self.low), self.high), v, a, t)

    def after(self, q: float, v: float, a: float, t: float) -> Numbers:
        """Return the table of the stop at `t` from lane position, velocity and acceleration."""
        phase: Phase = phases(braking(q, v, a, self.top, INFINITY))[0]
        x: Cubic = along(self.x, self.c, phase.c)
        y: Cubic = along(self.y, self.s, phase.c)
        table: Numbers = pose_room(1)
        poses(table)[0] = PosePiece(
            t,
            t + phase.duration,
            Cubic(x.p, x.v, x.a, 0.0),  # not -0.0
            Cubic(y.p, y.v, y.a, 0.0),
            constant(self.heading),
        )
        return table
