"""Bodies on the floor with their FCL objects, and the corners that paths bend around.

Around a convex corner of an obstacle the centre of a disc follows an arc. Arcs are approximated by
polylines that touch them from outside, in equal steps of a given angle. The area that remains is
thus a little smaller than the exact one, never larger.

All FCL objects are in the plane z = 0: a region is a mesh of triangles in that plane, a disc is a
sphere around its centre, and the sweep of a disc along a straight line is a capsule. Their
distances in the plane are those of the flat shapes, to about 1e-6 m.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import MutableSequence, Sequence
from dataclasses import field
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Any

import fcl
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import Polygon

from floorplan import Point
from floorplan.files.dataclass import dataclass

from .kernels.numbers import numbers

Floats = NDArray[np.float64]

_FULL = 2 * math.pi
_BEGIN, _TURN = np.array([math.pi]), np.array([_FULL])
"""Begin of the arc around a disc, and its angle (radians)."""

_STRAIGHT = 1e-9
"""Radians. Corners with smaller turns are ignored."""


@dataclass(frozen=True)
class Corners:
    """K arcs to pass clockwise.

    Each has a centre (K, 2), a radius in metres (0 at the corner of a polygon), the angle at which
    its arc begins, and the angle of the arc (radians, clockwise, more than 0).
    """

    centre: Floats
    radius: Floats
    begin: Floats
    turn: Floats

    def take(self, keep: NDArray[np.bool_]) -> Corners:
        """Return the corners that are marked in `keep` (K,)."""
        return Corners(*(column[keep] for column in vars(self).values()))


@dataclass(frozen=True)
class Bends:
    """The N places where a polyline around grown corners bends.

    `point` (N, 2) is in metres. `before` and `after` (N, 2) are the unit directions of the path
    clockwise around the corner, on either side of the bend. `reach` (N,) is the distance from the
    bend (metres) at which that path touches the arc. `corner` (N,) is the index of the corner.
    """

    point: Floats
    before: Floats
    after: Floats
    reach: Floats
    corner: NDArray[np.intp]

    def __len__(self) -> int:
        return len(self.point)

    def take(self, keep: NDArray[np.bool_] | NDArray[np.intp]) -> Bends:
        """Return the bends that are marked in `keep` (N,), or whose indices it contains."""
        return Bends(*(column[keep] for column in vars(self).values()))

    def columns(self) -> Floats:
        """Return x and y of point, before and after, and reach, in rows: (7, N)."""
        return np.vstack([self.point.T, self.before.T, self.after.T, self.reach])

    @staticmethod
    def join(parts: Sequence[Bends]) -> Bends:
        """Return the bends of all parts. Indices of corners are those in their part."""
        columns = zip(*(vars(part).values() for part in parts), strict=True)
        return Bends(*map(np.concatenate, columns))


def edges_of_room(room: shapely.Geometry) -> list[Floats]:
    """Return the closed rings ((n + 1, 2), metres) around a free `room`, with it on their left."""
    return _rings(shapely.orient_polygons(room))


def edges_of_solid(solid: shapely.Geometry) -> list[Floats]:
    """Return the closed rings ((n + 1, 2), metres) around a `solid`, with it on their right."""
    return _rings(shapely.orient_polygons(solid, exterior_cw=True))


def flat_sides(edges: list[Floats]) -> MutableSequence[float]:
    """Return x and y of both ends of all sides of the rings in turn (metres)."""
    return numbers(np.hstack(_sides(edges)).ravel().tolist())


def corners(edges: list[Floats]) -> Corners:
    """Return the convex corners of obstacles. The room is on the left of `edges`."""
    begin, end = _sides(edges)
    along = end - begin
    heading = np.arctan2(along[:, 1], along[:, 0])
    # The corner at begin[k] lies between the side k and the one before it in its ring.
    before = np.arange(len(heading)) - 1
    count = np.array([len(ring) - 1 for ring in edges], dtype=int)
    before[np.cumsum(count) - count] = np.cumsum(count) - 1
    arriving, leaving = heading[before], heading
    # The room is on the left, so a ring turns right at a convex corner of an obstacle.
    turn = (arriving - leaving + math.pi) % (2 * math.pi) - math.pi
    bent = turn > _STRAIGHT
    return Corners(
        begin[bent], np.zeros(np.count_nonzero(bent)), arriving[bent] + math.pi / 2, turn[bent]
    )


def round_corner(centre: tuple[float, float], radius: float) -> Corners:
    """Return a disc as one corner with a full circle, whose begin does not matter."""
    return Corners(np.array([centre]), np.array([radius]), _BEGIN, _TURN)


def bends(around: Corners, radius: float, step: float) -> Bends:
    """Return the bends of a disc of `radius` metres around corners, at most `step` radians each."""
    discs = len(around.turn) == 1 and around.turn[0] == _FULL
    fans = _fans_of_disc(step) if discs else _fans(around.begin, around.turn, step)
    of, cosine, sine, middle, before, after = fans
    # The polygon's sides touch the arc at their middles, so its corners are farther out.
    out = (radius + around.radius[of]) / cosine
    point = around.centre[of] + out[:, None] * middle
    return Bends(point, before, after, out * sine, of)


def _fans(begin: Floats, turn: Floats, step: float) -> tuple[Any, ...]:
    """Return the directions of the bends around corners, and of the path there.

    For each bend these are the index of its corner, cosine and sine of half of its angle, the
    direction to it, and the directions of the path before and after it.
    """
    count = np.maximum(np.ceil(turn / step - 1e-9), 1).astype(int)
    of = np.repeat(np.arange(len(count)), count)
    place = np.arange(len(of)) - np.repeat(np.cumsum(count) - count, count)
    share = turn[of] / count[of]
    middle = begin[of] - (place + 0.5) * share
    before, after = _clockwise(middle + share / 2), _clockwise(middle - share / 2)
    return of, np.cos(share / 2), np.sin(share / 2), _unit(middle), before, after


@lru_cache
def _fans_of_disc(step: float) -> tuple[Any, ...]:
    """Return `_fans` of a disc. All discs have the same."""
    return _fans(_BEGIN, _TURN, step)


def around_disc(centre: tuple[float, float], radius: float, step: float) -> Polygon:
    """Return the regular polygon around a disc whose sides subtend at most `step` radians."""
    return Polygon(bends(round_corner(centre, radius), 0.0, step).point)


def _rings(polygons: shapely.Geometry) -> list[Floats]:
    rings = shapely.get_rings(shapely.get_parts(polygons))
    points, of = shapely.get_coordinates(rings, return_index=True)
    fresh = np.ones(len(points), dtype=bool)
    fresh[1:] = (points[1:] != points[:-1]).any(axis=1) | (of[1:] != of[:-1])
    points, of = points[fresh], of[fresh]
    begin = np.searchsorted(of, np.arange(len(rings) + 1)).tolist()
    return [points[first:last] for first, last in pairwise(begin)]


def _sides(edges: list[Floats]) -> tuple[Floats, Floats]:
    """Return the begin and the end of all sides of the rings, (N, 2) metres each."""
    none = np.empty((0, 2))
    begin = np.concatenate([none, *(ring[:-1] for ring in edges)])
    end = np.concatenate([none, *(ring[1:] for ring in edges)])
    return begin, end


def _unit(angle: Floats) -> Floats:
    return _pairs(np.cos(angle), np.sin(angle))


def _clockwise(normal: Floats) -> Floats:
    """Return the clockwise direction at a normal with the angle `normal`."""
    return _pairs(np.sin(normal), -np.cos(normal))


def _pairs(x: Floats, y: Floats) -> Floats:
    """Return x and y (N,) as an array (N, 2), faster than `np.stack`."""
    pairs = np.empty((len(x), 2))
    pairs[:, 0], pairs[:, 1] = x, y
    return pairs


TOLERANCE = 1e-6
"""Maximum error of FCL's distances of flat shapes in metres."""

