"""Bounds on the distance of two motions, and on its rate, over intervals of time.

Distances are between centres, or between the surfaces of a person and of a machine that turns.

The distance is bounded to third order by its Taylor model about the middle of an interval. It is
exact for the tangents, which are convex, with a bound of the remainder. Undecided intervals are
halved, so that nothing is missed (interval subdivision as in S. Redon, A. Kheddar and S.
Coquillart, "Fast continuous collision detection between rigid bodies", Computer Graphics Forum 21,
2002).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

from .numbers import numbers
from .results import Bounds, DistanceBounds, Enclosure

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

if not cython.compiled:
    from math import copysign, cos, sin, sqrt

    from .cubics import *
    from .odometer import Odometer, enclosure_of, speed_along

_NONE: Numbers = room(0)
_SOME: cython.Py_ssize_t = 64  # initial room for ends of intervals
_SURFACE_ROUNDING: float = 1e-12  # metres; rounding of distances between surfaces
_NEAR: float = 1e-9  # metres; at smaller distances the direction to the other is mostly rounding


class Gauge:
    """Distance of a person, an upright cylinder, from one part of a machine, in its frame.

    The part's footprint is a rectangle of half lengths `along` and `across` about the machine's
    axis, grown by `rounding`. A box has no rounding, a cylinder no lengths. `height` is the gap
    between the heights of the two. All values are in metres.
    """

    def __init__(
        self, radius: float, height: float, along: float, across: float, rounding: float
    ) -> None:
        self.radius = radius
        self.height = height
        self.along = along
        self.across = across
        self.rounding = rounding
        self.reach = norm(along, across)
        self.corners = numbers([along, across, -along, across, along, -across, -along, -across])

    def nearest(self, x: float, y: float) -> NearestPoint:
        """Return the point of the footprint nearest to (x, y).

        Within the footprint the distance is 0 and the point is undefined.
        """
        px: float = min(max(x, -self.along), self.along)
        py: float = min(max(y, -self.across), self.across)
        dx: float = x - px
        dy: float = y - py
        gap: float = norm(dx, dy)
        away: float = max(gap - self.rounding, 0.0)
        if gap > 0.0:
            # The nearest point of the rounded footprint is farther out on the same line.
            px += dx * (self.rounding / gap)
            py += dy * (self.rounding / gap)
        return NearestPoint(px, py, away, self.over(away))

    def over(self, away: float) -> float:
        """Return the distance from the part to a person `away` metres from its footprint."""
        return norm(max(away - self.radius, 0.0), self.height)

    def distances(self, c: RelativeMotion, slope: float, curve: float) -> Range:
        """Bound distance − `slope` u − `curve` u² / 2 for all times u of a relative motion.

        The lower bound is that of a plane that separates the two at the middle. The plane keeps its
        normal, or turns with the machine, which is better beside a turning wall. Along the normal,
        the person and the corners of the footprint move at a known rate. The upper bound is the
        distance from the person to the point of the part that is nearest at the middle. The errors
        of both are of second order in `half`.
        """
        half: float = c.half
        nearest: NearestPoint = self.nearest(c.x, c.y)
        away: float = nearest.away
        farthest: float = self.reach + self.rounding
        # |exp(iθ) − 1 − iθ| ≤ θ² / 2 bounds the deviation from the tangent of a point that turns
        # by θ, relative to its radius. `twist` is the part of θ not due to the steady spin.
        turned: float = c.twist + c.swing * c.swing / 2
        moved: float = norm(c.vx, c.vy) * half + c.bend
        if away == 0.0:
            # Within the footprint only the heights separate the two.
            around: float = (abs(slope) + abs(curve) / 2 * half) * half
            return Range(self.height - around, self.over(moved + farthest * c.swing) + around)
        dx: float = c.x - nearest.x
        dy: float = c.y - nearest.y
        # Motion of the person relative to the part's point in half the interval. The point moves at
        # spin × (−y, x).
        wx: float = (c.vx + c.spin * nearest.y) * half
        wy: float = (c.vy - c.spin * nearest.x) * half
        rise: float = slope * half
        bow: float = abs(curve) / 2 * half * half
        bent: float = c.bend + farthest * turned
        # `over` is convex and never decreases, so on a straight line its maximum is at an end.
        after: float = self.over(norm(dx + wx, dy + wy) + bent) - rise
        before: float = self.over(norm(dx - wx, dy - wy) + bent) + rise
        high: float = max(after, before) + bow
        low: float = nearest.distance - abs(rise) - bow
        if away <= self.radius:
            # One is above the other, so the distance is the height.
            return Range(low if slope or curve else max(low, self.height), high)
        # The plane's normal is inclined, with a horizontal share of `level` and a vertical one of
        # height / distance. The terms of the height and the two radii are added below.
        level: float = (away - self.radius) / nearest.distance
        nx: float = dx / away * level
        ny: float = dy / away * level
        towards: float = nx * c.vx + ny * c.vy - slope
        low = INFINITY
        middle: float = INFINITY
        corner: Positions = positions_of(self.corners)
        k: cython.Py_ssize_t
        # The farthest point of a footprint along a normal is always one of its corners.
        for k in range(position_count(self.corners)):
            cx: float = corner[k].x
            cy: float = corner[k].y
            apart: float = nx * (c.x - cx) + ny * (c.y - cy)
            low = min(low, apart - abs(towards + c.spin * (nx * cy - ny * cx)) * half)
            middle = min(middle, apart)
        low -= abs(nx * c.ax + ny * c.ay - curve / 2) * half * half
        low -= level * (c.jolt + self.reach * turned)
        if c.swing > 0.0 and self.reach > 0.0:
            # The same with a normal that turns with the machine. In its frame the corners rest, and
            # the person rotates in addition to the own motion.
            turning: float = middle - bow
            turning -= abs(towards + c.spin * (nx * c.y - ny * c.x)) * half
            turning -= level * (
                c.bend + norm(c.x, c.y) * turned + moved * (c.swing + c.swing * c.swing / 2)
            )
            low = max(low, turning)
        low += self.height * self.height / nearest.distance - level * (self.radius + self.rounding)
        return Range(low if slope or curve else max(low, self.height), high)


class PolygonGauge(Gauge):
    """Distance of a person from a part whose footprint is a convex polygon.

    `corners` has x and y of each in turn, counterclockwise, in the frame of the machine (metres).
    """

    def __init__(self, radius: float, height: float, corners: list[float]) -> None:
        super().__init__(radius, height, 0.0, 0.0, 0.0)
        self.corners = numbers(corners)
        corner: Positions = positions_of(self.corners)
        k: cython.Py_ssize_t
        for k in range(position_count(self.corners)):
            self.reach = max(self.reach, norm(corner[k].x, corner[k].y))

    def nearest(self, x: float, y: float) -> NearestPoint:
        point: NearestPoint = NearestPoint(x, y, INFINITY, 0.0)
        corner: Positions = positions_of(self.corners)
        count: cython.Py_ssize_t = position_count(self.corners)
        k: cython.Py_ssize_t
        for k in range(count):
            a: Position = corner[k]
            b: Position = corner[k + 1 if k + 1 < count else 0]
            along_x: float = b.x - a.x
            along_y: float = b.y - a.y
            dx: float = x - a.x
            dy: float = y - a.y
            # The polygon is on the left of its sides.
            if along_x * dy - along_y * dx >= 0.0:
                continue
            share: float = (dx * along_x + dy * along_y) / (along_x * along_x + along_y * along_y)
            share = min(max(share, 0.0), 1.0)
            px: float = a.x + share * along_x
            py: float = a.y + share * along_y
            away: float = norm(x - px, y - py)
            if away < point.away:
                point = NearestPoint(px, py, away, 0.0)
        if point.away == INFINITY:
            return NearestPoint(x, y, 0.0, self.over(0.0))
        return NearestPoint(point.x, point.y, point.away, self.over(point.away))


class Follower:
    """Body that follows a motion, at rest before and after it.

    Its coordinates are cubics relative to the time at which the current piece was `entered`.
    """

    def __init__(self, table: Numbers) -> None:
        self.table = table
        self.rows = pose_count(table)
        self.row = -1
        self.since = self.begin = self.end = self.entered = 0.0
        self.x = self.y = self.rotation = constant(0.0)

    def seek(self, t: float) -> cython.int:
        """Move to the piece at `t`."""
        first: float = poses(self.table)[0].begin
        self.since = t
        if t < first:
            self.row = -1
            self.begin = t
            self.end = first
            return 0
        self.row = pose_at(self.table, t) - 1
        return self.go_on()

    def go_on(self) -> cython.int:
        """Move to the next piece. Pieces without duration are skipped."""
        while True:
            self.row += 1
            if self.row >= self.rows:
                self.begin = end_of(self.table)
                self.end = INFINITY
                return 0
            piece: PosePiece = poses(self.table)[self.row]
            self.begin = piece.begin
            self.end = piece.end
            if piece.end > max(self.since, piece.begin):
                if not is_pose_finite(self.table, self.row):
                    raise ValueError(
                        f"a motion is not finite from t = {self.begin} s to {self.end} s"
                    )
                return 0

    def enter(self, t: float) -> cython.int:
        """Set the coordinates relative to `t`, a time within the piece."""
        piece: PosePiece = poses(self.table)[min(max(self.row, 0), self.rows - 1)]
        u: float = 0.0
        if self.row >= self.rows:
            u = piece.end - piece.begin
        elif self.row >= 0:
            u = t - self.begin
        self.entered = t
        self.x = shift(piece.x, u)
        self.y = shift(piece.y, u)
        self.rotation = shift(piece.rotation, u)
        if self.row < 0 or self.row >= self.rows:
            self.x = constant(self.x.p)
            self.y = constant(self.y.p)
            self.rotation = constant(self.rotation.p)
        return 0

    def speeds(self, begin: float, end: float) -> Range:
        """Bound the speed from `begin` to `end`, an interval within the piece."""
        half: float = (end - begin) / 2
        x: Cubic = shift(self.x, begin - self.entered + half)
        y: Cubic = shift(self.y, begin - self.entered + half)
        speed: float = norm(x.v, y.v)
        if is_straight(x, y):
            return Range(speed, speed)
        # The coefficients are half of the acceleration and a sixth of the jerk.
        slack: float = half * 2 * norm(x.a, y.a)
        slack += half * half * 3 * norm(x.j, y.j)
        return Range(0.0 if slack > speed else speed - slack, speed + slack)

    def turning(self, begin: float, end: float) -> Range:
        """Bound the rate of turning (rad/s) from `begin` to `end`, an interval within the piece."""
        half: float = (end - begin) / 2
        turn: Cubic = shift(self.rotation, begin - self.entered + half)
        rate: float = abs(turn.v)
        # The coefficients are half of the acceleration and a sixth of the jerk.
        slack: float = half * (2 * abs(turn.a) + half * 3 * abs(turn.j))
        return Range(max(rate - slack, 0.0), rate + slack)

    def speed_over(self, begin: float, end: float) -> TaylorModel:
        """Return the speed from `begin` to `end`, an interval within the piece."""
        if self.row < 0 or self.row >= self.rows:
            return TaylorModel(0.0, 0.0, 0.0, 0.0)
        return speed_along(poses(self.table)[self.row], begin, end)


def nearest_surface(gauges: list[Gauge], x: float, y: float) -> float:
    """Return the distance between surfaces for a person at (x, y) in the machine's frame (m)."""
    least: float = INFINITY
    gauge: Gauge
    for gauge in gauges:
        least = min(least, gauge.nearest(x, y).distance)
    return least


