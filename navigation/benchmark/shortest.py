"""Lengths of shortest paths, computed slowly and apart from any planner, as a reference.

Every corner of what is left of the floor when all edges are grown by the radius is linked with
every other that it sees, and shortest paths are searched over these links (Dijkstra). Grown
corners are drawn from inside, so lengths are never too long, and too short by no more than
`SHORTFALL` of their arcs.
"""

from __future__ import annotations

import heapq
import itertools
import math

import numpy as np
import shapely
from numpy.typing import NDArray

from floorplan import Point

SIDES = 64
"""The sides of the polygons that stand for discs."""

SHORTFALL = 1 - math.cos(math.pi / SIDES)
"""Share by which arcs may come out too short: 0.12 %."""

_MARGIN = 1e-3
"""Metres. Gaps that are no more than this wider than the disc count as closed."""

_EDGE = 1e-7
"""Metres. How far links may leave the room, so that rounding doesn't cut those along its edges."""

_ROWS = 512

MOST_CORNERS = 20_000
"""Linking as many takes about a minute; on floors with more, nobody knows the shortest paths."""

Floats = NDArray[np.float64]
Links = list[list[tuple[int, float]]]


class ShortestPaths:
    """Lengths of shortest paths for a disc of `radius` metres within `walkable`."""

    def __init__(self, walkable: shapely.Geometry, radius: float) -> None:
        self.room = _shrunk(walkable, radius)
        """Free space of the centre of the disc."""
        self._wide = self.room.buffer(_EDGE)
        shapely.prepare(self._wide)
        shapely.prepare(self.room)
        self._corner, self._before, self._after = _corners(self.room)
        known = len(self._corner) <= MOST_CORNERS
        self._links = self._between_corners() if known else None

    def length(self, start: Point, goal: Point) -> float:
        """Return the metres from `start` to `goal`; infinity where there is no path.

        NaN where that would take too long to find out.
        """
        ends = np.array([start, goal])
        if self._see(ends[:1], ends[1:])[0]:
            return math.dist(start, goal)
        if self._links is None:
            return math.nan
        from_start, to_goal = (dict(self._from(end)) for end in ends)
        best = dict(from_start)
        queue = [(far, k) for k, far in from_start.items()]
        heapq.heapify(queue)
        shortest = math.inf
        while queue:
            far, here = heapq.heappop(queue)
            # Dijkstra: what comes from now on is no shorter than what is known to lead to the goal.
            if far >= shortest:
                break
            if far > best[here]:
                continue
            shortest = min(shortest, far + to_goal.get(here, math.inf))
            for there, step in self._links[here]:
                if far + step < best.get(there, math.inf):
                    best[there] = far + step
                    heapq.heappush(queue, (far + step, there))
        return shortest

    def _from(self, end: Floats) -> list[tuple[int, float]]:
        away = self._corner - end
        (touched,) = np.nonzero(_taut(away, self._before, self._after))
        seen = self._see(np.broadcast_to(end, (len(touched), 2)), self._corner[touched])
        return [(int(k), math.hypot(*away[k])) for k in touched[seen]]

    def _see(self, a: Floats, b: Floats) -> NDArray[np.bool_]:
        inside: NDArray[np.bool_] = shapely.covers(
            self._wide, shapely.linestrings(np.stack([a, b], axis=1))
        )
        return inside

    def _between_corners(self) -> Links:
        links: Links = [[] for _ in self._corner]
        for first in range(0, len(links), _ROWS):
            rows = slice(first, first + _ROWS)
            away = self._corner[None] - self._corner[rows, None]
            here = _taut(away, self._before[rows, None], self._after[rows, None])
            one, other = np.nonzero(here & _taut(away, self._before, self._after))
            one += first
            one, other = one[one < other], other[one < other]
            seen = self._see(self._corner[one], self._corner[other])
            for i, j in zip(one[seen].tolist(), other[seen].tolist(), strict=True):
                far = math.dist(self._corner[i], self._corner[j])
                links[i].append((j, far))
                links[j].append((i, far))
        return links


def _shrunk(walkable: shapely.Geometry, radius: float) -> shapely.Geometry:
    """Return `walkable` without discs at its corners, strips along its edges, and tight gaps."""
    angles = np.linspace(0, 2 * math.pi, SIDES, endpoint=False)
    disc = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    grown = []
    for line in shapely.get_parts(walkable.boundary):
        points = shapely.get_coordinates(line)
        grown += list(shapely.polygons(points[:-1, None] + disc))
        for a, b in itertools.pairwise(points):
            across = np.array([a[1] - b[1], b[0] - a[0]]) * radius / math.dist(a, b)
            grown.append(shapely.Polygon([a + across, b + across, b - across, a - across]))
    tight = _tight_gaps(walkable, radius)
    return walkable.difference(shapely.union_all([*grown, *tight]))


def _tight_gaps(walkable: shapely.Geometry, radius: float) -> list[shapely.Geometry]:
    """Return the middles of the gaps through which a disc comes only by a hair, or not at all.

    What is lost when the room is shrunk by the margin and grown back is too narrow for it.
    """
    wide = walkable.buffer(-radius - _MARGIN / 2, quad_segs=SIDES).buffer(_MARGIN)
    lost = walkable.buffer(-radius, quad_segs=SIDES).difference(wide)
    return [piece.buffer(_MARGIN) for piece in shapely.get_parts(lost) if not piece.is_empty]


def _corners(room: shapely.Geometry) -> tuple[Floats, Floats, Floats]:
    """The corners that stick out into `room`, and the vectors to the corners on either side."""
    found = []
    for polygon in shapely.get_parts(shapely.orient_polygons(room)):
        for ring in (polygon.exterior, *polygon.interiors):
            points = shapely.get_coordinates(ring)[:-1]
            before, after = np.roll(points, 1, 0) - points, np.roll(points, -1, 0) - points
            out = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0] > 0
            found.append(np.stack([points[out], before[out], after[out]]))
    corner, before, after = np.concatenate([np.empty((3, 0, 2)), *found], axis=1)
    return corner, before, after


def _taut(along: Floats, before: Floats, after: Floats) -> NDArray[np.bool_]:
    """Return whether a line along `along` leaves both sides of a corner on one side of it."""
    # A shortest path is a taut string: it bends at corners that stick out only, and comes and goes
    # along lines that touch them there. All other links can be left out: the tangent graph of
    # Y.-H. Liu and S. Arimoto, International Journal of Robotics Research 11, 1992.
    one = along[..., 0] * before[..., 1] - along[..., 1] * before[..., 0]
    other = along[..., 0] * after[..., 1] - along[..., 1] * after[..., 0]
    slack = 1e-9 * (1 + np.abs(along).sum(axis=-1))
    taut: NDArray[np.bool_] = (one * other >= 0) | (np.abs(one) < slack) | (np.abs(other) < slack)
    return taut
