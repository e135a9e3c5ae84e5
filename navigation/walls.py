"""Walls of a floor, kept by cells of a grid: whether there is room along a segment."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import shapely

from floorplan import Point

from .kernels.edges import touches

STRIDE = 1.0
"""Metres. A segment is looked at in cells at most so far apart."""

CELL = 1.0
"""Metres. The width of a cell."""


class Walls:
    """The edges of a floor, for discs of one radius (metres)."""

    def __init__(self, floor: shapely.Geometry, radius: float) -> None:
        self._floor = floor
        self._radius = radius
        rings = shapely.get_parts(shapely.boundary(floor))
        ends = [shapely.get_coordinates(ring) for ring in rings]
        self._edges = np.concatenate([np.hstack([xy[:-1], xy[1:]]) for xy in ends])
        self._tree: Any = shapely.STRtree(shapely.linestrings(self._edges.reshape(-1, 2, 2)))
        self._cells: dict[tuple[int, int], list[float] | None] = {}

    def clear(self, a: Point, b: Point) -> bool:
        """Return whether a disc touches nothing on the segment from `a`, where it is free, to b."""
        ax, ay = a
        bx, by = b
        length = math.sqrt((bx - ax) * (bx - ax) + (by - ay) * (by - ay))
        count = math.ceil(length / STRIDE) or 1
        last = None
        for k in range(count + 1):
            share = k / count
            key = (
                math.floor((ax + share * (bx - ax)) / CELL),
                math.floor((ay + share * (by - ay)) / CELL),
            )
            if key == last:
                continue
            last = key
            edges = self._cells[key] if key in self._cells else self._cell(key)
            if edges is None or (edges and touches(edges, ax, ay, bx, by, self._radius)):
                return False
        return True

    def _cell(self, key: tuple[int, int]) -> list[float] | None:
        """Return the edges that count in a cell; None if it is off the floor.

        No point of a segment is farther than half a stride from a place where it is looked at.
        """
        x, y = key[0] * CELL, key[1] * CELL
        margin = self._radius + STRIDE / 2
        box = shapely.box(x - margin, y - margin, x + CELL + margin, y + CELL + margin)
        near = np.sort(self._tree.query(box, predicate="intersects"))
        found: list[float] | None = self._edges[near].ravel().tolist()
        if not found and not shapely.intersects_xy(self._floor, x + CELL / 2, y + CELL / 2):
            found = None
        self._cells[key] = found
        return found
