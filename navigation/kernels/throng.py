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

    INFINITY = inf
else:
    from cython.cimports.libc.math import INFINITY, sqrt
    from cython.cimports.navigation.kernels.discs import within_bounds

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
        self.tables: list[list[float]] = []
        self.boxes: list[float] = []
        self.radii: list[float] = []
        self.bound = bytearray()
        self.onward: list[float] = []
        self.widest = 0.0
        """The greatest radius, metres."""
        self.x = self.y = self.c = self.s = 0.0

    def add(self, table: list[float], box: list[float], radius: float) -> None:
        """Add a disc that is bound for nowhere."""
        self.tables.append(table)
        self.boxes.extend(box)
        self.radii.append(radius)
        self.widest = max(self.widest, radius)
        self.bound.append(0)
        self.onward.append(INFINITY)
        self.onward.append(INFINITY)

    def commit(self, k: cython.Py_ssize_t, table: list[float], box: list[float]) -> None:
        """Let the k-th be committed to another motion."""
        i: cython.Py_ssize_t
        self.tables[k] = table
        for i in range(4):
            self.boxes[4 * k + i] = box[i]

    def send(self, k: cython.Py_ssize_t, bound: bool, x: float, y: float) -> None:
        """Let the k-th be bound for somewhere or not, by x, y first."""
        self.bound[k] = bound
        self.onward[2 * k] = x
        self.onward[2 * k + 1] = y

    def near(self, box: list[float], around: float) -> list[cython.Py_ssize_t]:
        """Return who may come so near to bounds with their bodies (metres): their indices.

        As wide as the widest there is: bounds are those of centres.
        """
        margin: float = around + self.widest + 2 * self.gap
        low_x: float = box[0] - margin
        low_y: float = box[1] - margin
        found: list[cython.Py_ssize_t] = within_bounds(
            self.boxes, low_x, low_y, box[2] + margin, box[3] + margin
        )
        return found

    def between(self, i: cython.Py_ssize_t, k: cython.Py_ssize_t, t: float) -> float:
        """Return the cosine between where the i-th and the k-th walk at `t`, or would walk on.

        0 if either rests.
        """
        return self.cosine(k, t, self.c, self.s) if self.heads(i, t) else 0.0

    def standing(self, me: int, box: list[float], around: float, now: float) -> list[float]:
        """Return who stands for good `now` (seconds), so near to bounds, but the `me`-th.

        Of each x, y, and how far the `me`-th has to stay from there (metres).
        """
        found: list[float] = []
        i: cython.Py_ssize_t
        there: list[cython.Py_ssize_t] = self._resting(me, box, around, now)
        for i in range(len(there)):
            table: list[float] = self.tables[there[i]]
            found.append(table[len(table) - _R + 2])
            found.append(table[len(table) - _R + 6])
            found.append(self.radii[me] + self.radii[there[i]] + self.gap)
        return found

    def _resting(
        self, me: cython.Py_ssize_t, box: list[float], around: float, now: float
    ) -> list[cython.Py_ssize_t]:
        found: list[cython.Py_ssize_t] = []
        i: cython.Py_ssize_t
        near: list[cython.Py_ssize_t] = self.near(box, around)
        for i in range(len(near)):
            k: cython.Py_ssize_t = near[i]
            if k != me and self.rests(k) <= now:
                found.append(k)
        return found

    def encloses(self, me: int, other: int, x: float, y: float, around: float, now: float) -> bool:
        """Return whether the `other` is one of those who stand around x, y (metres) `now`.

        From there a ring grows from neighbour to neighbour through gaps that are too narrow for the
        `me`-th, as far as `around`.
        """
        left: list[cython.Py_ssize_t] = self._resting(me, [x, y, x, y], around, now)
        width: float = 2 * (self.radii[me] + self.gap)
        ring: list[float] = [x, y, -self.radii[me]]  # of each who is to be left: x, y, radius
        i: cython.Py_ssize_t
        while len(ring) > 0:
            radius: float = ring.pop()
            at_y: float = ring.pop()
            at_x: float = ring.pop()
            for i in range(len(left) - 1, -1, -1):
                k: cython.Py_ssize_t = left[i]
                table: list[float] = self.tables[k]
                dx: float = table[len(table) - _R + 2] - at_x
                dy: float = table[len(table) - _R + 6] - at_y
                if sqrt(dx * dx + dy * dy) < radius + self.radii[k] + width:
                    if k == other:
                        return True
                    ring.append(at_x + dx)
                    ring.append(at_y + dy)
                    ring.append(self.radii[k])
                    left[i] = left[len(left) - 1]
                    left.pop()
        return False

    def heads(self, k: cython.Py_ssize_t, t: float) -> bool:
        """Set c, s to the unit vector of where the k-th walks at `t` (seconds), or would walk on.

        Return whether they do not rest.
        """
        table: list[float] = self.tables[k]
        o: cython.Py_ssize_t = 0
        # The last row never ends.
        while table[o + 1] <= t:
            o += _R
        if table[o] <= t:
            u: float = t - table[o]
            vx: float = table[o + 3] + u * (2 * table[o + 4] + u * 3 * table[o + 5])
            vy: float = table[o + 7] + u * (2 * table[o + 8] + u * 3 * table[o + 9])
            speed: float = sqrt(vx * vx + vy * vy)
            if speed > _SLOW:
                self.c = vx / speed
                self.s = vy / speed
                return True
        if not self.bound[k] or self.onward[2 * k] == INFINITY:
            return False
        self.find(k, t)
        dx: float = self.onward[2 * k] - self.x
        dy: float = self.onward[2 * k + 1] - self.y
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
        table: list[float] = self.tables[k]
        o: cython.Py_ssize_t = 0
        while table[o + 1] <= t:
            o += _R
        u: float = max(t - table[o], 0.0)
        # Who has come to rest is where their walk ended, to the last bit.
        if table[o + 1] == INFINITY and o > 0:
            o -= _R
            u = table[o + 1] - table[o]
        self.x = table[o + 2] + u * (table[o + 3] + u * (table[o + 4] + u * table[o + 5]))
        self.y = table[o + 6] + u * (table[o + 7] + u * (table[o + 8] + u * table[o + 9]))
        return 0

    def rests(self, k: cython.Py_ssize_t) -> float:
        """Return from when on the k-th stands for good, seconds."""
        table: list[float] = self.tables[k]
        begin: float = table[len(table) - _R]
        return begin
