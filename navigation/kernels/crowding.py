"""Discs among many, seen at instants side by side: the least distance, and when it may be less.

`xs` and `ys` are the centres at the instants, those of one disc after those of another (metres),
`radii` theirs (metres). A disc goes no farther than its of `steps` (metres) from one instant to the
next but in its `jumps`: the numbers of the instants after which it is put elsewhere, in order. So
two that are far apart stay so for many instants, which are passed over.
"""

from __future__ import annotations

from array import array
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .discs import ROW

if not cython.compiled:
    from math import inf, sqrt

    from .discs import _meeting
    from .numbers import Doubles, Numbers, at

    INFINITY = inf
else:
    from cython.cimports.libc.math import INFINITY, sqrt
    from cython.cimports.navigation.kernels.discs import _meeting
    from cython.cimports.navigation.kernels.numbers import Doubles, Numbers, at

_R: cython.Py_ssize_t = ROW
_SHARE: float = 1e-6  # of an instant, against rounding
_HAIR: float = 1e-9  # metres


def see(
    tables: list[Numbers], times: list[float], xs: array[float], ys: array[float]
) -> cython.int:
    """Set `xs` and `ys` to where the discs of these `tables` (see `discs`) are at `times`."""
    n: cython.Py_ssize_t = 0
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    for i in range(len(tables)):
        a: Doubles = at(tables[i])
        o: cython.Py_ssize_t = 0
        for k in range(len(times)):
            t: float = times[k]
            while a[o + 1] <= t:
                o += _R
            u: float = max(t - a[o], 0.0)
            xs[n] = a[o + 2] + u * (a[o + 3] + u * (a[o + 4] + u * a[o + 5]))
            ys[n] = a[o + 6] + u * (a[o + 7] + u * (a[o + 8] + u * a[o + 9]))
            n += 1
    return 0


def nearest_seen(
    xs: array[float],
    ys: array[float],
    radii: list[float],
    steps: list[float],
    jumps: list[list[float]],
) -> tuple[int, int, int]:
    """Return which two are nearest of all at any of the instants, and at which: their numbers.

    The earliest of several. For `xs`, `ys`, `radii`, `steps` and `jumps` see above.
    """
    count: cython.Py_ssize_t = len(xs) // len(radii)
    best: float = INFINITY
    at: cython.Py_ssize_t = 0
    one: cython.Py_ssize_t = 0
    two: cython.Py_ssize_t = 1
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    for i in range(len(radii)):
        for j in range(i + 1, len(radii)):
            least: float = radii[i] + radii[j]
            step: float = steps[i] + steps[j]
            k: cython.Py_ssize_t = 0
            while k < count:
                apart: float = _distance(xs, ys, i * count + k, j * count + k) - least
                if apart < best or (apart == best and k < at):
                    best = apart
                    at = k
                    one = i
                    two = j
                k += _passed(k, apart - best, step, jumps[i], jumps[j], count)
    found: tuple[int, int, int] = (one, two, at)
    return found


def nearer_between(
    xs: array[float],
    ys: array[float],
    radii: list[float],
    steps: list[float],
    jumps: list[list[float]],
    times: list[float],
    tables: list[Numbers],
    best: float,
) -> list[int]:
    """Return which two come nearer than `best` metres, and after which instant: three numbers.

    One such after another, by the first of the two, then the second, then the instant. `times` are
    those of the instants (seconds), `tables` the motions as in `discs`. For `xs`, `ys`, `radii`,
    `steps` and `jumps` see above.
    """
    count: cython.Py_ssize_t = len(times)
    last: cython.Py_ssize_t = count - 1
    found: list[int] = []
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    for i in range(len(radii)):
        for j in range(i + 1, len(radii)):
            least: float = radii[i] + radii[j]
            step: float = steps[i] + steps[j]
            row: cython.Py_ssize_t = 0
            other_row: cython.Py_ssize_t = 0
            k: cython.Py_ssize_t = 0
            while k < last:
                apart: float = _distance(xs, ys, i * count + k, j * count + k) - least
                passed: cython.Py_ssize_t = _passed(k, apart - best, step, jumps[i], jumps[j], last)
                if passed == 1:
                    then: float = _distance(xs, ys, i * count + k + 1, j * count + k + 1) - least
                    # Between two instants at distances p and q a pair that comes closer by v at
                    # most is never nearer than (p + q - v) / 2. No speed bounds a jump.
                    if (
                        (apart + then - step) / 2 < best
                        or _next(jumps[i], k, last) == k
                        or _next(jumps[j], k, last) == k
                    ):
                        begin: float = times[k]
                        end: float = times[k + 1]
                        row = _row_at(tables[i], row, begin)
                        other_row = _row_at(tables[j], other_row, begin)
                        if (
                            _meeting(
                                tables[i],
                                tables[j],
                                least + best - _HAIR,
                                begin,
                                end,
                                row,
                                other_row,
                            )
                            <= end
                        ):
                            found.append(i)
                            found.append(j)
                            found.append(k)
                k += passed
    return found


def _distance(
    xs: array[float], ys: array[float], i: cython.Py_ssize_t, j: cython.Py_ssize_t
) -> float:
    """Return the distance of two centres, metres."""
    dx: float = xs[i] - xs[j]
    dy: float = ys[i] - ys[j]
    return sqrt(dx * dx + dy * dy)


def _passed(
    k: cython.Py_ssize_t,
    spare: float,
    step: float,
    jumps: list[float],
    other_jumps: list[float],
    count: cython.Py_ssize_t,
) -> cython.Py_ssize_t:
    """Return after how many instants two may have come nearer by `spare` metres, one at least."""
    if spare < 2 * step:
        return 1
    passed: cython.Py_ssize_t = count
    if spare < step * count:
        passed = int(spare / step - _SHARE)
    # Up to the next jump of either, and over that one alone.
    return max(min(passed, min(_next(jumps, k, count), _next(other_jumps, k, count)) - k), 1)


def _next(jumps: list[float], k: cython.Py_ssize_t, count: cython.Py_ssize_t) -> cython.Py_ssize_t:
    """Return the first of the jumps from instant `k` on; `count` if there is none."""
    i: cython.Py_ssize_t
    for i in range(len(jumps)):
        if jumps[i] >= k:
            return int(jumps[i])
    return count


def _row_at(table: Numbers, row: cython.Py_ssize_t, t: float) -> cython.Py_ssize_t:
    """Return the row of a table from `row` on that is in force at `t` (seconds)."""
    while at(table)[row * _R + 1] <= t:
        row += 1
    return row