class Tabled(Protocol):
    """Motion, or part of a motion, with a table of pieces."""

    @property
    def table(self) -> Numbers: ...


class Encounter:
    """Time span in which the motions of a person and a machine are one cubic each.

    It gives custom conditions and laws bounds on distances and speeds. Distances are between
    centres on the floor, or between surfaces.

    Parameters
    ----------
    person, machine : Motion
        Motions.
    gauges : sequence of Gauge, optional
        Kernels that measure between surfaces: see `Shapes.gauges`.
    """

    def __init__(self, person: Tabled, machine: Tabled, gauges: Sequence[Gauge] = ()) -> None:
        self.person = Follower(person.table)
        self.machine = Follower(machine.table)
        self.gauges = [*gauges]
        self._person: Any = person
        self._machine: Any = machine
        self._human: Odometer | None = None
        self._robot: Odometer | None = None
        self.slack = _SURFACE_ROUNDING if gauges else 0.0
        self.begin = self.end = 0.0
        """Begin and end of the time span in seconds."""
        self.started = False
        self.x = self.y = constant(0.0)
        self.lower = self.upper = 0.0
        self.ends = _NONE
        self.left = 0

    def come_to(self, begin: float) -> cython.int:
        """Move to the time `begin`, before the first stretch."""
        self.started = False
        self.left = 0
        self.begin = self.end = begin
        self.person.seek(begin)
        self.machine.seek(begin)
        return 0

    def next_stretch(self, end: float) -> cython.bint:
        """Enter the next stretch, which ends by `end`. Return False if there is none."""
        person: Follower = self.person
        machine: Follower = self.machine
        t: float = self.end
        if self.started:
            if t >= end:
                return False
            if person.end <= t:
                person.go_on()
            if machine.end <= t:
                machine.go_on()
        self.started = True
        self.begin = t
        self.end = min(person.end, machine.end, end)
        person.enter(t)
        machine.enter(t)
        # Both are relative to the same time now, so their difference is a cubic as well.
        self.x = minus(machine.x, person.x)
        self.y = minus(machine.y, person.y)
        return True

    def next_interval(self, end: float) -> cython.bint:
        """Move to the next interval, from `lower` to `upper`. Return False if there is none.

        It is the later part of a divided interval, or the next stretch.
        """
        if self.left > 0:
            self.left -= 1
            self.lower = self.upper
            self.upper = at(self.ends)[self.left]
            return True
        if not self.next_stretch(end):
            return False
        self.lower = self.begin
        self.upper = self.end
        return True

    def halve(self) -> cython.bint:
        """Postpone the later half of the interval. Return False if it is too short."""
        return self.divide(0.5)

    def divide(self, share: float) -> cython.bint:
        """Postpone the part after a share of the interval. Return False if it is too short."""
        lower: float = self.lower
        upper: float = self.upper
        middle: float = lower + (upper - lower) * share
        if not lower < middle < upper:
            return False
        # Each postponed interval begins at the end of the one before it.
        left: cython.Py_ssize_t = self.left
        if left == len(self.ends):
            # A new row, because all encounters share the initial one.
            ends: Numbers = room(max(2 * left, _SOME))
            put(at(ends), 0, at(self.ends), 0, left)
            self.ends = ends
        at(self.ends)[left] = upper
        self.left = left + 1
        self.upper = middle
        return True

    def closest(self, begin: float, end: float, slope: float, curve: float) -> Closest:
        """Bound distance − `slope` u − `curve` u² / 2 from `begin` to `end`, u from the middle.

        The interval is within the stretch.
        """
        half: float = (end - begin) / 2
        middle: float = begin - self.begin + half
        bounds: Closest
        if self.gauges:
            apart: Range = self._between_surfaces(middle, half, slope, curve)
            bounds = Closest(apart.low, apart.high, 0.0)
        else:
            bounds = self._between_centres(middle, half, slope, curve)
        t: float = self.begin + middle + bounds.t
        return Closest(bounds.low, bounds.high, begin if t < begin else end if t > end else t)

    def _between_centres(self, u: float, half: float, slope: float, curve: float) -> Closest:
        """See `closest`, relative to the time u since the begin of the stretch.

        About the middle the relative position is r + v u + (a/2) u² + (j/6) u³. The bounds of |r +
        v u| − slope u are exact, because it is convex. The remainder is at most (a/2) h² + (j/6)
        h³.
        """
        x: Cubic = shift(self.x, u)
        y: Cubic = shift(self.y, u)
        if half == 0.0:
            return Closest(norm(x.p, y.p), norm(x.p, y.p), 0.0)
        t: float = _lowest_on_line(x, y, half, slope) if slope else nearest_on_line(x, y, half)
        near: float = norm(x.p + x.v * t, y.p + y.v * t)
        # The maximum of a convex function is at an end.
        before: float = norm(x.p - x.v * half, y.p - y.v * half)
        after: float = norm(x.p + x.v * half, y.p + y.v * half)
        bend: float
        if slope or curve:
            rise: float = slope * half
            bend = _deviation_of_distance(x, y, half, curve)
            return Closest(near - slope * t - bend, max(before + rise, after - rise) + bend, t)
        bend = deviation(x, y, half)
        return Closest(max(near - bend, 0.0), max(before, after) + bend, t)

    def _between_surfaces(self, u: float, half: float, slope: float, curve: float) -> Range:
        """See `closest`. The bounds are exact to second order in `half`."""
        x: Cubic = shift(self.x, u)
        y: Cubic = shift(self.y, u)
        turn: Cubic = shift(self.machine.rotation, u)
        c: float = cos(turn.p)
        s: float = sin(turn.p)
        # The coefficients are half of the acceleration and a sixth of the jerk, so these bound the
        # terms of second and third order.
        jolt: float = half * half * half * norm(x.j, y.j)
        twist: float = half * half * (abs(turn.a) + half * abs(turn.j))
        # The person in the frame of the machine at the middle.
        person: RelativeMotion = RelativeMotion(
            -(c * x.p + s * y.p),
            s * x.p - c * y.p,
            -(c * x.v + s * y.v),
            s * x.v - c * y.v,
            -(c * x.a + s * y.a),
            s * x.a - c * y.a,
            turn.v,
            half,
            half * half * norm(x.a, y.a) + jolt,
            jolt,
            twist,
            abs(turn.v) * half + twist,
        )
        low: float = INFINITY
        high: float = INFINITY
        if half == 0.0:
            low = nearest_surface(self.gauges, person.x, person.y)
            return Range(low, low)
        gauge: Gauge
        for gauge in self.gauges:
            apart: Range = gauge.distances(person, slope, curve)
            low = min(low, apart.low)
            high = min(high, apart.high)
        return Range(low, high)

    def approach(self, begin: float, end: float) -> Range:
        """Bound the rate of half the squared distance of the centres (m²/s)."""
        h: float = (end - begin) / 2
        x: Cubic = shift(self.x, begin - self.begin + h)
        y: Cubic = shift(self.y, begin - self.begin + h)
        # r·v as a polynomial about the middle, with the maximum of each term.
        rate: float = x.p * x.v + y.p * y.v
        slack: float = h * (
            abs(x.v * x.v + y.v * y.v + 2 * (x.p * x.a + y.p * y.a))
            + h
            * (
                3 * abs(x.v * x.a + y.v * y.a + x.p * x.j + y.p * y.j)
                + h
                * (
                    abs(2 * (x.a * x.a + y.a * y.a) + 4 * (x.v * x.j + y.v * y.j))
                    + h * (5 * abs(x.a * x.j + y.a * y.j) + h * 3 * (x.j * x.j + y.j * y.j))
                )
            )
        )
        return Range(rate - slack, rate + slack)

    @property
    def human(self) -> Odometer:
        """Path length and speed of the person's whole motion."""
        if self._human is None:
            self._human = Odometer(self._person)
        return self._human

    @property
    def robot(self) -> Odometer:
        """Path length and speed of the machine's whole motion."""
        if self._robot is None:
            self._robot = Odometer(self._machine)
        return self._robot

    def distance(self, t: float) -> float:
        """Return the distance at `t` in metres, 0 if surfaces overlap."""
        apart: Closest = self.closest(t, t, 0.0, 0.0)
        return apart.low

    def closing(self, begin: float, end: float) -> tuple[float, float]:
        """Return bounds on the derivative of half the squared distance in m²/s.

        It is negative while the centres approach each other.
        """
        rate: Range = self.approach(begin, end)
        return rate.low, rate.high

    def bounds(self, begin: float, end: float) -> Bounds:
        """Return bounds on distance and speeds from `begin` to `end`, within this time span."""
        apart: Closest = self.closest(begin, end, 0.0, 0.0)
        human: Range = self.person.speeds(begin, end)
        robot: Range = self.machine.speeds(begin, end)
        return Bounds(apart.low, apart.high, human.low, human.high, robot.low, robot.high)

    def apart(
        self, begin: float, end: float, slope: float = 0.0, curve: float = 0.0
    ) -> DistanceBounds:
        """Return bounds on distance − `slope` u − `curve` u² / 2, u from the interval's middle.

        Slope (m/s) and curve (m/s²) are derivatives of a required distance.
        """
        apart: Closest = self.closest(begin, end, slope, curve)
        return DistanceBounds(apart.low, apart.high, apart.t)

    def human_speed(self, begin: float, end: float) -> Enclosure:
        """Return the human's speed in m/s over an interval within this time span."""
        return enclosure_of(self.person.speed_over(begin, end))

    def robot_speed(self, begin: float, end: float) -> Enclosure:
        """Return the robot's speed in m/s over an interval within this time span."""
        return enclosure_of(self.machine.speed_over(begin, end))


