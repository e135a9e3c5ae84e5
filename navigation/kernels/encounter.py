"""Two motions, stretch by stretch: bounds on their distance, their speeds and their paths ahead.

A motion is a table: for each piece its begin and end, and four coefficients each of x, y and
rotation. An `Encounter` takes two of them through time; in a stretch of it each is one cubic.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

if cython.compiled:
    from cython.cimports.libc.math import INFINITY, copysign, cos, sin, sqrt
else:
    from math import copysign, cos, inf, sin, sqrt

    INFINITY = inf

WIDTH = 14
"""Numbers in a row of a motion's table."""

STRETCH = 8
"""Numbers in a row of a table of stretches: begin, metres before it, velocity along x and y."""

_W: cython.Py_ssize_t = WIDTH
_S: cython.Py_ssize_t = STRETCH
_NEAR: float = 1e-9  # metres; nearer than this, the direction to the other is mostly rounding

_NODES = [1.0 + node for node in np.polynomial.legendre.leggauss(8)[0].tolist()]
_WEIGHTS = np.polynomial.legendre.leggauss(8)[1].tolist()


@cython.cclass
class Figure:
    """A figure over an interval: within `slack` of value + slope u + curve u² / 2.

    u is the time from the middle of the interval (`navigation.Enclosure`).
    """

    value: float
    slope: float
    slack: float
    curve: float

    @cython.cfunc
    def set(self, value: float, slope: float, slack: float, curve: float) -> cython.int:
        self.value = value
        self.slope = slope
        self.slack = slack
        self.curve = curve
        return 0

    def numbers(self) -> tuple[float, float, float, float]:
        """Return value, slope, slack and curve."""
        return self.value, self.slope, self.slack, self.curve


@cython.cfunc
@cython.exceptval(check=False)
def _row_at(table: list[float], width: cython.Py_ssize_t, t: float) -> cython.Py_ssize_t:
    """Return the last row that begins by `t`, by halving; -1 if none does."""
    low: cython.Py_ssize_t = 0
    high: cython.Py_ssize_t = len(table) // width
    middle: cython.Py_ssize_t
    while low < high:
        middle = (low + high) // 2
        if t < table[middle * width]:
            high = middle
        else:
            low = middle + 1
    return low - 1


@cython.cfunc
def _speed_along(
    table: list[float], row: cython.Py_ssize_t, begin: float, end: float, figure: Figure
) -> cython.int:
    """Give the speed of a piece over an interval within it, m/s.

    Its second derivative is at most a² / |v| + |j|, with a the acceleration across the velocity.
    """
    o: cython.Py_ssize_t = row * _W
    half: float = (end - begin) / 2
    u: float = begin - table[o] + half
    x1: float = table[o + 3]
    x2: float = table[o + 4]
    x3: float = table[o + 5]
    y1: float = table[o + 7]
    y2: float = table[o + 8]
    y3: float = table[o + 9]
    vx: float = x1 + u * (2 * x2 + u * 3 * x3)
    vy: float = y1 + u * (2 * y2 + u * 3 * y3)
    speed: float = sqrt(vx * vx + vy * vy)
    if half == 0.0 or x2 == y2 == x3 == y3 == 0.0:
        return figure.set(speed, 0.0, 0.0, 0.0)
    ax: float = 2 * x2 + u * 6 * x3
    ay: float = 2 * y2 + u * 6 * y3
    jx: float = 6 * x3
    jy: float = 6 * y3
    jerk: float = sqrt(jx * jx + jy * jy)
    change: float = (sqrt(ax * ax + ay * ay) + jerk * half) * half
    least: float = speed - change
    if least > 0.0:
        across: float = abs(vx * ay - vy * ax) + half * abs(vx * jy - vy * jx)
        across += half * half / 2 * abs(ax * jy - ay * jx)
        ratio: float = across / least
        bend: float = (ratio * ratio / least + jerk) * half * half / 2
        if bend < change:
            return figure.set(speed, (vx * ax + vy * ay) / speed, bend, 0.0)
    return figure.set(speed, 0.0, change, 0.0)


