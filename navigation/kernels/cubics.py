"""Cubics of time, and the tables of motions that hold them.

A motion is a row of numbers, one piece after another: begin and end (seconds), then the four
coefficients of the cubic of each coordinate, counted from the begin. A `PlanarPiece` has x and y
(metres); a `PosePiece` has a rotation (radians) in addition. This module alone knows the layout.

Compiled kernels take all this from `cubics.pxd`, because Cython inlines across modules only what
stands in declarations. The two files say the same, to the last bit.

Bounds of a cubic are those of its control points in Bernstein form (R. T. Farouki, "The Bernstein
polynomial basis: a centennial retrospective", Computer Aided Geometric Design 29, 2012).
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple, TypeAlias

from .numbers import PLANAR_WIDTH, POSE_WIDTH, Numbers, cut, room, row_at
from .uncompiled import Rows


class Cubic(NamedTuple):
    """Polynomial p + v u + a u² + j u³ of the time u since a piece begins."""

    p: float
    v: float
    a: float
    j: float


class Range(NamedTuple):
    """Lower and upper bound."""

    low: float
    high: float


class BoundingBox(NamedTuple):
    """Axis-aligned bounds (metres)."""

    low_x: float
    low_y: float
    high_x: float
    high_y: float


class PlanarPiece(NamedTuple):
    """Piece of the motion of a point: its time span (seconds), and its coordinates (metres)."""

    begin: float
    end: float
    x: Cubic
    y: Cubic


class PosePiece(NamedTuple):
    """Piece of the motion of a body: as `PlanarPiece`, and its rotation (radians)."""

    begin: float
    end: float
    x: Cubic
    y: Cubic
    rotation: Cubic


class Phase(NamedTuple):
    """Phase of one coordinate: its duration (seconds), and the cubic since it began."""

    duration: float
    c: Cubic


Boxes: TypeAlias = "Rows[BoundingBox]"
PlanarPieces: TypeAlias = "Rows[PlanarPiece]"
PosePieces: TypeAlias = "Rows[PosePiece]"
Phases: TypeAlias = "Rows[Phase]"


def _planar_piece(begin: float, end: float, *c: float) -> PlanarPiece:
    return PlanarPiece(begin, end, Cubic(*c[:4]), Cubic(*c[4:]))


def _pose_piece(begin: float, end: float, *c: float) -> PosePiece:
    return PosePiece(begin, end, Cubic(*c[:4]), Cubic(*c[4:8]), Cubic(*c[8:]))


def _phase(duration: float, *c: float) -> Phase:
    return Phase(duration, Cubic(*c))


def boxes_of(row: Numbers) -> Boxes:
    """Return the boxes of a row."""
    return Rows(row, BoundingBox, 4)


def box_count(row: Numbers) -> int:
    """Return the number of boxes of a row."""
    return len(row) // 4


def planar(table: Numbers) -> PlanarPieces:
    """Return the pieces of a table of x and y."""
    return Rows(table, _planar_piece, PLANAR_WIDTH)


def poses(table: Numbers) -> PosePieces:
    """Return the pieces of a table of x, y and rotation."""
    return Rows(table, _pose_piece, POSE_WIDTH)


def phases(table: Numbers) -> Phases:
    """Return the phases of a table."""
    return Rows(table, _phase, 5)


def planar_count(table: Numbers) -> int:
    """Return the number of pieces of a table of x and y."""
    return len(table) // PLANAR_WIDTH


def pose_count(table: Numbers) -> int:
    """Return the number of pieces of a table of x, y and rotation."""
    return len(table) // POSE_WIDTH


def phase_count(table: Numbers) -> int:
    """Return the number of phases of a table."""
    return len(table) // 5


def planar_room(count: int) -> Numbers:
    """Return a table of x and y of `count` pieces, which are to be set."""
    return room(PLANAR_WIDTH * count)


def pose_room(count: int) -> Numbers:
    """Return a table of x, y and rotation of `count` pieces, which are to be set."""
    return room(POSE_WIDTH * count)


def phase_room(count: int) -> Numbers:
    """Return a table of `count` phases, which are to be set."""
    return room(5 * count)


def planar_cut(table: Numbers, count: int) -> None:
    """Shorten a table of x and y to its first pieces."""
    cut(table, PLANAR_WIDTH * count)


def pose_cut(table: Numbers, count: int) -> None:
    """Shorten a table of x, y and rotation to its first pieces."""
    cut(table, POSE_WIDTH * count)


def phase_cut(table: Numbers, count: int) -> None:
    """Shorten a table to its first phases."""
    cut(table, 5 * count)


def pose_at(table: Numbers, t: float) -> int:
    """Return the last piece of a table that begins by `t` (seconds); -1 if none does."""
    k: int = row_at(table, pose_count(table), POSE_WIDTH, t)
    return k


def end_of(table: Numbers) -> float:
    """Return when the last piece of a table of x, y and rotation ends (seconds)."""
    return poses(table)[pose_count(table) - 1].end


def planar_at(table: Numbers, t: float) -> int:
    """Return the last piece of a table that begins by `t` (seconds); -1 if none does."""
    k: int = row_at(table, planar_count(table), PLANAR_WIDTH, t)
    return k


def planar_from(table: Numbers, k: int, t: float) -> int:
    """Return the first piece from the k-th on that is not over at `t` (seconds)."""
    while planar(table)[k].end <= t:
        k += 1
    return k


def constant(p: float) -> Cubic:
    """Return the cubic of a coordinate at rest."""
    return Cubic(p, 0.0, 0.0, 0.0)


def value(c: Cubic, u: float) -> float:
    """Return the value of a cubic at u, by Horner's rule."""
    return c.p + u * (c.v + u * (c.a + u * c.j))


