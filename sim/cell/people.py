"""Commands and tasks of people: room near a goal, and how a person gets there."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import shapely

import bdi
from floorplan import Point, UserError

from ..core.entries import Command
from ..core.recorder import Event
from ..people.minds import Outside
from ..people.person import Person
from ..simulation import Simulation
from .tasks import SUCCEEDED, Running, tasks_to
from .values import Pose, Target, target_of

TOLERANCE = 0.5
"""Metres. A goal without room is moved by at most this, as Nav2's planners do by default."""


def commands_of_person(
    simulation: Simulation, person: Person
) -> dict[str, Callable[[Any], object]]:
    """Return the commands of a person, by name."""
    route, body = PersonRoute(simulation, person), f"people/{person.name}"
    commands: dict[str, Callable[[Any], object]] = {f"{body}/start": lambda _: person.start()}
    if not person.is_recorded:
        commands |= {f"{body}/goal": route.send, f"{body}/stop": lambda _: route.stop()}
        if route.is_external:
            commands[f"{body}/act"] = route.act
    return commands


def tasks_of_person(simulation: Simulation, person: Person) -> dict[str, Callable[[Any], Running]]:
    """Return the tasks of a person, by name."""
    if person.is_recorded:
        return {}
    walk = partial(PersonTask, PersonRoute(simulation, person))
    return tasks_to(f"people/{person.name}", target_of, walk)


class PersonRoute:
    """Commands of one person who is sent to goals."""

    def __init__(self, simulation: Simulation, person: Person) -> None:
        self.person = person
        self._simulation = simulation

    @property
    def is_external(self) -> bool:
        """Whether an external program decides for the person."""
        return isinstance(self.person.mind, Outside)

    def require(self, target: Target) -> None:
        """Raise a `ValueError` if the person cannot be sent to a target now."""
        person, (x, y) = self.person, target[:2]
        self._require_on_floor(target)
        if self._room((x, y)) is None:
            raise UserError(f"no room for a person within {TOLERANCE:g} m")
        if person.started_at is None:
            raise UserError(f"{person.name} has not started")
        if person.away:
            raise UserError(f"{person.name} is not on the floor")

    def _require_on_floor(self, target: Target) -> None:
        boundary = self._simulation.trial.floorplan.boundary
        if not boundary.covers(shapely.Point(target[:2])):
            west, south, east, north = boundary.bounds
            raise UserError(f"outside the floor (x {west:g} … {east:g}, y {south:g} … {north:g})")

    def _room(self, goal: Point) -> Point | None:
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

    def send(self, goal: Pose | Sequence[float]) -> None:
        """Send the person to a goal. Whether there is a path is a percept of an external one."""
        target = target_of(goal)
        if self.is_external:
            self._require_on_floor(target)
        else:
            self.require(target)
        self.go(target)

    def go(self, target: Target) -> None:
        """Send the person to a target."""
        x, y = self._room((target[0], target[1])) or target[:2]
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

    def act(self, action: str | bdi.Literal) -> None:
        """Carry out an action of an external person."""
        if isinstance(action, str):
            try:
                action = bdi.parse_literal(action)
            except bdi.ProgramError as why:
                raise UserError(f"is no action: {why}") from why
        if not isinstance(action, bdi.Literal):
            raise UserError("expected an action as text")
        self.person.act(action)


class PersonTask(Running):
    """Walk of a person to targets, one after the other."""

    def __init__(self, route: PersonRoute, goal: Any, targets: Sequence[Target]) -> None:
        super().__init__(goal, route.person.body, targets)
        for target in targets:
            route.require(target)
        self._route = route
        self._sent_to: list[float] | None = None

    def begin(self) -> None:
        """Set out for the first target."""
        self._sent_to, self._outcome = None, ""
        self._route.go(self._left[0])

    def _stop(self) -> None:
        self._route.stop()

    def see(self, event: Event) -> None:
        """Follow the events of the person."""
        if event.get("person") != self._route.person.name or self._outcome:
            return
        match event["kind"]:
            case "goal" if self._sent_to is None:
                self._sent_to = event["at"]
            case "goal" if event["at"] != self._sent_to:
                self._outcome = "failed: another goal replaced it"
            case "arrived" if self._sent_to is not None:
                self._outcome = SUCCEEDED
            case "path_blocked" if self._sent_to is not None:
                self._outcome = f"failed: {event['message']}"
            case "teleport" | "left":
                self._outcome = f"failed: {event['kind']}"
