"""Tells when a person comes near the gantry: once for each approach."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial

from navigation import Apart, FixedDistance, TooClose

from ..core.body import Body
from ..core.clock import Alarm, Clock, Turn
from .watches import Pair

PARTING = 0.1
"""Metres. By how much more than the distance the two have to part until it is told again."""


class ProximityWatch:
    """Calls `came_near` when a person comes within a distance of the gantry's axis.

    It watches from when `near` gives the distance on.
    """

    def __init__(
        self,
        clock: Clock,
        people: Sequence[Body],
        gantry: Body,
        end: float,
        came_near: Callable[[], None],
    ) -> None:
        self._pairs = [Pair(clock, person, gantry, end) for person in people]
        self._bodies = [*people, gantry]
        self._came_near = came_near
        self._distance = math.inf
        self._is_near = [False] * len(people)
        self._watching = False
        self._alarms = [
            Alarm(clock, partial(self._ring, k), Turn.NOTICE) for k in range(len(people))
        ]

    def near(self, distance: float | None) -> None:
        """Watch for this distance in metres from now on."""
        if distance is None:
            return
        self._distance = distance
        if not self._watching:
            self._watching = True
            for body in self._bodies:
                body.on_change.append(self._reconsider)
        self._reconsider()

    def _reconsider(self) -> None:
        for k, pair in enumerate(self._pairs):
            parted, close = Apart(self._distance + PARTING), TooClose(FixedDistance(self._distance))
            self._alarms[k].set(pair.first_time(parted if self._is_near[k] else close))

    def _ring(self, k: int) -> None:
        self._is_near[k] = not self._is_near[k]
        self._reconsider()
        if self._is_near[k]:
            self._came_near()
