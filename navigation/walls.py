"""Walls of a floor, kept by cells of a grid: whether there is room along a segment."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely

from floorplan import Point

from .kernels.edges import ROWS, clear

CELL = 1.0
"""Metres. The width of a cell; a segment is looked at in places at most so far apart."""

OFF = [0.0]
"""The edges of a cell that is off the floor."""


class Walls:
    """The edges of a floor, for discs of one radius (metres)."""

    def __init__(self, floor: shapely.Geometry, radius: float) -> None:
        self._floor = floor
        self._radius = radius
        rings = shapely.get_parts(shapely.boundary(floor))
        ends = [shapely.get_coordinates(ring) for ring in rings]
        self._edges = np.concatenate([np.hstack([xy[:-1], xy[1:]]) for xy in ends])
        self._tree: Any = shapely.STRtree(shapely.linestrings(self._edges.reshape(-1, 2, 2)))
        self._cells: dict[int, list[float]] = {}

    def clear(self, a: Point, b: Point) -> bool:
        """Return whether a disc touches nothing on the segment from `a`, where it is free, to b."""
        while True:
            missing: list[int] = []
            if clear(self._cells, CELL, *a, *b, self._radius, missing):
                return True
            if not missing:
                return False
            self._fill(missing[0])

    def _fill(self, key: int) -> None:
        """Find the edges that count in a cell.

        No point of a segment is farther than half a width from a place where it is looked at.
        """
        column, row = (key + ROWS // 2) // ROWS, (key + ROWS // 2) % ROWS - ROWS // 2
        x, y = column * CELL, row * CELL
        margin = self._radius + CELL / 2
        box = shapely.box(x - margin, y - margin, x + CELL + margin, y + CELL + margin)
        near = np.sort(self._tree.query(box, predicate="intersects"))
        found: list[float] = self._edges[near].ravel().tolist()
        if not found and not shapely.intersects_xy(self._floor, x + CELL / 2, y + CELL / 2):
            found = OFF
        self._cells[key] = found
