"""Stretches of a curve in which its speed is smooth enough for a quadrature with eight nodes."""

from __future__ import annotations

import cmath
import itertools

Cubic = tuple[float, float, float, float]
"""Coefficients, the constant one first."""

NODES_8 = (
    -0.9602898564975362,
    -0.7966664774136267,
    -0.525532409916329,
    -0.18343464249564978,
    0.18343464249564978,
    0.525532409916329,
    0.7966664774136267,
    0.9602898564975362,
)
WEIGHTS_8 = (
    0.10122853629037706,
    0.22238103445337443,
    0.3137066458778869,
    0.36268378337836166,
    0.36268378337836166,
    0.3137066458778869,
    0.22238103445337443,
    0.10122853629037706,
)
"""Gauss-Legendre's 8 nodes, exact for polynomials up to degree 15."""

_ELLIPSE = 7.0
"""Sum of the half axes of the Bernstein ellipse around a stretch in which speed is analytic. The
error of eight nodes is then below 2e-13 of the stretch's length (L. N. Trefethen, "Approximation
Theory and Approximation Practice", theorem 19.3)."""


def smooth_cuts(x: Cubic, y: Cubic, duration: float) -> list[float]:
    """Return cuts of a curve from 0 to `duration` between which its speed is smooth.

    The velocity as a complex number x' + i y' is a quadratic in time. Speed is its modulus, which
    is analytic except at its roots and their conjugates.
    """
    roots = _velocity_roots(x, y, duration)
    turns = sorted(root.real for root in roots if 0.0 < root.real < duration)
    cuts = [0.0, *turns, duration]
    # At a real root the body stops. The modulus has a corner there, and is smooth on both sides.
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


def _velocity_roots(x: Cubic, y: Cubic, duration: float) -> list[complex]:
    (_, x1, x2, x3), (_, y1, y2, y3) = x, y
    a, b, c = complex(3 * x3, 3 * y3), complex(2 * x2, 2 * y2), complex(x1, y1)
    if abs(a) * duration**2 > 1e-14 * (abs(b) * duration + abs(c)):
        # The sign avoids cancellation in q. The roots are q / a and c / q (W. H. Press et al.,
        # "Numerical Recipes", 3rd edition 2007, 5.6).
        root = cmath.sqrt(b * b - 4 * a * c)
        q = -(b + (root if (b.conjugate() * root).real >= 0 else -root)) / 2
        return [q / a, c / q] if q else [0j]
    if abs(b) * duration > 1e-14 * abs(c):
        return [-c / b]
    return []


def _ellipse(z: complex) -> float:
    """Return the sum of the half axes of the ellipse with foci ±1 through `z`."""
    return abs(z + cmath.sqrt(z - 1) * cmath.sqrt(z + 1))
