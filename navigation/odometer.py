"""Path length and speed of a motion over an interval, as figures that enclose them."""

from __future__ import annotations

import cmath
import itertools
import math
from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from .motion import Cubic, Motion, Piece, shift

_GAUSS = tuple(
    (1 + float(node), float(weight))
    for node, weight in zip(*np.polynomial.legendre.leggauss(8), strict=True)
)
"""Nodes (on 0 … 2) and weights of Gauss-Legendre quadrature."""

_ELLIPSE = 7.0
"""Sum of the half axes of the Bernstein ellipse in which speed must be analytic around a stretch
that is integrated with `_GAUSS`: the error is then below 2e-13 of the stretch's length
(L. N. Trefethen, "Approximation Theory and Approximation Practice", theorem 19.3)."""


@dataclass(frozen=True)
class Enclosure:
    """A figure over an interval: within `slack` of `value` + `slope` u + `curve` u² / 2.

    u is the time from the middle of the interval, in seconds. At an instant `value` is exact.
    """

    value: float
    slope: float = 0.0
    slack: float = 0.0
    curve: float = 0.0

    @staticmethod
    def between(low: float, high: float) -> Enclosure:
        """Return a figure of which only bounds are known."""
        return Enclosure((low + high) / 2, 0.0, (high - low) / 2)

    def range(self, half: float) -> tuple[float, float]:
        """Return the least and the most it may be on an interval of twice `half` (seconds)."""
        around = (abs(self.slope) + abs(self.curve) * half / 2) * half + self.slack
        return self.value - around, self.value + around

    def __add__(self, other: Enclosure | float) -> Enclosure:
        if isinstance(other, Enclosure):
            return Enclosure(
                self.value + other.value,
                self.slope + other.slope,
                self.slack + other.slack,
                self.curve + other.curve,
            )
        return Enclosure(self.value + other, self.slope, self.slack, self.curve)

    def __mul__(self, factor: float) -> Enclosure:
        return Enclosure(
            self.value * factor,
            self.slope * factor,
            self.slack * abs(factor),
            self.curve * factor,
        )


class Odometer:
    """Path length and speed of a motion at any time. Jumps add no length."""

    def __init__(self, motion: Motion) -> None:
        self.motion = motion

    def reading(self, t: float) -> float:
        """The metres gone from the motion's start to `t` (seconds); exact to 1e-12 of them."""
        begins, stretches, total = self._stretches
        if t >= self.motion.end:
            return total
        if t <= self.motion.start:
            return 0.0
        stretch = stretches[bisect_right(begins, t) - 1]
        return stretch.gone + stretch.length(t - stretch.begin)

    def ahead(self, begin: float, end: float, seconds: float) -> Enclosure:
        """The path length (metres) within `seconds` of each instant from `begin` to `end`."""
        middle, half = begin + (end - begin) / 2, (end - begin) / 2
        length = self.reading(middle + seconds) - self.reading(middle)
        if half == 0.0:
            return Enclosure(length)
        # Its derivative is the speed at the far end less that at the near one.
        growth = self.speed(begin + seconds, end + seconds) + self.speed(begin, end) * -1.0
        return Enclosure(length, growth.value, growth.slack * half, growth.slope)

    def speed(self, begin: float, end: float) -> Enclosure:
        """Return the speed (m/s) from `begin` to `end`; at a change, the one after it."""
        motion = self.motion
        if end < motion.start or begin >= motion.end:
            return Enclosure(0.0)
        k = bisect_right(self._begins, begin) - 1
        if k >= 0 and end <= motion.pieces[k].end:
            return speed_along(motion.pieces[k], begin, end)
        stands = begin < motion.start or end > motion.end
        low, high = (0.0, 0.0) if stands else (math.inf, 0.0)
        for piece in itertools.islice(motion.pieces, max(k, 0), None):
            if piece.begin >= end:
                break
            since, until = max(begin, piece.begin), min(end, piece.end)
            if until <= since:
                continue
            slowest, fastest = speed_along(piece, since, until).range((until - since) / 2)
            low, high = min(low, slowest), max(high, fastest)
        return Enclosure.between(max(low, 0.0), high)

    @cached_property
    def _begins(self) -> list[float]:
        return [piece.begin for piece in self.motion.pieces]

    @property
    def _stretches(self) -> _Stretches:
        """The begin of each stretch (seconds), the stretches, and the whole length (metres).

        They are kept with the motion: laws that look ahead ask for them at every instant.
        """
        kept: dict[str, _Stretches] = vars(self.motion)
        if _KEPT not in kept:
            kept[_KEPT] = _stretches(self.motion)
        return kept[_KEPT]


