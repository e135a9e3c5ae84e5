"""Lengths of shortest paths, with which the answers of planners are compared.

All edges of the floor are grown by the radius. Dijkstra's algorithm searches the visibility graph
of the remaining floor. Arcs of grown corners are inscribed polygons, so lengths are never too long,
and too short by at most `SHORTFALL` of their arcs.
"""

from __future__ import annotations

import heapq
import math
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from floorplan import Point

SIDES = 64
"""Sides of the polygons that represent discs."""

SHORTFALL = 1 - math.cos(math.pi / SIDES)
"""Share by which arcs may come out too short: 0.12 %."""

_MARGIN = 1e-3
"""Metres. Gaps that exceed the disc by at most this count as closed."""

_EDGE = 1e-7
"""Metres. Margin of the room for links, so that rounding does not cut links along its edges."""

_ROWS = 512
"""Number of corners that are linked together, to limit memory."""

MOST_CORNERS = 20_000
"""Maximum number of corners, which takes about a minute. On larger floors, lengths are unknown."""

Floats = NDArray[np.float64]


class ShortestPaths:
    """Lengths of shortest paths for a disc of `radius` metres within `walkable`."""

    def __init__(self, walkable: shapely.Geometry, radius: float) -> None:
        self.room = _shrunk(walkable, radius)
        """Free space of the centre of the disc."""
        self._wide = self.room.buffer(_EDGE)
        shapely.prepare(self._wide)
        shapely.prepare(self.room)
        self._corner, self._before, self._after = _corners(self.room)
        few = len(self._corner) <= MOST_CORNERS
        self._links = self._between_corners() if few else None

    def length(self, start: Point, goal: Point) -> float:
        """Return the metres from `start` to `goal`: inf without a path, NaN if unknown."""
        ends = np.array([start, goal])
        if self._see(ends[:1], ends[1:])[0]:
            return math.dist(start, goal)
        if self._links is None:
            return math.nan
        best, to_goal = (dict(self._from(end)) for end in ends)
        queue = [(far, k) for k, far in best.items()]
        heapq.heapify(queue)
        shortest = math.inf
        while queue:
            far, here = heapq.heappop(queue)
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
        """Return the corners that a shortest path may reach first from `end`, with distances."""
        away = self._corner - end
        (touched,) = np.nonzero(_taut(away, self._before, self._after))
        seen = self._see(np.broadcast_to(end, (len(touched), 2)), self._corner[touched])
        return [(int(k), math.hypot(*away[k])) for k in touched[seen]]

    def _see(self, a: Floats, b: Floats) -> NDArray[np.bool_]:
        lines = shapely.linestrings(np.stack([a, b], axis=1))
        inside: NDArray[np.bool_] = shapely.covers(self._wide, lines)
        return inside

    def _between_corners(self) -> list[list[tuple[int, float]]]:
        links: list[list[tuple[int, float]]] = [[] for _ in self._corner]
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
    """Return `walkable` without the margin of `radius` metres at its edges, and tight gaps."""
    # Each edge is grown alone, because GEOS simplifies longer lines before it grows them.
    edges = [
        np.stack([points[:-1], points[1:]], axis=1)
        for line in shapely.get_parts(walkable.boundary)
        for points in [shapely.get_coordinates(line)]
    ]
    grown = shapely.buffer(shapely.linestrings(np.concatenate(edges)), radius, quad_segs=SIDES // 4)
    # Places that are lost when the room is shrunk by the margin and grown back are too narrow.
    wide = walkable.buffer(-radius - _MARGIN / 2, quad_segs=SIDES).buffer(_MARGIN)
    lost = walkable.buffer(-radius, quad_segs=SIDES).difference(wide).buffer(_MARGIN)
    return walkable.difference(shapely.union_all([*grown, lost]))


class _TautCorners(NamedTuple):
    """Convex corners of obstacles, and the vectors to the corners on either side, (N, 2) each."""

    corner: Floats
    before: Floats
    after: Floats


def _corners(room: shapely.Geometry) -> _TautCorners:
    """Return the convex corners of obstacles."""
    parts = []
    for polygon in shapely.get_parts(shapely.orient_polygons(room)):
        for ring in (polygon.exterior, *polygon.interiors):
            points = shapely.get_coordinates(ring)[:-1]
            before, after = np.roll(points, 1, 0) - points, np.roll(points, -1, 0) - points
            out = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0] > 0
            parts.append(np.stack([points[out], before[out], after[out]]))
    return _TautCorners(*np.concatenate([np.empty((3, 0, 2)), *parts], axis=1))


def _taut(along: Floats, before: Floats, after: Floats) -> NDArray[np.bool_]:
    """Return whether a line along `along` has both sides of a corner on one side of it."""
    # A shortest path is taut. It bends only at convex corners of obstacles, along lines that touch
    # them. All other links can be left out: the tangent graph of Y.-H. Liu and S. Arimoto,
    # International Journal of Robotics Research 11, 1992.
    one = along[..., 0] * before[..., 1] - along[..., 1] * before[..., 0]
    other = along[..., 0] * after[..., 1] - along[..., 1] * after[..., 0]
    slack = 1e-9 * (1 + np.abs(along).sum(axis=-1))
    taut: NDArray[np.bool_] = (one * other >= 0) | (np.abs(one) < slack) | (np.abs(other) < slack)
    return taut
