"""Path length and speed of a motion over an interval.

A motion is a table: for each piece its begin and end, and four coefficients each of x, y and
rotation, all in one row of `numbers`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..polynomials import NODES_8, WEIGHTS_8

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

if not cython.compiled:
    from math import sqrt

    from .numbers import Doubles, Numbers, at, numbers, room
else:
    from cython.cimports.libc.math import sqrt
    from cython.cimports.navigation.kernels.numbers import Doubles, Numbers, at, numbers, room

_INFINITE: float = float("inf")

STRETCH = 8
"""Numbers of a stretch: begin, metres before it, coefficients of the velocity along x and y."""

_STRETCH: cython.Py_ssize_t = STRETCH
WIDTH = 14
"""Numbers of a piece in a motion's table: begin, end, and the coefficients."""

_WIDTH: cython.Py_ssize_t = WIDTH

# Nodes from 0 to 2, so that half a length times a node is a place from 0 to that length.
_NODES: Numbers = numbers([1.0 + node for node in NODES_8])
_WEIGHTS: Numbers = numbers(WEIGHTS_8)


class TaylorModel:
    """A figure over an interval: within `slack` of value + slope u + curve u² / 2.

    u is the time from the middle of the interval (`navigation.Enclosure`).
    """

    def __init__(self) -> None:
        self.value = self.slope = self.slack = self.curve = 0.0

    def set(self, value: float, slope: float, slack: float, curve: float) -> cython.int:
        self.value = value
        self.slope = slope
        self.slack = slack
        self.curve = curve
        return 0

    def numbers(self) -> tuple[float, float, float, float]:
        """Return value, slope, slack and curve."""
        return self.value, self.slope, self.slack, self.curve


def row_at(
    row: Doubles, rows: cython.Py_ssize_t, width: cython.Py_ssize_t, t: float
) -> cython.Py_ssize_t:
    """Return the last of so many rows that begins by `t`, by halving; -1 if none does."""
    low: cython.Py_ssize_t = 0
    high: cython.Py_ssize_t = rows
    middle: cython.Py_ssize_t
    while low < high:
        middle = (low + high) // 2
        if t < row[middle * width]:
            high = middle
        else:
            low = middle + 1
    return low - 1


def speed_along(
    c: Doubles, row: cython.Py_ssize_t, begin: float, end: float, figure: TaylorModel
) -> cython.int:
    """Give the speed of a piece over an interval within it, m/s.

    Its second derivative is at most a² / |v| + |j|, with a the acceleration across the velocity.
    """
    o: cython.Py_ssize_t = row * _WIDTH
    half: float = (end - begin) / 2
    u: float = begin - c[o] + half
    x1: float = c[o + 3]
    x2: float = c[o + 4]
    x3: float = c[o + 5]
    y1: float = c[o + 7]
    y2: float = c[o + 8]
    y3: float = c[o + 9]
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
        # v × a at u seconds from the middle is v × a + (v × j) u + (a × j) u² / 2, as a × a is 0.
        # Over |v| it is the acceleration across the velocity.
        across: float = abs(vx * ay - vy * ax) + half * abs(vx * jy - vy * jx)
        across += half * half / 2 * abs(ax * jy - ay * jx)
        ratio: float = across / least
        bend: float = (ratio * ratio / least + jerk) * half * half / 2
        # Near a standstill the second derivative has no useful bound; the first has one.
        if bend < change:
            return figure.set(speed, (vx * ax + vy * ay) / speed, bend, 0.0)
    return figure.set(speed, 0.0, change, 0.0)


