"""Discs on a floor side by side: what each is committed to, and where it would walk on.

For the tables see `discs`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .discs import ROW
from .following import SLOW

if not cython.compiled:
    from math import inf, sqrt

    from .discs import within_bounds
    from .numbers import Doubles, Numbers, at, numbers, put, room

    INFINITY = inf
else:
    from cython.cimports.libc.math import INFINITY, sqrt
    from cython.cimports.navigation.kernels.discs import within_bounds
    from cython.cimports.navigation.kernels.numbers import Doubles, Numbers, at, numbers, put, room

_R: cython.Py_ssize_t = ROW
_SLOW: float = SLOW
_THERE: float = 1e-6  # metres; nearer than this is there


class Throng:
    """Discs by their indices: `tables`, `boxes` (least x and y, greatest x and y), and `radii`.

    Of each that is `bound` for somewhere, `onward` has x and y of the next corner of its route;
    they are infinite where there is none (metres). Two keep `gap` metres between them in any case.
    """

    def __init__(self, gap: float) -> None:
        self.gap = gap
        self.tables: list[Numbers] = []
        self.boxes: Numbers = room(0)
        self.radii: Numbers = room(0)
        self.bound = bytearray()
        self.onward: Numbers = room(0)
        self.widest = 0.0
        """The greatest radius, metres."""
        self.x = self.y = self.c = self.s = 0.0

    def add(self, table: Numbers, box: Numbers, radius: float) -> None:
        """Add a disc that is bound for nowhere."""
        self.tables.append(table)
        self.boxes.extend(box)
        self.radii.append(radius)
        self.widest = max(self.widest, radius)
        self.bound.append(0)
        self.onward.append(INFINITY)
        self.onward.append(INFINITY)

    def commit(self, k: cython.Py_ssize_t, table: Numbers, box: Numbers) -> None:
        """Let the k-th be committed to another motion."""
        self.tables[k] = table
        put(at(self.boxes), 4 * k, at(box), 0, 4)

    def send(self, k: cython.Py_ssize_t, bound: bool, x: float, y: float) -> None:
        """Let the k-th be bound for somewhere or not, by x, y first."""
        self.bound[k] = bound
        onward: Doubles = at(self.onward)
        onward[2 * k] = x
        onward[2 * k + 1] = y

    def near(
        self, box: Numbers, around: float, but: cython.Py_ssize_t = -1
    ) -> list[cython.Py_ssize_t]:
        """Return who, `but` one, may come so near to bounds with their bodies (metres): indices.

        As wide as the widest there is: bounds are those of centres.
        """
        margin: float = around + self.widest + 2 * self.gap
        b: Doubles = at(box)
        found: list[cython.Py_ssize_t] = within_bounds(
            self.boxes, b[0] - margin, b[1] - margin, b[2] + margin, b[3] + margin, but
        )
        return found

    def between(self, i: cython.Py_ssize_t, k: cython.Py_ssize_t, t: float) -> float:
        """Return the cosine between where the i-th and the k-th walk at `t`, or would walk on.

        0 if either rests.
        """
        return self.cosine(k, t, self.c, self.s) if self.heads(i, t) else 0.0

    def standing(self, me: int, box: Numbers, around: float, now: float) -> Numbers:
        """Return who stands for good `now` (seconds), so near to bounds, but the `me`-th.

        Of each x, y, and how far the `me`-th has to stay from there (metres).
        """
        there: list[cython.Py_ssize_t] = self._resting(me, box, around, now)
        found: Numbers = room(3 * len(there))
        disc: Doubles = at(found)
        radii: Doubles = at(self.radii)
        i: cython.Py_ssize_t
        for i in range(len(there)):
            self.end(there[i])
            disc[3 * i] = self.x
            disc[3 * i + 1] = self.y
            disc[3 * i + 2] = radii[me] + radii[there[i]] + self.gap
        return found

    def _resting(
        self, me: cython.Py_ssize_t, box: Numbers, around: float, now: float
    ) -> list[cython.Py_ssize_t]:
        found: list[cython.Py_ssize_t] = []
        i: cython.Py_ssize_t
        near: list[cython.Py_ssize_t] = self.near(box, around, me)
        for i in range(len(near)):
            k: cython.Py_ssize_t = near[i]
            if self.rests(k) <= now:
                found.append(k)
        return found

    def encloses(self, me: int, other: int, x: float, y: float, around: float, now: float) -> bool:
        """Return whether the `other` is one of those who stand around x, y (metres) `now`.

        From there a ring grows from neighbour to neighbour through gaps that are too narrow for the
        `me`-th, as far as `around`.
        """
        place: Numbers = numbers((x, y, x, y))
        left: list[cython.Py_ssize_t] = self._resting(me, place, around, now)
        ring: Numbers = room(3 * len(left) + 3)  # of each who is to be left: x, y, radius
        disc: Doubles = at(ring)
        radii: Doubles = at(self.radii)
        width: float = 2 * (radii[me] + self.gap)
        disc[0] = x
        disc[1] = y
        disc[2] = -radii[me]
        last: cython.Py_ssize_t = 0
        i: cython.Py_ssize_t
        while last >= 0:
            at_x: float = disc[last]
            at_y: float = disc[last + 1]
            radius: float = disc[last + 2]
            last -= 3
            for i in range(len(left) - 1, -1, -1):
                k: cython.Py_ssize_t = left[i]
                self.end(k)
                dx: float = self.x - at_x
                dy: float = self.y - at_y
                if sqrt(dx * dx + dy * dy) < radius + radii[k] + width:
                    if k == other:
                        return True
                    last += 3
                    disc[last] = at_x + dx
                    disc[last + 1] = at_y + dy
                    disc[last + 2] = radii[k]
                    left[i] = left[len(left) - 1]
                    left.pop()
        return False

    def heads(self, k: cython.Py_ssize_t, t: float) -> bool:
        """Set c, s to the unit vector of where the k-th walks at `t` (seconds), or would walk on.

        Return whether they do not rest.
        """
        table: Numbers = self.tables[k]
        row: Doubles = at(table)
        o: cython.Py_ssize_t = 0
        # The last row never ends.
        while row[o + 1] <= t:
            o += _R
        if row[o] <= t:
            u: float = t - row[o]
            vx: float = row[o + 3] + u * (2 * row[o + 4] + u * 3 * row[o + 5])
            vy: float = row[o + 7] + u * (2 * row[o + 8] + u * 3 * row[o + 9])
            speed: float = sqrt(vx * vx + vy * vy)
            if speed > _SLOW:
                self.c = vx / speed
                self.s = vy / speed
                return True
        onward: Doubles = at(self.onward)
        if not self.bound[k] or onward[2 * k] == INFINITY:
            return False
        self.find(k, t)
        dx: float = onward[2 * k] - self.x
        dy: float = onward[2 * k + 1] - self.y
        away: float = sqrt(dx * dx + dy * dy)
        if away < _THERE:
            return False
        self.c = dx / away
        self.s = dy / away
        return True

    def cosine(self, k: cython.Py_ssize_t, t: float, c: float, s: float) -> float:
        """Return the cosine between c, s and where the k-th walks, or would; 0 for who rests."""
        return self.c * c + self.s * s if self.heads(k, t) else 0.0

    def find(self, k: cython.Py_ssize_t, t: float) -> cython.int:
        """Set x, y to the place of the k-th at `t` (seconds)."""
        table: Numbers = self.tables[k]
        row: Doubles = at(table)
        o: cython.Py_ssize_t = 0
        while row[o + 1] <= t:
            o += _R
        u: float = max(t - row[o], 0.0)
        # Who has come to rest is where their walk ended, to the last bit.
        if row[o + 1] == INFINITY and o > 0:
            o -= _R
            u = row[o + 1] - row[o]
        self.x = row[o + 2] + u * (row[o + 3] + u * (row[o + 4] + u * row[o + 5]))
        self.y = row[o + 6] + u * (row[o + 7] + u * (row[o + 8] + u * row[o + 9]))
        return 0

    def rests(self, k: cython.Py_ssize_t) -> float:
        """Return from when on the k-th stands for good, seconds."""
        table: Numbers = self.tables[k]
        begin: float = at(table)[len(table) - _R]
        return begin

    def end(self, k: cython.Py_ssize_t) -> cython.int:
        """Set x, y to where the k-th stands for good."""
        table: Numbers = self.tables[k]
        row: Doubles = at(table)
        o: cython.Py_ssize_t = len(table) - _R
        self.x = row[o + 2]
        self.y = row[o + 6]
        return 0