@cython.cclass
class Odometer:
    """Path length and speed of a motion at any time. Jumps add no length."""

    table: list[float]
    stretches: list[float] | None
    total: float
    start: float
    finish: float
    out: Figure
    near: Figure

    def __init__(self, table: list[float]) -> None:
        self.table = table
        self.stretches = None
        self.total = 0.0
        self.start = table[0]
        self.finish = table[len(table) - _W + 1]
        self.out = Figure()
        self.near = Figure()

    def cut(self) -> tuple[list[float], float]:
        """Return the table of stretches in which the speed is smooth, and the whole length."""
        raise NotImplementedError

    @cython.ccall
    def reading(self, t: float) -> float:
        """The metres gone from the motion's start to `t` (seconds); exact to 1e-12 of them."""
        if self.stretches is None:
            self.stretches, self.total = self.cut()
        if t >= self.finish:
            return self.total
        if t <= self.start:
            return 0.0
        table: list[float] = self.stretches
        row: cython.Py_ssize_t = _row_at(table, _S, t)
        return table[row * _S + 1] + length(table, row, t - table[row * _S])

    @cython.cfunc
    def look_ahead(self, begin: float, end: float, seconds: float) -> cython.int:
        """Find the path length within `seconds` of each instant of an interval: in `out`."""
        half: float = (end - begin) / 2
        middle: float = begin + half
        ahead: float = self.reading(middle + seconds) - self.reading(middle)
        if half == 0.0:
            return self.out.set(ahead, 0.0, 0.0, 0.0)
        # Its derivative is the speed at the far end less that at the near one.
        self.look(begin, end)
        self.near.set(self.out.value, self.out.slope, self.out.slack, 0.0)
        self.look(begin + seconds, end + seconds)
        slack: float = self.out.slack + self.near.slack
        return self.out.set(
            ahead,
            self.out.value - self.near.value,
            slack * half,
            self.out.slope - self.near.slope,
        )

    @cython.cfunc
    def look(self, begin: float, end: float) -> cython.int:
        """Find the speed over an interval: in `out`; at a change, the one after it."""
        table: list[float] = self.table
        if end < self.start or begin >= self.finish:
            return self.out.set(0.0, 0.0, 0.0, 0.0)
        rows: cython.Py_ssize_t = len(table) // _W
        k: cython.Py_ssize_t = _row_at(table, _W, begin)
        if k >= 0 and end <= table[k * _W + 1]:
            return _speed_along(table, k, begin, end, self.out)
        low: float = INFINITY
        high: float = 0.0
        if begin < self.start or end > self.finish:
            low = 0.0
        k = max(k, 0)
        while k < rows and table[k * _W] < end:
            since: float = max(begin, table[k * _W])
            until: float = min(end, table[k * _W + 1])
            if until > since:
                _speed_along(table, k, since, until, self.out)
                around: float = abs(self.out.slope) * ((until - since) / 2) + self.out.slack
                low = min(low, self.out.value - around)
                high = max(high, self.out.value + around)
            k += 1
        low = max(low, 0.0)
        return self.out.set((low + high) / 2, 0.0, (high - low) / 2, 0.0)

    def path_ahead(self, begin: float, end: float, seconds: float) -> Figure:
        """Return `look_ahead`'s figure, to be read at once."""
        self.look_ahead(begin, end, seconds)
        return self.out

    def speed_within(self, begin: float, end: float) -> Figure:
        """Return `look`'s figure, to be read at once."""
        self.look(begin, end)
        return self.out


@cython.ccall
def length(table: list[float], row: cython.Py_ssize_t, u: float) -> float:
    """Return the length of the first `u` seconds of a stretch, metres: Gauss-Legendre's."""
    o: cython.Py_ssize_t = row * _S
    x1: float = table[o + 2]
    x2: float = table[o + 3]
    x3: float = table[o + 4]
    y1: float = table[o + 5]
    y2: float = table[o + 6]
    y3: float = table[o + 7]
    if x2 == y2 == x3 == y3 == 0.0:
        return sqrt(x1 * x1 + y1 * y1) * u
    half: float = u / 2
    total: float = 0.0
    nodes: list[float] = _NODES
    weights: list[float] = _WEIGHTS
    k: cython.Py_ssize_t
    for k in range(8):
        w: float = half * nodes[k]
        vx: float = x1 + w * (2 * x2 + w * 3 * x3)
        vy: float = y1 + w * (2 * y2 + w * 3 * y3)
        weight: float = weights[k]
        total += weight * sqrt(vx * vx + vy * vy)
    return half * total


