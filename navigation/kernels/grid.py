"""Grid of square cells: cached coverage by an area, and shortest paths around standing discs.

Paths are found by A* (P. E. Hart, N. J. Nilsson and B. Raphael, "A formal basis for the heuristic
determination of minimum cost paths", IEEE Transactions on Systems Science and Cybernetics 4, 1968),
and then straightened as far as there is room.
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
"""Coverage of a cell that an area covers in part."""

# Whole numbers, so that costs can index buckets. 7 / 5 is √2 within 1 %.
_STRAIGHT: cython.Py_ssize_t = 5  # cost of a step to a neighbour, and of one across a corner
_ACROSS: cython.Py_ssize_t = 7
_BUCKETS: cython.Py_ssize_t = 15  # a step changes cost plus estimate by less than this

_SOME: cython.Py_ssize_t = SOME
_FAR: cython.Py_ssize_t = 1 << 20  # cells; wider than any floor

CHUNK = 64
"""Number of cells per side of the squares in which blocked cells are cached."""

_CHUNK: cython.Py_ssize_t = CHUNK
_LEAPS: list[cython.Py_ssize_t] = [64, 32, 16, 8, 4, 2, 1]  # cells to skip, longest first
_SPARE: float = 0.02  # metres; additional distance of cell centres from the discs


class Cells:
    """Square cells of `width` metres that cache which places are in an area.

    `whole(column, row)` is called once per cell. It returns 1 if the cell is in the area, 0 if it
    is outside, and `SOME` if it is in both. Then `within(x, y)` decides each place.
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
        self.cached: dict[int, int] = {}

    def has(self, x: float, y: float) -> bool:
        """Return whether a place (metres) is in the area."""
        column: cython.Py_ssize_t = int(floor(x / self.width))
        row: cython.Py_ssize_t = int(floor(y / self.width))
        cell: cython.Py_ssize_t = column * _FAR + row
        coverage: cython.Py_ssize_t = self.cached.get(cell, -1)
        if coverage < 0:
            coverage = self.whole(column, row)
            self.cached[cell] = coverage
        if coverage == _SOME:
            return bool(self.within(x, y))
        covered: bool = coverage == 1
        return covered


class WaysRound:
    """Search for paths in square cells of `width` metres, in windows of at most `limit` cells.

    A window extends `around` metres beyond both ends. `chunk(i, j)` is called once per square of
    `CHUNK` × `CHUNK` cells. It returns a byte per cell, row by row, 1 for blocked cells.
    """

    def __init__(
        self,
        width: float,
        around: float,
        limit: cython.Py_ssize_t,
        chunk: Callable[[int, int], bytes],
    ) -> None:
        self.width = width
        self.around = around
        self.limit = limit
        self.chunk = chunk
        self.chunks: dict[tuple[int, int], bytes] = {}

    def forget(self) -> None:
        """Clear the cache after a change of the floor."""
        self.chunks = {}

    def path(self, a: Place, b: Place, discs: Numbers, legs: Legs) -> list[Place]:
        """Return a path from a to b around `discs` along free `legs`, empty if there is none.

        Both ends are included. `discs` are rows of `Circle`.
        """
        ax: float = a[0]
        ay: float = a[1]
        bx: float = b[0]
        by: float = b[1]
        column: cython.Py_ssize_t = int(floor(bx / self.width))
        row: cython.Py_ssize_t = int(floor(by / self.width))
        # Most failing searches have a person at their goal.
        if covers(discs, (column + 0.5) * self.width, (row + 0.5) * self.width):
            return []
        window: CellWindow = self._span(ax, ay, bx, by)
        if window.columns * window.rows > self.limit:
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
        """Return the window of cells for a search from a to b."""
        column: cython.Py_ssize_t = int(floor((min(ax, bx) - self.around) / self.width))
        row: cython.Py_ssize_t = int(floor((min(ay, by) - self.around) / self.width))
        right: cython.Py_ssize_t = int(floor((max(ax, bx) + self.around) / self.width))
        top: cython.Py_ssize_t = int(floor((max(ay, by) + self.around) / self.width))
        return CellWindow(column, row, right - column + 1, top - row + 1)

    def _blocked(self, window: CellWindow) -> bytearray:
        """Return for each cell of the window whether it is blocked.

        Cells at the edge are blocked, so that the search need not test whether neighbours exist.
        """
        blocked: bytearray = bytearray(b"\1") * (window.rows * window.columns)
        k: cython.Py_ssize_t
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
                    for k in range(width):  # a slice of so few bytes costs more
                        blocked[o + k] = chunk[c + k]
                    row += 1
            left = beyond
        return blocked

    def _chunk(self, i: cython.Py_ssize_t, j: cython.Py_ssize_t) -> bytes:
        if (i, j) not in self.chunks:
            self.chunks[i, j] = self.chunk(i, j)
        return self.chunks[i, j]


