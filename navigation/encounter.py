"""Solids of people and machines, for distances between surfaces.

All solids are upright: a footprint between a bottom and a top. Their distance is √(p² + z²) with p
the distance of the footprints in the plane and z the gap between the heights. The footprint of a
machine is a disc or a polygon that turns with it. Its point nearest to the person's axis is known
in closed form, and the person's radius is subtracted from p.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import fields
from functools import cached_property
from typing import TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray
from typing_extensions import Self

from floorplan import Gantry, Lane, Point
from floorplan.files.dataclass import dataclass

from .kernels.encounter import Gauge, PolygonGauge

Floats = NDArray[np.float64]

PERSON_RADIUS = 0.30
"""Default radius of a person in metres."""

PERSON_HEIGHT = 1.75
"""Default height of a person in metres."""


def _require_solid(solid: Solid) -> None:
    for field in fields(solid):
        length = getattr(solid, field.name)
        if field.name == "footprint":
            continue
        if not (math.isfinite(length) and (length > 0 or (field.name == "bottom" and length == 0))):
            raise ValueError(f"{field.name} of a {type(solid).__name__} can't be {length} m")
    if solid.top <= solid.bottom:
        raise ValueError(f"top ({solid.top} m) must be above bottom ({solid.bottom} m)")


@dataclass(frozen=True, kw_only=True)
class Cylinder:
    """Upright cylinder around the axis of a body.

    Parameters
    ----------
    radius : float
        Radius in metres.
    bottom, top : float
        Heights above the floor in metres. The bottom is 0 by default.

    Raises
    ------
    ValueError
        If a value is not positive, or if `top` is not above `bottom`.
    """

    radius: float
    bottom: float = 0.0
    top: float

    def __post_init__(self) -> None:
        _require_solid(self)

    @classmethod
    def of_arm(cls, gantry: Gantry) -> Self:
        """Return the cylinder that a gantry's folded arm may cover, up to the top of its torso."""
        return cls(radius=gantry.arm_reach, bottom=gantry.arm_bottom, top=gantry.torso[3])

    @property
    def corners(self) -> tuple[tuple[float, float], ...]:
        """Points whose hull, grown by `rounding`, is the footprint."""
        return ((0.0, 0.0),)

    @property
    def rounding(self) -> float:
        """Radius around `corners` in metres."""
        return self.radius


@dataclass(frozen=True, kw_only=True)
class Box:
    """Upright box around the axis of a body that turns with it.

    Parameters
    ----------
    length, width : float
        Size along the heading and across it in metres.
    bottom, top : float
        Heights above the floor in metres. The bottom is 0 by default.

    Raises
    ------
    ValueError
        If a value is not positive, or if `top` is not above `bottom`.
    """

    length: float
    width: float
    bottom: float = 0.0
    top: float

    def __post_init__(self) -> None:
        _require_solid(self)

    @classmethod
    def of_torso(cls, gantry: Gantry) -> Self:
        """Return the torso of a gantry, which turns with its rotation."""
        length, width, bottom, top = gantry.torso
        return cls(length=length, width=width, bottom=bottom, top=top)

    @classmethod
    def of_agv(cls, lane: Lane) -> Self:
        """Return the box of the AGV of a lane with its load."""
        return cls(length=lane.length, width=lane.width, top=lane.height)

    def is_level_with(self, other: Box) -> bool:
        """Return whether the heights of both boxes overlap."""
        return self.bottom < other.top and other.bottom < self.top

    @property
    def corners(self) -> tuple[tuple[float, float], ...]:
        """Points whose hull, grown by `rounding`, is the footprint."""
        x, y = self.length / 2, self.width / 2
        return ((x, y), (-x, y), (-x, -y), (x, -y))

    @property
    def rounding(self) -> float:
        """Radius around `corners` in metres."""
        return 0.0


