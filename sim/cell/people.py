"""Goals of people from outside: room near a goal, and how a person gets there."""

from __future__ import annotations

import math

import shapely

import bdi
from floorplan import Point, UserError

from ..core.entries import Command
from ..people.minds import Outside
from ..people.person import Person
from ..simulation import Simulation
from .values import Target

TOLERANCE = 0.5
"""Metres. A goal without room is moved by at most this, as Nav2's planners do by default."""


class PersonRoute:
    """Commands of one person who is sent to goals."""

    def __init__(self, simulation: Simulation, person: Person) -> None:
        self.person = person
        self._simulation = simulation

    @property
    def is_external(self) -> bool:
        """Whether an external program decides for the person."""
        return isinstance(self.person.mind, Outside)

    def require_on_floor(self, target: Target) -> None:
        """Raise a `ValueError` for a target outside the floor."""
        boundary = self._simulation.trial.floorplan.boundary
        if not boundary.covers(shapely.Point(target[:2])):
            west, south, east, north = boundary.bounds
            raise UserError(f"outside the floor (x {west:g} … {east:g}, y {south:g} … {north:g})")

    def require(self, target: Target) -> None:
        """Raise a `ValueError` if the person cannot be sent to a target now."""
        person, (x, y) = self.person, target[:2]
        self.require_on_floor(target)
        if self.room((x, y)) is None:
            raise UserError(f"no room for a person within {TOLERANCE:g} m")
        if person.started_at is None:
            raise UserError(f"{person.name} has not started")
        if person.away:
            raise UserError(f"{person.name} is not on the floor")

    def room(self, goal: Point) -> Point | None:
        """Return a goal, the nearest free point if it is in an obstacle, or None without room.

        A goal on which only a vehicle stands is kept, because people wait for it to be free.
        """
        world, radius = self.person.walker.world, self.person.walker.human.radius
        if world.fixed_space(radius).nearest(goal) == goal:
            return goal
        for agv in self._simulation.agvs:
            agv.stand_in(world)
        near = world.nearest_free(goal, radius)
        return near if near is not None and math.dist(near, goal) <= TOLERANCE else None

    def go(self, target: Target) -> None:
        """Send the person to a target."""
        x, y = self.room((target[0], target[1])) or target[:2]
        if self.is_external:
            self.person.act(bdi.Literal("move", (x, y)))
        else:
            self._simulation.command(Command(send=self.person.name, to=(x, y)))

    def stop(self) -> None:
        """Stop the person."""
        if self.is_external:
            self.person.act(bdi.Literal("stop_movement"))
        else:
            self._simulation.command(Command(send=self.person.name, to=self.person.body.at))
