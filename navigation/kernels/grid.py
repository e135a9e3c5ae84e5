"""Cells of a floor: what an area covers, and shortest paths round discs that stand on it.

Paths lead over cells, by A* (P. E. Hart, N. J. Nilsson and B. Raphael, "A formal basis for the
heuristic determination of minimum cost paths", IEEE Transactions on Systems Science and Cybernetics
4, 1968), and then as straight as there is room.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .edges import Legs
from .numbers import Place

if not cython.compiled:
    from math import floor

    from .cubics import *
    from .discs import covers
    from .edges import touches


SOME: int = 2
"""Answer for a cell that an area covers in part."""

# Whole numbers, so that costs go into buckets; 7 / 5 is √2 but for 1 %.
_STRAIGHT: cython.Py_ssize_t = 5  # cost of a step to a neighbour, and of one across a corner
_ACROSS: cython.Py_ssize_t = 7
_BUCKETS: cython.Py_ssize_t = 15  # a step changes cost and estimate together by less than this

_SOME: cython.Py_ssize_t = SOME
_FAR: cython.Py_ssize_t = 1 << 20  # cells; no floor is so wide

CHUNK = 64
"""Cells of a side of the squares that are known to be blocked or not at a time."""

_CHUNK: cython.Py_ssize_t = CHUNK
_LEAPS: list[cython.Py_ssize_t] = [64, 32, 16, 8, 4, 2, 1]  # cells that are tried to be left out
_SPARE: float = 0.02  # metres; the middles of cells are as much farther from the discs


class Cells:
    """Square cells of `width` metres, and an area: whether a place is in it.

    `whole(column, row)` is asked once for each cell that a place is in: 1 if all of it is in the
    area, 0 if none is, `SOME` if some is; then `within(x, y)` is asked for the place.
    """

    def __init__(
        self,
        width: float,
        whole: Callable[[int, int], int],
        within: Callable[[float, float], bool],
    ) -> None:
        self.width = width
        self.whole = whole
        self.within = within
        self.known: dict[int, int] = {}

    def has(self, x: float, y: float) -> bool:
        """Return whether a place (metres) is in the area."""
        column: cython.Py_ssize_t = int(floor(x / self.width))
        row: cython.Py_ssize_t = int(floor(y / self.width))
        cell: cython.Py_ssize_t = column * _FAR + row
        found: cython.Py_ssize_t = self.known.get(cell, -1)
        if found < 0:
            found = self.whole(column, row)
            self.known[cell] = found
        if found == _SOME:
            return bool(self.within(x, y))
        covered: bool = found == 1
        return covered


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

    def forget(self) -> None:
        """Ask again for each chunk: the floor has changed."""
        self.chunks = {}

    def path(self, a: Place, b: Place, discs: Numbers, legs: Legs) -> list[Place]:
        """Return a path from a to b round `discs` along free `legs`; empty if none is found.

        Both ends are included. `discs` are rows as those of `Circle`.
        """
        ax: float = a[0]
        ay: float = a[1]
        bx: float = b[0]
        by: float = b[1]
        column: cython.Py_ssize_t = int(floor(bx / self.width))
        row: cython.Py_ssize_t = int(floor(by / self.width))
        # Most who look in vain have somebody at their goal.
        if covers(discs, (column + 0.5) * self.width, (row + 0.5) * self.width):
            return []
        window: CellWindow = self._span(ax, ay, bx, by)
        if window.columns * window.rows > self.most:
            return []
        blocked: bytearray = self._blocked(window)
        corner = window.column * self.width, window.row * self.width
        block_discs(blocked, window.columns, corner, self.width, _wider(discs))
        end: cython.Py_ssize_t = (row - window.row) * window.columns + column - window.column
        if blocked[end]:
            return []
        column = int(floor(ax / self.width)) - window.column
        row = int(floor(ay / self.width)) - window.row
        begin: cython.Py_ssize_t = row * window.columns + column
        cells: list[cython.Py_ssize_t] = grid_path(blocked, window.columns, begin, end)
        if len(cells) == 0:
            return []
        # The middles of the cells between the two ends.
        places: Numbers = position_room(max(len(cells), 2))
        k: cython.Py_ssize_t
        for k in range(1, len(cells) - 1):
            positions_of(places)[k] = Position(
                (cells[k] % window.columns + window.column + 0.5) * self.width,
                (cells[k] // window.columns + window.row + 0.5) * self.width,
            )
        positions_of(places)[0] = Position(ax, ay)
        positions_of(places)[position_count(places) - 1] = Position(bx, by)
        return _straightened(places, discs, legs)

    def _span(self, ax: float, ay: float, bx: float, by: float) -> CellWindow:
        """Return the window of cells in which a path from a to b is looked for."""
        column: cython.Py_ssize_t = int(floor((min(ax, bx) - self.around) / self.width))
        row: cython.Py_ssize_t = int(floor((min(ay, by) - self.around) / self.width))
        right: cython.Py_ssize_t = int(floor((max(ax, bx) + self.around) / self.width))
        top: cython.Py_ssize_t = int(floor((max(ay, by) + self.around) / self.width))
        return CellWindow(column, row, right - column + 1, top - row + 1)

    def _blocked(self, window: CellWindow) -> bytearray:
        """Return for each cell of the window whether it is blocked.

        Those around its edge are, so that the search need not ask whether a cell has neighbours.
        """
        found: bytearray = bytearray(b"\1") * (window.rows * window.columns)
        left: cython.Py_ssize_t = window.column + 1
        right: cython.Py_ssize_t = window.column + window.columns - 1
        bottom: cython.Py_ssize_t = window.row + 1
        top: cython.Py_ssize_t = window.row + window.rows - 1
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
                    o: cython.Py_ssize_t = (row - window.row) * window.columns
                    o += left - window.column
                    c: cython.Py_ssize_t = (row - j * _CHUNK) * _CHUNK + left - i * _CHUNK
                    found[o : o + width] = chunk[c : c + width]
                    row += 1
            left = beyond
        return found

    def _chunk(self, i: cython.Py_ssize_t, j: cython.Py_ssize_t) -> bytes:
        if (i, j) not in self.chunks:
            self.chunks[i, j] = self.chunk(i, j)
        return self.chunks[i, j]


def _straightened(places: Numbers, discs: Numbers, legs: Legs) -> list[Place]:
    """Return a path along places without those that a straight line can leave out; or []."""
    place: Positions = positions_of(places)
    ends: Numbers = middles(discs)
    least: float = 0.0
    i: cython.Py_ssize_t
    for i in range(circle_count(discs)):
        least = max(least, circles_of(discs)[i].radius)
    here: Position = place[0]
    kept: list[Place] = [(here.x, here.y)]
    k: cython.Py_ssize_t = 0
    last: cython.Py_ssize_t = position_count(places) - 1
    while k < last:
        # Cells zigzag: as many are left out as can be, by halving leaps from the farthest.
        before: cython.Py_ssize_t = k
        tried: cython.Py_ssize_t = -1
        for i in range(len(_LEAPS)):
            end: cython.Py_ssize_t = min(k + _LEAPS[i], last)
            if end == tried:
                continue
            tried = end
            to: Position = place[end]
            if not touches(ends, here.x, here.y, to.x, to.y, least) and legs.free(
                here.x, here.y, to.x, to.y
            ):
                kept.append((to.x, to.y))
                here = to
                k = end
                break
        if k == before:
            return []
    return kept


def _wider(discs: Numbers) -> Numbers:
    """Return `discs` for the middles of cells, which are farther off."""
    found: Numbers = circle_room(circle_count(discs))
    k: cython.Py_ssize_t
    for k in range(circle_count(discs)):
        disc: Circle = circles_of(discs)[k]
        circles_of(found)[k] = Circle(disc.x, disc.y, disc.radius + _SPARE)
    return found


def _chunk_of(cell: cython.Py_ssize_t) -> cython.Py_ssize_t:
    """Return the index of the chunk that a column or row of cells is in."""
    return int(floor(1.0 * cell / _CHUNK))


def block_discs(
    blocked: bytearray, columns: cython.Py_ssize_t, corner: Place, width: float, discs: Numbers
) -> cython.int:
    """Block the cells of a grid whose middle is in one of `discs` (rows as those of `Circle`).

    `blocked` and `columns` are as for `grid_path`; the cells are `width` metres wide, and the
    `corner` is that of the first.
    """
    rows: cython.Py_ssize_t = len(blocked) // columns
    low_x: float = corner[0]
    low_y: float = corner[1]
    k: cython.Py_ssize_t
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    for k in range(circle_count(discs)):
        disc: Circle = circles_of(discs)[k]
        x: float = (disc.x - low_x) / width - 0.5
        y: float = (disc.y - low_y) / width - 0.5
        reach: float = disc.radius / width
        # One cell more on either side than can be within reach; whole numbers are cut towards 0.
        left: cython.Py_ssize_t = int(max(x - reach, 0.0))
        right: cython.Py_ssize_t = int(min(max(x + reach + 2.0, 0.0), columns * 1.0))
        bottom: cython.Py_ssize_t = int(max(y - reach, 0.0))
        top: cython.Py_ssize_t = int(min(max(y + reach + 2.0, 0.0), rows * 1.0))
        for j in range(bottom, top):
            dy: float = j - y
            for i in range(left, right):
                dx: float = i - x
                if dx * dx + dy * dy < reach * reach:
                    blocked[j * columns + i] = 1
    return 0


def middles(discs: Numbers) -> Numbers:
    """Return the middles of `discs` as edges of no length (see `edges`)."""
    found: Numbers = edge_room(circle_count(discs))
    k: cython.Py_ssize_t
    for k in range(circle_count(discs)):
        disc: Circle = circles_of(discs)[k]
        edges_of(found)[k] = Edge(disc.x, disc.y, disc.x, disc.y)
    return found


def grid_path(
    blocked: bytearray,
    columns: cython.Py_ssize_t,
    start: cython.Py_ssize_t,
    goal: cython.Py_ssize_t,
) -> list[int]:
    """Return the cells of a shortest path from `start` to `goal`, both included; [] without one.

    `blocked` has a byte for each cell, row by row, `columns` in each; those around the edge are all
    blocked. A step across a corner needs both cells beside it. The queue of A* is one of buckets
    of whole costs (R. Dial, "Algorithm 360", Communications of the ACM 12, 1969).
    """
    count: cython.Py_ssize_t = len(blocked)
    k: cython.Py_ssize_t
    unseen: cython.Py_ssize_t = 100 * count
    # Each bucket is a stack: its top, and for each cell which are above and below it. Of each cell
    # the cost, the cell before it, and the two of its stack.
    rows: list[Wholes] = [whole(-1, count) for _ in range(4)]
    row: Wholes = whole(-1, _BUCKETS)
    tops: Ints = ints(row)
    costs: Ints = ints(rows[0])
    came: Ints = ints(rows[1])
    above: Ints = ints(rows[2])
    below: Ints = ints(rows[3])
    for k in range(count):
        costs[k] = unseen
    costs[start] = 0
    level: cython.Py_ssize_t = _estimate(start, goal, columns)
    tops[level % _BUCKETS] = start
    empty: cython.Py_ssize_t = 0
    while empty < _BUCKETS:
        # Of equal estimates the last one found: towards the goal, not across all that are as good.
        bucket: cython.Py_ssize_t = level % _BUCKETS
        cell: cython.Py_ssize_t = tops[bucket]
        if cell < 0:
            level += 1
            empty += 1
            continue
        empty = 0
        tops[bucket] = below[cell]
        if below[cell] >= 0:
            above[below[cell]] = -1
        if cell == goal:
            found: list[int] = []
            while cell >= 0:
                found.append(cell)
                cell = came[cell]
            found.reverse()
            return found
        cost: cython.Py_ssize_t = costs[cell]
        for k in range(8):
            across: cython.Py_ssize_t = 0
            along: cython.Py_ssize_t = 0
            if k == 0 or k == 4 or k == 5:
                across = 1
            elif k == 1 or k == 6 or k == 7:
                across = -1
            if k == 2 or k == 4 or k == 6:
                along = columns
            elif k == 3 or k == 5 or k == 7:
                along = -columns
            other: cython.Py_ssize_t = cell + across + along
            if blocked[other]:
                continue
            dearer: cython.Py_ssize_t = cost + _STRAIGHT
            if k > 3:
                if blocked[cell + across] or blocked[cell + along]:
                    continue
                dearer = cost + _ACROSS
            if dearer < costs[other]:
                estimate: cython.Py_ssize_t = _estimate(other, goal, columns)
                if costs[other] < unseen:  # it changes from one bucket to another
                    if above[other] < 0:
                        tops[(costs[other] + estimate) % _BUCKETS] = below[other]
                    else:
                        below[above[other]] = below[other]
                    if below[other] >= 0:
                        above[below[other]] = above[other]
                costs[other] = dearer
                came[other] = cell
                bucket = (dearer + estimate) % _BUCKETS
                above[other] = -1
                below[other] = tops[bucket]
                if below[other] >= 0:
                    above[below[other]] = other
                tops[bucket] = other
    return []


def _estimate(
    cell: cython.Py_ssize_t, goal: cython.Py_ssize_t, columns: cython.Py_ssize_t
) -> cython.Py_ssize_t:
    """Return the cost from a cell to the goal, were nothing blocked."""
    # Diagonal until level with the goal, then straight: never more than the true cost, and a step
    # changes it by no more than the step's cost, so no cell is opened twice.
    dx: cython.Py_ssize_t = cell % columns - goal % columns
    dy: cython.Py_ssize_t = cell // columns - goal // columns
    if dx < 0:
        dx = -dx
    if dy < 0:
        dy = -dy
    if dx < dy:
        return _STRAIGHT * dy + (_ACROSS - _STRAIGHT) * dx
    return _STRAIGHT * dx + (_ACROSS - _STRAIGHT) * dy
