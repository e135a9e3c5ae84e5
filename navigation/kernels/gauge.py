"""Distances between the surfaces of a person and of a machine that turns."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

if not cython.compiled:
    from .cubics import *


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
        self.reach = norm(along, across)

    def nearest(self, x: float, y: float) -> NearestPoint:
        """Return the point of the footprint nearest to (x, y).

        Within the footprint its distance is 0, and the point means nothing.
        """
        px: float = min(max(x, -self.along), self.along)
        py: float = min(max(y, -self.across), self.across)
        dx: float = x - px
        dy: float = y - py
        gap: float = norm(dx, dy)
        away: float = max(gap - self.rounding, 0.0)
        if gap > 0.0:
            # The nearest point of the rounded footprint is on the same line, farther out by the
            # rounding.
            px += dx * (self.rounding / gap)
            py += dy * (self.rounding / gap)
        return NearestPoint(px, py, away, self.over(away))

    def over(self, away: float) -> float:
        """Return the distance from the part to a person `away` metres from its footprint."""
        return norm(max(away - self.radius, 0.0), self.height)

    def distances(self, c: RelativeMotion, slope: float, curve: float) -> Range:
        """Bound distance − `slope` u − `curve` u² / 2 for all times u of a relative motion.

        The lower bound is that of a plane that separates the two at the middle: one that keeps its
        normal, or one that turns with the machine (better beside a wall that turns). Along the
        normal, the person and the corners of the footprint move at a known rate. The upper bound is
        the distance from the person to the part's point that is nearest at the middle and moves
        with it. Both are off by second order in `half`.
        """
        half: float = c.half
        nearest: NearestPoint = self.nearest(c.x, c.y)
        away: float = nearest.away
        farthest: float = self.reach + self.rounding
        # |exp(iθ) − 1 − iθ| ≤ θ² / 2: a point that turns by θ leaves its tangent by so much of its
        # radius; `twist` is the part of θ that the steady spin leaves out.
        turned: float = c.twist + c.swing * c.swing / 2
        moved: float = norm(c.vx, c.vy) * half + c.bend
        if away == 0.0:
            # Within the footprint there is no plane between the two; only the heights keep them
            # apart.
            around: float = (abs(slope) + abs(curve) / 2 * half) * half
            return Range(self.height - around, self.over(moved + farthest * c.swing) + around)
        dx: float = c.x - nearest.x
        dy: float = c.y - nearest.y
        # How far the person gets from the part's point in half the interval: the point itself goes
        # at spin × (−y, x).
        wx: float = (c.vx + c.spin * nearest.y) * half
        wy: float = (c.vy - c.spin * nearest.x) * half
        rise: float = slope * half
        bow: float = abs(curve) / 2 * half * half
        bent: float = c.bend + farthest * turned
        # `over` is convex and does not fall, so along a straight line it is greatest at an end.
        after: float = self.over(norm(dx + wx, dy + wy) + bent) - rise
        before: float = self.over(norm(dx - wx, dy - wy) + bent) + rise
        high: float = max(after, before) + bow
        low: float = nearest.distance - abs(rise) - bow
        if away <= self.radius:
            # One is above the other: the distance is the height, which never changes.
            return Range(low if slope or curve else max(low, self.height), high)
        # The plane's normal leans: `level` is its share along the floor, height / distance the
        # rest. What lies along it is counted without the height and the two radii, which are added
        # below.
        level: float = (away - self.radius) / nearest.distance
        nx: float = dx / away * level
        ny: float = dy / away * level
        towards: float = nx * c.vx + ny * c.vy - slope
        low = INFINITY
        middle: float = INFINITY
        corner: cython.Py_ssize_t
        # A rectangle reaches farthest along a normal at one of its corners, whichever way it turns.
        for corner in range(4):
            cx: float = self.along if corner % 2 == 0 else -self.along
            cy: float = self.across if corner < 2 else -self.across
            apart: float = nx * (c.x - cx) + ny * (c.y - cy)
            low = min(low, apart - abs(towards + c.spin * (nx * cy - ny * cx)) * half)
            middle = min(middle, apart)
        low -= abs(nx * c.ax + ny * c.ay - curve / 2) * half * half
        low -= level * (c.jolt + self.reach * turned)
        if c.swing > 0.0 and self.reach > 0.0:
            # The same with a normal that turns along: then the corners rest, and it is the person
            # who is carried round, with what they move meanwhile.
            turning: float = middle - bow
            turning -= abs(towards + c.spin * (nx * c.y - ny * c.x)) * half
            turning -= level * (
                c.bend + norm(c.x, c.y) * turned + moved * (c.swing + c.swing * c.swing / 2)
            )
            low = max(low, turning)
        low += self.height * self.height / nearest.distance - level * (self.radius + self.rounding)
        return Range(low if slope or curve else max(low, self.height), high)
