"""Rows of watches: each has the motions of a person and a machine, and the next change to expect.

A new motion of a person updates all rows of this person in one call. Only rows whose next change
has another time are reported.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .encounter import Encounter, Gauge, Tabled

if not cython.compiled:
    from .contacts import extent_from
    from .cubics import *
    from .pieces import instant
    from .watch import KernelCondition, next_change

_AFTERWARDS: float = 1.0  # seconds of the endless standstill after two motions that are searched


class WatchRow:
    """Next change of a watch on a person beside a machine, until `end` (s).

    It is the first time from `since` (s) on at which `condition` holds, to `resolution` seconds.
    Distances are between the surfaces of `gauges`, if there are any. If the two are within `beyond`
    metres, the row is `open`: the caller has to find the time. Without a condition, the bounds of
    the motions count. While the condition `holds`, the end of that is the next change. A row that
    is `idle` has no next change, and one that `asks` is always open. With `driven`, the condition
    never holds while the machine is stationary.
    """

    def __init__(
        self,
        end: float,
        resolution: float,
        gauges: Sequence[Gauge] = (),
        condition: KernelCondition | None = None,
        beyond: float = -INFINITY,
        driven: bool = False,
    ) -> None:
        self.end = end
        self.resolution = resolution
        self.gauges = [*gauges]
        self.condition = condition
        self.beyond = beyond
        self.driven = driven
        self.since = 0.0
        self.idle = False
        self.asks = False
        self.holds = False
        self.due = INFINITY
        self.open = False
        self.person: Any = None
        self.machine: Any = None
        self.person_ends = 0.0
        self.machine_ends = 0.0

    @property
    def time(self) -> float | None:
        """Time of the next change (s), or None."""
        return None if self.due == INFINITY else self.due

    def search(self, person: Tabled, machine: Tabled, now: float) -> None:
        """Update the row by the present motions of both."""
        self.person = person
        self.person_ends = end_of(person.table)
        self.machine = machine
        self.machine_ends = end_of(machine.table)
        self.update(now)

    def update(self, now: float) -> cython.int:
        """Set the time `due` of the next change from `now` on, or infinity, and whether `open`."""
        self.open = self.asks
        self.due = INFINITY
        if self.idle or self.asks:
            return 0
        if self.driven and self.machine_ends <= now:
            if self.holds:
                self.due = now
            return 0
        if self.beyond >= 0.0 and self._is_near(now):
            self.open = True
        elif self.condition is not None:
            last: float = horizon(now, self.person_ends, self.machine_ends, self.end)
            begin: float = now if self.holds else max(now, self.since)
            end: float = max(begin, last)
            encounter: Encounter = Encounter(self.person, self.machine, self.gauges)
            encounter.come_to(begin)
            self.due = next_change(self.condition, encounter, end, self.resolution, False)
            if self.holds:
                # The present interval begins now, within the resolution. A later one is another.
                if self.due > now + 10 * self.resolution:
                    self.due = now
                else:
                    # An interval that lasts to the end lasts until a motion changes.
                    self.due = next_change(self.condition, encounter, end, self.resolution, True)
                    if self.due >= last:
                        self.due = INFINITY
        return 0

    def _is_near(self, now: float) -> bool:
        """Return whether the two, or the bounds of their motions, are within `beyond` metres."""
        one: Numbers = self.person.table
        other: Numbers = self.machine.table
        if self.condition is not None:
            here: PosePiece = instant(one, now)
            there: PosePiece = instant(other, now)
            return norm(here.x.p - there.x.p, here.y.p - there.y.p) <= self.beyond
        a: BoundingBox = extent_from(one, now)
        b: BoundingBox = extent_from(other, now)
        return not (
            a.low_x - b.high_x > self.beyond
            or b.low_x - a.high_x > self.beyond
            or a.low_y - b.high_y > self.beyond
            or b.low_y - a.high_y > self.beyond
        )


def horizon(now: float, one_ends: float, other_ends: float, end: float) -> float:
    """Return a time (s) after which nothing changes, at most `end`.

    It is later than the ends of both motions, because a motion may end at speed.
    """
    return min(max(now, max(one_ends, other_ends)) + _AFTERWARDS, end)


def changed_rows(rows: list[WatchRow], person: Tabled, now: float) -> list[int]:
    """Update all rows of a person after a new motion. Return the indices of those that changed."""
    changed: list[int] = []
    ends: float = end_of(person.table)
    k: cython.Py_ssize_t
    for k in range(len(rows)):
        row: WatchRow = rows[k]
        row.person = person
        row.person_ends = ends
        if row.idle or (row.driven and row.machine_ends < now and not (row.asks or row.holds)):
            continue
        was_open: cython.bint = row.open
        due: float = row.due
        row.update(now)
        if row.open or was_open or row.due != due:
            changed.append(k)
    return changed
