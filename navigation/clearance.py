"""Conflicts of discs on the floor: the first instant at which two of them come too close.

Both follow motions that end in a standing which counts for ever. Where they go is kept in tables
of plain numbers, in which the kernel of `discs` looks.
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence
from typing import NamedTuple

from .kernels.discs import ROW, gone, meeting, swept
from .kernels.numbers import room
from .kernels.pacing import turned
from .motion import Motion, motion_of


class Swath(NamedTuple):
    """The floor that a disc's centre takes from an instant on: its table, and the bounds of it.

    The `table` is one of `discs`; `rests` is when the final standing begins (seconds); `box` bounds
    the whole: least x and y, greatest x and y (metres).
    """

    table: MutableSequence[float]
    rests: float
    box: MutableSequence[float]

    @staticmethod
    def of(table: MutableSequence[float], box: MutableSequence[float]) -> Swath:
        """Return the swath of a table within bounds."""
        return tuple.__new__(Swath, (table, table[-ROW], box))  # as `Swath(...)`, but quicker

    @property
    def walk(self) -> MutableSequence[float]:
        """Its table without the final standing."""
        return self.table[:-ROW]

    @property
    def place(self) -> tuple[float, float]:
        """Where it comes to stand."""
        return (self.table[2 - ROW], self.table[6 - ROW])

    def gone(self, since: float, t: float) -> float:
        """Return the metres that a walk along straight legs goes from `since` to `t` (seconds)."""
        return gone(self.table, since, t)


def swath(motion: Motion, begin: float) -> Swath:
    """Return the swath of `motion` from `begin` (seconds) on."""
    since = max(begin, motion.end)
    box = room(4)
    return Swath.of(swept(motion.table, begin, since, *motion.state(since).at, box), box)


def walked(swath: Swath, heading: float) -> Motion:
    """Return the motion along a `swath`: turned to where it goes, at first by `heading` (rad)."""
    return motion_of(turned(swath.table, heading))


def first_conflict(one: Swath, other: Swath, least: float, begin: float) -> float | None:
    """Return the first instant from `begin` on at which two centres are closer than `least`.

    Seconds and metres; None if there is none. The swaths of `one` and of the `other` reach back to
    `begin`. Never misses one; finds one too many only where the two stay within rounding of
    `least`.
    """
    low_x, low_y, high_x, high_y = other.box
    a = one.box
    if (
        a[0] - high_x >= least
        or low_x - a[2] >= least
        or a[1] - high_y >= least
        or low_y - a[3] >= least
    ):
        return None
    t = meeting(one.table, other.table, least, begin, math.inf)
    return None if t == math.inf else t
