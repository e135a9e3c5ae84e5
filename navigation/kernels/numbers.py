"""Rows of numbers, from which all tables of the kernels are made.

If the kernels are compiled, a row is an array of doubles, and `at` returns a pointer. The pointer
is invalid after the array changes its length, so it must not be stored. Otherwise a row is a list,
and `at` returns the list itself.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterable, MutableSequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from typing import TypeAlias

    import cython
    import numpy as np
    from numpy.typing import NDArray
else:
    from . import uncompiled as cython

Place = tuple[float, float]

PLANAR_WIDTH = 10
"""Numbers of a piece of x and y (see `cubics`)."""

POSE_WIDTH = 14
"""Numbers of a piece of x, y and rotation."""

if not cython.compiled:
    INFINITY = float("inf")
    Numbers: TypeAlias = MutableSequence[float]
    Doubles: TypeAlias = MutableSequence[float]
    Wholes: TypeAlias = MutableSequence[int]
    Ints: TypeAlias = MutableSequence[int]

    def at(row: Numbers) -> Doubles:
        """Return a view of a row of numbers for access by index."""
        return row

    def ints(row: Wholes) -> Ints:
        """Return a view of a row of whole numbers for access by index."""
        return row

    def cut(row: Numbers, count: int) -> None:
        """Shorten a row to its first `count` numbers."""
        del row[count:]

    def grow(row: Numbers, count: int) -> None:
        """Lengthen a row to at least `count` numbers. New ones are undefined."""
        row.extend([0.0] * (count - len(row)))

    def put(
        row: Doubles, o: cython.Py_ssize_t, other: Doubles, p: cython.Py_ssize_t, count: int
    ) -> None:
        """Copy `count` numbers of another row from `p` on into a row from `o` on."""
        row[o : o + count] = other[p : p + count]

    def room(count: int) -> Numbers:
        """Return a row of `count` undefined numbers."""
        return [0.0] * count
else:
    from cython.cimports.cpython.array import clone

    _NONE: Numbers = array("d")

    def room(count: cython.Py_ssize_t) -> Numbers:
        return clone(_NONE, count, False)


def row_at(
    row: Doubles, rows: cython.Py_ssize_t, width: cython.Py_ssize_t, t: float
) -> cython.Py_ssize_t:
    """Return the last row that begins by `t`, by bisection, or -1."""
    low: cython.Py_ssize_t = 0
    high: cython.Py_ssize_t = rows
    while low < high:
        middle: cython.Py_ssize_t = (low + high) // 2
        if t < row[middle * width]:
            high = middle
        else:
            low = middle + 1
    return low - 1


def whole(value: cython.int, count: cython.Py_ssize_t) -> Wholes:
    """Return a row of `count` whole numbers that all equal `value`."""
    row: Wholes = array("i", [value]) * count
    return row


def part(row: Numbers, begin: cython.Py_ssize_t, count: cython.Py_ssize_t) -> Numbers:
    """Return a copy of `row[begin:begin + count]`."""
    copy: Numbers = room(count)
    put(at(copy), 0, at(row), begin, count)
    return copy


def numbers(values: Iterable[float]) -> Numbers:
    """Return `values` as a row of numbers for kernels."""
    return array("d", values) if cython.compiled else [*map(float, values)]


def numbers_of(values: NDArray[np.float64]) -> Numbers:
    """Return the numbers of an array, row by row."""
    return array("d", values.tobytes()) if cython.compiled else values.ravel().tolist()


def flat(places: list[Place]) -> Numbers:
    """Return x and y of `places` in turn."""
    row: Numbers = room(2 * len(places))
    a: Doubles = at(row)
    k: cython.Py_ssize_t
    for k in range(len(places)):
        a[2 * k], a[2 * k + 1] = places[k]
    return row
