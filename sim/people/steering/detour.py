"""Detours: the path of somebody who is stuck, round all who stand in the way."""

from __future__ import annotations

from collections.abc import MutableSequence

import numpy as np
import shapely
from numpy.typing import NDArray

from floorplan import Point
from navigation import CollisionWorld
from navigation.kernels.edges import Legs
from navigation.kernels.ways_round import CHUNK, WaysRound

CELL = 0.3
"""Metres. The width of the cells in which a way round is looked for."""

AROUND = 6.0
"""Metres. So far around where they stand and where they go, people look for a way round."""

MOST = 40_000
"""Cells. Nobody looks for a way round farther than this."""


class Detours:
    """Ways round those who stand, for people of one radius (metres)."""

    def __init__(self, world: CollisionWorld, radius: float) -> None:
        self._world = world
        self._radius = radius
        self._pieces: NDArray[np.object_] = np.empty(0, dtype=object)
        self._ways = WaysRound(CELL, AROUND, MOST, self._chunk)

    def path(
        self, at: Point, goal: Point, standing: MutableSequence[float], legs: Legs
    ) -> list[Point]:
        """Return a path from `at` to `goal`, both included; empty if none is found.

        It stays away from those who are `standing`: x, y, and how far from there (metres) of each;
        `legs` are the segments that are free.
        """
        pieces = self._world.free_space(self._radius).pieces
        if pieces is not self._pieces:
            self._pieces = pieces
            self._ways.forget()
        corners = self._ways.path(*at, *goal, standing, legs)
        return [*zip(corners[::2], corners[1::2], strict=True)]

    def _chunk(self, i: int, j: int) -> bytes:
        """Return of a square of cells which of them are not in the free space: 1, else 0."""
        k = np.arange(CHUNK) + 0.5
        x, y = np.meshgrid((i * CHUNK + k) * CELL, (j * CHUNK + k) * CELL)
        free = np.zeros(x.shape, dtype=bool)
        for piece in self._pieces:
            free |= shapely.intersects_xy(piece, x, y)
        return (~free).astype(np.uint8).tobytes()
