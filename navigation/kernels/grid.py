"""Cells of a floor: shortest paths around blocked cells (A*), and cells that an area covers."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

if not cython.compiled:
    from math import floor, sqrt

    from .numbers import *

SOME: int = 2
"""Answer for a cell that an area covers in part."""

# Whole numbers, so that costs go into buckets; 7 / 5 is √2 but for 1 %.
_STRAIGHT: cython.Py_ssize_t = 5  # cost of a step to a neighbour, and of one across a corner
_ACROSS: cython.Py_ssize_t = 7
_BUCKETS: cython.Py_ssize_t = 15  # a step changes cost and estimate together by less than this

_SOME: cython.Py_ssize_t = SOME
_FAR: cython.Py_ssize_t = 1 << 20  # cells; no floor is so wide


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


def block_discs(
    blocked: bytearray,
    columns: cython.Py_ssize_t,
    low_x: float,
    low_y: float,
    width: float,
    discs: Numbers,
    spare: float,
) -> cython.int:
    """Block the cells of a grid whose middle is in a disc, or up to `spare` metres beside it.

    `blocked` and `columns` are as for `grid_path`; the cells are `width` metres wide, and the
    corner of the first is at `low_x`, `low_y`. `discs` holds x, y and radius of each (metres).
    """
    rows: cython.Py_ssize_t = len(blocked) // columns
    disc: Doubles = at(discs)
    k: cython.Py_ssize_t
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    for k in range(0, len(discs), 3):
        radius: float = disc[k + 2] + spare
        x: float = (disc[k] - low_x) / width - 0.5
        y: float = (disc[k + 1] - low_y) / width - 0.5
        reach: float = radius / width
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


def covers(discs: Numbers, x: float, y: float) -> bool:
    """Return whether a place is in one of `discs`: x, y and radius of each (metres)."""
    disc: Doubles = at(discs)
    k: cython.Py_ssize_t
    for k in range(0, len(discs), 3):
        dx: float = disc[k] - x
        dy: float = disc[k + 1] - y
        if sqrt(dx * dx + dy * dy) < disc[k + 2]:
            return True
    return False


def middles(discs: Numbers) -> Numbers:
    """Return the middles of `discs` as edges of no length (see `edges`)."""
    count: cython.Py_ssize_t = len(discs) // 3
    found: Numbers = room(4 * count)
    disc: Doubles = at(discs)
    edge: Doubles = at(found)
    k: cython.Py_ssize_t
    for k in range(count):
        edge[4 * k] = edge[4 * k + 2] = disc[3 * k]
        edge[4 * k + 1] = edge[4 * k + 3] = disc[3 * k + 1]
    return found


def grid_path(
    blocked: bytearray,
    columns: cython.Py_ssize_t,
    start: cython.Py_ssize_t,
    goal: cython.Py_ssize_t,
) -> list[int]:
    """Return the cells of a shortest path from `start` to `goal`, both included; [] without one.

    `blocked` has a byte for each cell, row by row, `columns` in each; those around the edge are all
    blocked. A step across a corner needs both cells beside it. This is A* (P. Hart et al., 1968)
    with buckets of whole costs (R. Dial, "Algorithm 360", 1969).
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
