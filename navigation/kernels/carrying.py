"""Motions of points that a body carries beside its axis.

If the body turns, such a point moves on an arc. Its cubics are Hermite's, with place and velocity
of the arc at both ends.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

if not cython.compiled:
    from math import cos, sin, sqrt

    from .cubics import *


def carried(table: Numbers, ahead: float, aside: float, close: float) -> Numbers:
    """Return the table of a point `ahead` of a body's axis and `aside` to its left, in metres.

    Its error is at most `close` metres.
    """
    piece: PosePieces = poses(table)
    reach: float = norm(ahead, aside)
    k: cython.Py_ssize_t
    n: cython.Py_ssize_t
    total: cython.Py_ssize_t = 0
    for k in range(pose_count(table)):
        total += parts_of(piece[k], reach, close)
    motion: Numbers = pose_room(total)
    part: PosePieces = poses(motion)
    place: cython.Py_ssize_t = 0
    for k in range(pose_count(table)):
        whole: PosePiece = piece[k]
        duration: float = whole.end - whole.begin
        parts: cython.Py_ssize_t = parts_of(whole, reach, close)
        step: float = duration / parts
        begin: float = whole.begin
        for n in range(parts):
            end: float = whole.end if n + 1 == parts else whole.begin + step * (n + 1)
            part[place] = _carried_part(whole, step * n, begin, end, ahead, aside)
            place += 1
            begin = end
    return motion


def parts_of(piece: PosePiece, reach: float, close: float) -> cython.Py_ssize_t:
    """Return the number of cubics for the arc of a piece with a radius of `reach` metres.

    The error of Hermite's cubic over h seconds is at most h⁴ M / 384, with M the maximum fourth
    derivative (A. Quarteroni, R. Sacco and F. Saleri, "Numerical Mathematics", 2nd edition 2007,
    8.4). For exp(i θ), M is at most ω⁴ + 6 ω² α + 3 α² + 4 ω j with the derivatives of θ.
    """
    h: float = piece.end - piece.begin
    v: float = abs(piece.rotation.v)
    a: float = abs(piece.rotation.a)
    j: float = abs(piece.rotation.j)
    rate: float = v + h * (2 * a + h * 3 * j)
    bend: float = 2 * a + 6 * j * h
    square: float = rate * rate
    limit: float = square * square + 6 * square * bend + 3 * bend * bend + 24 * rate * j
    parts: float = h * sqrt(sqrt(reach * limit / (384 * close)))
    count: cython.Py_ssize_t = int(parts)
    return max(count + 1 if parts > count else count, 1)


def _carried_part(
    whole: PosePiece, low: float, begin: float, end: float, ahead: float, aside: float
) -> PosePiece:
    """Return the part of a piece from `low` seconds after its begin, for a point beside it."""
    x: Cubic = shift(whole.x, low)
    y: Cubic = shift(whole.y, low)
    turn: Cubic = shift(whole.rotation, low)
    u: float = end - begin
    p: Position = _beside(turn.p, ahead, aside)
    v: Position = Position(-turn.v * p.y, turn.v * p.x)
    bend: Position = Position(0.0, 0.0)
    twist: Position = Position(0.0, 0.0)
    if u > 0.0 and (turn.v != 0.0 or turn.a != 0.0 or turn.j != 0.0):
        q: Position = _beside(value(turn, u), ahead, aside)
        rate: float = slope(turn, u)
        w: Position = Position(-rate * q.y, rate * q.x)
        share: float = 1.0 / u
        gx: float = q.x - p.x
        gy: float = q.y - p.y
        bend = Position(
            (3 * gx * share - 2 * v.x - w.x) * share, (3 * gy * share - 2 * v.y - w.y) * share
        )
        twist = Position(
            (v.x + w.x - 2 * gx * share) / (u * u), (v.y + w.y - 2 * gy * share) / (u * u)
        )
    return PosePiece(
        begin,
        end,
        Cubic(x.p + p.x, x.v + v.x, x.a + bend.x, x.j + twist.x),
        Cubic(y.p + p.y, y.v + v.y, y.a + bend.y, y.j + twist.y),
        turn,
    )


def _beside(rotation: float, ahead: float, aside: float) -> Position:
    """Return the place of a point relative to the axis of a body with a `rotation` (radians)."""
    c: float = cos(rotation)
    s: float = sin(rotation)
    return Position(ahead * c - aside * s, ahead * s + aside * c)
