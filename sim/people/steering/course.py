"""Courses on the floor: polylines, and the points that belong to lengths along them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

from floorplan import Point


def length_of(course: Sequence[Point]) -> float:
    """Return the length of a polyline, metres."""
    return sum(math.dist(a, b) for a, b in itertools.pairwise(course))


def first(course: Sequence[Point], length: float) -> list[Point]:
    """Return the first `length` metres of a polyline, or all of it."""
    kept = [course[0]]
    for a, b in itertools.pairwise(course):
        leg = math.dist(a, b)
        if leg >= length:
            if length > 1e-9:
                share = length / leg
                kept.append((a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])))
            return kept
        kept.append(b)
        length -= leg
    return kept


def rest(course: Sequence[Point], length: float) -> list[Point]:
    """Return the polyline from `length` metres on; its last point at least."""
    at, k = _sought(course, length)
    return [at, *course[k:]]


def place_after(course: Sequence[Point], length: float) -> Point:
    """Return the place on a polyline `length` metres on, or its last point."""
    return _sought(course, length)[0]


def nearest_length(course: Sequence[Point], place: Point) -> float:
    """Return the length along a polyline at which it is nearest to a point."""
    best, at, gone = math.inf, 0.0, 0.0
    for (ax, ay), (bx, by) in itertools.pairwise(course):
        leg = math.hypot(bx - ax, by - ay)
        if leg < 1e-9:
            continue
        u = ((place[0] - ax) * (bx - ax) + (place[1] - ay) * (by - ay)) / leg
        u = min(max(u, 0.0), leg)
        away = math.hypot(ax + u * (bx - ax) / leg - place[0], ay + u * (by - ay) / leg - place[1])
        if away < best:
            best, at = away, gone + u
        gone += leg
    return at


def _sought(course: Sequence[Point], length: float) -> tuple[Point, int]:
    """Return the place `length` metres on, and the index of the corner that comes after it."""
    for k, (a, b) in enumerate(itertools.pairwise(course), 1):
        leg = math.dist(a, b)
        if leg > length:
            share = max(length, 0.0) / leg
            return (a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])), k
        length -= leg
    return course[-1], len(course)
