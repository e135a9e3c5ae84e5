"""Errand of a person: walks to a goal, replanning, and waits beside an occupied goal."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from functools import lru_cache, partial

from floorplan import Human, Point, Station
from navigation import (
    CollisionWorld,
    Cylinder,
    Disc,
    FixedDistance,
    PlanningError,
    Shapes,
    standing,
    violations,
)

from ..core.body import Machine
from ..core.clock import Alarm, Turn
from ..core.events import Arrived, GoalChanged, GoalFree, GoalOccupied, PathBlocked, Replanned
from ..core.stage import Stage
from .perception import Senses
from .walker import Walker

SPARE = 0.1
"""Metres. Additional distance at which people wait for a vehicle."""

_ZONE = "the zone that a vehicle needs to set out"


class WaitingPlaces:
    """Places where a person can wait beside a goal, so that the vehicle on it can leave."""

    def __init__(self, stage: Stage, world: CollisionWorld, human: Human) -> None:
        self._stage = stage
        self._world = world
        self._human = human

    def occupant(self, goal: Point) -> Machine | None:
        """Return the vehicle on `goal` if only vehicles occupy it, or None."""
        radius, vehicles = self._human.radius, self._stage.vehicles
        touched = {body.name for body in self._world.hits(goal, goal, radius)}
        occupant = next((vehicle for vehicle in vehicles if vehicle.name in touched), None)
        if occupant is None:
            return None
        without = self._world.as_if(away=[vehicle.name for vehicle in vehicles])
        return occupant if without.free(goal, radius) else None

    def beside(self, goal: Point, vehicle: Machine) -> Point | None:
        """Return the free place nearest to `goal` outside the zone of the vehicle, or None."""
        zone = Disc(vehicle.centre, self._kept_from(vehicle))
        return self._world.as_if({_ZONE: zone}).nearest_free(goal, self._human.radius)

    def left(self, goal: Point, vehicle: Machine) -> float | None:
        """Return when the moving vehicle leaves `goal` and its surroundings (s), or None."""
        now, drive = self._stage.clock.now, vehicle.body.motion
        if drive.end <= now:
            return None
        person = Cylinder(radius=self._human.radius, top=self._human.height)
        shapes = Shapes(person=person, machine=(vehicle.shape.chassis,))
        near = FixedDistance(self._kept_from(vehicle))
        stays = violations(standing(goal), drive, near, now, drive.end, shapes=shapes)
        return next((end for _, end in stays if now < end < drive.end), None)

    def _kept_from(self, vehicle: Machine) -> float:
        """Return the distance (m) at which a person does not prevent a vehicle from starting."""
        zone = vehicle.zone(self._human.max_speed)
        return max(zone + SPARE - self._human.radius, SPARE)


BESIDE = 1e-3
"""Metres. People who arrive farther from their goal have arrived beside another person."""


class Errand:
    """Walk of a person to a goal around obstacles.

    The person waits beside a goal that a vehicle occupies, and replans a blocked path. Percepts
    report the outcome: `work_completed`, `path_blocked`, `goal_blocked` or `goal_occupied`.
    """

    def __init__(self, stage: Stage, walker: Walker, senses: Senses) -> None:
        self.visits: list[str] = []
        """Stations reached, in order."""
        self.escorts: Callable[[], bool] | None = None
        """Returns whether an arrival counts. Set while the person walks with or to another one."""
        self.refusal = ""
        """Reason of the last failure to find a path."""
        self._stage = stage
        self._record = stage.record
        self._walker = walker
        self._senses = senses
        self._name = walker.body.name
        self._waiting_places = WaitingPlaces(stage, walker.world, walker.human)
        self._station_at = lru_cache(maxsize=256)(
            partial(_nearest_station, stage.floorplan.stations, walker.human)
        )
        self._waits_for: Point | None = None
        self._occupant: Machine | None = None
        """Vehicle for which the person waits or last waited."""
        self._leaving = Alarm(stage.clock, self._look_again, Turn.MOTION_ENDS)

    def go(self, goal: Point) -> bool:
        """Set out for `goal`. Return whether there is a path to it, or to a place to wait."""
        self._stage.place_machines()
        self._record(GoalChanged(person=self._name, station=self._station_at(goal), at=goal))
        return self._set_out(goal)

    def _set_out(self, goal: Point) -> bool:
        """Walk to `goal`, or to a place to wait beside it. Return whether there is a path."""
        try:
            self._walker.go(goal)
        except PlanningError as why:
            at_the_goal = why.reason == "goal_blocked"
            if at_the_goal and self._wait_beside(goal):
                return True
            return self.fail(goal, str(why), at_the_goal=at_the_goal)
        return True

    def resume(self, goal: Point) -> None:
        """Walk to `goal` on a new path after a wait for a vehicle."""
        if self._set_out(goal):
            self._walker.replans += 1
            self._record(Replanned(person=self._name, goal=goal))

    def give_up(self) -> None:
        """Stop waiting for a goal to be free."""
        self._waits_for = None

    def interrupt(self) -> Point | None:
        """Stop, and return the goal for `go_on`, or None if the person is not walking to one."""
        goal = self._walker.goal
        if goal is None or self._waits_for is not None:
            return None
        self._walker.stop()
        return goal

    def go_on(self, goal: Point) -> None:
        """Set out again for the goal of an interrupted errand."""
        self._stage.place_machines()
        self._set_out(goal)

    def fail(self, goal: Point, message: str, *, at_the_goal: bool = False) -> bool:
        """Perceive that there is no path to `goal`. Return False, the outcome of the action."""
        self.refusal = message
        self._record(PathBlocked(person=self._name, goal=goal, message=message))
        self._senses.count("goal_blocked" if at_the_goal else "path_blocked")
        return False

    def floor_changed(self, came: Collection[str]) -> None:
        """Check the path after a change of the floor. `came` are the names of new obstacles."""
        if self._waits_for is not None:
            self._check_wait(self._waits_for, came)
            return
        goal = self._walker.goal
        failure = self._walker.check_path(came)
        if failure is None or goal is None:
            return
        at_the_goal = failure.reason == "goal_blocked"
        if not (at_the_goal and self._wait_beside(goal)):
            self._senses.count("goal_blocked" if at_the_goal else "path_blocked")

    def arrived(self, goal: Point) -> None:
        """Handle the arrival at `goal`, or at the place to wait for it."""
        if self._waits_for is not None:
            self._senses.count("goal_occupied")
            return
        if self.escorts is not None and not self.escorts():
            return
        station = self._station_at(goal)
        beside = math.dist(self._walker.body.at, goal) > BESIDE
        at = self._walker.body.at if beside else goal
        self._record(Arrived(person=self._name, station=station, at=at))
        if station is not None:
            self.visits.append(station)
        self._senses.see("at", *self._walker.body.at)
        self._senses.count("work_completed")

    def _check_wait(self, goal: Point, came: Collection[str]) -> None:
        """Walk to `goal` if it is free now. Otherwise continue to wait."""
        occupant = self._waiting_places.occupant(goal)
        if occupant is None:
            self._waits_for = None
            self._record(GoalFree(person=self._name, goal=goal))
            self._walker.halt_if_blocked()
            if not self._set_out(goal):
                self._walker.stop()
        elif self._walker.check_path(came) is not None and not self._wait_beside(goal):
            self.fail(goal, "there is no way to a place to wait", at_the_goal=True)
        else:
            self._wait_for(occupant)

    def _wait_for(self, occupant: Machine) -> None:
        """Wait for a vehicle, and update the alarm whenever the vehicle changes its motion."""
        self._occupant = occupant
        if self._occupant_moves not in occupant.body.on_change:
            occupant.body.on_change.append(self._occupant_moves)
        self._occupant_moves()

    def _occupant_moves(self) -> None:
        """Set the alarm to the time at which the vehicle leaves the goal, if known."""
        goal, occupant = self._waits_for, self._occupant
        if goal is not None and occupant is not None:
            self._leaving.set(self._waiting_places.left(goal, occupant))

    def _look_again(self) -> None:
        """Walk to the goal that the vehicle has left."""
        if self._waits_for is not None:
            self._stage.place_machines()
            self._check_wait(self._waits_for, ())

    def _wait_beside(self, goal: Point) -> bool:
        """Wait near a goal until the vehicle on it has left. Return False if there is none."""
        self._waits_for = None
        occupant = self._waiting_places.occupant(goal)
        place = None if occupant is None else self._waiting_places.beside(goal, occupant)
        if occupant is None or place is None:
            return False
        try:
            self._walker.go(place)
        except PlanningError:
            return False
        self._waits_for = goal
        self._record(GoalOccupied(person=self._name, goal=goal, by=occupant.name))
        self._wait_for(occupant)
        return True


def _nearest_station(stations: Sequence[Station], human: Human, point: Point) -> str | None:
    """Return the name of the station at a point, within the tolerance of goals, or None."""
    near = [
        (distance, station.name)
        for station in stations
        if (distance := math.dist(station.position, point)) <= human.goal_tolerance
    ]
    return min(near)[1] if near else None
