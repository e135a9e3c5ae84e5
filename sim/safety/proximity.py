"""Notification that a person comes near a machine: once for each approach."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from navigation import Apart, FixedDistance, TooClose

from ..core.clock import Alarm, Turn
from ..core.machine import Machine
from ..core.stage import Stage
from .watches import Pair

PARTING = 0.1
"""Metres. Distance beyond the watched one to which the two have to part before another approach."""


class ProximityWatch:
    """Calls `came_near` when a person comes within a distance of a machine's axis.

    It watches from when `near` gives the distance on.
    """

    def __init__(self, stage: Stage, machine: Machine, came_near: Callable[[], None]) -> None:
        people = stage.people
        self._pairs = [Pair(stage, person, machine) for person in people]
        self._bodies = [*(person.body for person in people), machine.body]
        self._came_near = came_near
        self._close = TooClose(FixedDistance(0.0))
        self._parted = Apart(PARTING)
        self._is_near = [False] * len(people)
        self._watching = False
        self._alarms = [
            Alarm(stage.clock, partial(self._ring, k), Turn.NOTICE) for k in range(len(people))
        ]

    def near(self, distance: float | None) -> None:
        """Watch for this distance in metres from now on."""
        if distance is None:
            return
        self._close = TooClose(FixedDistance(distance))
        self._parted = Apart(distance + PARTING)
        if not self._watching:
            self._watching = True
            for body in self._bodies:
                body.on_change.append(self._reconsider)
        self._reconsider()

    def _reconsider(self) -> None:
        for k, pair in enumerate(self._pairs):
            self._alarms[k].set(pair.first_time(self._parted if self._is_near[k] else self._close))

    def _ring(self, k: int) -> None:
        # Hysteresis: near until parted, apart until near, so that no rounding notifies twice.
        self._is_near[k] = not self._is_near[k]
        self._reconsider()
        if self._is_near[k]:
            self._came_near()