def _lowest_on_line(x: Cubic, y: Cubic, half: float, slope: float) -> float:
    """Return the u, |u| <= half, that minimizes the tangent's distance from the origin − slope u.

    With d the distance of the line r + v u from the origin, √(d² + v² (u − u₀)²) − slope u has its
    minimum where v² (u − u₀) is slope times the root: u − u₀ = d slope / (v √(v² − slope²)).
    """
    square: float = x.v * x.v + y.v * y.v
    if square <= slope * slope:
        # The slope exceeds the speed along the line, so the difference is monotonic.
        return copysign(half, slope)
    u: float = -(x.p * x.v + y.p * y.v) / square
    u += abs(x.p * y.v - y.p * x.v) / square * (slope / sqrt(square - slope * slope))
    return -half if u < -half else half if u > half else u


def _deviation_of_distance(x: Cubic, y: Cubic, half: float, curve: float) -> float:
    """Bound the deviation of distance − curve u² / 2 from that along a line, to third order.

    With n the direction of r, it is (n·a − curve) u² / 2 + (n·j/6) u³, plus terms due to the
    rotation of n and to the deviation across n.
    """
    bend: float = deviation(x, y, half)
    # Moving the end of a vector by `bend` changes its length by no more than that.
    whole: float = bend + abs(curve) / 2 * half * half
    away: float = norm(x.p, y.p)
    # `nearest` bounds the distance on the line r + v u. The rate at which n turns is r × v over the
    # squared distance, and r × v is constant, so n turns by at most |r × v| h / nearest².
    nearest: float = away - norm(x.v, y.v) * half
    if nearest < _NEAR:
        return whole
    along: float = abs((x.p * x.a + y.p * y.a) / away - curve / 2)
    along += abs(x.p * x.j + y.p * y.j) / away * half
    turn: float = abs(x.p * y.v - y.p * x.v) * half / (nearest * nearest)
    # √(p² + q²) exceeds p by at most q² / (2 p), the effect of a displacement q across n.
    return min(along * half * half + bend * (turn + bend / (2 * nearest)), whole)
