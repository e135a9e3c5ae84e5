"""Detours: the path of somebody who is stuck, round all who stand in the way."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, MutableSequence

import numpy as np
import shapely
from numpy.typing import NDArray

from floorplan import Point
from navigation import CollisionWorld, block_discs, covers, grid_path, middles, touches

CELL = 0.3
"""Metres. The width of the cells in which a way round is looked for."""

CHUNK = 64
"""Cells of a side of the squares that are known to be free or not at a time."""

AROUND = 6.0
"""Metres. So far around where they stand and where they go, people look for a way round."""

MOST = 40_000
"""Cells. Nobody looks for a way round farther than this."""


LEAPS = (64, 32, 16, 8, 4, 2, 1)
"""Cells of a way round that are tried to be left out."""

SPARE = 0.02
"""Metres. Cells have their middle as much farther from those who stand."""

Free = Callable[[Point, Point], bool]
Pieces = NDArray[np.object_]
Cells = NDArray[np.uint8]


class Detours:
    """Ways round those who stand, for people of one radius (metres)."""

    def __init__(self, world: CollisionWorld, radius: float) -> None:
        self._world = world
        self._radius = radius
        self._pieces: Pieces | None = None
        self._chunks: dict[tuple[int, int], Cells] = {}

    def path(
        self, at: Point, goal: Point, standing: MutableSequence[float], free: Free
    ) -> list[Point] | None:
        """Return a path from `at` to `goal`, both included; None if none is found.

        It stays away from those who are `standing`: x, y, and how far from there (metres) of each;
        `free` says whether there are no walls along a segment.
        """
        found = self._cells(at, goal, standing)
        if found is None:
            return None
        cells, middle = found
        width, discs = max(standing[2::3], default=0.0), middles(standing)
        kept, k, last = [at], 0, max(len(cells) - 1, 1)
        while k < last:
            # Cells zigzag: leave out as many as a straight line can, by halving leaps from the
            # farthest.
            a, tried = kept[-1], -1
            for step in LEAPS:
                end = min(k + step, last)
                if end == tried:
                    continue
                tried, b = end, goal if end == last else middle(cells[end])
                if not touches(discs, *a, *b, width) and free(a, b):
                    kept.append(b)
                    k = end
                    break
            else:
                return None
        return kept

    def _cells(
        self, at: Point, goal: Point, standing: MutableSequence[float]
    ) -> tuple[list[int], Callable[[int], Point]] | None:
        """Return the cells of a way round, and what says where the middle of one is.

        None if there is none.
        """
        # Most who look in vain have somebody at their goal.
        there = (
            (math.floor(goal[0] / CELL) + 0.5) * CELL,
            (math.floor(goal[1] / CELL) + 0.5) * CELL,
        )
        if covers(standing, *there):
            return None
        low_column, high_column = _span(at[0], goal[0])
        low_row, high_row = _span(at[1], goal[1])
        columns, rows = high_column - low_column + 1, high_row - low_row + 1
        if columns * rows > MOST:
            return None
        blocked = self._blocked(low_column, low_row, columns, rows)

        def cell(place: Point) -> int:
            column = math.floor(place[0] / CELL) - low_column
            return (math.floor(place[1] / CELL) - low_row) * columns + column

        block_discs(blocked, columns, low_column * CELL, low_row * CELL, CELL, standing, SPARE)
        start, end = cell(at), cell(goal)
        if blocked[end]:
            return None
        cells = grid_path(blocked, columns, start, end)
        if not cells:
            return None

        def middle(k: int) -> Point:
            row, column = divmod(k, columns)
            return ((column + low_column + 0.5) * CELL, (row + low_row + 0.5) * CELL)

        return cells, middle

    def _blocked(self, low_column: int, low_row: int, columns: int, rows: int) -> bytearray:
        """Return for each cell of a window whether it is blocked; those around its edge are."""
        pieces = self._world.free_space(self._radius).pieces
        if pieces is not self._pieces:
            self._pieces, self._chunks = pieces, {}
        # All blocked around the edge, so that the search need not ask whether a cell has
        # neighbours.
        cells = bytearray(b"\1") * (rows * columns)
        blocked = np.frombuffer(cells, dtype=np.uint8).reshape(rows, columns)
        for j, below, above in _parts(low_row + 1, low_row + rows - 1):
            for i, left, right in _parts(low_column + 1, low_column + columns - 1):
                if (i, j) not in self._chunks:
                    self._chunks[i, j] = _chunk(pieces, i, j)
                # Of a chunk only what the window covers.
                some = self._chunks[i, j][below - j * CHUNK :, left - i * CHUNK :]
                row, column = below - low_row, left - low_column
                some = some[: above - below, : right - left]
                blocked[row : row + above - below, column : column + right - left] = some
        return cells


def _parts(begin: int, end: int) -> Iterator[tuple[int, int, int]]:
    """Yield the chunks that cells from `begin` to `end` are in: the index, and which cells."""
    for k in range(begin // CHUNK, (end - 1) // CHUNK + 1):
        yield k, max(begin, k * CHUNK), min(end, (k + 1) * CHUNK)


def _span(a: float, b: float) -> tuple[int, int]:
    return math.floor((min(a, b) - AROUND) / CELL), math.floor((max(a, b) + AROUND) / CELL)


def _chunk(pieces: Pieces, i: int, j: int) -> Cells:
    """Return of a square of cells which of them are not in a free space: 1, else 0."""
    k = np.arange(CHUNK) + 0.5
    x, y = np.meshgrid((i * CHUNK + k) * CELL, (j * CHUNK + k) * CELL)
    free = np.zeros(x.shape, dtype=bool)
    for piece in pieces:
        free |= shapely.intersects_xy(piece, x, y)
    return (~free).astype(np.uint8)
