"""Path length and speed of a motion over an interval, as figures that enclose them."""

from __future__ import annotations

import cmath
import itertools
from collections.abc import MutableSequence
from dataclasses import dataclass

from .kernels import odometer as kernel
from .kernels.numbers import room
from .motion import Motion, Piece, shift

_ELLIPSE = 7.0
"""Sum of the half axes of the Bernstein ellipse in which speed must be analytic around a stretch
that is integrated with eight nodes: the error is then below 2e-13 of the stretch's length
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


class Odometer(kernel.Odometer):
    """Path length and speed of a motion at any time. Jumps add no length."""

    def __init__(self, motion: Motion) -> None:
        super().__init__(motion.table)
        self.motion = motion

    def ahead(self, begin: float, end: float, seconds: float) -> Enclosure:
        """The path length (metres) within `seconds` of each instant from `begin` to `end`."""
        return Enclosure(*self.path_ahead(begin, end, seconds).numbers())

    def speed(self, begin: float, end: float) -> Enclosure:
        """Return the speed (m/s) from `begin` to `end`; at a change, the one after it."""
        return Enclosure(*self.speed_within(begin, end).numbers())

    def cut(self) -> tuple[MutableSequence[float], float]:
        """Return the stretches in which the speed is smooth, and the whole length (metres).

        They are kept with the motion: laws that look ahead ask for them at every instant.
        """
        kept: dict[str, tuple[MutableSequence[float], float]] = vars(self.motion)
        if _KEPT not in kept:
            kept[_KEPT] = _stretches(self.motion)
        return kept[_KEPT]


_KEPT = "_stretches"
"""The name by which a motion keeps its stretches."""


def _stretches(motion: Motion) -> tuple[MutableSequence[float], float]:
    table = room(0)
    gone = 0.0
    for piece in motion.pieces:
        for u, w in itertools.pairwise(_smooth_cuts(piece)):
            (_, *x), (_, *y) = shift(piece.x, u), shift(piece.y, u)
            table.extend((piece.begin + u, gone, *x, *y))
            gone += kernel.length(table, len(table) // kernel.STRETCH - 1, w - u)
    return table, gone


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
        # With the sign for which b and the root add up, nothing cancels in q; the roots are then
        # q / a and c / q (W. H. Press et al., "Numerical Recipes", 3rd edition 2007, 5.6).
        root = cmath.sqrt(b * b - 4 * a * c)
        q = -(b + (root if (b.conjugate() * root).real >= 0 else -root)) / 2
        return [q / a, c / q] if q else [0j]
    if abs(b) * duration > 1e-14 * abs(c):
        return [-c / b]
    return []


def _ellipse(z: complex) -> float:
    """Return the sum of the half axes of the ellipse with foci ±1 through `z`."""
    return abs(z + cmath.sqrt(z - 1) * cmath.sqrt(z + 1))
