"""Motions of points that a body carries along: beside its axis, they turn with it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

from .arcs import ARC
from .motion import Cubic, Motion, Piece, shift, value


def carried(motion: Motion, ahead: float, aside: float) -> Motion:
    """Return the motion of a point `ahead` of a body's axis and `aside` to its left, in metres.

    Where the body turns, the point is on an arc. Its cubics are Hermite's, and stay within `ARC`
    metres of it.
    """
    offset = complex(ahead, aside)
    if not offset:
        return motion
    pieces = [part for piece in motion.pieces for part in _parts(piece, offset)]
    return Motion(tuple(pieces), motion.jumps)


def _parts(piece: Piece, offset: complex) -> Iterator[Piece]:
    """Yield the pieces of a point that a body carries along on one piece of its motion."""
    duration = piece.end - piece.begin
    count = _count(piece.rotation, abs(offset), duration)
    cuts = [*(duration * k / count for k in range(count)), duration]
    for low, high in pairwise(cuts):
        h = high - low
        (p, v), (q, w) = (_at(piece.rotation, offset, u) for u in (low, high))
        # Place and velocity at both ends are those of the arc.
        bend = twist = 0j
        if (v or w) and h > 0.0:
            bend = (3 * (q - p) / h - 2 * v - w) / h
            twist = (v + w - 2 * (q - p) / h) / h**2
        x, y = shift(piece.x, low), shift(piece.y, low)
        yield Piece(
            piece.begin + low,
            piece.end if high == duration else piece.begin + high,
            (x[0] + p.real, x[1] + v.real, x[2] + bend.real, x[3] + twist.real),
            (y[0] + p.imag, y[1] + v.imag, y[2] + bend.imag, y[3] + twist.imag),
            shift(piece.rotation, low),
        )


def _at(rotation: Cubic, offset: complex, u: float) -> tuple[complex, complex]:
    """Return place and velocity of the point relative to the axis, as complex numbers."""
    angle, (_, rate, _, _) = value(rotation, u), shift(rotation, u)
    place = offset * complex(math.cos(angle), math.sin(angle))
    return place, 1j * rate * place


def _count(rotation: Cubic, reach: float, duration: float) -> int:
    """Return into how many cubics an arc of a radius of `reach` metres is divided.

    Hermite's cubic over h seconds is off by h⁴ M / 384 at most, with M the greatest fourth
    derivative (A. Quarteroni, R. Sacco and F. Saleri, "Numerical Mathematics", 2nd edition 2007,
    8.4). That of exp(i θ) is at most ω⁴ + 6 ω² α + 3 α² + 4 ω j with the derivatives of θ.
    """
    _, v, a, j = map(abs, rotation)
    rate, bend, jerk = v + duration * (2 * a + duration * 3 * j), 2 * a + 6 * j * duration, 6 * j
    most = reach * (rate**4 + 6 * rate**2 * bend + 3 * bend**2 + 4 * rate * jerk)
    per_second: float = (most / (384 * ARC)) ** (1 / 4)
    return max(1, math.ceil(duration * per_second))
