"""FCL shapes of a flat world: everything lies in the plane z = 0.

A region is a mesh of triangles in that plane, a disc is a sphere centred on it, and the sweep of
a disc along a straight line a capsule. In the plane their distances are those of the flat shapes,
to about 1e-6 m.
"""

from __future__ import annotations

import math
from typing import Any

import fcl
import numpy as np
import shapely

from floorplan import Point

TOLERANCE = 1e-6
"""Metres. How far FCL's answers about flat shapes may be off."""

_POINT = 1e-6
"""Metres. The radius of the sphere that stands for a point."""


def region(geometry: shapely.Geometry) -> Any:
    """The FCL object of a polygon or several, holes left out."""
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
    """The FCL object of a disc."""
    at = np.array([centre[0], centre[1], 0.0])
    return fcl.CollisionObject(fcl.Sphere(radius), fcl.Transform(at))


class Sweep:
    """All that a disc covers on its straight way, as an FCL object.

    There is one object for all ways: python-fcl never gives back the memory of an object that it
    has made, 32 bytes each.
    """

    def __init__(self) -> None:
        self._ball = fcl.Sphere(1.0)
        self._capsule = fcl.Capsule(1.0, 1.0)
        self._still = fcl.CollisionObject(self._ball, fcl.Transform())
        self._moving = fcl.CollisionObject(self._capsule, fcl.Transform())

    def between(self, a: Point, b: Point, radius: float) -> Any:
        """The object for the way from `a` to `b`, until the next call."""
        dx, dy = b[0] - a[0], b[1] - a[1]
        length = math.hypot(dx, dy)
        middle = np.array([(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, 0.0])
        if length == 0:
            self._ball.radius = radius
            self._still.setTranslation(middle)
            return self._still
        c, s = dx / length, dy / length
        # FCL's capsules lie along z: this turns z into the direction of the way.
        turn = np.array([[0.0, -s, c], [0.0, c, s], [-1.0, 0.0, 0.0]])
        self._capsule.radius, self._capsule.lz = radius, length
        self._moving.setTransform(fcl.Transform(turn, middle))
        return self._moving

    def distance(self, point: Point, other: Any) -> float:
        """Metres from `point` to an FCL object; 0 inside it."""
        probe = self.between(point, point, _POINT)
        # FCL leaves the distance of overlapping shapes undefined.
        if touch(probe, other):
            return 0.0
        gap = fcl.distance(probe, other, fcl.DistanceRequest(), fcl.DistanceResult())
        return float(gap) + _POINT


def touch(one: Any, other: Any) -> bool:
    """Whether two FCL objects share a point."""
    return bool(fcl.collide(one, other, fcl.CollisionRequest(), fcl.CollisionResult()))