def gain(c: Cubic, u: float) -> float:
    """Return by how much a cubic changes from 0 to u."""
    return u * (c.v + u * (c.a + u * c.j))


def slope(c: Cubic, u: float) -> float:
    """Return the first derivative of a cubic at u."""
    return c.v + u * (2 * c.a + u * 3 * c.j)


def second_slope(c: Cubic, u: float) -> float:
    """Return the second derivative of a cubic at u."""
    return 2 * c.a + 6 * u * c.j


def shift(c: Cubic, u: float) -> Cubic:
    """Return the same cubic counted from u: its Taylor coefficients there."""
    return Cubic(value(c, u), slope(c, u), c.a + u * 3 * c.j, c.j)


def minus(c: Cubic, d: Cubic) -> Cubic:
    """Return the difference of two cubics."""
    return Cubic(c.p - d.p, c.v - d.v, c.a - d.a, c.j - d.j)


def norm(x: float, y: float) -> float:
    """Return the length of a vector; `hypot` of C and Python differ in the last bit."""
    return sqrt(x * x + y * y)


def along(x: float, c: float, way: Cubic) -> Cubic:
    """Return the coordinate of a point that covers `way` on a line from x with the cosine c."""
    return Cubic(x + way.p * c, way.v * c, way.a * c, way.j * c)


def speed(x: Cubic, y: Cubic, u: float) -> float:
    """Return the speed at u of a point with these coordinates."""
    return norm(slope(x, u), slope(y, u))


def is_straight(x: Cubic, y: Cubic) -> bool:
    """Return whether a point with these coordinates moves at a constant velocity."""
    return x.a == 0.0 and y.a == 0.0 and x.j == 0.0 and y.j == 0.0


def is_at_rest(x: Cubic, y: Cubic) -> bool:
    """Return whether a point with these coordinates does not move."""
    return is_straight(x, y) and x.v == 0.0 and y.v == 0.0


def deviation(x: Cubic, y: Cubic, half: float) -> float:
    """Bound the distance from the tangent at 0 of a point, for all |u| <= half."""
    return half * half * (norm(x.a, y.a) + half * norm(x.j, y.j))


def held(begin: float, end: float, t: float) -> float:
    """Return the time since `begin` at `t`, limited to the interval."""
    return min(max(t, begin), end) - begin


def bounds(c: Cubic, u: float) -> Range:
    """Return bounds of a cubic from 0 to u; exact for a quadratic that is monotonic."""
    last = value(c, u)
    low = min(c.p, last)
    high = max(c.p, last)
    # A quadratic turns back where its slope changes sign between the two ends.
    if c.j != 0.0 or (c.a != 0.0 and c.v * (c.v + 2 * c.a * u) < 0.0):
        third: float = u * c.v / 3
        one: float = c.p + third
        two: float = c.p + 2 * third + u * u * c.a / 3
        low = min(low, min(one, two))
        high = max(high, max(one, two))
    return Range(low, high)


def nearest_on_line(x: Cubic, y: Cubic, half: float) -> float:
    """Return the u, |u| <= half, at which the tangent at 0 is nearest to the origin."""
    square = x.v * x.v + y.v * y.v
    if square == 0.0:
        return 0.0
    u = -(x.p * x.v + y.p * y.v) / square
    return -half if u < -half else half if u > half else u


def united(a: BoundingBox, b: BoundingBox) -> BoundingBox:
    """Return the bounds of two boxes."""
    low_x, low_y = min(a.low_x, b.low_x), min(a.low_y, b.low_y)
    return BoundingBox(low_x, low_y, max(a.high_x, b.high_x), max(a.high_y, b.high_y))


def are_within(a: BoundingBox, b: BoundingBox, least: float) -> bool:
    """Return whether two boxes are nearer to each other than `least` along both axes."""
    return (
        a.low_x - b.high_x < least
        and b.low_x - a.high_x < least
        and a.low_y - b.high_y < least
        and b.low_y - a.high_y < least
    )
