"""Polynomials on intervals: signs, extrema, integrals, and the nodes of Gaussian quadrature.

Nodes are literals, because the last bits of those of `numpy.polynomial` depend on its LAPACK.

Signs and extrema follow from Bernstein coefficients, whose minimum and maximum bound a polynomial
(R. T. Farouki, "The Bernstein polynomial basis: a centennial retrospective", Computer Aided
Geometric Design 29, 2012). Intervals on which they decide nothing are divided.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray

from .kernels.smoothness import NODES_8, WEIGHTS_8

NODES_5 = (
    -0.906179845938664,
    -0.5384693101056831,
    0.0,
    0.5384693101056831,
    0.906179845938664,
)
WEIGHTS_5 = (
    0.23692688505618928,
    0.4786286704993663,
    0.5688888888888887,
    0.4786286704993663,
    0.23692688505618928,
)
"""Gauss-Legendre's 5 nodes, exact for polynomials up to degree 9."""

LOBATTO_NODES_8 = (
    -1.0,
    -0.8717401485096066,
    -0.5917001814331423,
    -0.20929921790247888,
    0.20929921790247888,
    0.5917001814331423,
    0.8717401485096066,
    1.0,
)
LOBATTO_WEIGHTS_8 = (
    0.03571428571428571,
    0.21070422714350603,
    0.34112269248350435,
    0.4124587946587039,
    0.4124587946587039,
    0.34112269248350435,
    0.21070422714350603,
    0.03571428571428571,
)
"""Lobatto's 8 nodes, both ends included, exact for polynomials up to degree 13."""


Array = NDArray[np.float64]
Index = NDArray[np.intp]

SHORTEST = 1e-9
"""Seconds. Minimum length of an interval."""

NEGATIVE = -1e-12
"""Values above this count as zero, so that rounding of zeros is not subdivided forever."""

_PARTS = 8
"""Number of parts of a divided interval, a power of two."""

_NODES, _WEIGHTS = np.array(NODES_8), np.array(WEIGHTS_8)
_LOBATTO_NODES, _LOBATTO_WEIGHTS = np.array(LOBATTO_NODES_8), np.array(LOBATTO_WEIGHTS_8)


def bernstein(coefficients: Array, durations: Array) -> Array:
    """Return power coefficients (..., n) on 0 … duration (...) as Bernstein ones (..., n)."""
    n = coefficients.shape[-1] - 1
    scaled = coefficients * durations[..., None] ** np.arange(n + 1)
    basis = [
        [math.comb(i, k) / math.comb(n, k) if k <= i else 0.0 for k in range(n + 1)]
        for i in range(n + 1)
    ]
    return np.asarray(scaled @ np.array(basis).T)


def square(x: Array) -> Array:
    """Return the squares of polynomials with power coefficients (..., n): (..., 2 n - 1)."""
    n = x.shape[-1]
    product = np.zeros((*x.shape[:-1], 2 * n - 1))
    for k in range(n):
        product[..., k : k + n] += x[..., k : k + 1] * x
    return product


def monotone_cubics(t: Array, values: Array) -> Array:
    """Return cubics through values (N, K) at times t (N,), as power coefficients (N - 1, K, 4).

    They are Hermite cubics, continuous in value and slope, that stay in the range of two samples
    between them. The slope at a sample is the weighted harmonic mean of those of the lines to its
    neighbours, or 0 if their signs differ (F. N. Fritsch and J. Butland, "A method for constructing
    local monotone piecewise cubic interpolants", SIAM Journal on Scientific and Statistical
    Computing 5, 1984).
    """
    h = np.diff(t)[:, None]
    secant = np.diff(values, axis=0) / h
    before, after = secant[:-1], secant[1:]
    w, v = h[:-1] + 2 * h[1:], 2 * h[:-1] + h[1:]
    # Level lines divide by 0, but `where` ignores the result.
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        mean = (w + v) / (w / before + v / after)
    slope = np.concatenate([secant[:1], np.where(before * after > 0, mean, 0.0), secant[-1:]])
    left, right = slope[:-1], slope[1:]
    curve, bend = (3 * secant - 2 * left - right) / h, (left + right - 2 * secant) / h**2
    return np.stack([values[:-1], left, curve, bend], axis=-1)


def derivative(x: Array) -> Array:
    """Return the derivatives of polynomials with power coefficients (..., n): (..., n - 1)."""
    return np.asarray(x[..., 1:] * np.arange(1, x.shape[-1]))


