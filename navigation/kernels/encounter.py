"""Two motions, stretch by stretch: bounds on their distance and on how fast they come closer."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

if not cython.compiled:
    from math import copysign, cos, sin, sqrt

    from .follower import Follower
    from .gauge import Course, Gauge
    from .numbers import Numbers, at, put, room
    from .odometer import PathLength, TaylorModel
else:
    from cython.cimports.libc.math import copysign, cos, sin, sqrt
    from cython.cimports.navigation.kernels.follower import Follower
    from cython.cimports.navigation.kernels.gauge import Course, Gauge
    from cython.cimports.navigation.kernels.numbers import Numbers, at, put, room
    from cython.cimports.navigation.kernels.odometer import PathLength, TaylorModel

_INFINITE: float = float("inf")

_NO_COURSE = Course()
_NONE: Numbers = room(0)
_SOME: cython.Py_ssize_t = 64  # ends of intervals, to begin with

_NEAR: float = 1e-9  # metres; nearer than this, the direction to the other is mostly rounding


class EncounterBounds:
    """The motions of a person and a machine, and a stretch of time in which each is one cubic.

    Distances are those between the two places, or between the surfaces of `gauges`.
    """

    def __init__(
        self,
        person: Numbers,
        machine: Numbers,
        gauges: list[Gauge],
        rounding: float,
    ) -> None:
        self.person = Follower(person)
        self.machine = Follower(machine)
        self.gauges = gauges
        self.course = Course() if gauges else _NO_COURSE
        self.ways: tuple[PathLength, ...] = ()
        self.slack = rounding
        self.since = self.until = 0.0
        self.near = self.far = self.offset = 0.0
        self.started = False
        self.lower = self.upper = 0.0
        self.ends = _NONE
        self.left = 0

    def odometers(self) -> tuple[PathLength, ...]:
        """Return those of the person and of the machine."""
        raise NotImplementedError

    def paths(self) -> tuple[PathLength, ...]:
        """Return the odometers, made where a law asks for them."""
        if not self.ways:
            self.ways = self.odometers()
        return self.ways

    def start(self, begin: float) -> cython.int:
        """Come to the instant `begin`, before the first stretch."""
        self.started = False
        self.left = 0
        self.since = self.until = begin
        self.person.seek(begin)
        self.machine.seek(begin)
        return 0

    def go_on(self, end: float) -> cython.bint:
        """Enter the next stretch, until `end` at most, or return that there is none."""
        person: Follower = self.person
        machine: Follower = self.machine
        t: float = self.until
        if self.started:
            if t >= end:
                return False
            if person.end <= t:
                person.go_on()
            if machine.end <= t:
                machine.go_on()
        self.started = True
        self.since = t
        self.until = min(person.end, machine.end, end)
        person.enter(t)
        machine.enter(t)
        # Both count from the same instant now, so the relative position is one cubic as well.
        self.x0 = machine.x0 - person.x0
        self.x1 = machine.x1 - person.x1
        self.x2 = machine.x2 - person.x2
        self.x3 = machine.x3 - person.x3
        self.y0 = machine.y0 - person.y0
        self.y1 = machine.y1 - person.y1
        self.y2 = machine.y2 - person.y2
        self.y3 = machine.y3 - person.y3
        return True

    def next_interval(self, end: float) -> cython.bint:
        """Come to the next interval, from `lower` to `upper`, or return that there is none.

        That is what is left of those that were halved, or the next stretch.
        """
        if self.left > 0:
            self.left -= 1
            self.lower = self.upper
            self.upper = at(self.ends)[self.left]
            return True
        if not self.go_on(end):
            return False
        self.lower = self.since
        self.upper = self.until
        return True

    def halve(self) -> cython.bint:
        """Leave the later half of the interval for later, or return that it is too short."""
        lower: float = self.lower
        upper: float = self.upper
        middle: float = lower + (upper - lower) / 2
        if not lower < middle < upper:
            return False
        # Each of those that are left begins where the one before it ends.
        left: cython.Py_ssize_t = self.left
        if left == len(self.ends):
            # A row of its own: the one to begin with is that of all encounters.
            ends: Numbers = room(max(2 * left, _SOME))
            put(at(ends), 0, at(self.ends), 0, left)
            self.ends = ends
        at(self.ends)[left] = upper
        self.left = left + 1
        self.upper = middle
        return True

    def look(self, begin: float, end: float) -> cython.int:
        """Bound distance and speeds from `begin` to `end`, within the stretch."""
        half: float = (end - begin) / 2
        middle: float = begin - self.since + half
        self.person.pace(middle, half)
        self.machine.pace(middle, half)
        return self.measure(middle, half, 0.0, 0.0)

    def apart_over(self, begin: float, end: float, slope: float, curve: float) -> cython.int:
        """Bound distance − `slope` u − `curve` u² / 2; `offset` is an instant near the least."""
        half: float = (end - begin) / 2
        middle: float = begin - self.since + half
        self.measure(middle, half, slope, curve)
        t: float = self.since + middle + self.offset
        self.offset = begin if t < begin else end if t > end else t
        return 0

    def measure(self, middle: float, half: float, slope: float, curve: float) -> cython.int:
        """See `apart_over`, for all |u| <= `half`; `offset` is a u.

        About the middle the relative position is r + v u + (a/2) u² + (j/6) u³. What |r + v u| −
        slope u may be is known exactly, for it is convex; the rest of the position can't be longer
        than (a/2) h² + (j/6) h³.
        """
        if self.gauges:
            return self.measure_surfaces(middle, half, slope, curve)
        a1: float = self.x1
        a2: float = self.x2
        a3: float = self.x3
        b1: float = self.y1
        b2: float = self.y2
        b3: float = self.y3
        x: float = self.x0 + middle * (a1 + middle * (a2 + middle * a3))
        y: float = self.y0 + middle * (b1 + middle * (b2 + middle * b3))
        self.offset = 0.0
        if half == 0.0:
            self.near = self.far = sqrt(x * x + y * y)
            return 0
        vx: float = a1 + middle * (2 * a2 + middle * 3 * a3)
        vy: float = b1 + middle * (2 * b2 + middle * 3 * b3)
        ax: float = a2 + 3 * a3 * middle
        ay: float = b2 + 3 * b3 * middle
        bend: float = half * half * sqrt(ax * ax + ay * ay)
        if a3 or b3:
            bend += half * half * half * sqrt(a3 * a3 + b3 * b3)
        square: float = vx * vx + vy * vy
        offset: float = 0.0
        if square > slope * slope:
            # With d the distance of the line r + v u from 0, √(d² + v² (u − u₀)²) − slope u is
            # least where v² (u − u₀) is slope times the root: u − u₀ = d slope / (v √(v² −
            # slope²)).
            offset = -(x * vx + y * vy) / square
            if slope:
                offset += abs(x * vy - y * vx) / square * (slope / sqrt(square - slope * slope))
            if offset < -half:
                offset = -half
            elif offset > half:
                offset = half
        elif slope:
            # No speed along the line makes up for the slope: the figure falls, or rises, all the
            # time.
            offset = copysign(half, slope)
        px: float = x + vx * offset
        py: float = y + vy * offset
        near: float = sqrt(px * px + py * py)
        # A convex function is greatest at an end.
        px = x - vx * half
        py = y - vy * half
        before: float = sqrt(px * px + py * py)
        px = x + vx * half
        py = y + vy * half
        after: float = sqrt(px * px + py * py)
        self.offset = offset
        if slope or curve:
            rise: float = slope * half
            bend = self.bend(x, y, vx, vy, ax, ay, half, curve, bend)
            self.near = near - slope * offset - bend
            self.far = max(before + rise, after - rise) + bend
        else:
            near -= bend
            self.near = 0.0 if near < 0.0 else near
            self.far = (after if after > before else before) + bend
        return 0

    def bend(
        self,
        x: float,
        y: float,
        vx: float,
        vy: float,
        ax: float,
        ay: float,
        half: float,
        curve: float,
        bend: float,
    ) -> float:
        """Bound the deviation of distance − curve u² / 2 from that along a line: of third order.

        With n the direction of r, that is (n·a − curve) u² / 2 + (n·j/6) u³, and in addition what
        is due to n turning, and to the part of the bend across n. `bend` is the length of it all.
        """
        # Moving the end of a vector by `bend` changes its length by no more than that.
        whole: float = bend + abs(curve) / 2 * half * half
        away: float = sqrt(x * x + y * y)
        # On the line r + v u nothing is nearer than this, so n turns by |r × v| h / nearest² at
        # most: r × v is the same for all u, and the rate at which n turns is r × v over the
        # distance's square.
        nearest: float = away - sqrt(vx * vx + vy * vy) * half
        if nearest < _NEAR:
            return whole
        along: float = abs((x * ax + y * ay) / away - curve / 2)
        along += abs(x * self.x3 + y * self.y3) / away * half
        turn: float = abs(x * vy - y * vx) * half / (nearest * nearest)
        # √(p² + q²) exceeds p by q² / (2 p) at most: that is the share of a displacement q across
        # n.
        return min(along * half * half + bend * (turn + bend / (2 * nearest)), whole)

    def measure_surfaces(
        self, middle: float, half: float, slope: float, curve: float
    ) -> cython.int:
        """See `measure`. Exact to second order in `half`, so it converges as fast."""
        machine: Follower = self.machine
        turn: float = machine.r0 + middle * (
            machine.r1 + middle * (machine.r2 + middle * machine.r3)
        )
        cosine: float = cos(turn)
        sine: float = sin(turn)
        u: float = middle
        # The person as the machine sees them at the middle: the world turned back by its rotation.
        px: float = -(self.x0 + u * (self.x1 + u * (self.x2 + u * self.x3)))
        py: float = -(self.y0 + u * (self.y1 + u * (self.y2 + u * self.y3)))
        x: float = cosine * px + sine * py
        y: float = cosine * py - sine * px
        gauge: Gauge
        self.offset = 0.0
        self.near = self.far = _INFINITE
        if half == 0.0:
            for gauge in self.gauges:
                self.near = min(self.near, gauge.look(x, y))
            self.far = self.near
            return 0
        vx: float = self.x1 + u * (2 * self.x2 + u * 3 * self.x3)
        vy: float = self.y1 + u * (2 * self.y2 + u * 3 * self.y3)
        ax: float = self.x2 + u * 3 * self.x3
        ay: float = self.y2 + u * 3 * self.y3
        spin_up: float = machine.r2 + u * 3 * machine.r3
        c: Course = self.course
        # x₂ and x₃ are a / 2 and j / 6, so these are the lengths of the terms of second and third
        # order.
        c.jolt = half * half * half * sqrt(self.x3 * self.x3 + self.y3 * self.y3)
        c.twist = half * half * (abs(spin_up) + half * abs(machine.r3))
        c.x = x
        c.y = y
        c.vx = -(cosine * vx + sine * vy)
        c.vy = sine * vx - cosine * vy
        c.ax = -(cosine * ax + sine * ay)
        c.ay = sine * ax - cosine * ay
        c.spin = machine.r1 + u * (2 * machine.r2 + u * 3 * machine.r3)
        c.half = half
        c.bend = half * half * sqrt(ax * ax + ay * ay) + c.jolt
        c.swing = abs(c.spin) * half + c.twist
        for gauge in self.gauges:
            gauge.range(c, slope, curve)
            self.near = min(self.near, gauge.low)
            self.far = min(self.far, gauge.high)
        return 0

    def close_in(self, begin: float, end: float) -> cython.int:
        """Bound the rate of half the squared distance of the places, m²/s: `near` and `far`."""
        h: float = (end - begin) / 2
        u: float = begin - self.since + h
        a1: float = self.x1
        a2: float = self.x2
        jx: float = self.x3
        b1: float = self.y1
        b2: float = self.y2
        jy: float = self.y3
        x: float = self.x0 + u * (a1 + u * (a2 + u * jx))
        y: float = self.y0 + u * (b1 + u * (b2 + u * jy))
        vx: float = a1 + u * (2 * a2 + u * 3 * jx)
        vy: float = b1 + u * (2 * b2 + u * 3 * jy)
        ax: float = a2 + u * 3 * jx
        ay: float = b2 + u * 3 * jy
        # r·v as a polynomial about the middle: its terms one by one, by their greatest size.
        rate: float = x * vx + y * vy
        slack: float = h * (
            abs(vx * vx + vy * vy + 2 * (x * ax + y * ay))
            + h
            * (
                3 * abs(vx * ax + vy * ay + x * jx + y * jy)
                + h
                * (
                    abs(2 * (ax * ax + ay * ay) + 4 * (vx * jx + vy * jy))
                    + h * (5 * abs(ax * jx + ay * jy) + h * 3 * (jx * jx + jy * jy))
                )
            )
        )
        self.near = rate - slack
        self.far = rate + slack
        return 0

    # The same for Python.

    def come_to(self, begin: float) -> None:
        """Come to the instant `begin`, before the first stretch."""
        self.start(begin)

    def next_stretch(self, end: float) -> bool:
        """Enter the next stretch, until `end` at most, or return that there is none."""
        return bool(self.go_on(end))

    def stretch(self) -> tuple[float, float]:
        """Return begin and end of the present stretch, seconds."""
        return self.since, self.until

    def all_bounds(
        self, begin: float, end: float
    ) -> tuple[float, float, float, float, float, float]:
        """Return bounds on distance (m), the person's speed and the machine's (m/s)."""
        self.look(begin, end)
        return (
            self.near,
            self.far,
            self.person.low,
            self.person.high,
            self.machine.low,
            self.machine.high,
        )

    def bounds_apart(
        self, begin: float, end: float, slope: float, curve: float
    ) -> tuple[float, float, float]:
        """Return bounds on distance − `slope` u − `curve` u² / 2, and an instant near the least."""
        self.apart_over(begin, end, slope, curve)
        return self.near, self.far, self.offset

    def bounds_closing(self, begin: float, end: float) -> tuple[float, float]:
        """Return bounds on the rate of half the squared distance of the places (m²/s)."""
        self.close_in(begin, end)
        return self.near, self.far

    def speed_of(self, machine: bool, begin: float, end: float) -> TaylorModel:
        """Return the speed of the person or the machine."""
        figure: TaylorModel = TaylorModel()
        (self.machine if machine else self.person).speed(begin, end, figure)
        return figure
