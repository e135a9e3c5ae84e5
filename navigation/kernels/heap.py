"""Priority queue of a search.

A binary heap (J. W. J. Williams, "Algorithm 232: Heapsort", Communications of the ACM 7, 1964).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from typing import TypeAlias

    import cython
else:
    from . import uncompiled as cython

if not cython.compiled:
    from .numbers import *
    from .uncompiled import Entry, Rows

    Entries: TypeAlias = "Rows[Entry]"

    def _entries(row: Numbers) -> Entries:
        """Return entries by their numbers."""
        return Rows(row, Entry, _WIDTH)


_SOME: cython.Py_ssize_t = 256  # entries, at first
_WIDTH: cython.Py_ssize_t = 4  # numbers of an entry


class Heap:
    """Entries of a search, the least first."""

    def __init__(self) -> None:
        self.entries: Numbers = room(_WIDTH * _SOME)
        self.count = 0

    def clear(self) -> cython.int:
        """Remove all entries."""
        self.count = 0
        return 0

    def push(self, entry: Entry) -> cython.int:
        """Add an entry."""
        if _WIDTH * (self.count + 1) > len(self.entries):
            grow(self.entries, 2 * len(self.entries))
        self.count += 1
        return self._rise(self.count - 1, entry)

    def pop(self) -> Entry:
        """Remove the least entry, and return it."""
        row: Entries = _entries(self.entries)
        least: Entry = row[0]
        self.count -= 1
        # The lesser children move up to the bottom, as the last entry is seldom a small one.
        last: cython.Py_ssize_t = self.count
        place: cython.Py_ssize_t = 0
        child: cython.Py_ssize_t = 1
        while child < last:
            if child + 1 < last and _precedes(row[child + 1], row[child]):
                child += 1
            row[place] = row[child]
            place = child
            child = 2 * place + 1
        self._rise(place, row[last])
        return least

    def _rise(self, place: cython.Py_ssize_t, entry: Entry) -> cython.int:
        """Put an entry where it belongs on the path from `place` up to the top."""
        row: Entries = _entries(self.entries)
        while place > 0:
            above: cython.Py_ssize_t = (place - 1) // 2
            if not _precedes(entry, row[above]):
                break
            row[place] = row[above]
            place = above
        row[place] = entry
        return 0


def _precedes(entry: Entry, other: Entry) -> bool:
    """Return whether an entry is less than another."""
    if entry.bound != other.bound:
        return entry.bound < other.bound
    if entry.so_far != other.so_far:
        return entry.so_far < other.so_far
    if entry.here != other.here:
        return entry.here < other.here
    return entry.there < other.there
