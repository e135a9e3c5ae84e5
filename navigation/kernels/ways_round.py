"""Ways round discs that stand on a floor: over cells, and then as straight as there is room.

For the discs see `grid`, for the legs `edges`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .edges import Legs

if not cython.compiled:
    from math import floor

    from .edges import touches
    from .grid import block_discs, covers, grid_path, middles
    from .numbers import Doubles, Numbers, at
else:
    from cython.cimports.libc.math import floor
    from cython.cimports.navigation.kernels.edges import touches
    from cython.cimports.navigation.kernels.grid import block_discs, covers, grid_path, middles
    from cython.cimports.navigation.kernels.numbers import Doubles, Numbers, at

CHUNK = 64
"""Cells of a side of the squares that are known to be blocked or not at a time."""

_CHUNK: cython.Py_ssize_t = CHUNK
_LEAPS: list[cython.Py_ssize_t] = [64, 32, 16, 8, 4, 2, 1]  # cells that are tried to be left out
_SPARE: float = 0.02  # metres; the middles of cells are as much farther from the discs


class WaysRound:
    """Ways over a floor in square cells of `width` metres, of which `most` are looked at.

    As far as `around` metres around both ends. `chunk(i, j)` is asked once for each square of
    `CHUNK` cells a side: a byte for each of them, row by row, 1 for those that are blocked.
    """

    def __init__(
        self,
        width: float,
        around: float,
        most: cython.Py_ssize_t,
        chunk: Callable[[int, int], bytes],
    ) -> None:
        self.width = width
        self.around = around
        self.most = most
        self.chunk = chunk
        self.chunks: dict[tuple[int, int], bytes] = {}
        self.low_column = self.low_row = self.columns = self.rows = 0

    def forget(self) -> None:
        """Ask again for each chunk: the floor has changed."""
        self.chunks = {}

    def path(
        self, ax: float, ay: float, bx: float, by: float, discs: Numbers, legs: Legs
    ) -> list[float]:
        """Return a path from a to b round `discs` along free `legs`; empty if none is found.

        It has x and y of each corner in turn, both ends included.
        """
        column: cython.Py_ssize_t = int(floor(bx / self.width))
        row: cython.Py_ssize_t = int(floor(by / self.width))
        # Most who look in vain have somebody at their goal.
        if covers(discs, (column + 0.5) * self.width, (row + 0.5) * self.width):
            return []
        self._span(ax, ay, bx, by)
        if self.columns * self.rows > self.most:
            return []
        blocked: bytearray = self._blocked()
        low_x: float = self.low_column * self.width
        low_y: float = self.low_row * self.width
        block_discs(blocked, self.columns, low_x, low_y, self.width, discs, _SPARE)
        end: cython.Py_ssize_t = (row - self.low_row) * self.columns + column - self.low_column
        if blocked[end]:
            return []
        column = int(floor(ax / self.width)) - self.low_column
        row = int(floor(ay / self.width)) - self.low_row
        begin: cython.Py_ssize_t = row * self.columns + column
        cells: list[cython.Py_ssize_t] = grid_path(blocked, self.columns, begin, end)
        if len(cells) == 0:
            return []
        return self._straightened(cells, ax, ay, bx, by, discs, legs)

    def _span(self, ax: float, ay: float, bx: float, by: float) -> cython.int:
        """Set the window of cells in which a path from a to b is looked for."""
        self.low_column = int(floor((min(ax, bx) - self.around) / self.width))
        self.low_row = int(floor((min(ay, by) - self.around) / self.width))
        high: cython.Py_ssize_t = int(floor((max(ax, bx) + self.around) / self.width))
        self.columns = high - self.low_column + 1
        high = int(floor((max(ay, by) + self.around) / self.width))
        self.rows = high - self.low_row + 1
        return 0

    def _blocked(self) -> bytearray:
        """Return for each cell of the window whether it is blocked.

        Those around its edge are, so that the search need not ask whether a cell has neighbours.
        """
        found: bytearray = bytearray(b"\1") * (self.rows * self.columns)
        left: cython.Py_ssize_t = self.low_column + 1
        right: cython.Py_ssize_t = self.low_column + self.columns - 1
        bottom: cython.Py_ssize_t = self.low_row + 1
        top: cython.Py_ssize_t = self.low_row + self.rows - 1
        while left < right:
            i: cython.Py_ssize_t = _chunk_of(left)
            beyond: cython.Py_ssize_t = min(right, (i + 1) * _CHUNK)
            width: cython.Py_ssize_t = beyond - left
            row: cython.Py_ssize_t = bottom
            while row < top:
                j: cython.Py_ssize_t = _chunk_of(row)
                chunk: bytes = self._chunk(i, j)
                above: cython.Py_ssize_t = min(top, (j + 1) * _CHUNK)
                while row < above:
                    o: cython.Py_ssize_t = (row - self.low_row) * self.columns
                    o += left - self.low_column
                    c: cython.Py_ssize_t = (row - j * _CHUNK) * _CHUNK + left - i * _CHUNK
                    found[o : o + width] = chunk[c : c + width]
                    row += 1
            left = beyond
        return found

    def _chunk(self, i: cython.Py_ssize_t, j: cython.Py_ssize_t) -> bytes:
        if (i, j) not in self.chunks:
            self.chunks[i, j] = self.chunk(i, j)
        return self.chunks[i, j]

    def _straightened(
        self,
        cells: list[cython.Py_ssize_t],
        x: float,
        y: float,
        bx: float,
        by: float,
        discs: Numbers,
        legs: Legs,
    ) -> list[float]:
        """Return the path along cells without those that a straight line can leave out."""
        ends: Numbers = middles(discs)
        disc: Doubles = at(discs)
        least: float = 0.0
        i: cython.Py_ssize_t
        for i in range(2, len(discs), 3):
            least = max(least, disc[i])
        kept: list[float] = [x, y]
        k: cython.Py_ssize_t = 0
        last: cython.Py_ssize_t = max(len(cells) - 1, 1)
        while k < last:
            # Cells zigzag: as many are left out as can be, by halving leaps from the farthest.
            before: cython.Py_ssize_t = k
            tried: cython.Py_ssize_t = -1
            for i in range(len(_LEAPS)):
                end: cython.Py_ssize_t = min(k + _LEAPS[i], last)
                if end == tried:
                    continue
                tried = end
                px: float = bx
                py: float = by
                if end < last:
                    cell: cython.Py_ssize_t = cells[end]
                    px = (cell % self.columns + self.low_column + 0.5) * self.width
                    py = (cell // self.columns + self.low_row + 0.5) * self.width
                if not touches(ends, x, y, px, py, least) and legs.free(x, y, px, py):
                    kept.append(px)
                    kept.append(py)
                    x = px
                    y = py
                    k = end
                    break
            if k == before:
                return []
        return kept


def _chunk_of(cell: cython.Py_ssize_t) -> cython.Py_ssize_t:
    """Return the index of the chunk that a column or row of cells is in."""
    return int(floor(1.0 * cell / _CHUNK))
