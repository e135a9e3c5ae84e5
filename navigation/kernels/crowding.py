"""Closest pair of moving discs over many times, and when a pair may come closer in between.

The times are processed a window at a time. Pairs are pruned by the bounds of their centres (sweep
and prune, J. D. Cohen et al., "I-COLLIDE", 1995) and by conservative advancement: two discs that
are far apart stay apart for as many times as their speeds allow (B. Mirtich, "Impulse-based dynamic
simulation of rigid body systems", 1996).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .numbers import numbers

if not cython.compiled:
    from .cubics import *
    from .discs import conflict_from

_SHARE: float = 1e-6  # of an instant, against rounding
_HAIR: float = 1e-9  # metres


class DiscWindow:
    """Centres of discs at the times of a window, which are numbered through all windows.

    `tables` are the motions of the centres, `radii` in metres. From one time to the next a disc
    moves no farther than its of `steps` (metres), except in its `jumps`: the numbers of the times
    after which it is put elsewhere, in order.
    """

    def __init__(
        self,
        tables: list[Numbers],
        radii: list[float],
        steps: list[float],
        jumps: list[list[float]],
    ) -> None:
        none: Numbers = room(0)
        self.tables = tables
        self.radii = numbers(radii)
        self.steps = numbers(steps)
        self.jumps = [numbers(each) for each in jumps]
        self.rows = [0] * len(tables)
        self.first = 0
        self.times = none
        self.xs = none
        self.ys = none
        self.boxes: Numbers = room(4 * len(tables))

    def see(self, first: cython.Py_ssize_t, times: list[float]) -> None:
        """Come to a window: its `times` (seconds), and the number of the first.

        Windows follow each other, or begin again at 0.
        """
        if first == 0:
            self.rows = [0] * len(self.tables)
        width: cython.Py_ssize_t = len(times)
        self.first = first
        self.times = numbers(times)
        self.xs = room(width * len(self.tables))
        self.ys = room(width * len(self.tables))
        t: Doubles = at(self.times)
        x: Doubles = at(self.xs)
        y: Doubles = at(self.ys)
        i: cython.Py_ssize_t
        k: cython.Py_ssize_t
        for i in range(len(self.tables)):
            table: Numbers = self.tables[i]
            row: cython.Py_ssize_t = self.rows[i]
            box: BoundingBox = BoundingBox(INFINITY, INFINITY, -INFINITY, -INFINITY)
            for k in range(width):
                row = planar_from(table, row, t[k])
                piece: PlanarPiece = planar(table)[row]
                u: float = max(t[k] - piece.begin, 0.0)
                n: cython.Py_ssize_t = i * width + k
                x[n] = value(piece.x, u)
                y[n] = value(piece.y, u)
                box = united(box, BoundingBox(x[n], y[n], x[n], y[n]))
            boxes_of(self.boxes)[i] = box
            self.rows[i] = row

    def centre(self, i: cython.Py_ssize_t, k: cython.Py_ssize_t) -> tuple[float, float]:
        """Return the centre of the i-th disc at the k-th time."""
        n: cython.Py_ssize_t = i * len(self.times) + k - self.first
        return self.xs[n], self.ys[n]

    def nearest(self, best: float) -> tuple[int, int, int, float]:
        """Return which two are nearest at any of the times, at which, and their distance.

        That is `best` where no two are nearer. The earliest of several.
        """
        end: cython.Py_ssize_t = self.first + len(self.times)
        when: cython.Py_ssize_t = self.first
        one: cython.Py_ssize_t = 0
        two: cython.Py_ssize_t = 1
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        for i in range(len(self.tables)):
            for j in range(i + 1, len(self.tables)):
                if self._between(i, j) > best:
                    continue
                k: cython.Py_ssize_t = self.first
                while k < end:
                    gap: float = self._gap(i, j, k)
                    if gap < best or (gap == best and k < when):
                        best = gap
                        when = k
                        one = i
                        two = j
                    k += self._passed(i, j, k, gap - best, end)
        found: tuple[int, int, int, float] = (one, two, when, best)
        return found

    def nearer_between(self, best: float) -> list[tuple[int, int, int]]:
        """Return which two come nearer than `best` metres, and after which time."""
        last: cython.Py_ssize_t = self.first + len(self.times) - 1
        found: list[tuple[int, int, int]] = []
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        for i in range(len(self.tables)):
            for j in range(i + 1, len(self.tables)):
                step: float = at(self.steps)[i] + at(self.steps)[j]
                # Between two times each is within a step of where it is at one of them.
                if self._between(i, j) - 2 * step > best:
                    continue
                k: cython.Py_ssize_t = self.first
                while k < last:
                    gap: float = self._gap(i, j, k)
                    passed: cython.Py_ssize_t = self._passed(i, j, k, gap - best, last)
                    # Between two times at distances p and q a pair that comes closer by v at most
                    # is never nearer than (p + q - v) / 2. No speed bounds a jump.
                    if passed == 1 and (
                        (gap + self._gap(i, j, k + 1) - step) / 2 < best
                        or self._next_jump(i, k, last) == k
                        or self._next_jump(j, k, last) == k
                    ):
                        begin: float = at(self.times)[k - self.first]
                        end: float = at(self.times)[k - self.first + 1]
                        least: float = at(self.radii)[i] + at(self.radii)[j] + best - _HAIR
                        one: Numbers = self.tables[i]
                        two: Numbers = self.tables[j]
                        row: cython.Py_ssize_t = max(planar_at(one, begin), 0)
                        other: cython.Py_ssize_t = max(planar_at(two, begin), 0)
                        if conflict_from(one, two, least, begin, end, row, other) <= end:
                            found.append((i, j, k))
                    k += passed
        return found

    def _between(self, i: cython.Py_ssize_t, j: cython.Py_ssize_t) -> float:
        """Return the distance between two discs by the bounds of their centres, metres."""
        a: BoundingBox = boxes_of(self.boxes)[i]
        b: BoundingBox = boxes_of(self.boxes)[j]
        dx: float = max(a.low_x - b.high_x, max(b.low_x - a.high_x, 0.0))
        dy: float = max(a.low_y - b.high_y, max(b.low_y - a.high_y, 0.0))
        least: float = at(self.radii)[i] + at(self.radii)[j]
        return norm(dx, dy) - least

    def _gap(self, i: cython.Py_ssize_t, j: cython.Py_ssize_t, k: cython.Py_ssize_t) -> float:
        """Return the distance between two discs at the k-th time, metres."""
        o: cython.Py_ssize_t = i * len(self.times) + k - self.first
        p: cython.Py_ssize_t = j * len(self.times) + k - self.first
        apart: float = norm(at(self.xs)[o] - at(self.xs)[p], at(self.ys)[o] - at(self.ys)[p])
        least: float = at(self.radii)[i] + at(self.radii)[j]
        return apart - least

    def _passed(
        self,
        i: cython.Py_ssize_t,
        j: cython.Py_ssize_t,
        k: cython.Py_ssize_t,
        spare: float,
        end: cython.Py_ssize_t,
    ) -> cython.Py_ssize_t:
        """Return after how many times two may have come nearer by `spare` metres, one at least."""
        step: float = at(self.steps)[i] + at(self.steps)[j]
        if spare < 2 * step:
            return 1
        passed: cython.Py_ssize_t = end
        if spare < step * end:
            passed = int(spare / step - _SHARE)
        # Up to the next jump of either, and over that one alone.
        jump: cython.Py_ssize_t = min(self._next_jump(i, k, end), self._next_jump(j, k, end))
        return max(min(passed, jump - k), 1)

    def _next_jump(
        self, i: cython.Py_ssize_t, k: cython.Py_ssize_t, end: cython.Py_ssize_t
    ) -> cython.Py_ssize_t:
        """Return the first jump of a disc from the k-th time on; `end` if there is none."""
        jumps: Numbers = self.jumps[i]
        jump: Doubles = at(jumps)
        n: cython.Py_ssize_t
        for n in range(len(jumps)):
            if jump[n] >= k:
                return int(jump[n])
        return end
