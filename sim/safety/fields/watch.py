"""Watch on one person in the fields of one machine: occupied fields, and the next change."""

from __future__ import annotations

import math
from collections.abc import Callable

from navigation import FixedDistance, TooClose, intrusions

from ...core.clock import Alarm, Turn
from ...core.fields import MachineFields
from ..monitors import Pair

MOMENT = 1e-8
"""Seconds. Shorter intrusions do not count, because times are not more exact than this."""

BEYOND = 1e-3
"""Metres beyond the reach of all fields. Of people farther away, only the distance is watched."""


class FieldWatch:
    """Calls `changed` when a person enters or leaves fields of a machine.

    `occupied` has the field set with which each field became occupied. Muted fields are not
    occupied.
    """

    # Most people are far from most machines. Beyond the reach of all fields, only the row is
    # watched, because distances are faster than the polygons.

    def __init__(
        self,
        pair: Pair,
        fields: MachineFields,
        radius: float,
        changed: Callable[[FieldWatch, dict[str, str]], None],
    ) -> None:
        self.pair = pair
        self.occupied: dict[str, str] = {}
        self._fields = fields.protective
        self._radius = radius
        self._reach = fields.reach + radius
        self._changed = changed
        self.row = pair.row(TooClose(FixedDistance(self._reach)), beyond=self._reach + BEYOND)
        self.row.asks = True  # until the first search
        self.alarm = Alarm(pair.clock, self.reconsider, Turn.VIOLATION)

    @property
    def person(self) -> str:
        """Name of the person."""
        return self.pair.person.name

    def mute(self, muted: bool) -> None:
        """Mute the fields, or end that."""
        self.row.idle = muted
        self.reconsider()

    def reconsider(self) -> None:
        """Compute occupied fields and the next change. It is called for each new motion."""
        # A person in a field may have left it.
        self.row.asks = False
        self.row.search(*self.pair.motions, self.pair.clock.now)
        if self.row.open:
            self._become(*self._in_reach())
        else:
            self._become({}, self.row.time)

    def _in_reach(self) -> tuple[dict[str, str], float | None]:
        """Return the occupied fields with their sets, and the time of the next change (s)."""
        pair, now = self.pair, self.pair.clock.now
        person, machine = pair.motions
        end = max(now, pair.horizon())
        occupied: dict[str, str] = {}
        until: dict[str, float] = {}
        change = math.inf
        for intrusion in intrusions(
            self._fields, machine, person, self._radius, now, end, pair.machine.loaded
        ):
            if intrusion.end <= now + MOMENT:
                continue
            if intrusion.begin <= until.get(intrusion.field, now) + MOMENT:
                # A change of the set does not end the occupation.
                occupied.setdefault(intrusion.field, intrusion.set)
                until[intrusion.field] = max(intrusion.end, until.get(intrusion.field, now))
            elif intrusion.field not in occupied:
                change = min(change, intrusion.begin)
        # An intrusion up to the horizon lasts until a motion changes.
        change = min([change, *(t for t in until.values() if t < end)])
        return occupied, None if change == math.inf else change

    def _become(self, occupied: dict[str, str], change: float | None) -> None:
        self.alarm.set(change)
        self.row.asks = bool(occupied)
        before = self.occupied
        if occupied.keys() != before.keys():
            self.occupied = {field: before.get(field, name) for field, name in occupied.items()}
            self._changed(self, before)