def _straightened(places: Numbers, discs: Numbers, legs: Legs) -> list[Place]:
    """Return a path along places without those that a straight line can skip, or []."""
    place: Positions = positions_of(places)
    ends: Numbers = middles(discs)
    least: float = 0.0
    i: cython.Py_ssize_t
    for i in range(circle_count(discs)):
        least = max(least, circles_of(discs)[i].radius)
    here: Position = place[0]
    path: list[Place] = [(here.x, here.y)]
    k: cython.Py_ssize_t = 0
    last: cython.Py_ssize_t = position_count(places) - 1
    while k < last:
        # Paths over cells zigzag, so skip as many places as possible, halving from the farthest.
        before: cython.Py_ssize_t = k
        previous: cython.Py_ssize_t = -1
        for i in range(len(_LEAPS)):
            end: cython.Py_ssize_t = min(k + _LEAPS[i], last)
            if end == previous:
                continue
            previous = end
            to: Position = place[end]
            if not touches(ends, here.x, here.y, to.x, to.y, least) and legs.free(
                here.x, here.y, to.x, to.y
            ):
                path.append((to.x, to.y))
                here = to
                k = end
                break
        if k == before:
            return []
    return path


def _wider(discs: Numbers) -> Numbers:
    """Return `discs` with a larger radius for tests of cell centres."""
    wider: Numbers = circle_room(circle_count(discs))
    k: cython.Py_ssize_t
    for k in range(circle_count(discs)):
        disc: Circle = circles_of(discs)[k]
        circles_of(wider)[k] = Circle(disc.x, disc.y, disc.radius + _SPARE)
    return wider


def _chunk_of(cell: cython.Py_ssize_t) -> cython.Py_ssize_t:
    """Return the index of the chunk that a column or row of cells is in."""
    return int(floor(1.0 * cell / _CHUNK))


def block_discs(
    blocked: bytearray, columns: cython.Py_ssize_t, corner: Place, width: float, discs: Numbers
) -> cython.int:
    """Block the cells of a grid whose centre is in one of `discs` (rows of `Circle`).

    `blocked` and `columns` are as for `grid_path`. The cells are `width` metres wide, and `corner`
    is the lower left corner of the first.
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
        # One cell more on either side than within reach, because conversion truncates towards 0.
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
    """Return the centres of `discs` as edges without length (see `edges`)."""
    edges: Numbers = edge_room(circle_count(discs))
    k: cython.Py_ssize_t
    for k in range(circle_count(discs)):
        disc: Circle = circles_of(discs)[k]
        edges_of(edges)[k] = Edge(disc.x, disc.y, disc.x, disc.y)
    return edges


def grid_path(
    blocked: bytearray,
    columns: cython.Py_ssize_t,
    start: cython.Py_ssize_t,
    goal: cython.Py_ssize_t,
) -> list[int]:
    """Return the cells of a shortest path from `start` to `goal`, both included, or [].

    `blocked` has a byte for each cell, row by row, `columns` in each. All cells at the edge must be
    blocked. A diagonal step needs both cells beside it. The queue of A* consists of buckets of
    whole costs (R. Dial, "Algorithm 360", Communications of the ACM 12, 1969).
    """
    count: cython.Py_ssize_t = len(blocked)
    k: cython.Py_ssize_t
    unseen: cython.Py_ssize_t = 100 * count
    # Each bucket is a stack with a top, linked by the cells above and below each cell. `costs` and
    # `came` have the cost of each cell and its predecessor.
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
        # Among equal estimates, the last one added leads towards the goal.
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
            path: list[int] = []
            while cell >= 0:
                path.append(cell)
                cell = came[cell]
            path.reverse()
            return path
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
                if costs[other] < unseen:  # remove the cell from its bucket
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
    """Return the cost from a cell to the goal without blocked cells."""
    # Diagonal until level with the goal, then straight. This is a lower bound of the cost, and a
    # step changes it by at most the step's cost, so no cell is expanded twice.
    dx: cython.Py_ssize_t = cell % columns - goal % columns
    dy: cython.Py_ssize_t = cell // columns - goal // columns
    if dx < 0:
        dx = -dx
    if dy < 0:
        dy = -dy
    if dx < dy:
        return _STRAIGHT * dy + (_ACROSS - _STRAIGHT) * dx
    return _STRAIGHT * dx + (_ACROSS - _STRAIGHT) * dy