class PathLength:
    """Path length and speed of a motion at any time. Jumps add no length."""

    def __init__(self, table: Numbers) -> None:
        row: Doubles = at(table)
        self.table = table
        self.stretches: Numbers = room(0)
        self.total = 0.0
        self.start = row[0]
        self.finish = row[len(table) - _WIDTH + 1]
        self.out = TaylorModel()
        self.near = TaylorModel()

    def cut(self) -> tuple[Numbers, float]:
        """Return the table of stretches in which the speed is smooth, and the whole length."""
        raise NotImplementedError

    def reading(self, t: float) -> float:
        """The metres gone from the motion's start to `t` (seconds); exact to 1e-12 of them."""
        if len(self.stretches) == 0:
            self.stretches, self.total = self.cut()
        if t >= self.finish:
            return self.total
        if t <= self.start:
            return 0.0
        table: Numbers = self.stretches
        c: Doubles = at(table)
        k: cython.Py_ssize_t = row_at(c, len(table) // _STRETCH, _STRETCH, t)
        gone: float = c[k * _STRETCH + 1]
        return gone + length(table, k, t - c[k * _STRETCH])

    def look_ahead(self, begin: float, end: float, seconds: float) -> cython.int:
        """Find the path length within `seconds` of each instant of an interval: in `out`."""
        half: float = (end - begin) / 2
        middle: float = begin + half
        # Its second derivative, then, is the difference of the two slopes, and what both are
        # uncertain of adds up over half the interval.
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

    def look(self, begin: float, end: float) -> cython.int:
        """Find the speed over an interval: in `out`; at a change, the one after it."""
        table: Numbers = self.table
        row: Doubles = at(table)
        if end < self.start or begin >= self.finish:
            return self.out.set(0.0, 0.0, 0.0, 0.0)
        rows: cython.Py_ssize_t = len(table) // _WIDTH
        k: cython.Py_ssize_t = row_at(row, rows, _WIDTH, begin)
        if k >= 0 and end <= row[k * _WIDTH + 1]:
            return speed_along(row, k, begin, end, self.out)
        # Over several pieces the speed may jump: its least and its most are all that holds.
        low: float = _INFINITE
        high: float = 0.0
        if begin < self.start or end > self.finish:
            low = 0.0
        k = max(k, 0)
        while k < rows and row[k * _WIDTH] < end:
            since: float = max(begin, row[k * _WIDTH])
            until: float = min(end, row[k * _WIDTH + 1])
            if until > since:
                speed_along(row, k, since, until, self.out)
                around: float = abs(self.out.slope) * ((until - since) / 2) + self.out.slack
                low = min(low, self.out.value - around)
                high = max(high, self.out.value + around)
            k += 1
        low = max(low, 0.0)
        return self.out.set((low + high) / 2, 0.0, (high - low) / 2, 0.0)

    def path_ahead(self, begin: float, end: float, seconds: float) -> TaylorModel:
        """Return `look_ahead`'s figure, to be read at once."""
        self.look_ahead(begin, end, seconds)
        return self.out

    def speed_within(self, begin: float, end: float) -> TaylorModel:
        """Return `look`'s figure, to be read at once."""
        self.look(begin, end)
        return self.out


def length(table: Numbers, row: cython.Py_ssize_t, u: float) -> float:
    """Return the length of the first `u` seconds of a stretch, metres: Gauss-Legendre's."""
    c: Doubles = at(table)
    o: cython.Py_ssize_t = row * _STRETCH
    x1: float = c[o + 2]
    x2: float = c[o + 3]
    x3: float = c[o + 4]
    y1: float = c[o + 5]
    y2: float = c[o + 6]
    y3: float = c[o + 7]
    if x2 == y2 == x3 == y3 == 0.0:
        return sqrt(x1 * x1 + y1 * y1) * u
    # Stretches are cut so that eight nodes are enough: see `_ELLIPSE` in `navigation.odometer`.
    half: float = u / 2
    total: float = 0.0
    nodes: Doubles = at(_NODES)
    weights: Doubles = at(_WEIGHTS)
    k: cython.Py_ssize_t
    for k in range(8):
        w: float = half * nodes[k]
        vx: float = x1 + w * (2 * x2 + w * 3 * x3)
        vy: float = y1 + w * (2 * y2 + w * 3 * y3)
        weight: float = weights[k]
        total += weight * sqrt(vx * vx + vy * vy)
    return half * total