def time_negative(polynomials: Array, durations: Array) -> Array:
    """Return the time (M,) in which any of A Bernstein polynomials (M, A, n) is negative."""
    total = np.zeros(len(durations))
    rows, width = np.arange(len(durations)), durations
    while len(rows):
        inside = (polynomials.max(-1) < 0.0).any(-1)
        # Decided if one of A is negative throughout, by its maximum coefficient, or if none is
        # anywhere, by the minimum ones.
        decided = inside | (polynomials.min(-1) >= NEGATIVE).all(-1)
        short = ~decided & (width <= SHORTEST)
        inside[short] = (polynomials[short].mean(-1) < 0.0).any(-1)
        np.add.at(total, rows[inside], width[inside])
        open_ = ~decided & ~short
        rows, width = np.repeat(rows[open_], _PARTS), np.repeat(width[open_] / _PARTS, _PARTS)
        polynomials = _split(polynomials[open_])
    return total


def least(polynomials: Array, groups: Index, count: int) -> Array:
    """Return the minimum (count,) of the Bernstein polynomials (M, n) of each group (M,)."""
    best = np.full(count, np.inf)
    for _ in range(20):
        # The first and last Bernstein coefficients are values of the polynomial at both ends.
        np.minimum.at(best, groups, polynomials[:, 0])
        np.minimum.at(best, groups, polynomials[:, -1])
        bound = best[groups]
        # The minimum coefficient is a lower bound, so divide only where it is below the best.
        hopeful = polynomials.min(-1) < bound - 1e-15 * (1.0 + np.abs(bound))
        if not hopeful.any():
            break
        groups = np.repeat(groups[hopeful], _PARTS)
        polynomials = _split(polynomials[hopeful])
    return best


def integral_of_least_length(x: Array, y: Array, less: Array, durations: Array) -> Array:
    """∫ minₐ(√(x² + y²) − less) dt over each interval, exact to about 1e-10: (M,).

    x and y are power coefficients (M, A, n), `less` (M, A). Gauss-Legendre quadrature on intervals
    that are halved until Lobatto's rule agrees. Halving converges to kinks.
    """
    total = np.zeros(len(durations))
    rows = np.arange(len(durations))
    begin, width = np.zeros(len(durations)), durations
    # Rows last, because they are most numerous, and numpy is fast along them.
    x, y, less = (np.ascontiguousarray(each.T) for each in (x, y, less))

    def quadrature(nodes: Array, weights: Array) -> Array:
        u = (begin + width * ((1 + nodes) / 2)[:, None])[:, None]
        lengths = np.hypot(_horner(x[..., rows], u), _horner(y[..., rows], u)) - less[:, rows]
        return np.asarray((lengths.min(1) * weights[:, None]).sum(0) * width / 2)

    while len(rows):
        lengths = quadrature(_NODES, _WEIGHTS)
        # Lobatto's rule includes the ends, near which a kink may be beyond Gauss's nodes.
        change = np.abs(lengths - quadrature(_LOBATTO_NODES, _LOBATTO_WEIGHTS))
        open_ = (change > 1e-13 * (1.0 + np.abs(lengths))) & (width > SHORTEST)
        np.add.at(total, rows[~open_], lengths[~open_])
        half = width[open_] / 2
        rows, width = np.tile(rows[open_], 2), np.tile(half, 2)
        begin = np.concatenate([begin[open_], begin[open_] + half])
    return total


def _horner(coefficients: Array, u: Array) -> Array:
    """Return polynomials (n, A, M), lowest coefficient first, at u (K, 1, M): (K, A, M)."""
    *rest, value = coefficients
    for c in reversed(rest):
        value = value * u + c
    return np.asarray(value)


def _split(polynomials: Array) -> Array:
    """Return the parts of equal length of polynomials (M, ..., n), one after another."""
    count, *middle, n = polynomials.shape
    parts = polynomials.reshape(count, 1, math.prod(middle), n) @ _parts(n)
    return np.asarray(parts.reshape(count * _PARTS, *middle, n))


@cache
def _parts(n: int) -> Array:
    """Return matrices from n Bernstein coefficients to those of each part (de Casteljau)."""
    left = np.zeros((n, n))
    for i in range(n):
        # Coefficient i of the left half is the mean of the first i + 1, weighted by binomial
        # coefficients. The right half is its mirror image.
        left[: i + 1, i] = [math.comb(i, k) / 2**i for k in range(i + 1)]
    parts = [np.eye(n)]
    while len(parts) < _PARTS:
        parts = [part @ half for part in parts for half in (left, left[::-1, ::-1])]
    return np.array(parts)