_POINT = 1e-6
"""Radius in metres of the sphere that represents a point."""

_HALF_TURN = math.sqrt(0.5)
"""Cosine and sine of half of a quarter turn, for quaternions."""

_ANY = fcl.CollisionRequest()
"""Request for any contact."""

_STEP = math.radians(1.0)
"""Radians. Step of the polygon around a round body, which is at most 4e-5 of the radius too large.
That is less than the clearance of paths."""


@dataclass(frozen=True)
class Disc:
    """Round footprint.

    Parameters
    ----------
    centre : Point
        Centre (x, y) in metres.
    radius : float
        Radius in metres.

    Raises
    ------
    ValueError
        If a value is not finite, or the radius not positive.
    """

    centre: Point
    radius: float

    def __post_init__(self) -> None:
        if not (all(map(math.isfinite, self.centre)) and 0 < self.radius < math.inf):
            raise ValueError(f"a disc needs a finite centre and a positive radius, found {self}")


@dataclass(frozen=True, eq=False)
class CollisionBody:
    """Body at its present place. A moved body is another value."""

    name: str
    shape: Polygon | Disc
    bounds: tuple[float, float, float, float] = field(repr=False)

    @staticmethod
    def of(name: str, shape: Polygon | Disc) -> CollisionBody:
        """Return the body `name` with this footprint. `ValueError` if it is no simple polygon."""
        if isinstance(shape, Disc):
            (x, y), r = shape.centre, shape.radius
            return CollisionBody(name, shape, (x - r, y - r, x + r, y + r))
        if not isinstance(shape, Polygon) or shape.is_empty or not shape.is_valid:
            raise ValueError(f"the footprint of {name!r} must be a Disc or a simple polygon")
        return CollisionBody(name, shape, shape.bounds)

    @cached_property
    def solid(self) -> Any:
        """FCL's object. Many bodies are never near anything, or tested in the plane alone."""
        if isinstance(self.shape, Disc):
            return disc(self.shape.centre, self.shape.radius)
        return region(self.shape)

    @property
    def footprint(self) -> Polygon:
        """Covered area. A disc is the polygon around it."""
        if isinstance(self.shape, Disc):
            return around_disc(self.shape.centre, self.shape.radius, _STEP)
        return self.shape

    @property
    def corners(self) -> Corners:
        """Corners that a path bends around to pass the body."""
        if isinstance(self.shape, Disc):
            return round_corner(self.shape.centre, self.shape.radius)
        return corners(self.edges)

    def clear_of(self, line: shapely.Geometry) -> float:
        """Return the distance from a line in metres."""
        if isinstance(self.shape, Disc):
            centre = shapely.Point(self.shape.centre)
            return max(float(shapely.distance(line, centre)) - self.shape.radius, 0.0)
        return float(shapely.distance(line, self.shape))

    @cached_property
    def outline(self) -> tuple[MutableSequence[float], float]:
        """Edges, with x and y of both ends of each in turn, and the width of a margin around them.

        Units are metres. A disc is its centre with the radius as margin.
        """
        if isinstance(self.shape, Disc):
            return numbers(self.shape.centre * 2), self.shape.radius
        rings = (self.shape.exterior, *self.shape.interiors)
        sides = (side for ring in rings for side in itertools.pairwise(ring.coords))
        return numbers(c for a, b in sides for c in (*a[:2], *b[:2])), 0.0

    @cached_property
    def edges(self) -> list[Floats]:
        """Rings around the polygon."""
        return edges_of_solid(self.shape)

    def near(self, a: Point, b: Point, radius: float) -> bool:
        """Return whether the bounds of the body overlap those of a disc that moves from a to b."""
        low_x, low_y, high_x, high_y = self.bounds
        return (
            (a[0] > low_x - radius or b[0] > low_x - radius)
            and (a[0] < high_x + radius or b[0] < high_x + radius)
            and (a[1] > low_y - radius or b[1] > low_y - radius)
            and (a[1] < high_y + radius or b[1] < high_y + radius)
        )


