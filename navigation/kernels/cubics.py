"""Mathematics of motions: values, slopes, shifts, differences and bounds of cubics of time.

Compiled kernels use `cubics.pxd` instead, because Cython inlines across modules only functions in
declarations. Both files must agree to the last bit.

Bounds of a cubic are those of its control points in Bernstein form (R. T. Farouki, "The Bernstein
polynomial basis: a centennial retrospective", Computer Aided Geometric Design 29, 2012).
"""

from __future__ import annotations

from math import sqrt

from .tables import *


def end_of(table: Numbers) -> float:
    """Return the end of the last piece of a table of x, y and rotation (seconds)."""
    return poses(table)[pose_count(table) - 1].end


def planar_from(table: Numbers, k: int, t: float) -> int:
    """Return the first piece from the k-th on that ends after `t` (seconds)."""
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
    """Return the change of a cubic from 0 to u."""
    return u * (c.v + u * (c.a + u * c.j))


def slope(c: Cubic, u: float) -> float:
    """Return the first derivative of a cubic at u."""
    return c.v + u * (2 * c.a + u * 3 * c.j)


def second_slope(c: Cubic, u: float) -> float:
    """Return the second derivative of a cubic at u."""
    return 2 * c.a + 6 * u * c.j


def shift(c: Cubic, u: float) -> Cubic:
    """Return the same cubic relative to u: its Taylor coefficients there."""
    return Cubic(value(c, u), slope(c, u), c.a + u * 3 * c.j, c.j)


def minus(c: Cubic, d: Cubic) -> Cubic:
    """Return the difference of two cubics."""
    return Cubic(c.p - d.p, c.v - d.v, c.a - d.a, c.j - d.j)


def norm(x: float, y: float) -> float:
    """Return the length of a vector. `hypot` of C and Python differ in the last bit."""
    return sqrt(x * x + y * y)


def along(x: float, c: float, way: Cubic) -> Cubic:
    """Return the coordinate of a point that covers `way` on a line from x with the cosine c."""
    return Cubic(x + way.p * c, way.v * c, way.a * c, way.j * c)


def position_at(table: Numbers, t: float) -> Position:
    """Return the place at `t` (s) of a point with a table of x and y, or its first place."""
    piece = planar(table)[planar_from(table, 0, t)]
    u = max(t - piece.begin, 0.0)
    return Position(value(piece.x, u), value(piece.y, u))


def rest_piece(t: float, x: float, y: float) -> PlanarPiece:
    """Return a final rest at (x, y) in metres from `t` (seconds) on."""
    return PlanarPiece(t, INFINITY, constant(x), constant(y))


def ahead_of(here: CoursePlace, x: float, y: float) -> float:
    """Return the distance of a place ahead in the direction at `here` (metres)."""
    return (x - here.x) * here.c + (y - here.y) * here.s


def left_of(here: CoursePlace, x: float, y: float) -> float:
    """Return the distance of a place to the left of the direction at `here` (metres)."""
    return (y - here.y) * here.c - (x - here.x) * here.s


def sweep_along(e: Edge) -> SweptSegment:
    """Return the sweep along a segment, without a direction if the length is 0."""
    dx, dy = e.bx - e.ax, e.by - e.ay
    length = norm(dx, dy)
    if length > 0.0:
        return SweptSegment(e.ax, e.ay, dx, dy, dx / length, dy / length, length)
    return SweptSegment(e.ax, e.ay, dx, dy, 0.0, 0.0, length)


def speed_at(x: Cubic, y: Cubic, u: float) -> float:
    """Return the speed of a point with these coordinates at u."""
    return norm(slope(x, u), slope(y, u))


def is_straight(x: Cubic, y: Cubic) -> bool:
    """Return whether a point with these coordinates moves at a constant velocity."""
    return x.a == 0.0 and y.a == 0.0 and x.j == 0.0 and y.j == 0.0


def is_at_rest(x: Cubic, y: Cubic) -> bool:
    """Return whether a point with these coordinates does not move."""
    return is_straight(x, y) and x.v == 0.0 and y.v == 0.0


def deviation(x: Cubic, y: Cubic, half: float) -> float:
    """Bound the distance of a point from its tangent at 0 for |u| <= half."""
    return half * half * (norm(x.a, y.a) + half * norm(x.j, y.j))


def elapsed(begin: float, end: float, t: float) -> float:
    """Return the time since `begin` at `t`, limited to the interval."""
    return min(max(t, begin), end) - begin


def range_of(c: Cubic, u: float) -> Range:
    """Return bounds of a cubic from 0 to u, exact for a monotonic quadratic."""
    last = value(c, u)
    low = min(c.p, last)
    high = max(c.p, last)
    # A quadratic turns back if its slope changes sign between both ends.
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


def box_around(row: Numbers, count: int) -> BoundingBox:
    """Return the bounds of the first `count` positions of a row."""
    position = positions_of(row)
    box = BoundingBox(INFINITY, INFINITY, -INFINITY, -INFINITY)
    for k in range(count):
        p = position[k]
        box = united(box, BoundingBox(p.x, p.y, p.x, p.y))
    return box


def are_within(a: BoundingBox, b: BoundingBox, least: float) -> bool:
    """Return whether two boxes are nearer than `least` along both axes."""
    return (
        a.low_x - b.high_x < least
        and b.low_x - a.high_x < least
        and a.low_y - b.high_y < least
        and b.low_y - a.high_y < least
    )
