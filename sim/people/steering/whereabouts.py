"""Whereabouts: who may be near some part of the floor, without a look at everybody.

The floor is a grid of cells without end, and each cell knows who has committed themselves to a
motion whose bounds reach into it. So what somebody's decision costs depends on who is near.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from .traveller import Traveller

CELL = 2.0
"""Metres. The width of a cell: a motion reaches into some ten of them."""

MOST = 400
"""Bounds that reach into more cells than this belong to none: they are always looked at."""

Cell = tuple[int, int]


class Whereabouts:
    """The people on a floor, by the cells that they may be in."""

    def __init__(self) -> None:
        self._cells: dict[Cell, dict[Traveller, None]] = {}
        self._of: dict[Traveller, list[Cell]] = {}
        self._far: dict[Traveller, None] = {}

    def put(self, who: Traveller) -> None:
        """Take note of what somebody has committed themselves to."""
        for cell in self._of.get(who, ()):
            del self._cells[cell][who]
        self._far.pop(who, None)
        cells = _cells(who.swath.box)
        self._of[who] = cells or []
        if cells is None:
            self._far[who] = None
            return
        for cell in cells:
            self._cells.setdefault(cell, {})[who] = None

    def within(self, box: Sequence[float]) -> list[Traveller]:
        """Return who may come into `box`: least x and y, greatest x and y (metres).

        By their index. The bounds are those of centres: add what bodies need beyond theirs.
        """
        low_x, low_y, high_x, high_y = box
        cells = _cells(box)
        found = dict(self._far) if cells is not None else dict.fromkeys(self._of)
        for cell in cells or ():
            there = self._cells.get(cell)
            if there:
                found.update(there)
        near = []
        for who in found:
            a, b, c, d = who.swath.box
            if a < high_x and c > low_x and b < high_y and d > low_y:
                near.append(who)
        near.sort(key=_index)
        return near


def _index(who: Traveller) -> int:
    return who.index


def _cells(box: Sequence[float]) -> list[Cell] | None:
    """Return the cells that a box reaches into; None if they are too many."""
    low_x, low_y, high_x, high_y = (math.floor(bound / CELL) for bound in box)
    if (high_x - low_x + 1) * (high_y - low_y + 1) > MOST:
        return None
    return [(i, j) for i in range(low_x, high_x + 1) for j in range(low_y, high_y + 1)]
