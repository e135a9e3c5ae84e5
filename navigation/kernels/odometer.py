"""Path length and speed of a motion over an interval, as Taylor models.

A Taylor model is a polynomial with a bound of its remainder (K. Makino and M. Berz, "Taylor models
and other validated functional inclusion methods", International Journal of Pure and Applied
Mathematics 4, 2003). Lengths are integrated by Gauss-Legendre quadrature.
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any

from .numbers import numbers
from .results import Enclosure
from .smoothness import NODES_8, WEIGHTS_8, smooth_cuts

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

if not cython.compiled:
    from .cubics import *

    def radius_of(model: TaylorModel, half: float) -> float:
        """Return the maximum difference from the value within `half` seconds."""
        return (abs(model.slope) + abs(model.curve) * half / 2) * half + model.slack


# Nodes from 0 to 2, so that half a length times a node is a position from 0 to that length.
_NODES: Numbers = numbers([1.0 + node for node in NODES_8])
_WEIGHTS: Numbers = numbers(WEIGHTS_8)

_STRETCHES = "_stretches"
"""Key under which a motion caches its stretches, because predictive laws often need them."""


def enclosure_of(model: TaylorModel) -> Enclosure:
    """Return a model as an object for custom laws."""
    return Enclosure(value=model.value, slope=model.slope, slack=model.slack, curve=model.curve)


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
        # Near a standstill only the first derivative has a useful bound.
        if bend < change:
            return TaylorModel(pace, (x.v * ax + y.v * ay) / pace, bend, 0.0)
    return TaylorModel(pace, 0.0, change, 0.0)


class Odometer:
    """Path length and speed of a motion at any time. Jumps add no length."""

    def __init__(self, motion: Any) -> None:
        self.motion = motion
        self.table = motion.table
        self.stretches: Numbers = room(0)
        self.before: Numbers = self.stretches
        self.total = 0.0

    def ahead(self, begin: float, end: float, seconds: float) -> Enclosure:
        """Return the path length (m) in the `seconds` after each time from `begin` to `end`."""
        return enclosure_of(self.length_ahead(begin, end, seconds))

    def speed(self, begin: float, end: float) -> Enclosure:
        """Return the speed (m/s) from `begin` to `end`. At a jump, it is the speed after it."""
        return enclosure_of(speed_over(self.table, begin, end))

    def reading(self, t: float) -> float:
        """Return the length of the path up to `t` (s) in metres, with a relative error of 1e-12."""
        if len(self.stretches) == 0:
            self.stretches, self.before, self.total = smooth_stretches(self.motion)
        if t >= end_of(self.table):
            return self.total
        if t <= poses(self.table)[0].begin:
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
        # The derivative is the speed at the far end less that at the near end. The second
        # derivative is the difference of both slopes. Both uncertainties add up over half of the
        # interval.
        near: TaylorModel = speed_over(self.table, begin, end)
        far: TaylorModel = speed_over(self.table, begin + seconds, end + seconds)
        slack: float = (far.slack + near.slack) * half
        return TaylorModel(ahead, far.value - near.value, slack, far.slope - near.slope)


def speed_over(table: Numbers, begin: float, end: float) -> TaylorModel:
    """Return the speed of a motion over an interval. At a jump, it is the speed after it."""
    row: PosePieces = poses(table)
    start: float = row[0].begin
    finish: float = end_of(table)
    if end < start or begin >= finish:
        return TaylorModel(0.0, 0.0, 0.0, 0.0)
    k: cython.Py_ssize_t = pose_at(table, begin)
    if k >= 0 and end <= row[k].end:
        return speed_along(row[k], begin, end)
    # Over several pieces the speed may jump, so only its bounds are known.
    low: float = INFINITY
    high: float = 0.0
    if begin < start or end > finish:
        low = 0.0
    k = max(k, 0)
    while k < pose_count(table) and row[k].begin < end:
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


def smooth_stretches(motion: Any) -> tuple[Numbers, Numbers, float]:
    """Return stretches in which speed is smooth, the lengths before each, and the whole length."""
    cache = vars(motion)
    if _STRETCHES not in cache:
        table: Numbers = room(0)
        before: Numbers = room(0)
        total: float = 0.0
        k: cython.Py_ssize_t
        for k in range(pose_count(motion.table)):
            piece: PosePiece = poses(motion.table)[k]
            cuts = smooth_cuts(motion.pieces[k].x, motion.pieces[k].y, piece.end - piece.begin)
            for u, w in itertools.pairwise(cuts):
                x: Cubic = shift(piece.x, u)
                y: Cubic = shift(piece.y, u)
                table.extend((piece.begin + u, piece.begin + w))
                table.extend((x.p, x.v, x.a, x.j, y.p, y.v, y.a, y.j))
                before.append(total)
                total += length(table, len(before) - 1, w - u)
        cache[_STRETCHES] = table, before, total
    stretches: tuple[Numbers, Numbers, float] = cache[_STRETCHES]
    return stretches


def length(stretches: Numbers, k: cython.Py_ssize_t, u: float) -> float:
    """Return the length of the first `u` seconds of a stretch, metres."""
    stretch: PlanarPiece = planar(stretches)[k]
    if is_straight(stretch.x, stretch.y):
        return norm(stretch.x.v, stretch.y.v) * u
    # Stretches are short enough for eight nodes: see `smooth_cuts`.
    half: float = u / 2
    total: float = 0.0
    nodes: Doubles = at(_NODES)
    weights: Doubles = at(_WEIGHTS)
    i: cython.Py_ssize_t
    for i in range(8):
        total += weights[i] * speed_at(stretch.x, stretch.y, half * nodes[i])
    return half * total