@cython.cclass
class Follower:
    """A body on its motion: standing before it, one piece after another, standing after it."""

    table: list[float]
    rows: cython.Py_ssize_t
    row: cython.Py_ssize_t  # -1 and `rows` where it stands before and after the motion
    since: float  # the watch begins
    begin: float
    end: float
    x0: float  # the coefficients, counted from where the stretch begins
    x1: float
    x2: float
    x3: float
    y0: float
    y1: float
    y2: float
    y3: float
    r0: float
    r1: float
    r2: float
    r3: float
    low: float  # bounds on the speed over an interval
    high: float

    def __init__(self, table: list[float]) -> None:
        self.table = table
        self.rows = len(table) // _W

    @cython.cfunc
    def seek(self, t: float) -> cython.int:
        """Come to the piece at `t`."""
        table: list[float] = self.table
        self.since = t
        if t < table[0]:
            self.row = -1
            self.begin = t
            self.end = table[0]
            return 0
        self.row = _row_at(table, _W, t) - 1
        return self.go_on()

    @cython.cfunc
    def go_on(self) -> cython.int:
        """Come to the next piece. Those of no length are left out: no velocity for no time."""
        table: list[float] = self.table
        while True:
            self.row += 1
            if self.row >= self.rows:
                self.begin = table[(self.rows - 1) * _W + 1]
                self.end = INFINITY
                return 0
            o: cython.Py_ssize_t = self.row * _W
            self.begin = table[o]
            self.end = table[o + 1]
            if self.end > max(self.since, self.begin):
                total: float = 0.0
                k: cython.Py_ssize_t
                for k in range(_W):
                    total += table[o + k]
                if total - total != 0.0:
                    raise ValueError(
                        f"a motion is not finite from t = {self.begin} s to {self.end} s"
                    )
                return 0

    @cython.cfunc
    @cython.exceptval(check=False)
    def enter(self, t: float) -> cython.int:
        """Count from `t`, within the piece."""
        table: list[float] = self.table
        o: cython.Py_ssize_t = min(max(self.row, 0), self.rows - 1) * _W
        u: float = 0.0
        if self.row >= self.rows:
            u = table[o + 1] - table[o]
        elif self.row >= 0:
            u = t - self.begin
        self.x0 = table[o + 2]
        self.x1 = table[o + 3]
        self.x2 = table[o + 4]
        self.x3 = table[o + 5]
        self.y0 = table[o + 6]
        self.y1 = table[o + 7]
        self.y2 = table[o + 8]
        self.y3 = table[o + 9]
        self.r0 = table[o + 10]
        self.r1 = table[o + 11]
        self.r2 = table[o + 12]
        self.r3 = table[o + 13]
        if u != 0.0:
            self.x0 = self.x0 + u * (self.x1 + u * (self.x2 + u * self.x3))
            self.x1 = self.x1 + u * (2 * self.x2 + u * 3 * self.x3)
            self.x2 = self.x2 + u * 3 * self.x3
            self.y0 = self.y0 + u * (self.y1 + u * (self.y2 + u * self.y3))
            self.y1 = self.y1 + u * (2 * self.y2 + u * 3 * self.y3)
            self.y2 = self.y2 + u * 3 * self.y3
            self.r0 = self.r0 + u * (self.r1 + u * (self.r2 + u * self.r3))
            self.r1 = self.r1 + u * (2 * self.r2 + u * 3 * self.r3)
            self.r2 = self.r2 + u * 3 * self.r3
        if self.row < 0 or self.row >= self.rows:
            self.x1 = self.x2 = self.x3 = 0.0
            self.y1 = self.y2 = self.y3 = 0.0
            self.r1 = self.r2 = self.r3 = 0.0
        return 0

    @cython.cfunc
    @cython.exceptval(check=False)
    def pace(self, middle: float, half: float) -> cython.int:
        """Bound the speed within `half` of `middle`, counted from the stretch's begin."""
        x2: float = self.x2
        y2: float = self.y2
        x3: float = self.x3
        y3: float = self.y3
        if x2 == y2 == x3 == y3 == 0.0:
            self.low = self.high = sqrt(self.x1 * self.x1 + self.y1 * self.y1)
            return 0
        vx: float = self.x1 + middle * (2 * x2 + middle * 3 * x3)
        vy: float = self.y1 + middle * (2 * y2 + middle * 3 * y3)
        speed: float = sqrt(vx * vx + vy * vy)
        ax: float = x2 + 3 * x3 * middle
        ay: float = y2 + 3 * y3 * middle
        slack: float = half * 2 * sqrt(ax * ax + ay * ay)
        slack += half * half * 3 * sqrt(x3 * x3 + y3 * y3)
        self.low = max(speed - slack, 0.0)
        self.high = speed + slack
        return 0

    @cython.cfunc
    def speed(self, begin: float, end: float, figure: Figure) -> cython.int:
        """Give the speed from `begin` to `end`, an interval within the piece."""
        if self.row < 0 or self.row >= self.rows:
            return figure.set(0.0, 0.0, 0.0, 0.0)
        return _speed_along(self.table, self.row, begin, end, figure)


@cython.cclass
class Course:
    """Motion of a person in the frame that a machine has at the middle of an interval.

    Place, velocity and half the acceleration, and how fast the machine turns. For `half` seconds
    before and after, the person stays within `bend` (m) of place and velocity, and within `jolt`
    if the acceleration counts too; the machine stays within `twist` (rad) and turns by no more
    than `swing`.
    """

    x: float
    y: float
    vx: float
    vy: float
    ax: float
    ay: float
    spin: float
    half: float
    bend: float
    jolt: float
    twist: float
    swing: float


