"""Free space of a disc: connected pieces, one-way gates, narrow places and walls.

A position on the line of a gate is on its far side. So each position is on one side, and a path
crosses a gate if and only if one of its segments does.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import TypeVar
from weakref import WeakKeyDictionary

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import Polygon

from floorplan import Gate, Point

from .bodies import (
    CollisionBody,
    Disc,
    around_disc,
    bends,
    corners,
    edges_of_room,
    flat_sides,
)
from .kernels.edges import Grid, back_through
from .kernels.grid import SOME, Cells
from .kernels.numbers import numbers

_Result = TypeVar("_Result")

STEP = math.radians(3.0)
"""Radians. Step of polylines around arcs, which lose at most 0.04 % of the radius."""

_CHORDS = math.ceil(0.75 * math.pi / STEP)
"""Chords per quarter of an arc of GEOS. It rounds the number of chords of an arc to the nearest, so
a chord spans at most 1.5 times its share of the quarter, which is `STEP`."""

_MOST_KNOWN = 200
"""Number of places for which a space caches the piece or the nearest position."""

_MOST_GROWN = 64
"""Number of bodies for which the blocked area is cached."""

_EDGE = 1e-3
"""Maximum distance in metres from a piece at which a place counts as on its edge."""


class FreeSpace:
    """Positions that are at least a radius from everything, in connected pieces.

    A path between two positions exists if and only if they are in one piece.
    """

    def __init__(self, room: shapely.Geometry | NDArray[np.object_]) -> None:
        parts = shapely.get_parts(room)
        self.pieces = parts[shapely.area(parts) > 0]
        """Pieces, as an array of polygons."""
        shapely.prepare(self.pieces)
        self._pieces_at: dict[Point, int | None] = {}
        self._nearest: dict[Point, Point | None] = {}
        self._sides: NDArray[np.float64] | None = None
        """Bounds of the sides of all pieces: see `_bounds_of_sides`."""

    def __repr__(self) -> str:
        return f"<FreeSpace, pieces: {len(self.pieces)}>"

    def piece_of(self, point: Point) -> int | None:
        """Return the index of the piece that contains `point`, or is within a millimetre of it."""
        return _once(self._pieces_at, point, self._piece_at)

    def _piece_at(self, point: Point) -> int | None:
        inside = np.flatnonzero(shapely.intersects_xy(self.pieces, *point))
        if len(inside):
            return int(inside[0])
        gaps = shapely.distance(self.pieces, shapely.points(*point))
        return int(np.argmin(gaps)) if len(gaps) and gaps.min() < _EDGE else None

    def together(self, one: Point, other: Point) -> bool:
        """Return whether both positions are in the same piece."""
        piece = self.piece_of(one)
        return piece is not None and piece == self.piece_of(other)

    def nearest(self, point: Point) -> Point | None:
        """Return the position nearest to `point`, or None if there is none."""
        return _once(self._nearest, point, self._nearest_to)

    def _nearest_to(self, point: Point) -> Point | None:
        at = shapely.points(*point)
        if not len(self.pieces):
            return None
        gaps = shapely.distance(self.pieces, at)
        closest = int(gaps.argmin())
        if gaps[closest] == 0:
            return (float(point[0]), float(point[1]))
        line = shapely.get_coordinates(shapely.shortest_line(self.pieces[closest], at))
        return (float(line[0, 0]), float(line[0, 1]))

    def bounds_at(self, place: Point) -> tuple[Point, Point]:
        """Return the lower left and upper right of `place` and the sides that it may be on."""
        if self._sides is None:
            self._sides = _bounds_of_sides(self.pieces)
        x, y = place
        low_x, low_y, high_x, high_y = sides = self._sides
        on = (low_x < x + _EDGE) & (high_x > x - _EDGE) & (low_y < y + _EDGE) & (high_y > y - _EDGE)
        low_x, low_y, high_x, high_y = sides[:, on]
        low = float(low_x.min(initial=x)), float(low_y.min(initial=y))
        return low, (float(high_x.max(initial=x)), float(high_y.max(initial=y)))

    def outward(self, point: Point, reach: float) -> list[list[Point]]:
        """Return positions within `reach` metres of `point` for each piece that is so near.

        They are the nearest position and the first one in every direction (`STEP` apart), sorted by
        distance.
        """
        at = shapely.Point(point)
        near = self.pieces[shapely.dwithin(self.pieces, at, reach)]
        # The nearest position of a piece, and the first one along each ray from the point.
        angle = np.arange(0.0, 2 * math.pi, STEP)
        ends = np.column_stack([np.cos(angle), np.sin(angle)]) * reach + point
        rays = shapely.linestrings([[point, end] for end in ends])
        # Clip the pieces first, because a piece of a large floor has thousands of edges.
        around = shapely.box(*(c - reach for c in point), *(c + reach for c in point))
        places_of = []
        for piece in shapely.intersection(near, around):
            met = shapely.intersection(rays, piece)
            ends = shapely.shortest_line([piece, *met[~shapely.is_empty(met)]], at)
            # Each shortest line ends at the point itself. Its first end is the position.
            places = shapely.get_coordinates(ends)[::2]
            order = np.argsort(np.hypot(*(places - point).T), kind="stable")
            places_of.append([(float(x), float(y)) for x, y in places[order]])
        return places_of


def _once(cached: dict[Point, _Result], point: Point, find: Callable[[Point], _Result]) -> _Result:
    """Return the result of `find` for a point from the cache, or compute it."""
    if point in cached:
        return cached[point]
    if len(cached) >= _MOST_KNOWN:
        cached.clear()
    result = cached[point] = find(point)
    return result


def shrunk(room: shapely.Geometry, radius: float) -> shapely.Geometry:
    """Return the part of `room` that is at least `radius` metres from its edges.

    GEOS fills dents along walls that are shallower than 1 % of the radius.
    """
    return room.buffer(-radius / math.cos(STEP / 2), quad_segs=_CHORDS)


def without(space: FreeSpace, bodies: Sequence[CollisionBody], radius: float) -> FreeSpace:
    """Return the part of `space` that is at least `radius` metres from all `bodies`."""
    if not bodies:
        return space
    taken = shapely.union_all([_grown_body(body, radius) for body in bodies])
    # Pieces that no body touches remain the same objects, because they are prepared.
    touched = shapely.intersects(space.pieces, taken)
    left = [shapely.difference(piece, taken) for piece in space.pieces[touched]]
    parts = shapely.get_parts(np.array(left, dtype=object))
    return FreeSpace(np.concatenate([space.pieces[~touched], parts]))


def _bounds_of_sides(pieces: NDArray[np.object_]) -> NDArray[np.float64]:
    """Return minimum x and y, maximum x and y of the sides of polygons, in rows: (4, N)."""
    points, of = shapely.get_coordinates(shapely.get_rings(pieces), return_index=True)
    joined = of[1:] == of[:-1]
    a, b = points[:-1][joined], points[1:][joined]
    return np.hstack([np.minimum(a, b), np.maximum(a, b)]).T


@lru_cache(_MOST_GROWN)
def _grown_body(body: CollisionBody, radius: float) -> shapely.Geometry:
    """Return the area that `body` blocks for the centre of a disc of `radius` metres."""
    if isinstance(body.shape, Disc):
        return around_disc(body.shape.centre, body.shape.radius + radius, STEP)
    edges = body.edges
    around = corners(edges)
    if len(edges) == 1 and len(around.turn) == len(edges[0]) - 1:
        # The outline of a convex body consists of the bends around its corners.
        return Polygon(bends(around, radius, STEP).point)
    return body.shape.buffer(radius / math.cos(STEP / 2), quad_segs=_CHORDS)


_THIN = 1e-7
"""Metres. Half of the width of the strip by which a gate divides the room."""


class Gates:
    """One-way gates that apply to the user of a world."""

    def __init__(self, gates: Iterable[Gate] = ()) -> None:
        self.all = tuple(gates)
        self.lines = [numbers((*gate.ends[0], *gate.ends[1], *gate.normal)) for gate in self.all]
        """x and y of both ends and of the direction of each gate, in turn."""
        self._parted: WeakKeyDictionary[FreeSpace, _Parted] = WeakKeyDictionary()

    def __repr__(self) -> str:
        return f"<Gates {', '.join(gate.name for gate in self.all)}>"

    def __bool__(self) -> bool:
        return bool(self.all)

    def allow(self, a: Point, b: Point) -> bool:
        """Return whether the segment from a to b crosses no gate against its direction."""
        return not any(back_through(line, *a, *b) for line in self.lines)

    def apart(self, a: Point, b: Point) -> bool:
        """Return whether the segment between a and b crosses a gate in any direction."""
        return not (self.allow(a, b) and self.allow(b, a))

    def broken(self, points: Sequence[Point]) -> tuple[Gate, ...]:
        """Return the gates that the polyline `points` crosses against their direction."""
        return tuple(
            gate
            for gate, line in zip(self.all, self.lines, strict=True)
            if any(back_through(line, *a, *b) for a, b in pairwise(points))
        )

    def reach(self, space: FreeSpace, start: Point, goal: Point) -> bool:
        """Return whether a path within `space` leads from `start` to `goal`."""
        if not self.all:
            return space.together(start, goal)
        if not space.together(start, goal):
            return False
        parted = self._of(space)
        return parted.face_of(goal) in parted.reached(start)

    def closing(self, space: FreeSpace, start: Point) -> list[str]:
        """Return the names of the gates that separate the area reachable from `start`."""
        parted = self._of(space)
        reached = parted.reached(start)
        names = (
            self.all[k].name
            for k, before, behind in parted.passages
            if behind in reached and before not in reached
        )
        return [*dict.fromkeys(names)]

    def _of(self, space: FreeSpace) -> _Parted:
        parted = self._parted.get(space)
        if parted is None:
            parted = self._parted[space] = _Parted(space, self.all)
        return parted


class _Parted:
    """Parts into which gates divide a space, and the passages between them.

    `passages` has the index of a gate, and those of the parts before and behind it.
    """

    def __init__(self, space: FreeSpace, gates: tuple[Gate, ...]) -> None:
        self._gates = gates
        lines = shapely.linestrings([gate.ends for gate in gates])
        # A strip along each gate cuts the space, so that only passages connect the parts.
        strips = shapely.union_all(shapely.buffer(lines, _THIN, cap_style="flat"))
        self._parts = FreeSpace(shapely.difference(space.pieces, strips))
        self.passages: list[tuple[int, int | None, int | None]] = []
        for k, gate in enumerate(gates):
            nx, ny = gate.normal
            for span in shapely.get_parts(shapely.intersection(lines[k], space.pieces)):
                if span.length > 2 * _THIN:
                    x, y = shapely.get_coordinates(span.interpolate(0.5, normalized=True))[0]
                    before, behind = (
                        self._parts.piece_of((x + side * nx, y + side * ny))
                        for side in (-2 * _THIN, 2 * _THIN)
                    )
                    self.passages.append((k, before, behind))

    def face_of(self, place: Point) -> int | None:
        """Return the index of the part that contains `place`."""
        x, y = place
        for gate in self._gates:
            (nx, ny), (ax, ay) = gate.normal, gate.ends[0]
            ahead = (x - ax) * nx + (y - ay) * ny
            # The strip belongs to no part, so move the place off it to its own side.
            if abs(ahead) < 2 * _THIN:
                side = 2 * _THIN if ahead >= 0 else -2 * _THIN
                x, y = x + side * nx, y + side * ny
        return self._parts.piece_of((x, y))

    def reached(self, start: Point) -> set[int | None]:
        """Return the parts that are reachable from `start`."""
        reached = {self.face_of(start)}
        while True:
            # Reachability of a directed graph, one step in every direction at a time.
            fresh = {behind for _, before, behind in self.passages if before in reached} - reached
            if not fresh:
                return reached
            reached |= fresh


SPARE = 0.03
"""Metres. Additional width of a passage per disc beside another."""

APRON = 0.35
"""Metres. Distance from a narrow place within which a standing person is in its way."""

CELL = 0.5
"""Metres. Width of the cells of the cache of narrow places."""

_NICHE = 0.3
"""Square metres. Minimum area of a narrow dead end. Corners are smaller."""


class Narrows:
    """Narrow places of a floor and the areas before them, where people should not stop."""

    def __init__(self, find: Callable[[], shapely.Geometry]) -> None:
        self._find = find
        self.cells = Cells(CELL, self._whole, self._within)
        """Cache of the area."""

    @cached_property
    def _area(self) -> shapely.Geometry:
        """Area, found at the first query, because many people are never in a narrow place."""
        area = self._find()
        shapely.prepare(area)
        return area

    def has(self, place: Point) -> bool:
        """Return whether a place (x, y in metres) is in the area."""
        return self.cells.has(*place)

    def _whole(self, column: int, row: int) -> int:
        """Return 1 if all of a cell is narrow, 0 if none of it is, and otherwise `SOME`."""
        x, y = column * CELL, row * CELL
        cell = shapely.box(x, y, x + CELL, y + CELL)
        if not shapely.intersects(self._area, cell):
            return 0
        return 1 if shapely.contains_properly(self._area, cell) else SOME

    def _within(self, x: float, y: float) -> bool:
        return bool(shapely.intersects_xy(self._area, x, y))


def narrows(space: FreeSpace, radius: float, abreast: int) -> shapely.Geometry:
    """Return the area of narrow places of a free space, with the areas before them.

    The narrow places for discs of `radius` metres are the free space of their centres minus its
    opening by a disc of the width for `abreast` discs: a passage, or a dead end of some size.
    """
    narrow = []
    half = (abreast - 1) * (radius + SPARE / 2)
    for piece in space.pieces:
        # The opening of mathematical morphology (J. Serra, "Image Analysis and Mathematical
        # Morphology", 1982): the area that a disc of this width can cover. One millimetre more
        # hides rounding.
        wide = piece.buffer(-half).buffer(half + 1e-3)
        for part in shapely.get_parts(piece.difference(wide)):
            mouths = part.buffer(2e-3).intersection(wide)
            # The rest of each corner has one mouth as well, but is small.
            if part.area > _NICHE or len(shapely.get_parts(mouths)) > 1:
                narrow.append(part)
    return shapely.union_all(narrow).buffer(APRON)


_SIDES_IN_A_CELL = 2.0
"""Mean number of sides per cell of the grid."""


def walls(floor: shapely.Geometry) -> Grid:
    """Return the grid of the edges of a floor."""
    sides = flat_sides(edges_of_room(floor))
    low_x, low_y, high_x, high_y = floor.bounds
    area = (high_x - low_x) * (high_y - low_y)
    return Grid(sides, math.sqrt(area * _SIDES_IN_A_CELL / (len(sides) / 4)))
