"""The floor as people of one radius see it: free segments, detours, and courses (polylines)."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, MutableSequence, Sequence
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray

from floorplan import Point
from navigation import CollisionWorld
from navigation.freespace import Narrows
from navigation.kernels.edges import Legs
from navigation.kernels.grid import CHUNK, WaysRound
from navigation.kernels.numbers import numbers

from .parameters import PARAMETERS

EVERYWHERE = numbers((-math.inf, -math.inf, math.inf, math.inf))
"""Bounds that overlap with everything."""

CELL = 0.3
"""Width of the cells of a detour, m."""

MOST = 40_000
"""Maximum number of cells for one detour."""


class Detours:
    """Planner of detours around stationary people, for people of one radius (m)."""

    def __init__(self, world: CollisionWorld, radius: float) -> None:
        self._world = world
        self._radius = radius
        self._pieces: NDArray[np.object_] = np.empty(0, dtype=object)
        self._ways = WaysRound(CELL, PARAMETERS.detour_around, MOST, self._chunk)

    def path(
        self, at: Point, goal: Point, standing: MutableSequence[float], legs: Legs
    ) -> list[Point]:
        """Return a path from `at` to `goal`, both included, or an empty list.

        `standing` has x, y and the distance to keep of each stationary person (m). `legs` tests
        segments.
        """
        pieces = self._world.free_space(self._radius).pieces
        if pieces is not self._pieces:
            self._pieces = pieces
            self._ways.forget()
        return self._ways.path(at, goal, standing, legs)

    def _chunk(self, i: int, j: int) -> bytes:
        """Return the cells of a square chunk: 0 in the free space, otherwise 1."""
        k = np.arange(CHUNK) + 0.5
        x, y = np.meshgrid((i * CHUNK + k) * CELL, (j * CHUNK + k) * CELL)
        free = np.zeros(x.shape, dtype=bool)
        for piece in self._pieces:
            free |= shapely.intersects_xy(piece, x, y)
        return (~free).astype(np.uint8).tobytes()


class Ground:
    """The floor as people of one radius (metres) see it."""

    def __init__(self, world: CollisionWorld, radius: float) -> None:
        self.world = world
        self.radius = radius
        self.detours = Detours(world, radius)
        self.walls = world.walls
        """The sides of the walls."""
        self._gates = world.gates
        self._gated = bool(self._gates)
        self._legs = Legs(self.walls, radius, self._free_of_bodies)
        self._changes = -1

    @cached_property
    def narrow(self) -> Narrows:
        """Narrow places as people inside see them."""
        return self.world.narrows(self.radius, PARAMETERS.abreast_inside)

    @cached_property
    def narrow_outside(self) -> Narrows:
        """Narrow places as people outside see them."""
        return self.world.narrows(self.radius, PARAMETERS.abreast_outside)

    def free(self, a: Point, b: Point) -> bool:
        """Return whether the segment from a, a free position, to b is free.

        A segment through a gate against its direction is not.
        """
        return self.legs.free(*a, *b)

    @property
    def legs(self) -> Legs:
        """Test of segments in the present world."""
        if self._changes != self.world.changes:
            self._changes = self.world.changes
            self._legs.bounds = EVERYWHERE if self._gated else self.world.bounds
        return self._legs

    def _free_of_bodies(self, a: Point, b: Point) -> bool:
        """Return whether a segment that is clear of walls is free of bodies and closed gates."""
        if self._gated and not self._gates.allow(a, b):
            return False
        return not self.world.hits(a, b, self.radius)

    def paths_ahead(
        self, at: Point, course: Sequence[Point], lengths: Iterable[float]
    ) -> Iterator[list[Point]]:
        """Yield paths from `at`, a position beside a course, along it to increasing `lengths` (m).

        The last path is the one before the first that is not free in both directions.
        """
        free: set[tuple[Point, Point]] = set()
        for length in lengths:
            path = [at, *first(course, length)]
            if not all(leg in free or self.free_and_back(*leg) for leg in itertools.pairwise(path)):
                return
            free.update(itertools.pairwise(path))
            yield path

    def has_only_walls(self, place: Point, metres: float) -> bool:
        """Return whether only walls are within `metres` of a place."""
        return not self._gated and not self.world.near(place, place, self.radius + metres)

    def free_and_back(self, a: Point, b: Point) -> bool:
        """Return whether the segment from a to b is free, and a path leads back.

        After a segment through a gate, this may be another path.
        """
        return self.free(a, b) and (
            not self._gated
            or self._gates.allow(b, a)
            or self._gates.reach(self.world.fixed_space(self.radius), b, a)
        )


def length_of(course: Sequence[Point]) -> float:
    """Return the length of a polyline, metres."""
    return sum(math.dist(a, b) for a, b in itertools.pairwise(course))


def first(course: Sequence[Point], length: float) -> list[Point]:
    """Return the first `length` metres of a polyline, or all of it."""
    start = [course[0]]
    for a, b in itertools.pairwise(course):
        leg = math.dist(a, b)
        if leg >= length:
            if length > 1e-9:
                share = length / leg
                start.append((a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])))
            return start
        start.append(b)
        length -= leg
    return start


def rest(course: Sequence[Point], length: float) -> list[Point]:
    """Return the polyline from `length` metres on, or its last point."""
    at, k = _after(course, length)
    return [at, *course[k:]]


def corners_passed(course: Sequence[Point], place: Point) -> int:
    """Return the number of corners of a polyline before the point nearest to `place`."""
    best, passed = math.inf, 0
    x, y = place
    for k, ((ax, ay), (bx, by)) in enumerate(itertools.pairwise(course)):
        dx, dy = bx - ax, by - ay
        square = dx * dx + dy * dy
        if square < 1e-18:
            continue
        share = min(max(((x - ax) * dx + (y - ay) * dy) / square, 0.0), 1.0)
        off_x, off_y = ax + share * dx - x, ay + share * dy - y
        away = off_x * off_x + off_y * off_y
        if away < best:
            best, passed = away, k if share * share * square > 1e-18 else max(k - 1, 0)
    return passed


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


def _after(course: Sequence[Point], length: float) -> tuple[Point, int]:
    """Return the position after `length` metres, and the index of the next corner."""
    for k, (a, b) in enumerate(itertools.pairwise(course), 1):
        leg = math.dist(a, b)
        if leg > length:
            share = max(length, 0.0) / leg
            return (a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])), k
        length -= leg
    return course[-1], len(course)