def region(geometry: shapely.Geometry) -> Any:
    """Return the FCL object of one or more polygons with holes."""
    # A triangulation of the region's edges has no slivers across its holes.
    triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(geometry))
    corners = shapely.get_coordinates(shapely.get_exterior_ring(triangles)).reshape(-1, 4, 2)
    flat = corners[:, :3].reshape(-1, 2)
    mesh = fcl.BVHModel()
    mesh.beginModel(len(flat), len(triangles))
    mesh.addSubModel(
        np.column_stack([flat, np.zeros(len(flat))]), np.arange(len(flat)).reshape(-1, 3)
    )
    mesh.endModel()
    return fcl.CollisionObject(mesh, fcl.Transform())


def disc(centre: Point, radius: float) -> Any:
    """Return the FCL object of a disc."""
    at = np.array([centre[0], centre[1], 0.0])
    return fcl.CollisionObject(fcl.Sphere(radius), fcl.Transform(at))


class Sweep:
    """Area that a disc sweeps along a segment, as an FCL object.

    All segments share one object, because python-fcl leaks 32 bytes per object.
    """

    def __init__(self) -> None:
        self._ball = fcl.Sphere(1.0)
        self._capsule = fcl.Capsule(1.0, 1.0)
        self._still = fcl.CollisionObject(self._ball, fcl.Transform())
        self._moving = fcl.CollisionObject(self._capsule, fcl.Transform())
        self._middle = np.zeros(3)
        self._turn = np.array([_HALF_TURN, 0.0, 0.0, 0.0])

    def between(self, a: Point, b: Point, radius: float) -> Any:
        """Return the object for the segment from `a` to `b`, valid until the next call."""
        dx, dy = b[0] - a[0], b[1] - a[1]
        length = math.hypot(dx, dy)
        self._middle[0], self._middle[1] = (a[0] + b[0]) / 2, (a[1] + b[1]) / 2
        if length == 0:
            self._ball.radius = radius
            self._still.setTranslation(self._middle)
            return self._still
        # FCL's capsules lie along z. A quarter turn about the normal of the segment in the plane
        # turns z into its direction.
        share = _HALF_TURN / length
        self._turn[1], self._turn[2] = -dy * share, dx * share
        self._capsule.radius, self._capsule.lz = radius, length
        self._moving.setQuatRotation(self._turn)
        self._moving.setTranslation(self._middle)
        return self._moving

    def distance(self, point: Point, other: Any) -> float:
        """Return the distance (m) from `point` to an FCL object, 0 inside it."""
        probe = self.between(point, point, _POINT)
        # FCL does not define the distance of overlapping shapes.
        if touch(probe, other):
            return 0.0
        gap = fcl.distance(probe, other, fcl.DistanceRequest(), fcl.DistanceResult())
        return float(gap) + _POINT


def touch(one: Any, other: Any) -> bool:
    """Return whether two FCL objects share a point."""
    return bool(fcl.collide(one, other, _ANY, fcl.CollisionResult()))