@cython.cclass
class Gauge:
    """Measures between a person, an upright cylinder, and one part of a machine, in its frame.

    The part's footprint is a rectangle of half lengths `along` and `across` about the machine's
    axis, grown by `rounding`: a box has no rounding, a cylinder no lengths. `height` is the gap
    between the heights of the two. All in metres.
    """

    radius: float
    height: float
    along: float
    across: float
    rounding: float
    reach: float
    low: float
    high: float
    away: float
    at_x: float
    at_y: float

    def __init__(
        self, radius: float, height: float, along: float, across: float, rounding: float
    ) -> None:
        self.radius = radius
        self.height = height
        self.along = along
        self.across = across
        self.rounding = rounding
        self.reach = sqrt(along * along + across * across)
        self.low = self.high = self.away = self.at_x = self.at_y = 0.0

    @cython.cfunc
    @cython.exceptval(check=False)
    def look(self, x: float, y: float) -> float:
        """Find the footprint's point nearest to (x, y), how far it is, and so the surfaces.

        0 within the footprint, and then the point is of no use.
        """
        self.at_x = min(max(x, -self.along), self.along)
        self.at_y = min(max(y, -self.across), self.across)
        dx: float = x - self.at_x
        dy: float = y - self.at_y
        gap: float = sqrt(dx * dx + dy * dy)
        self.away = max(gap - self.rounding, 0.0)
        if gap > 0.0:
            self.at_x += dx * (self.rounding / gap)
            self.at_y += dy * (self.rounding / gap)
        return self.over(self.away)

    @cython.cfunc
    @cython.exceptval(check=False)
    def over(self, away: float) -> float:
        """The distance from the part to a person whose axis is `away` metres from its footprint."""
        flat: float = max(away - self.radius, 0.0)
        return sqrt(flat * flat + self.height * self.height)

    @cython.cfunc
    @cython.exceptval(check=False)
    def range(self, c: Course, slope: float, curve: float) -> cython.int:
        """Bound distance − `slope` u − `curve` u² / 2 for the instants u of a course.

        The lower bound is that of a plane that separates the two at the middle: one that keeps its
        normal, or one that turns with the machine (better beside a wall that turns). Along the
        normal, the person and the corners of the footprint move at a known rate. The upper bound
        is the distance from the person to the part's point that is nearest at the middle and moves
        with it. Both are off by second order in the course's `half`.
        """
        half: float = c.half
        distance: float = self.look(c.x, c.y)
        away: float = self.away
        farthest: float = self.reach + self.rounding
        turned: float = c.twist + c.swing * c.swing / 2
        moved: float = sqrt(c.vx * c.vx + c.vy * c.vy) * half + c.bend
        if away == 0.0:
            around: float = (abs(slope) + abs(curve) / 2 * half) * half
            self.low = self.height - around
            self.high = self.over(moved + farthest * c.swing) + around
            return 0
        dx: float = c.x - self.at_x
        dy: float = c.y - self.at_y
        wx: float = (c.vx + c.spin * self.at_y) * half
        wy: float = (c.vy - c.spin * self.at_x) * half
        rise: float = slope * half
        bow: float = abs(curve) / 2 * half * half
        bent: float = c.bend + farthest * turned
        px: float = dx + wx
        py: float = dy + wy
        after: float = self.over(sqrt(px * px + py * py) + bent) - rise
        px = dx - wx
        py = dy - wy
        before: float = self.over(sqrt(px * px + py * py) + bent) + rise
        self.high = max(after, before) + bow
        if away <= self.radius:
            self.low = distance - abs(rise) - bow
            if not (slope or curve):
                self.low = max(self.low, self.height)
            return 0
        level: float = (away - self.radius) / distance
        nx: float = dx / away * level
        ny: float = dy / away * level
        towards: float = nx * c.vx + ny * c.vy - slope
        low: float = INFINITY
        nearest: float = INFINITY
        corner: cython.Py_ssize_t
        for corner in range(4):
            cx: float = self.along if corner % 2 == 0 else -self.along
            cy: float = self.across if corner < 2 else -self.across
            apart: float = nx * (c.x - cx) + ny * (c.y - cy)
            low = min(low, apart - abs(towards + c.spin * (nx * cy - ny * cx)) * half)
            nearest = min(nearest, apart)
        low -= abs(nx * c.ax + ny * c.ay - curve / 2) * half * half
        low -= level * (c.jolt + self.reach * turned)
        if c.swing > 0.0 and self.reach > 0.0:
            turning: float = nearest - bow
            turning -= abs(towards + c.spin * (nx * c.y - ny * c.x)) * half
            turning -= level * (
                c.bend
                + sqrt(c.x * c.x + c.y * c.y) * turned
                + moved * (c.swing + c.swing * c.swing / 2)
            )
            low = max(low, turning)
        low += self.height * self.height / distance - level * (self.radius + self.rounding)
        self.low = low if slope or curve else max(low, self.height)
        self.high = self.high
        return 0


