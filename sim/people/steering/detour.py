"""Detours: the path of somebody who is stuck, round all who stand in the way."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from floorplan import Point
from navigation import CollisionWorld, block_discs, grid_path, touches

CELL = 0.3
"""Metres. The width of the cells in which a way round is looked for."""

CHUNK = 32
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


class Detours:
    """Ways round those who stand, for people of one radius (metres)."""

    def __init__(self, world: CollisionWorld, radius: float) -> None:
        self._world = world
        self._radius = radius
        self._pieces: Pieces | None = None
        self._chunks: dict[tuple[int, int], list[bytes]] = {}

    def path(
        self, at: Point, goal: Point, standing: Sequence[tuple[Point, float]], free: Free
    ) -> list[Point] | None:
        """Return a path from `at` to `goal`, both included; None if none is found.

        It stays as far from each place where somebody is `standing` as is said with it (metres);
        `free` says whether there are no walls along a segment.
        """
        cells = self._cells(at, goal, standing)
        if cells is None:
            return None
        width = max((needed for _, needed in standing), default=0.0)
        discs = [number for place, _ in standing for number in (*place, *place)]
        kept, k = [at], 0
        while k < len(cells) - 1:
            ends = dict.fromkeys(min(k + step, len(cells) - 1) for step in LEAPS)
            for end in ends:
                a, b = cells[k], cells[end]
                if not touches(discs, *a, *b, width) and free(a, b):
                    kept.append(b)
                    k = end
                    break
            else:
                return None
        return kept

    def _cells(
        self, at: Point, goal: Point, standing: Sequence[tuple[Point, float]]
    ) -> list[Point] | None:
        """Return the middles of the cells of a way round, with both ends; None if there is none."""
        low_column, high_column = _span(at[0], goal[0])
        low_row, high_row = _span(at[1], goal[1])
        columns, rows = high_column - low_column + 1, high_row - low_row + 1
        if columns * rows > MOST:
            return None
        blocked = self._blocked(low_column, low_row, columns, rows)

        def cell(place: Point) -> int:
            column = math.floor(place[0] / CELL) - low_column
            return (math.floor(place[1] / CELL) - low_row) * columns + column

        discs = [c for place, needed in standing for c in (*place, needed + SPARE)]
        block_discs(blocked, columns, low_column * CELL, low_row * CELL, CELL, discs)
        start, end = cell(at), cell(goal)
        if blocked[end]:
            return None
        cells = grid_path(blocked, columns, start, end)
        if not cells:
            return None
        between = [
            ((k % columns + low_column + 0.5) * CELL, (k // columns + low_row + 0.5) * CELL)
            for k in cells[1:-1]
        ]
        return [at, *between, goal]

    def _blocked(self, low_column: int, low_row: int, columns: int, rows: int) -> bytearray:
        """Return for each cell of a window whether it is blocked; those around its edge are."""
        pieces = self._world.free_space(self._radius).pieces
        if pieces is not self._pieces:
            self._pieces, self._chunks = pieces, {}
        blocked = bytearray(b"\1" * (columns * rows))
        for row in range(1, rows - 1):
            j, inner_row = divmod(low_row + row, CHUNK)
            column = 1
            while column < columns - 1:
                i, inner = divmod(low_column + column, CHUNK)
                if (i, j) not in self._chunks:
                    self._chunks[i, j] = _chunk(pieces, i, j)
                some = self._chunks[i, j][inner_row][inner : inner + columns - 1 - column]
                k = row * columns + column
                blocked[k : k + len(some)] = some
                column += len(some)
        return blocked


def _span(a: float, b: float) -> tuple[int, int]:
    return math.floor((min(a, b) - AROUND) / CELL), math.floor((max(a, b) + AROUND) / CELL)


def _chunk(pieces: Pieces, i: int, j: int) -> list[bytes]:
    """Return for each row of a square of cells which of them are not in a free space."""
    k = np.arange(CHUNK) + 0.5
    x, y = np.meshgrid((i * CHUNK + k) * CELL, (j * CHUNK + k) * CELL)
    free = np.zeros(x.shape, dtype=bool)
    for piece in pieces:
        free |= shapely.intersects_xy(piece, x, y)
    return [row.tobytes() for row in (~free).astype(np.uint8)]