class _Stretch(NamedTuple):
    """A part of a motion in which its speed is smooth, after `gone` metres."""

    begin: float
    gone: float
    x: Cubic
    y: Cubic

    def length(self, u: float) -> float:
        """Return the length of its first `u` seconds, metres."""
        (_, x1, x2, x3), (_, y1, y2, y3) = self.x, self.y
        if x2 == y2 == x3 == y3 == 0.0:
            return math.hypot(x1, y1) * u
        half = u / 2
        total = 0.0
        for node, weight in _GAUSS:
            w = half * node
            total += weight * math.hypot(
                x1 + w * (2 * x2 + w * 3 * x3), y1 + w * (2 * y2 + w * 3 * y3)
            )
        return half * total


_Stretches = tuple[list[float], list[_Stretch], float]

_KEPT = "_stretches"
"""The name by which a motion keeps its stretches."""


def _stretches(motion: Motion) -> _Stretches:
    stretches: list[_Stretch] = []
    gone = 0.0
    for piece in motion.pieces:
        for u, w in itertools.pairwise(_smooth_cuts(piece)):
            x, y = shift(piece.x, u), shift(piece.y, u)
            stretches.append(_Stretch(piece.begin + u, gone, x, y))
            gone += stretches[-1].length(w - u)
    return [stretch.begin for stretch in stretches], stretches, gone


def _smooth_cuts(piece: Piece) -> list[float]:
    """Return cuts of a piece (seconds from its begin) between which its speed is smooth.

    The velocity as a complex number x' + i y' is a quadratic in time; speed is its modulus, and
    analytic but at its roots and their conjugates.
    """
    duration = piece.end - piece.begin
    roots = _velocity_roots(piece, duration)
    turns = sorted(root.real for root in roots if 0.0 < root.real < duration)
    cuts = [0.0, *turns, duration]
    # At a real root the body stands: the modulus has a corner there, and is smooth on both sides.
    corners = [root for root in roots if abs(root.imag) > 1e-12]
    undecided = [*itertools.pairwise(cuts)][::-1]
    smooth = [0.0]
    while undecided:
        low, high = undecided.pop()
        middle, half = (low + high) / 2, (high - low) / 2
        if half < 1e-9 or all(_ellipse((root - middle) / half) > _ELLIPSE for root in corners):
            smooth.append(high)
        else:
            undecided += [(middle, high), (low, middle)]
    return smooth


def _velocity_roots(piece: Piece, duration: float) -> list[complex]:
    (_, x1, x2, x3), (_, y1, y2, y3) = piece.x, piece.y
    a, b, c = complex(3 * x3, 3 * y3), complex(2 * x2, 2 * y2), complex(x1, y1)
    if abs(a) * duration**2 > 1e-14 * (abs(b) * duration + abs(c)):
        root = cmath.sqrt(b * b - 4 * a * c)
        q = -(b + (root if (b.conjugate() * root).real >= 0 else -root)) / 2
        return [q / a, c / q] if q else [0j]
    if abs(b) * duration > 1e-14 * abs(c):
        return [-c / b]
    return []


def _ellipse(z: complex) -> float:
    """Return the sum of the half axes of the ellipse with foci ±1 through `z`."""
    return abs(z + cmath.sqrt(z - 1) * cmath.sqrt(z + 1))


def speed_along(piece: Piece, begin: float, end: float) -> Enclosure:
    """Return the speed of a piece over an interval within it, m/s.

    Its second derivative is at most a² / |v| + |j|, with a the acceleration across the velocity.
    """
    half = (end - begin) / 2
    u = begin - piece.begin + half
    (_, x1, x2, x3), (_, y1, y2, y3) = piece.x, piece.y
    vx, vy = x1 + u * (2 * x2 + u * 3 * x3), y1 + u * (2 * y2 + u * 3 * y3)
    speed = math.hypot(vx, vy)
    if half == 0.0 or x2 == y2 == x3 == y3 == 0.0:
        return Enclosure(speed)
    ax, ay, jx, jy = 2 * x2 + u * 6 * x3, 2 * y2 + u * 6 * y3, 6 * x3, 6 * y3
    jerk = math.hypot(jx, jy)
    change = (math.hypot(ax, ay) + jerk * half) * half
    least = speed - change
    if least > 0.0:
        across = abs(vx * ay - vy * ax) + half * abs(vx * jy - vy * jx)
        across += half * half / 2 * abs(ax * jy - ay * jx)
        bend = ((across / least) ** 2 / least + jerk) * half * half / 2
        if bend < change:
            return Enclosure(speed, (vx * ax + vy * ay) / speed, bend)
    return Enclosure(speed, 0.0, change)
