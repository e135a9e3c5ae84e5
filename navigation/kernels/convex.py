"""Convex polygons, as rows of corners in counterclockwise order.

Two of them have no common point if a line along an edge separates them (S. Gottschalk, M. Lin and
D. Manocha, "OBBTree", SIGGRAPH 1996).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

if not cython.compiled:
    from .cubics import *


def hull(points: Numbers) -> Numbers:
    """Return the convex hull of points (A. Andrew, "Another efficient algorithm", 1979)."""
    count: cython.Py_ssize_t = position_count(points)
    p: Positions = positions_of(points)
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    for i in range(1, count):
        point: Position = p[i]
        k = i
        while k > 0 and (p[k - 1].x > point.x or (p[k - 1].x == point.x and p[k - 1].y > point.y)):
            p[k] = p[k - 1]
            k -= 1
        p[k] = point
    corners: Numbers = position_room(2 * count)
    total: cython.Py_ssize_t = 0
    for i in range(count):
        total = _added(corners, total, 0, p[i])
    lower: cython.Py_ssize_t = total - 1
    for i in range(count - 2, -1, -1):
        total = _added(corners, total, lower, p[i])
    return first_positions(corners, max(total - 1, 1))


def _added(
    corners: Numbers, total: cython.Py_ssize_t, first: cython.Py_ssize_t, point: Position
) -> cython.Py_ssize_t:
    """Add a corner to a chain after `first`, without the last ones that turn right at it."""
    p: Positions = positions_of(corners)
    while total - first > 1 and turn_of(p[total - 2], p[total - 1], point) <= 0.0:
        total -= 1
    p[total] = point
    return total + 1


def turn_of(a: Position, b: Position, c: Position) -> float:
    """Return twice the area of a triangle, positive if it turns left."""
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)


def is_apart(polygon: Numbers, points: Numbers) -> bool:
    """Return whether all points are beyond one edge of a polygon."""
    count: cython.Py_ssize_t = position_count(polygon)
    p: Positions = positions_of(polygon)
    other: Positions = positions_of(points)
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    for i in range(count):
        apart: bool = True
        for k in range(position_count(points)):
            if turn_of(p[i], p[i + 1 if i + 1 < count else 0], other[k]) >= 0.0:
                apart = False
                break
        if apart:
            return True
    return False


def meets_edge(polygon: Numbers, e: Edge) -> bool:
    """Return whether an edge and a polygon have a common point."""
    count: cython.Py_ssize_t = position_count(polygon)
    p: Positions = positions_of(polygon)
    a: Position = Position(e.ax, e.ay)
    b: Position = Position(e.bx, e.by)
    left: bool = False
    right: bool = False
    k: cython.Py_ssize_t
    for k in range(count):
        after: Position = p[k + 1 if k + 1 < count else 0]
        if turn_of(p[k], after, a) < 0.0 and turn_of(p[k], after, b) < 0.0:
            return False
        side: float = turn_of(a, b, p[k])
        left = left or side >= 0.0
        right = right or side <= 0.0
    return left and right
