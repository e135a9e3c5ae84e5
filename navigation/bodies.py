"""Bodies on the floor (AGVs, other people, a gantry's shadow) and their FCL objects.

All FCL objects here lie in the plane z = 0: a region is a mesh of triangles in that plane, a disc
a sphere centred on it, and the sweep of a disc along a straight line a capsule. In the plane their
distances are those of the flat shapes, to about 1e-6 m.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import MutableSequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import fcl
import numpy as np
import shapely
from shapely.geometry import Polygon

from floorplan import Point

from .corners import Corners, Floats, around_disc, corners, edges_of_solid, round_corner
from .kernels.numbers import numbers

TOLERANCE = 1e-6
"""Metres. How far FCL's answers about flat shapes may be off."""

_POINT = 1e-6
"""Metres. The radius of the sphere that stands for a point."""

_HALF_TURN = math.sqrt(0.5)
"""Cosine and sine of half of a quarter turn, as quaternions have it."""

_ANY = fcl.CollisionRequest()
"""Question to FCL that any contact answers."""

_STEP = math.radians(1.0)
"""Radians. How finely a round body's footprint is drawn as a polygon, from outside: 4e-5 of its
radius too large at most, less than paths keep beyond theirs."""


@dataclass(frozen=True)
class Disc:
    """A round footprint: centre and radius in metres."""

    centre: Point
    radius: float

    def __post_init__(self) -> None:
        if not (all(map(math.isfinite, self.centre)) and 0 < self.radius < math.inf):
            raise ValueError(f"a disc needs a finite centre and a positive radius, found {self}")


@dataclass(frozen=True, eq=False)
class Body:
    """A body where it is now. One that moves is replaced by another value."""

    name: str
    shape: Polygon | Disc
    solid: Any = field(repr=False)
    bounds: tuple[float, float, float, float] = field(repr=False)

    @staticmethod
    def of(name: str, shape: Polygon | Disc) -> Body:
        """Return the body `name` with this footprint; `ValueError` if it is no simple polygon."""
        if isinstance(shape, Disc):
            (x, y), r = shape.centre, shape.radius
            return Body(name, shape, disc(shape.centre, r), (x - r, y - r, x + r, y + r))
        if not isinstance(shape, Polygon) or shape.is_empty or not shape.is_valid:
            raise ValueError(f"the footprint of {name!r} must be a Disc or a simple polygon")
        return Body(name, shape, region(shape), shape.bounds)

    @property
    def footprint(self) -> Polygon:
        """The area that it covers; a disc as the polygon around it."""
        if isinstance(self.shape, Disc):
            return around_disc(self.shape.centre, self.shape.radius, _STEP)
        return self.shape

    @property
    def corners(self) -> Corners:
        """The corners that a path bends around to pass it."""
        if isinstance(self.shape, Disc):
            return round_corner(self.shape.centre, self.shape.radius)
        return corners(self.edges)

    def clear_of(self, line: shapely.Geometry) -> float:
        """Return the metres between it and a line (shapely)."""
        if isinstance(self.shape, Disc):
            centre = shapely.Point(self.shape.centre)
            return max(float(shapely.distance(line, centre)) - self.shape.radius, 0.0)
        return float(shapely.distance(line, self.shape))

    @cached_property
    def outline(self) -> tuple[MutableSequence[float], float]:
        """Its edges: x and y of both ends of each in turn; and how much larger it is all round.

        Metres. A disc is its centre, and larger by its radius.
        """
        if isinstance(self.shape, Disc):
            return numbers(self.shape.centre * 2), self.shape.radius
        rings = (self.shape.exterior, *self.shape.interiors)
        sides = (side for ring in rings for side in itertools.pairwise(ring.coords))
        return numbers(c for a, b in sides for c in (*a[:2], *b[:2])), 0.0

    @cached_property
    def edges(self) -> list[Floats]:
        """The rings around the polygon that it is."""
        return edges_of_solid(self.shape)

    def near(self, a: Point, b: Point, radius: float) -> bool:
        """Return whether its bounds overlap those of a disc that moves from a to b."""
        low_x, low_y, high_x, high_y = self.bounds
        return (
            (a[0] > low_x - radius or b[0] > low_x - radius)
            and (a[0] < high_x + radius or b[0] < high_x + radius)
            and (a[1] > low_y - radius or b[1] > low_y - radius)
            and (a[1] < high_y + radius or b[1] < high_y + radius)
        )


def region(geometry: shapely.Geometry) -> Any:
    """Return the FCL object of a polygon or several, holes left out."""
    # Triangles of the region's own edges: a mesh without slivers over its holes.
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
    """The area that a disc sweeps along a segment, as an FCL object.

    There is one object for all segments: python-fcl never frees all of the memory of an object,
    32 bytes each.
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
        # FCL's capsules lie along z: a quarter turn about the normal of the segment that lies in
        # the plane turns z into its direction.
        share = _HALF_TURN / length
        self._turn[1], self._turn[2] = -dy * share, dx * share
        self._capsule.radius, self._capsule.lz = radius, length
        self._moving.setQuatRotation(self._turn)
        self._moving.setTranslation(self._middle)
        return self._moving

    def distance(self, point: Point, other: Any) -> float:
        """Return the metres from `point` to an FCL object; 0 inside it."""
        probe = self.between(point, point, _POINT)
        # FCL leaves the distance of overlapping shapes undefined.
        if touch(probe, other):
            return 0.0
        gap = fcl.distance(probe, other, fcl.DistanceRequest(), fcl.DistanceResult())
        return float(gap) + _POINT


def touch(one: Any, other: Any) -> bool:
    """Return whether two FCL objects share a point."""
    return bool(fcl.collide(one, other, _ANY, fcl.CollisionResult()))
