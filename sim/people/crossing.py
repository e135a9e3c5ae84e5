"""Vehicles that drive across a person's path: the person lets them pass."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

from floorplan import Human
from navigation import Box, Cylinder, FixedDistance, Motion, Shapes, TooClose, first_time

from ..core.clock import Alarm, Turn
from ..safety.watches import GLANCE, Pair

AHEAD = 1.5
"""Seconds. Time before they would walk into an AGV at which people stop."""

GAP = 0.1
"""Metres. Nearer than this to the surface of an AGV that drives, a person counts as touched."""

TOUCHING = TooClose(FixedDistance(GAP))
"""The condition under which somebody counts as touched."""


@lru_cache
def _shapes(human: Human, vehicle: Box) -> Shapes:
    """Return the solids of a person and of a vehicle; most people are alike."""
    return Shapes(person=Cylinder(radius=human.radius, top=human.height), machine=(vehicle,))


class CrossingWatch:
    """Calls `let_pass(self)` in time if a person is about to walk into an AGV that drives.

    That is, if they see it; who reacts slowly is later by as much.
    """

    def __init__(self, pair: Pair, human: Human, let_pass: Callable[[CrossingWatch], None]) -> None:
        self.pair = pair
        self._shapes = _shapes(human, pair.machine.shape.box)
        self._let_pass = let_pass
        self._alarm = Alarm(pair.clock, self._ring, Turn.NOTICE)
        self.lasts = False

    def touches(self, person: Motion) -> float | None:
        """Return the instant (seconds) at which the AGV would touch somebody who moves like this.

        None if it never would.
        """
        now, agv = self.pair.clock.now, self.pair.machine.body.motion
        if agv.end <= now:
            return None
        end = min(agv.end, self.pair.end)
        return first_time(TOUCHING, person, agv, now, max(now, end), shapes=self._shapes)

    def reconsider(self) -> None:
        """Compute anew when to stop; called whenever a motion changes."""
        if self.pair.machine.body.motion.end <= self.pair.clock.now:
            self._alarm.set(None)
            return
        person = self.pair.person.body.motion
        walks = person.end > self.pair.clock.now
        touched = self.touches(person) if walks else None
        early = AHEAD - self.pair.person.reaction_time
        self._alarm.set(None if touched is None else max(self.pair.clock.now, touched - early))

    def _ring(self) -> None:
        if self.pair.person.sees(self.pair.machine):
            self._let_pass(self)
        else:
            self._alarm.set(self.pair.clock.now + GLANCE)
