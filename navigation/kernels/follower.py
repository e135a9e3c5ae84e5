"""A body on its motion, one piece after another."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .odometer import WIDTH

if not cython.compiled:
    from math import sqrt

    from .numbers import Doubles, Numbers, are_finite, at
    from .odometer import TaylorModel, row_at, speed_along
else:
    from cython.cimports.libc.math import sqrt
    from cython.cimports.navigation.kernels.numbers import Doubles, Numbers, are_finite, at
    from cython.cimports.navigation.kernels.odometer import TaylorModel, row_at, speed_along

_INFINITE: float = float("inf")

_WIDTH: cython.Py_ssize_t = WIDTH


class Follower:
    """A body on its motion: standing before it, one piece after another, standing after it."""

    def __init__(self, table: Numbers) -> None:
        self.table = table
        self.rows = len(table) // _WIDTH

    def seek(self, t: float) -> cython.int:
        """Come to the piece at `t`."""
        row: Doubles = at(self.table)
        first: float = row[0]
        self.since = t
        if t < first:
            self.row = -1
            self.begin = t
            self.end = first
            return 0
        self.row = row_at(row, self.rows, _WIDTH, t) - 1
        return self.go_on()

    def go_on(self) -> cython.int:
        """Come to the next piece. Those of no length are left out: no velocity for no time."""
        row: Doubles = at(self.table)
        while True:
            self.row += 1
            if self.row >= self.rows:
                self.begin = row[(self.rows - 1) * _WIDTH + 1]
                self.end = _INFINITE
                return 0
            o: cython.Py_ssize_t = self.row * _WIDTH
            self.begin = row[o]
            self.end = row[o + 1]
            if self.end > max(self.since, self.begin):
                if not are_finite(row, o, _WIDTH):
                    raise ValueError(
                        f"a motion is not finite from t = {self.begin} s to {self.end} s"
                    )
                return 0

    def enter(self, t: float) -> cython.int:
        """Count from `t`, within the piece."""
        row: Doubles = at(self.table)
        o: cython.Py_ssize_t = min(max(self.row, 0), self.rows - 1) * _WIDTH
        u: float = 0.0
        if self.row >= self.rows:
            u = row[o + 1] - row[o]
        elif self.row >= 0:
            u = t - self.begin
        x0: float = row[o + 2]
        x1: float = row[o + 3]
        x2: float = row[o + 4]
        x3: float = row[o + 5]
        y0: float = row[o + 6]
        y1: float = row[o + 7]
        y2: float = row[o + 8]
        y3: float = row[o + 9]
        r0: float = row[o + 10]
        r1: float = row[o + 11]
        r2: float = row[o + 12]
        r3: float = row[o + 13]
        # Each polynomial about the later instant: its Taylor coefficients there, by Horner's rule.
        if u != 0.0:
            x0 += u * (x1 + u * (x2 + u * x3))
            x1 += u * (2 * x2 + u * 3 * x3)
            x2 += u * 3 * x3
            y0 += u * (y1 + u * (y2 + u * y3))
            y1 += u * (2 * y2 + u * 3 * y3)
            y2 += u * 3 * y3
            r0 += u * (r1 + u * (r2 + u * r3))
            r1 += u * (2 * r2 + u * 3 * r3)
            r2 += u * 3 * r3
        if self.row < 0 or self.row >= self.rows:
            x1 = x2 = x3 = 0.0
            y1 = y2 = y3 = 0.0
            r1 = r2 = r3 = 0.0
        self.x0 = x0
        self.x1 = x1
        self.x2 = x2
        self.x3 = x3
        self.y0 = y0
        self.y1 = y1
        self.y2 = y2
        self.y3 = y3
        self.r0 = r0
        self.r1 = r1
        self.r2 = r2
        self.r3 = r3
        return 0

    def pace(self, middle: float, half: float) -> cython.int:
        """Bound the speed within `half` of `middle`, counted from the stretch's begin."""
        x2: float = self.x2
        y2: float = self.y2
        x3: float = self.x3
        y3: float = self.y3
        if x2 == y2 == x3 == y3 == 0.0:
            self.low = self.high = sqrt(self.x1 * self.x1 + self.y1 * self.y1)
            return 0
        vx: float = self.x1 + middle * (2 * x2 + middle * 3 * x3)
        vy: float = self.y1 + middle * (2 * y2 + middle * 3 * y3)
        speed: float = sqrt(vx * vx + vy * vy)
        # Half the acceleration at the middle; x₃ is a sixth of the jerk.
        ax: float = x2 + 3 * x3 * middle
        ay: float = y2 + 3 * y3 * middle
        slack: float = half * 2 * sqrt(ax * ax + ay * ay)
        slack += half * half * 3 * sqrt(x3 * x3 + y3 * y3)
        self.low = 0.0 if slack > speed else speed - slack
        self.high = speed + slack
        return 0

    def speed(self, begin: float, end: float, figure: TaylorModel) -> cython.int:
        """Give the speed from `begin` to `end`, an interval within the piece."""
        if self.row < 0 or self.row >= self.rows:
            return figure.set(0.0, 0.0, 0.0, 0.0)
        return speed_along(at(self.table), self.row, begin, end, figure)
