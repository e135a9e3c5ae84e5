"""Free space of the centre of a disc, in connected pieces."""

from __future__ import annotations

import math
from collections.abc import Callable, MutableSequence, Sequence
from functools import lru_cache
from typing import TypeVar

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import Polygon

from floorplan import Point

from .bodies import Body, Disc
from .corners import around_disc, bends, corners, edges_of_room, grown
from .kernels.discs import within_bounds
from .kernels.numbers import numbers

_Found = TypeVar("_Found")

STEP = math.radians(3.0)
"""Radians. How finely arcs are drawn here: at most 0.04 % of the radius is lost."""

_MOST_KNOWN = 200
"""Number of places of which the piece that they are in, or the nearest place, is kept."""

_MOST_GROWN = 64
"""Number of bodies of which the area that they take is kept."""

_EDGE = 1e-3
"""Metres. How far outside a piece a place may be that counts as on its edge."""


class FreeSpace:
    """The places that are at least a radius from everything, in connected pieces.

    Two places can be reached from each other if, and only if, they are in one piece.
    """

    def __init__(self, room: shapely.Geometry | NDArray[np.object_]) -> None:
        parts = shapely.get_parts(room)
        self.pieces = parts[shapely.area(parts) > 0]
        """The pieces, as an array of polygons."""
        shapely.prepare(self.pieces)
        self._known: dict[Point, int | None] = {}
        self._nearest: dict[Point, Point | None] = {}
        self._sides: MutableSequence[float] | None = None
        """Bounds of the sides of all pieces, one after another."""

    def __repr__(self) -> str:
        return f"<FreeSpace, pieces: {len(self.pieces)}>"

    def piece_of(self, point: Point) -> int | None:
        """Return the index of the piece that `point` is in, or within a millimetre of."""
        return _once(self._known, point, self._piece_at)

    def _piece_at(self, point: Point) -> int | None:
        inside = np.flatnonzero(shapely.intersects_xy(self.pieces, *point))
        if len(inside):
            return int(inside[0])
        gaps = shapely.distance(self.pieces, shapely.points(*point))
        return int(np.argmin(gaps)) if len(gaps) and gaps.min() < _EDGE else None

    def together(self, one: Point, other: Point) -> bool:
        """Return whether both places are in the same piece."""
        piece = self.piece_of(one)
        return piece is not None and piece == self.piece_of(other)

    def nearest(self, point: Point) -> Point | None:
        """Return the place nearest to `point`, or None where there is none at all."""
        return _once(self._nearest, point, self._nearest_to)

    def _nearest_to(self, point: Point) -> Point | None:
        at = shapely.points(*point)
        if not len(self.pieces):
            return None
        gaps = shapely.distance(self.pieces, at)
        closest = int(gaps.argmin())
        if gaps[closest] == 0:
            return (float(point[0]), float(point[1]))
        found = shapely.get_coordinates(shapely.shortest_line(self.pieces[closest], at))
        return (float(found[0, 0]), float(found[0, 1]))

    def bounds_at(self, place: Point) -> tuple[Point, Point]:
        """Return the lower left and the upper right of `place` and the sides that it may be on."""
        if self._sides is None:
            self._sides = _bounds_of_sides(self.pieces)
        (x, y), sides = place, self._sides
        on = within_bounds(sides, x - _EDGE, y - _EDGE, x + _EDGE, y + _EDGE)
        low_x, low_y, high_x, high_y = (
            [end, *(sides[4 * k + n] for k in on)] for n, end in enumerate((x, y, x, y))
        )
        return (min(low_x), min(low_y)), (max(high_x), max(high_y))

    def outward(self, point: Point, reach: float) -> list[list[Point]]:
        """Return places within `reach` metres of `point`, for each piece that is so near.

        They are the nearest one and the first one in every direction (`STEP` apart), the nearest
        first.
        """
        at = shapely.Point(point)
        near = self.pieces[shapely.dwithin(self.pieces, at, reach)]
        # The nearest place of a piece, and along each ray from the point the first place in it.
        angle = np.arange(0.0, 2 * math.pi, STEP)
        ends = np.column_stack([np.cos(angle), np.sin(angle)]) * reach + point
        rays = shapely.linestrings([[point, end] for end in ends])
        # Rays are cut with what is near only: a piece of a big floor has thousands of edges.
        around = shapely.box(*(c - reach for c in point), *(c + reach for c in point))
        found = []
        for piece in shapely.intersection(near, around):
            met = shapely.intersection(rays, piece)
            ends = shapely.shortest_line([piece, *met[~shapely.is_empty(met)]], at)
            # Each shortest line ends at the point itself; its first end is the place.
            places = shapely.get_coordinates(ends)[::2]
            order = np.argsort(np.hypot(*(places - point).T), kind="stable")
            found.append([(float(x), float(y)) for x, y in places[order]])
        return found


def _once(known: dict[Point, _Found], point: Point, find: Callable[[Point], _Found]) -> _Found:
    """Return what `find` finds for a point, or what is `known` of it since it was asked before."""
    if point in known:
        return known[point]
    if len(known) >= _MOST_KNOWN:
        known.clear()
    found = known[point] = find(point)
    return found


def shrunk(room: shapely.Geometry, radius: float) -> shapely.Geometry:
    """Return the part of `room` that is at least `radius` metres from its edges."""
    return room.difference(grown(edges_of_room(room), radius, STEP))


def without(space: FreeSpace, bodies: Sequence[Body], radius: float) -> FreeSpace:
    """Return the part of `space` that is at least `radius` metres from all `bodies`."""
    if not bodies:
        return space
    taken = shapely.union_all([_grown_body(body, radius) for body in bodies])
    # Pieces that the bodies don't touch stay the same objects, with what is prepared for them.
    touched = shapely.intersects(space.pieces, taken)
    left = [shapely.difference(piece, taken) for piece in space.pieces[touched]]
    parts = shapely.get_parts(np.array(left, dtype=object))
    return FreeSpace(np.concatenate([space.pieces[~touched], parts]))


def _bounds_of_sides(pieces: NDArray[np.object_]) -> MutableSequence[float]:
    """Return least x and y, greatest x and y of each side of some polygons, in turn."""
    points, of = shapely.get_coordinates(shapely.get_rings(pieces), return_index=True)
    joined = of[1:] == of[:-1]
    a, b = points[:-1][joined], points[1:][joined]
    return numbers(np.hstack([np.minimum(a, b), np.maximum(a, b)]).ravel().tolist())


@lru_cache(_MOST_GROWN)
def _grown_body(body: Body, radius: float) -> shapely.Geometry:
    """Return the area that `body` takes from the centre of a disc of `radius` metres."""
    if isinstance(body.shape, Disc):
        return around_disc(body.shape.centre, body.shape.radius + radius, STEP)
    edges = body.edges
    around = corners(edges)
    if len(edges) == 1 and len(around.turn) == len(edges[0]) - 1:
        # Convex: the bends around its corners are all there is to the outline.
        return Polygon(bends(around, radius, STEP).point)
    return body.shape.union(grown(edges, radius, STEP))
