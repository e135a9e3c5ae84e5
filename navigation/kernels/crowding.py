"""Discs among many, seen at instants side by side: the least distance, and when it may be less.

They are looked at a window of instants at a time. `xs` and `ys` are the centres at the instants of
one, from the number `first` on, those of one disc after those of another (metres), `boxes` the
bounds of these (least x and y, greatest x and y), `radii` theirs (metres). A disc goes no farther
than its of `steps` (metres) from one instant to the next but in its `jumps`: the numbers of the
instants after which it is put elsewhere, in order. So two that are far apart stay so for many
instants, which are passed over.
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

    from .discs import conflict_from
    from .numbers import Doubles, Numbers, at

    INFINITY = inf
else:
    from cython.cimports.libc.math import INFINITY, sqrt
    from cython.cimports.navigation.kernels.discs import conflict_from
    from cython.cimports.navigation.kernels.numbers import Doubles, Numbers, at

_R: cython.Py_ssize_t = ROW
_SHARE: float = 1e-6  # of an instant, against rounding
_HAIR: float = 1e-9  # metres


def see(
    tables: list[Numbers],
    times: list[float],
    rows: array[int],
    xs: array[float],
    ys: array[float],
    boxes: array[float],
) -> cython.int:
    """Set `xs`, `ys` and `boxes` to where the discs of these `tables` (see `discs`) are at `times`.

    `rows` are those of the tables from which on to look, and become those of the last time.
    """
    n: cython.Py_ssize_t = 0
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    for i in range(len(tables)):
        a: Doubles = at(tables[i])
        o: cython.Py_ssize_t = rows[i] * _R
        low_x: float = INFINITY
        low_y: float = INFINITY
        high_x: float = -INFINITY
        high_y: float = -INFINITY
        for k in range(len(times)):
            t: float = times[k]
            while a[o + 1] <= t:
                o += _R
            u: float = max(t - a[o], 0.0)
            x: float = a[o + 2] + u * (a[o + 3] + u * (a[o + 4] + u * a[o + 5]))
            y: float = a[o + 6] + u * (a[o + 7] + u * (a[o + 8] + u * a[o + 9]))
            low_x = min(low_x, x)
            low_y = min(low_y, y)
            high_x = max(high_x, x)
            high_y = max(high_y, y)
            xs[n] = x
            ys[n] = y
            n += 1
        rows[i] = o // _R
        boxes[4 * i] = low_x
        boxes[4 * i + 1] = low_y
        boxes[4 * i + 2] = high_x
        boxes[4 * i + 3] = high_y
    return 0


def nearest_seen(
    xs: array[float],
    ys: array[float],
    boxes: array[float],
    first: cython.Py_ssize_t,
    radii: list[float],
    steps: list[float],
    jumps: list[list[float]],
    best: float,
) -> tuple[int, int, int, float]:
    """Return which two are nearest of all at any of the instants, at which, and how near.

    Their numbers, that of the instant, and metres: no less than `best` where no two are nearer. The
    earliest of several. For `xs`, `ys`, `boxes`, `first`, `radii`, `steps` and `jumps` see above.
    """
    width: cython.Py_ssize_t = len(xs) // len(radii)
    end: cython.Py_ssize_t = first + width
    at: cython.Py_ssize_t = first
    one: cython.Py_ssize_t = 0
    two: cython.Py_ssize_t = 1
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    for i in range(len(radii)):
        radius: float = radii[i]
        for j in range(i + 1, len(radii)):
            least: float = radius + radii[j]
            if _between(boxes, i, j) - least > best:
                continue
            step: float = steps[i] + steps[j]
            k: cython.Py_ssize_t = first
            while k < end:
                apart: float = _distance(xs, ys, i * width + k - first, j * width + k - first)
                apart -= least
                if apart < best or (apart == best and k < at):
                    best = apart
                    at = k
                    one = i
                    two = j
                k += _passed(k, apart - best, step, jumps[i], jumps[j], end)
    found: tuple[int, int, int, float] = (one, two, at, best)
    return found


def nearer_between(
    xs: array[float],
    ys: array[float],
    boxes: array[float],
    first: cython.Py_ssize_t,
    radii: list[float],
    steps: list[float],
    jumps: list[list[float]],
    times: list[float],
    tables: list[Numbers],
    best: float,
) -> list[int]:
    """Return which two come nearer than `best` metres, and after which instant: three numbers.

    One such after another. `times` are those of the instants (seconds), `tables` the motions as in
    `discs`. For `xs`, `ys`, `boxes`, `first`, `radii`, `steps` and `jumps` see above.
    """
    width: cython.Py_ssize_t = len(times)
    last: cython.Py_ssize_t = first + width - 1
    found: list[int] = []
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    for i in range(len(radii)):
        radius: float = radii[i]
        for j in range(i + 1, len(radii)):
            least: float = radius + radii[j]
            step: float = steps[i] + steps[j]
            # Between two instants each is within a step of where it is at one of them.
            if _between(boxes, i, j) - least - 2 * step > best:
                continue
            row: cython.Py_ssize_t = 0
            other_row: cython.Py_ssize_t = 0
            k: cython.Py_ssize_t = first
            while k < last:
                one: cython.Py_ssize_t = i * width + k - first
                other: cython.Py_ssize_t = j * width + k - first
                apart: float = _distance(xs, ys, one, other) - least
                passed: cython.Py_ssize_t = _passed(k, apart - best, step, jumps[i], jumps[j], last)
                if passed == 1:
                    then: float = _distance(xs, ys, one + 1, other + 1) - least
                    # Between two instants at distances p and q a pair that comes closer by v at
                    # most is never nearer than (p + q - v) / 2. No speed bounds a jump.
                    if (
                        (apart + then - step) / 2 < best
                        or _next(jumps[i], k, last) == k
                        or _next(jumps[j], k, last) == k
                    ):
                        begin: float = times[k - first]
                        end: float = times[k - first + 1]
                        row = _row_at(tables[i], row, begin)
                        other_row = _row_at(tables[j], other_row, begin)
                        if (
                            conflict_from(
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


def _between(boxes: array[float], i: cython.Py_ssize_t, j: cython.Py_ssize_t) -> float:
    """Return the distance between two of the boxes, metres; 0 where they overlap."""
    dx: float = max(boxes[4 * i] - boxes[4 * j + 2], boxes[4 * j] - boxes[4 * i + 2], 0.0)
    dy: float = max(boxes[4 * i + 1] - boxes[4 * j + 3], boxes[4 * j + 1] - boxes[4 * i + 3], 0.0)
    return sqrt(dx * dx + dy * dy)


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
