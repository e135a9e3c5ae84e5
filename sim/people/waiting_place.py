"""Places to wait beside a goal that a vehicle stands on."""

from __future__ import annotations

from floorplan import Human, Point
from navigation import CollisionWorld, Disc

from ..core.machine import Machine
from ..core.stage import Stage

SPARE = 0.1
"""Metres. Distance beyond the needed one at which people wait."""

_ZONE = "the zone that a vehicle needs to set out"


class WaitingPlaces:
    """Finds where a person waits beside a goal, so that the vehicle there can leave."""

    def __init__(self, stage: Stage, world: CollisionWorld, human: Human) -> None:
        self._stage = stage
        self._world = world
        self._human = human

    def occupant(self, goal: Point) -> Machine | None:
        """Return the vehicle that is all that keeps a person from standing at `goal`."""
        radius, vehicles = self._human.radius, [*self._stage.vehicles]
        names = [vehicle.name for vehicle in vehicles]
        if not self._world.as_if(away=names).free(goal, radius):
            return None
        for vehicle in vehicles:
            others = [name for name in names if name != vehicle.name]
            if not self._world.as_if(away=others).free(goal, radius):
                return vehicle
        return None

    def beside(self, goal: Point, vehicle: Machine) -> Point | None:
        """Return the free place nearest to `goal` that lets the vehicle set out, if any."""
        radius = self._human.radius
        kept = vehicle.zone(self._human.max_speed) + SPARE - radius
        zone = Disc(vehicle.centre, max(kept, SPARE))
        return self._world.as_if({_ZONE: zone}).nearest_free(goal, radius)
