"""Distances between the surfaces of a person and of a machine that turns."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

if not cython.compiled:
    from math import sqrt

else:
    from cython.cimports.libc.math import sqrt

_INFINITE: float = float("inf")


class Course:
    """Motion of a person in the frame that a machine has at the middle of an interval.

    Place, velocity and half the acceleration, and how fast the machine turns. For `half` seconds
    before and after, the person stays within `bend` (m) of place and velocity, and within `jolt`
    if the acceleration counts too; the machine stays within `twist` (rad) and turns by no more
    than `swing`.
    """

    def __init__(self) -> None:
        self.x = self.y = self.vx = self.vy = self.ax = self.ay = 0.0
        self.spin = self.half = self.bend = self.jolt = self.twist = self.swing = 0.0


class Gauge:
    """Measures between a person, an upright cylinder, and one part of a machine, in its frame.

    The part's footprint is a rectangle of half lengths `along` and `across` about the machine's
    axis, grown by `rounding`: a box has no rounding, a cylinder no lengths. `height` is the gap
    between the heights of the two. All in metres.
    """

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
            # The nearest point of the rounded footprint is on the same line, farther out by the
            # rounding.
            self.at_x += dx * (self.rounding / gap)
            self.at_y += dy * (self.rounding / gap)
        return self.over(self.away)

    def over(self, away: float) -> float:
        """The distance from the part to a person whose axis is `away` metres from its footprint."""
        flat: float = max(away - self.radius, 0.0)
        return sqrt(flat * flat + self.height * self.height)

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
        # |exp(iθ) − 1 − iθ| ≤ θ² / 2: a point that turns by θ leaves its tangent by so much of its
        # radius; `twist` is the part of θ that the steady spin leaves out.
        turned: float = c.twist + c.swing * c.swing / 2
        moved: float = sqrt(c.vx * c.vx + c.vy * c.vy) * half + c.bend
        if away == 0.0:
            # Within the footprint there is no plane between the two; only the heights keep them
            # apart.
            around: float = (abs(slope) + abs(curve) / 2 * half) * half
            self.low = self.height - around
            self.high = self.over(moved + farthest * c.swing) + around
            return 0
        dx: float = c.x - self.at_x
        dy: float = c.y - self.at_y
        # How far the person gets from the part's point in half the interval: the point itself goes
        # at spin × (−y, x).
        wx: float = (c.vx + c.spin * self.at_y) * half
        wy: float = (c.vy - c.spin * self.at_x) * half
        rise: float = slope * half
        bow: float = abs(curve) / 2 * half * half
        bent: float = c.bend + farthest * turned
        # `over` is convex and does not fall, so along a straight line it is greatest at an end.
        px: float = dx + wx
        py: float = dy + wy
        after: float = self.over(sqrt(px * px + py * py) + bent) - rise
        px = dx - wx
        py = dy - wy
        before: float = self.over(sqrt(px * px + py * py) + bent) + rise
        self.high = max(after, before) + bow
        if away <= self.radius:
            # One is above the other: the distance is the height, which never changes.
            self.low = distance - abs(rise) - bow
            if not (slope or curve):
                self.low = max(self.low, self.height)
            return 0
        # The plane's normal leans: `level` is its share along the floor, height / distance the
        # rest. What lies along it is counted without the height and the two radii, which are added
        # below.
        level: float = (away - self.radius) / distance
        nx: float = dx / away * level
        ny: float = dy / away * level
        towards: float = nx * c.vx + ny * c.vy - slope
        low: float = _INFINITE
        nearest: float = _INFINITE
        corner: cython.Py_ssize_t
        # A rectangle reaches farthest along a normal at one of its corners, whichever way it turns.
        for corner in range(4):
            cx: float = self.along if corner % 2 == 0 else -self.along
            cy: float = self.across if corner < 2 else -self.across
            apart: float = nx * (c.x - cx) + ny * (c.y - cy)
            low = min(low, apart - abs(towards + c.spin * (nx * cy - ny * cx)) * half)
            nearest = min(nearest, apart)
        low -= abs(nx * c.ax + ny * c.ay - curve / 2) * half * half
        low -= level * (c.jolt + self.reach * turned)
        if c.swing > 0.0 and self.reach > 0.0:
            # The same with a normal that turns along: then the corners rest, and it is the person
            # who is carried round, with what they move meanwhile.
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
        return 0
