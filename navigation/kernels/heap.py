"""A binary heap of the entries of a search, the least first.

Compiled, they are columns of plain numbers; as Python it is `heapq` with tuples, as which entries
compare in either case.
"""

from __future__ import annotations

import heapq
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

Entry = tuple[float, float, int, int]
"""Lower bound of a path's length, length up to its last link, and the places of that link."""

_ROOM: cython.Py_ssize_t = 256  # entries, at first


class Heap:
    """Entries: the lower bound of a path's length, its length so far, and its last link.

    The one that was taken last is in `so_far`, `here` and `there`.
    """

    def __init__(self) -> None:
        self.entries: list[Entry] = []
        self.count = 0
        self.so_far = 0.0
        self.here = self.there = 0
        self._room = _ROOM
        self._bounds = np.empty(self._room)
        self._lengths = np.empty(self._room)
        self._froms = np.empty(self._room, dtype=np.intp)
        self._tos = np.empty(self._room, dtype=np.intp)

    def clear(self) -> cython.int:
        """Leave all entries out."""
        self.count = 0
        self.entries = []
        return 0

    def push(
        self, bound: float, so_far: float, here: cython.Py_ssize_t, there: cython.Py_ssize_t
    ) -> cython.int:
        """Add an entry."""
        self.count += 1
        if not cython.compiled:
            heapq.heappush(self.entries, (bound, so_far, here, there))
            return 0
        if self.count > self._room:
            self._widen()
        self._rise(self.count - 1, bound, so_far, here, there)
        return 0

    def pop(self) -> cython.int:
        """Take the least entry away."""
        self.count -= 1
        if not cython.compiled:
            _, self.so_far, self.here, self.there = heapq.heappop(self.entries)
            return 0
        self.so_far = self._lengths[0]
        self.here = self._froms[0]
        self.there = self._tos[0]
        # The lesser children move up to the bottom, as the last entry is seldom a small one.
        last: cython.Py_ssize_t = self.count
        place: cython.Py_ssize_t = 0
        child: cython.Py_ssize_t = 1
        while child < last:
            if child + 1 < last and self._before(
                child,
                self._bounds[child + 1],
                self._lengths[child + 1],
                self._froms[child + 1],
                self._tos[child + 1],
            ):
                child += 1
            self._move(child, place)
            place = child
            child = 2 * place + 1
        self._rise(
            place, self._bounds[last], self._lengths[last], self._froms[last], self._tos[last]
        )
        return 0

    def _rise(
        self,
        place: cython.Py_ssize_t,
        bound: float,
        so_far: float,
        here: cython.Py_ssize_t,
        there: cython.Py_ssize_t,
    ) -> cython.int:
        """Put an entry where it belongs on the way from `place` up to the top."""
        above: cython.Py_ssize_t
        while place > 0:
            above = (place - 1) // 2
            if not self._before(above, bound, so_far, here, there):
                break
            self._move(above, place)
            place = above
        self._bounds[place] = bound
        self._lengths[place] = so_far
        self._froms[place] = here
        self._tos[place] = there
        return 0

    def _before(
        self,
        other: cython.Py_ssize_t,
        bound: float,
        so_far: float,
        here: cython.Py_ssize_t,
        there: cython.Py_ssize_t,
    ) -> cython.bint:
        """Return whether an entry is less than the one at `other`."""
        if bound != self._bounds[other]:
            return bound < self._bounds[other]
        if so_far != self._lengths[other]:
            return so_far < self._lengths[other]
        if here != self._froms[other]:
            return here < self._froms[other]
        return there < self._tos[other]

    def _move(self, place: cython.Py_ssize_t, to: cython.Py_ssize_t) -> cython.int:
        """Copy an entry to another place."""
        self._bounds[to] = self._bounds[place]
        self._lengths[to] = self._lengths[place]
        self._froms[to] = self._froms[place]
        self._tos[to] = self._tos[place]
        return 0

    def _widen(self) -> cython.int:
        """Double the room for entries."""
        self._bounds = np.resize(self._bounds, 2 * self._room)
        self._lengths = np.resize(self._lengths, 2 * self._room)
        self._froms = np.resize(self._froms, 2 * self._room)
        self._tos = np.resize(self._tos, 2 * self._room)
        self._room = 2 * self._room
        return 0
