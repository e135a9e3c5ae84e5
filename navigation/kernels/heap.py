"""A binary heap of entries, the least first, for compiled searches.

It is `heapq` for tuples that begin with two numbers: these are compared without asking Python.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

Entry = tuple[float, float, int, int]


def heappush(heap: list[Entry], entry: Entry) -> None:
    """Add an entry."""
    heap.append(entry)
    place: cython.Py_ssize_t = len(heap) - 1
    _rise(heap, entry, place)


def heappop(heap: list[Entry]) -> Entry:
    """Take the least entry away, and return it."""
    entry: tuple[float, float, int, int] = heap.pop()
    count: cython.Py_ssize_t = len(heap)
    if count == 0:
        return entry
    least: tuple[float, float, int, int] = heap[0]
    one: tuple[float, float, int, int]
    other: tuple[float, float, int, int]
    # The lesser children move up to the bottom, as the last entry is seldom a small one.
    place: cython.Py_ssize_t = 0
    child: cython.Py_ssize_t = 1
    while child < count:
        one = heap[child]
        if child + 1 < count:
            other = heap[child + 1]
            if _before(other, one):
                child += 1
                one = other
        heap[place] = one
        place = child
        child = 2 * place + 1
    _rise(heap, entry, place)
    return least


def _rise(heap: list[Entry], entry: Entry, place: cython.Py_ssize_t) -> None:
    """Put `entry` where it belongs on the way from `place` up to the top."""
    other: tuple[float, float, int, int]
    above: cython.Py_ssize_t
    while place > 0:
        above = (place - 1) // 2
        other = heap[above]
        if not _before(entry, other):
            break
        heap[place] = other
        place = above
    heap[place] = entry


# Tuples compare as `heapq` has them compared, so that the order is the same without a compiler.
def _before(one: Entry, other: Entry) -> bool:
    """Return whether one entry is less than another."""
    a: float = one[0]
    b: float = other[0]
    if a != b:
        return a < b
    a = one[1]
    b = other[1]
    if a != b:
        return a < b
    return one < other
