"""Cells of a floor, of which it is known whether an area covers all of them, or nothing."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

if not cython.compiled:
    from math import floor
else:
    from cython.cimports.libc.math import floor

SOME: int = 2
"""Answer of who is asked about a cell that an area covers in part."""

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
