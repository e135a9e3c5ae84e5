"""Walls of a floor: whether there is room along a segment."""

from __future__ import annotations

import math

import shapely

from floorplan import Point

from .corners import edges_of_room, flat_sides
from .kernels.edges import Grid

_SIDES_IN_A_CELL = 2.0
"""Number of sides for each cell of the grid in which they are looked up."""


class Walls:
    """The edges of a floor, for discs of one radius (metres)."""

    def __init__(self, floor: shapely.Geometry, radius: float) -> None:
        self._radius = radius
        sides = flat_sides(edges_of_room(floor))
        low_x, low_y, high_x, high_y = floor.bounds
        area = (high_x - low_x) * (high_y - low_y)
        width = math.sqrt(area * _SIDES_IN_A_CELL / (len(sides) / 4))
        self.grid = Grid(sides, width)
        """Their sides."""

    def clear(self, a: Point, b: Point) -> bool:
        """Return whether a disc touches nothing on the segment from `a`, where it is free, to b."""
        return not self.grid.touched(a[0], a[1], b[0], b[1], self._radius)
