"""Where to wait beside a goal that an AGV stands on."""

from __future__ import annotations

from collections.abc import Callable

from navigation import CollisionWorld, Disc

from .walker import Place

SPARE = 0.1
"""Metres. How much farther away than needed people wait."""

_ZONE = "the zone that an AGV needs to set out"


class WaitingPlaces:
    """Finds where a person of a size waits beside a goal, so that the AGV there can leave.

    `zone(agv)` is how far from its centre a person must stand (metres) when it sets out.
    """

    def __init__(self, world: CollisionWorld, radius: float, zone: Callable[[str], float]) -> None:
        self._world = world
        self._radius = radius
        self._zone = zone

    def occupant(self, goal: Place) -> str | None:
        """The AGV that is all that keeps a person from standing at `goal`."""
        lanes = [lane.name for lane in self._world.plan.lanes]
        if not self._world.as_if(away=lanes).free(goal, self._radius):
            return None
        for name in lanes:
            others = [lane for lane in lanes if lane != name]
            if not self._world.as_if(away=others).free(goal, self._radius):
                return name
        return None

    def beside(self, goal: Place, agv: str) -> Place | None:
        """The place nearest to `goal` that is free, and out of the AGV's way when it leaves."""
        centre = self._world.plan.lane(agv).position(self._world.agv_position(agv))
        zone = Disc(centre, max(self._zone(agv) + SPARE - self._radius, SPARE))
        return self._world.as_if({_ZONE: zone}).nearest_free(goal, self._radius)