@dataclass(frozen=True, kw_only=True, repr=False)
class Prism:
    """Upright prism beside or around the axis of a body that turns with it.

    Parameters
    ----------
    footprint : tuple of (float, float)
        Points in metres from the axis, along the heading and to its left. The footprint is their
        convex hull.
    bottom, top : float
        Heights above the floor in metres. The bottom is 0 by default.

    Raises
    ------
    ValueError
        If the footprint has no area, or if `top` is not above `bottom`.
    """

    footprint: tuple[Point, ...]
    bottom: float = 0.0
    top: float

    def __repr__(self) -> str:
        return f"<Prism of {len(self.footprint)} points from {self.bottom:g} to {self.top:g} m>"

    def __post_init__(self) -> None:
        _require_solid(self)
        points = np.array(self.footprint, dtype=float).reshape(-1, 2)
        hull = shapely.MultiPoint(points).convex_hull if np.isfinite(points).all() else None
        if not isinstance(hull, shapely.Polygon):
            raise ValueError(f"footprint of a Prism must have an area, not {self.footprint}")

    @cached_property
    def corners(self) -> tuple[Point, ...]:
        """Corners of the footprint, counterclockwise."""
        hull = shapely.orient_polygons(shapely.MultiPoint(self.footprint).convex_hull)
        return tuple((x, y) for x, y in shapely.get_coordinates(hull)[:-1].tolist())

    @property
    def rounding(self) -> float:
        """Radius around `corners` in metres."""
        return 0.0


Solid: TypeAlias = Cylinder | Box | Prism
"""Part of a machine."""


@dataclass(frozen=True, kw_only=True)
class Shapes:
    """Solids of a person and a machine.

    Parameters
    ----------
    person : Cylinder, optional
        Cylinder around the person's position. By default its radius is 0.3 m and its height 1.75 m.
    machine : tuple of Cylinder, Box or Prism
        Solids of the machine, which move together.

    Raises
    ------
    ValueError
        If the person is no `Cylinder`, or if the machine has no solid.
    """

    person: Cylinder = Cylinder(radius=PERSON_RADIUS, top=PERSON_HEIGHT)
    machine: tuple[Solid, ...]

    def __post_init__(self) -> None:
        if not isinstance(self.person, Cylinder):
            raise ValueError(f"a person is a Cylinder, not {self.person!r}")
        if not self.machine:
            raise ValueError("a machine needs at least one solid")
        for part in self.machine:
            if not isinstance(part, Solid):
                raise ValueError(f"a machine is made of Cylinder, Box and Prism, not {part!r}")

    def __getstate__(self) -> dict[str, object]:
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @cached_property
    def gauges(self) -> tuple[Gauge, ...]:
        """Kernels that measure between the person and each solid of the machine."""
        return tuple(self._gauge(part) for part in self.machine)

    @property
    def reach(self) -> float:
        """Distance in metres from the machine's axis to the farthest point of its solids."""
        return max(
            math.hypot(x, y) + part.rounding for part in self.machine for x, y in part.corners
        )

    def distances(self, places: Floats, poses: Floats) -> Floats:
        """Return the distances between surfaces at many times.

        Parameters
        ----------
        places : ndarray, shape (N, 2)
            Positions of the person in metres.
        poses : ndarray, shape (N, 3)
            Poses of the machine: x, y in metres and rotation in radians.

        Returns
        -------
        ndarray, shape (N,)
            Distances in metres, 0 if surfaces overlap.
        """
        away = places - poses[:, :2]
        c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
        x, y = c * away[:, 0] + s * away[:, 1], c * away[:, 1] - s * away[:, 0]
        least = np.full(len(places), np.inf)
        for part in self.machine:
            level = _distances_to_hull(x, y, part.corners) - part.rounding - self.person.radius
            least = np.minimum(least, np.hypot(np.maximum(level, 0.0), self._above(part)))
        return least

    def _above(self, part: Solid) -> float:
        """Return the gap in metres between the heights of the person and a part."""
        return max(part.bottom - self.person.top, self.person.bottom - part.top, 0.0)

    def _gauge(self, part: Solid) -> Gauge:
        radius, height = self.person.radius, self._above(part)
        match part:
            case Cylinder():
                return Gauge(radius, height, 0.0, 0.0, part.radius)
            case Box():
                return Gauge(radius, height, part.length / 2, part.width / 2, 0.0)
        return PolygonGauge(radius, height, [c for corner in part.corners for c in corner])


def _distances_to_hull(x: Floats, y: Floats, corners: Sequence[Point]) -> Floats:
    """Return the distances (m) of points from a convex polygon with counterclockwise corners."""
    square = np.full(len(x), np.inf)
    inside = np.full(len(x), len(corners) > 2)
    for (ax, ay), (bx, by) in itertools.pairwise([*corners, corners[0]]):
        ex, ey, px, py = bx - ax, by - ay, x - ax, y - ay
        along = np.clip((px * ex + py * ey) / ((ex * ex + ey * ey) or 1.0), 0.0, 1.0)
        square = np.minimum(square, (px - along * ex) ** 2 + (py - along * ey) ** 2)
        inside &= ex * py >= ey * px
    return np.where(inside, 0.0, np.sqrt(square))