@cython.cclass
class Encounter:
    """The motions of a person and a machine, and a stretch of time in which each is one cubic.

    Distances are those between the two places, or between the surfaces of `gauges`.
    """

    person: Follower
    machine: Follower
    gauges: list[Gauge]
    course: Course
    ways: tuple[Odometer, Odometer] | None
    since: float
    until: float
    started: cython.bint
    x0: float  # the machine's place less the person's
    x1: float
    x2: float
    x3: float
    y0: float
    y1: float
    y2: float
    y3: float
    slack: float
    near: float
    far: float
    offset: float
    speed_of_one: Figure
    speed_of_other: Figure

    def __init__(
        self,
        person: list[float],
        machine: list[float],
        gauges: list[Gauge],
        rounding: float,
    ) -> None:
        self.person = Follower(person)
        self.machine = Follower(machine)
        self.gauges = gauges
        self.course = Course()
        self.ways = None
        self.slack = rounding
        self.since = self.until = 0.0
        self.near = self.far = self.offset = 0.0
        self.started = False
        self.speed_of_one = Figure()
        self.speed_of_other = Figure()

    def odometers(self) -> tuple[Odometer, Odometer]:
        """Return those of the person and of the machine."""
        raise NotImplementedError

    @cython.cfunc
    def paths(self) -> tuple[Odometer, Odometer]:
        """Return the odometers, made where a law asks for them."""
        if self.ways is None:
            self.ways = self.odometers()
        return self.ways

    @cython.cfunc
    def start(self, begin: float) -> cython.int:
        """Come to the instant `begin`, before the first stretch."""
        self.started = False
        self.since = self.until = begin
        self.person.seek(begin)
        self.machine.seek(begin)
        return 0

    @cython.cfunc
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
        self.x0 = machine.x0 - person.x0
        self.x1 = machine.x1 - person.x1
        self.x2 = machine.x2 - person.x2
        self.x3 = machine.x3 - person.x3
        self.y0 = machine.y0 - person.y0
        self.y1 = machine.y1 - person.y1
        self.y2 = machine.y2 - person.y2
        self.y3 = machine.y3 - person.y3
        return True

    @cython.cfunc
    @cython.exceptval(check=False)
    def look(self, begin: float, end: float) -> cython.int:
        """Bound distance and speeds from `begin` to `end`, within the stretch."""
        half: float = (end - begin) / 2
        middle: float = begin - self.since + half
        self.person.pace(middle, half)
        self.machine.pace(middle, half)
        return self.measure(middle, half, 0.0, 0.0)

    @cython.cfunc
    @cython.exceptval(check=False)
    def apart_over(self, begin: float, end: float, slope: float, curve: float) -> cython.int:
        """Bound distance − `slope` u − `curve` u² / 2; `offset` is an instant near the least."""
        half: float = (end - begin) / 2
        middle: float = begin - self.since + half
        self.measure(middle, half, slope, curve)
        self.offset = min(max(self.since + middle + self.offset, begin), end)
        return 0

    @cython.cfunc
    @cython.exceptval(check=False)
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
            offset = -(x * vx + y * vy) / square
            if slope:
                offset += abs(x * vy - y * vx) / square * (slope / sqrt(square - slope * slope))
            offset = min(max(offset, -half), half)
        elif slope:
            offset = copysign(half, slope)
        px: float = x + vx * offset
        py: float = y + vy * offset
        near: float = sqrt(px * px + py * py)
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
            self.near = max(near - bend, 0.0)
            self.far = max(before, after) + bend
        return 0

    @cython.cfunc
    @cython.exceptval(check=False)
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
        whole: float = bend + abs(curve) / 2 * half * half
        away: float = sqrt(x * x + y * y)
        nearest: float = away - sqrt(vx * vx + vy * vy) * half
        if nearest < _NEAR:
            return whole
        along: float = abs((x * ax + y * ay) / away - curve / 2)
        along += abs(x * self.x3 + y * self.y3) / away * half
        turn: float = abs(x * vy - y * vx) * half / (nearest * nearest)
        return min(along * half * half + bend * (turn + bend / (2 * nearest)), whole)

    @cython.cfunc
    @cython.exceptval(check=False)
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
        px: float = -(self.x0 + u * (self.x1 + u * (self.x2 + u * self.x3)))
        py: float = -(self.y0 + u * (self.y1 + u * (self.y2 + u * self.y3)))
        x: float = cosine * px + sine * py
        y: float = cosine * py - sine * px
        gauge: Gauge
        self.offset = 0.0
        self.near = self.far = INFINITY
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

    @cython.cfunc
    @cython.exceptval(check=False)
    def close_in(self, begin: float, end: float) -> cython.int:
        """Bound the rate of half the squared distance of the places, m²/s: `near` and `far`."""
        h: float = (end - begin) / 2
        u: float = begin - self.since + h
        jx: float = self.x3
        jy: float = self.y3
        x: float = self.x0 + u * (self.x1 + u * (self.x2 + u * jx))
        y: float = self.y0 + u * (self.y1 + u * (self.y2 + u * jy))
        vx: float = self.x1 + u * (2 * self.x2 + u * 3 * jx)
        vy: float = self.y1 + u * (2 * self.y2 + u * 3 * jy)
        ax: float = self.x2 + u * 3 * jx
        ay: float = self.y2 + u * 3 * jy
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

    def speed_of(self, machine: bool, begin: float, end: float) -> Figure:
        """Return the speed of the person or the machine, to be read at once."""
        (self.machine if machine else self.person).speed(begin, end, self.speed_of_one)
        return self.speed_of_one


