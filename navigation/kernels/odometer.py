"""Path length and speed of a motion over an interval, as Taylor models.

A Taylor model is a polynomial with a bound of its remainder (K. Makino and M. Berz, "Taylor models
and other validated functional inclusion methods", International Journal of Pure and Applied
Mathematics 4, 2003). Lengths are integrated by Gauss-Legendre quadrature.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..polynomials import NODES_8, WEIGHTS_8
from .numbers import numbers

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

if not cython.compiled:
    from .cubics import *

    def radius_of(model: TaylorModel, half: float) -> float:
        """Return by how much a number may differ from its value within `half` seconds."""
        return (abs(model.slope) + abs(model.curve) * half / 2) * half + model.slack


# Nodes from 0 to 2, so that half a length times a node is a place from 0 to that length.
_NODES: Numbers = numbers([1.0 + node for node in NODES_8])
_WEIGHTS: Numbers = numbers(WEIGHTS_8)


def speed_along(piece: PosePiece, begin: float, end: float) -> TaylorModel:
    """Return the speed of a piece over an interval within it, m/s.

    Its second derivative is at most a² / |v| + |j|, with a the acceleration across the velocity.
    """
    half: float = (end - begin) / 2
    x: Cubic = shift(piece.x, begin - piece.begin + half)
    y: Cubic = shift(piece.y, begin - piece.begin + half)
    pace: float = norm(x.v, y.v)
    if half == 0.0 or is_straight(x, y):
        return TaylorModel(pace, 0.0, 0.0, 0.0)
    ax: float = 2 * x.a
    ay: float = 2 * y.a
    jx: float = 6 * x.j
    jy: float = 6 * y.j
    jerk: float = norm(jx, jy)
    change: float = (norm(ax, ay) + jerk * half) * half
    least: float = pace - change
    if least > 0.0:
        # v × a at u seconds from the middle is v × a + (v × j) u + (a × j) u² / 2, as a × a is 0.
        # Over |v| it is the acceleration across the velocity.
        across: float = abs(x.v * ay - y.v * ax) + half * abs(x.v * jy - y.v * jx)
        across += half * half / 2 * abs(ax * jy - ay * jx)
        ratio: float = across / least
        bend: float = (ratio * ratio / least + jerk) * half * half / 2
        # Near a standstill the second derivative has no useful bound; the first has one.
        if bend < change:
            return TaylorModel(pace, (x.v * ax + y.v * ay) / pace, bend, 0.0)
    return TaylorModel(pace, 0.0, change, 0.0)


class PathLength:
    """Path length and speed of a motion at any time. Jumps add no length."""

    def __init__(self, table: Numbers) -> None:
        row: PosePieces = poses(table)
        self.table = table
        self.stretches: Numbers = room(0)
        self.before: Numbers = self.stretches
        self.total = 0.0
        self.start = row[0].begin
        self.finish = end_of(table)

    def smooth_stretches(self) -> tuple[Numbers, Numbers, float]:
        """Return the stretches in which speed is smooth, the lengths before each, and the whole."""
        raise NotImplementedError

    def reading(self, t: float) -> float:
        """Return the length of the path up to `t` (seconds), metres; exact to 1e-12 of it."""
        if len(self.stretches) == 0:
            self.stretches, self.before, self.total = self.smooth_stretches()
        if t >= self.finish:
            return self.total
        if t <= self.start:
            return 0.0
        k: cython.Py_ssize_t = planar_at(self.stretches, t)
        stretch: PlanarPiece = planar(self.stretches)[k]
        walked: float = at(self.before)[k] + length(self.stretches, k, t - stretch.begin)
        return walked

    def length_ahead(self, begin: float, end: float, seconds: float) -> TaylorModel:
        """Return the path length within `seconds` of each time of an interval."""
        half: float = (end - begin) / 2
        middle: float = begin + half
        ahead: float = self.reading(middle + seconds) - self.reading(middle)
        if half == 0.0:
            return TaylorModel(ahead, 0.0, 0.0, 0.0)
        # Its derivative is the speed at the far end less that at the near one. Its second
        # derivative, then, is the difference of the two slopes, and what both are uncertain of adds
        # up over half the interval.
        near: TaylorModel = self.speed_over(begin, end)
        far: TaylorModel = self.speed_over(begin + seconds, end + seconds)
        slack: float = (far.slack + near.slack) * half
        return TaylorModel(ahead, far.value - near.value, slack, far.slope - near.slope)

    def speed_over(self, begin: float, end: float) -> TaylorModel:
        """Return the speed over an interval; at a change, the one after it."""
        row: PosePieces = poses(self.table)
        if end < self.start or begin >= self.finish:
            return TaylorModel(0.0, 0.0, 0.0, 0.0)
        k: cython.Py_ssize_t = pose_at(self.table, begin)
        if k >= 0 and end <= row[k].end:
            return speed_along(row[k], begin, end)
        # Over several pieces the speed may jump: its least and its most are all that holds.
        low: float = INFINITY
        high: float = 0.0
        if begin < self.start or end > self.finish:
            low = 0.0
        k = max(k, 0)
        while k < pose_count(self.table) and row[k].begin < end:
            since: float = max(begin, row[k].begin)
            until: float = min(end, row[k].end)
            if until > since:
                model: TaylorModel = speed_along(row[k], since, until)
                around: float = radius_of(model, (until - since) / 2)
                low = min(low, model.value - around)
                high = max(high, model.value + around)
            k += 1
        low = max(low, 0.0)
        return TaylorModel((low + high) / 2, 0.0, (high - low) / 2, 0.0)

    def path_ahead(
        self, begin: float, end: float, seconds: float
    ) -> tuple[float, float, float, float]:
        """Return the numbers of `length_ahead`."""
        model: TaylorModel = self.length_ahead(begin, end, seconds)
        return model.value, model.slope, model.slack, model.curve

    def speed_within(self, begin: float, end: float) -> tuple[float, float, float, float]:
        """Return the numbers of `speed_over`."""
        model: TaylorModel = self.speed_over(begin, end)
        return model.value, model.slope, model.slack, model.curve


def length(stretches: Numbers, k: cython.Py_ssize_t, u: float) -> float:
    """Return the length of the first `u` seconds of a stretch, metres."""
    stretch: PlanarPiece = planar(stretches)[k]
    if is_straight(stretch.x, stretch.y):
        return norm(stretch.x.v, stretch.y.v) * u
    # Stretches are cut so that eight nodes are enough: see `_ELLIPSE` in `navigation.encounter`.
    half: float = u / 2
    total: float = 0.0
    nodes: Doubles = at(_NODES)
    weights: Doubles = at(_WEIGHTS)
    i: cython.Py_ssize_t
    for i in range(8):
        total += weights[i] * speed(stretch.x, stretch.y, half * nodes[i])
    return half * total
