"""Things on the floor that come, move and go: AGVs, other people, a gantry's shadow."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import shapely
from shapely.geometry import Polygon

from floorplan import Point

from . import shapes
from .corners import Corners, around_disc, corners, edges_of_solid, round_corner

_STEP = math.radians(1.0)
"""Radians. How finely a round body's footprint is drawn as a polygon, from outside: 4e-5 of its
radius too large at most, less than what ways keep beyond theirs."""


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
    """One such thing where it is now. A body that moves is replaced by another value."""

    name: str
    shape: Polygon | Disc
    solid: Any = field(repr=False)
    bounds: tuple[float, float, float, float] = field(repr=False)

    @staticmethod
    def of(name: str, shape: Polygon | Disc) -> Body:
        """The body `name` with this footprint; `ValueError` if it is no simple polygon."""
        if isinstance(shape, Disc):
            (x, y), r = shape.centre, shape.radius
            return Body(name, shape, shapes.disc(shape.centre, r), (x - r, y - r, x + r, y + r))
        if not isinstance(shape, Polygon) or shape.is_empty or not shape.is_valid:
            raise ValueError(f"the footprint of {name!r} must be a Disc or a simple polygon")
        return Body(name, shape, shapes.region(shape), shape.bounds)

    @property
    def footprint(self) -> Polygon:
        """What it covers; a disc as the polygon around it."""
        if isinstance(self.shape, Disc):
            return around_disc(self.shape.centre, self.shape.radius, _STEP)
        return self.shape

    @property
    def corners(self) -> Corners:
        """What one goes round to pass it."""
        if isinstance(self.shape, Disc):
            return round_corner(self.shape.centre, self.shape.radius)
        return corners(edges_of_solid(self.shape))

    def clear_of(self, line: shapely.Geometry) -> float:
        """Metres between it and a line (shapely)."""
        if isinstance(self.shape, Disc):
            centre = shapely.Point(self.shape.centre)
            return max(float(shapely.distance(line, centre)) - self.shape.radius, 0.0)
        return float(shapely.distance(line, self.shape))

    def near(self, a: Point, b: Point, radius: float) -> bool:
        """Whether the bounds of it and of a disc that moves from a to b overlap."""
        low_x, low_y, high_x, high_y = self.bounds
        return (
            (a[0] > low_x - radius or b[0] > low_x - radius)
            and (a[0] < high_x + radius or b[0] < high_x + radius)
            and (a[1] > low_y - radius or b[1] > low_y - radius)
            and (a[1] < high_y + radius or b[1] < high_y + radius)
        )