@cython.cclass
class Law:
    """A separation law: `distance` from two speeds, `require` of an encounter, in `out`."""

    of_speeds: cython.bint
    source: Any
    out: Figure

    @cython.cfunc
    def distance(self, human: float, robot: float) -> float:
        return 0.0

    @cython.cfunc
    def require(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        return 0

    def required(
        self, encounter: Encounter, begin: float, end: float
    ) -> tuple[float, float, float, float]:
        """Return the required distance over an interval: value, slope, slack and curve."""
        self.require(encounter, begin, end)
        return self.out.numbers()


@cython.cclass
class LinearLaw(Law):
    """`human` · v_H + `robot` · v_R + `stopping` + `intrusion`."""

    human: float
    robot: float
    stopping: float
    intrusion: float

    def __init__(self, human: float, robot: float, stopping: float, intrusion: float) -> None:
        self.of_speeds = True
        self.source = None
        self.out = Figure()
        self.human = human
        self.robot = robot
        self.stopping = stopping
        self.intrusion = intrusion

    @cython.cfunc
    def distance(self, human: float, robot: float) -> float:
        return human * self.human + robot * self.robot + self.stopping + self.intrusion

    @cython.cfunc
    def require(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        fixed: float = self.stopping + self.intrusion
        if self.human == 0.0 and self.robot == 0.0:
            return self.out.set(fixed, 0.0, 0.0, 0.0)
        human: Figure = encounter.speed_of_one
        robot: Figure = encounter.speed_of_other
        encounter.person.speed(begin, end, human)
        encounter.machine.speed(begin, end, robot)
        return self.out.set(
            human.value * self.human + robot.value * self.robot + fixed,
            human.slope * self.human + robot.slope * self.robot,
            human.slack * self.human + robot.slack * self.robot,
            0.0,
        )


@cython.cclass
class IntegralLaw(Law):
    """The integral form (`navigation.IntegralLaw`); `stopping` is negative where it is braking."""

    t1: float
    t2: float
    stopping: float
    allowance: float

    def __init__(self, t1: float, t2: float, stopping: float, allowance: float) -> None:
        self.of_speeds = False
        self.source = None
        self.out = Figure()
        self.t1 = t1
        self.t2 = t2
        self.stopping = stopping
        self.allowance = allowance

    @cython.cfunc
    def require(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        human: Odometer
        robot: Odometer
        human, robot = encounter.paths()
        human.look_ahead(begin, end, self.t1 + self.t2)
        robot.look_ahead(begin, end, self.t1)
        value: float = human.out.value + robot.out.value
        slope: float = human.out.slope + robot.out.slope
        slack: float = human.out.slack + robot.out.slack
        curve: float = human.out.curve + robot.out.curve
        if self.stopping >= 0.0:
            return self.out.set(value + (self.stopping + self.allowance), slope, slack, curve)
        robot.look(begin + self.t1, end + self.t1)
        half: float = self.t2 / 2
        return self.out.set(
            value + robot.out.value * half + self.allowance,
            slope + robot.out.slope * half,
            slack + robot.out.slack * half,
            curve,
        )


@cython.cclass
class ScaledLaw(Law):
    """`factor` times another law, capped first at `cap` metres."""

    law: Law
    factor: float
    cap: float

    def __init__(self, law: Law, factor: float, cap: float) -> None:
        self.of_speeds = law.of_speeds
        self.source = None
        self.out = Figure()
        self.law = law
        self.factor = factor
        self.cap = cap

    @cython.cfunc
    def distance(self, human: float, robot: float) -> float:
        return self.factor * min(self.law.distance(human, robot), self.cap)

    @cython.cfunc
    def require(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        self.law.require(encounter, begin, end)
        whole: Figure = self.law.out
        half: float = (end - begin) / 2
        around: float = (abs(whole.slope) + abs(whole.curve) * half / 2) * half + whole.slack
        if whole.value + around <= self.cap:
            return self.out.set(
                whole.value * self.factor,
                whole.slope * self.factor,
                whole.slack * self.factor,
                whole.curve * self.factor,
            )
        low: float = self.factor * min(whole.value - around, self.cap)
        high: float = self.factor * self.cap
        return self.out.set((low + high) / 2, 0.0, (high - low) / 2, 0.0)


@cython.cclass
class OwnLaw(Law):
    """A law that is written in Python: `source` has a method `distance`, `required` or both."""

    of_motions: cython.bint

    def __init__(self, source: Any, of_speeds: bool, of_motions: bool) -> None:
        self.source = source
        self.of_speeds = of_speeds
        self.of_motions = of_motions
        self.out = Figure()

    @cython.cfunc
    def distance(self, human: float, robot: float) -> float:
        return float(self.source.distance(human, robot))

    @cython.cfunc
    def require(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        if self.of_motions:
            required = self.source.required(encounter, begin, end)
            return self.out.set(required.value, required.slope, required.slack, required.curve)
        encounter.look(begin, end)
        low: float = self.distance(encounter.person.low, encounter.machine.low)
        high: float = self.distance(encounter.person.high, encounter.machine.high)
        return self.out.set((low + high) / 2, 0.0, (high - low) / 2, 0.0)


UNDECIDED: cython.int = -1


@cython.cclass
class Judge:
    """A condition on an encounter, decided over an interval: 1 holds, 0 does not, -1 undecided."""

    @cython.cfunc
    @cython.exceptval(-2)
    def holds(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        return 0

    def verdict(self, encounter: Encounter, begin: float, end: float) -> bool | None:
        """Return whether it holds throughout (True), nowhere (False), or None."""
        decided: cython.int = self.holds(encounter, begin, end)
        return None if decided < 0 else decided == 1


@cython.cclass
class TooClose(Judge):
    """The distance is less than `law` requires; laws that look ahead are sure of `rounding`."""

    law: Law
    rounding: float

    def __init__(self, law: Law, rounding: float) -> None:
        self.law = law
        self.rounding = rounding

    @cython.cfunc
    @cython.exceptval(-2)
    def holds(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        law: Law = self.law
        if not law.of_speeds:
            return self.short_of(encounter, begin, end)
        encounter.look(begin, end)
        person: Follower = encounter.person
        machine: Follower = encounter.machine
        near: float = encounter.near
        far: float = encounter.far
        most: float = law.distance(person.high, machine.high)
        # The second limit is below the first, so that rounding can't leave a tie undecided.
        if near + encounter.slack >= most:
            return 0
        least: float = law.distance(person.low, machine.low)
        if far + encounter.slack / 2 < least:
            return 1
        if not least <= most:
            raise ValueError(
                f"{law.source} requires {least} m at speeds of {person.low:g} and"
                f" {machine.low:g} m/s, but {most} m at {person.high:g} and {machine.high:g} m/s;"
                " a law must not ask for less when speeds grow"
            )
        return UNDECIDED

    @cython.cfunc
    @cython.exceptval(-2)
    def short_of(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        margin_bounds(self.law, encounter, begin, end)
        if encounter.near >= -self.rounding:
            return 0
        if encounter.far < -self.rounding / 2:
            return 1
        if not encounter.near <= encounter.far:
            raise ValueError(f"a law requires {self.law.out.value} m from t = {begin} s to {end} s")
        return UNDECIDED


@cython.cfunc
def margin_bounds(law: Law, encounter: Encounter, begin: float, end: float) -> cython.int:
    """Bound distance − required: `near`, `far` of the encounter; `offset` is near the least."""
    law.require(encounter, begin, end)
    out: Figure = law.out
    if begin == end:
        encounter.measure(begin - encounter.since, 0.0, 0.0, 0.0)
        encounter.near -= out.value
        encounter.far = encounter.near
        encounter.offset = begin
        return 0
    encounter.apart_over(begin, end, out.slope, out.curve)
    encounter.near = encounter.near - out.value - out.slack
    encounter.far = encounter.far - out.value + out.slack
    return 0


@cython.cclass
class Faster(Judge):
    """The machine moves faster than `limit` m/s."""

    limit: float

    def __init__(self, limit: float) -> None:
        self.limit = limit

    @cython.cfunc
    @cython.exceptval(-2)
    def holds(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        half: float = (end - begin) / 2
        machine: Follower = encounter.machine
        machine.pace(begin - encounter.since + half, half)
        if machine.high <= self.limit:
            return 0
        return 1 if machine.low > self.limit else UNDECIDED


@cython.cclass
class Approaching(Judge):
    """The places of the two come closer to each other."""

    @cython.cfunc
    @cython.exceptval(-2)
    def holds(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        encounter.close_in(begin, end)
        if encounter.near >= 0.0:
            return 0
        return 1 if encounter.far < 0.0 else UNDECIDED


@cython.cclass
class Apart(Judge):
    """The distance is at least `metres`."""

    metres: float

    def __init__(self, metres: float) -> None:
        self.metres = metres

    @cython.cfunc
    @cython.exceptval(-2)
    def holds(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        encounter.look(begin, end)
        if encounter.far + encounter.slack / 2 < self.metres:
            return 0
        return 1 if encounter.near + encounter.slack >= self.metres else UNDECIDED


@cython.cclass
class Not(Judge):
    """Another condition does not hold."""

    other: Judge

    def __init__(self, other: Judge) -> None:
        self.other = other

    @cython.cfunc
    @cython.exceptval(-2)
    def holds(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        verdict: cython.int = self.other.holds(encounter, begin, end)
        return verdict if verdict < 0 else 1 - verdict


@cython.cclass
class Both(Judge):
    """Two conditions hold at once."""

    first: Judge
    second: Judge

    def __init__(self, first: Judge, second: Judge) -> None:
        self.first = first
        self.second = second

    @cython.cfunc
    @cython.exceptval(-2)
    def holds(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        one: cython.int = self.first.holds(encounter, begin, end)
        if one == 0:
            return 0
        other: cython.int = self.second.holds(encounter, begin, end)
        if other == 0:
            return 0
        return 1 if one == 1 and other == 1 else UNDECIDED


@cython.cclass
class OwnJudge(Judge):
    """A condition that is written in Python."""

    condition: Any

    def __init__(self, condition: Any) -> None:
        self.condition = condition

    @cython.cfunc
    @cython.exceptval(-2)
    def holds(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        verdict = self.condition.holds(encounter, begin, end)
        if verdict is None:
            return UNDECIDED
        return 1 if verdict else 0


@cython.cclass
class Watch:
    """Finds the instants at which a condition begins and ceases to hold, one after another.

    Undecided intervals are halved, left half first, until they are no longer than `resolution`.
    """

    judge: Judge
    encounter: Encounter
    end: float
    resolution: float
    held: cython.bint
    over: cython.bint
    undecided: list[float]  # ends and begins of intervals, the next one last

    def __init__(
        self, judge: Judge, encounter: Encounter, begin: float, end: float, resolution: float
    ) -> None:
        self.judge = judge
        self.encounter = encounter
        self.end = end
        self.resolution = resolution
        self.held = False
        self.over = False
        self.undecided = []
        encounter.start(begin)

    def change(self) -> float | None:
        """Return the next instant at which the condition begins or ceases to hold, seconds."""
        encounter: Encounter = self.encounter
        judge: Judge = self.judge
        undecided: list[float] = self.undecided
        lower: float
        upper: float
        t: float
        middle: float
        holds: cython.int
        if self.over:
            return None
        while True:
            if undecided:
                lower = undecided.pop()
                upper = undecided.pop()
            elif encounter.go_on(self.end):
                lower = encounter.since
                upper = encounter.until
            else:
                break
            t = lower
            holds = judge.holds(encounter, lower, upper)
            if holds < 0:
                middle = lower + (upper - lower) / 2
                if upper - lower > self.resolution and lower < middle and middle < upper:
                    undecided.append(upper)
                    undecided.append(middle)
                    undecided.append(middle)
                    undecided.append(lower)
                    continue
                holds = judge.holds(encounter, lower, lower)
                if holds != 1:
                    holds = 0
                    if judge.holds(encounter, upper, upper) == 1:
                        t = upper
                        holds = 1
            if (holds == 1) != self.held:
                self.held = holds == 1
                return t
        self.over = True
        return self.end if self.held else None


def least(
    law: Law | None, encounter: Encounter, begin: float, end: float, tolerance: float
) -> tuple[float, float]:
    """Return the first instant at which distance − required is least (seconds), and how much.

    Without a law nothing is required. Exact to `tolerance` metres.
    """
    best: float = INFINITY
    when: float = 0.0
    lower: float
    upper: float
    low: float
    high: float
    candidate: float
    middle: float
    undecided: list[float] = []
    encounter.start(begin)
    while True:
        if undecided:
            lower = undecided.pop()
            upper = undecided.pop()
        elif encounter.go_on(end):
            lower = encounter.since
            upper = encounter.until
        else:
            return when, best
        margin_over(law, encounter, lower, upper)
        low = encounter.near
        high = encounter.far
        candidate = encounter.offset
        if low >= best - tolerance:
            continue
        if (low + high) != (low + high):
            raise ValueError(f"the law asks for no finite distance from {lower} s to {upper} s")
        k: cython.Py_ssize_t
        for k in range(3):
            t: float = lower if k == 0 else candidate if k == 1 else upper
            margin_over(law, encounter, t, t)
            if encounter.near < best - 1e-12:
                when = t
                best = encounter.near
        middle = lower + (upper - lower) / 2
        if low < best - tolerance and lower < middle and middle < upper:
            undecided.append(upper)
            undecided.append(middle)
            undecided.append(middle)
            undecided.append(lower)


@cython.cfunc
def margin_over(law: Law | None, encounter: Encounter, begin: float, end: float) -> cython.int:
    """See `margin_bounds`; without a law, bound the distance."""
    if law is None:
        return encounter.apart_over(begin, end, 0.0, 0.0)
    return margin_bounds(law, encounter, begin, end)
