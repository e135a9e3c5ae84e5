"""Fastest stops in closed form: of an axis, of a gantry on its axes, of an AGV on its lane.

The profile of an axis has a limited acceleration and jerk. It is the double S of L. Biagiotti and
C. Melchiorri, "Trajectory Planning for Automatic Machines and Robots", 2008, section 3.4.
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

_STANDS: float = 1e-12  # m/s; an axis with less velocity and acceleration is at rest
_EASES: float = 1e-7  # m/s²


def stands(velocity: float, acceleration: float) -> bool:
    """Return whether an axis is at rest, apart from rounding."""
    return abs(velocity) < _STANDS and abs(acceleration) < _EASES


def braking(
    position: float, velocity: float, acceleration: float, top: float, jerk: float
) -> Numbers:
    """Return the phases of the fastest stop of an axis.

    The acceleration is at most `top` and changes by at most `jerk` per second (inf: without limit).

    Without a limit of acceleration, the fastest change of velocity has full jerk up to a peak p and
    back to 0. It changes the velocity by p² / j minus b² / (2 j), the part that the initial
    acceleration b has gained before. If p exceeds `top`, the acceleration stays at `top` for the
    remaining change.
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
    # The velocity that remains after the acceleration is reduced to 0.
    left: float = velocity + acceleration * abs(acceleration) / (2 * jerk)
    sign = -1.0 if left > 0.0 else 1.0
    speed: float = sign * velocity  # with the sign for which the acceleration must rise
    slope: float = sign * acceleration
    # From b up to p and down to 0 the velocity changes by (p² − b²) / (2 j) + p² / (2 j). With the
    # whole change −v, p² = b² / 2 − v j.
    square: float = slope * slope / 2 - speed * jerk
    peak: float = sqrt(square) if square > 0.0 else 0.0
    steady: float = 0.0
    change: float = jerk
    rising: float
    if peak > top:
        peak = top
        # The change up to the limit, and down from it. The rest of the change takes place at the
        # limit.
        gained: float = (top * top - slope * slope) / (2 * jerk)
        if slope > top:  # the acceleration first returns to its limit
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
    """Fastest stops of a machine."""

    def table(self, motion: Numbers, t: float) -> Numbers:
        """Return the table of the stop from a motion at `t` (seconds)."""
        raise NotImplementedError


class AxisStops(Stops):
    """Stops of three independent axes. `limits` are acceleration and jerk of each."""

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
        # If all axes stand, the motion has one piece without length.
        return table if len(table) > 0 else rest(t, t, x.p, y.p, r.p)


class LaneStops(Stops):
    """Stops on a lane from (x, y) in direction (c, s), at positions from `low` to `high` (m)."""

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
