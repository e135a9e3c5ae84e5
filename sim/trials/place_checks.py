"""Faults of places that change: names of nothing, times that can't be, and people in the way."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from shapely.geometry import Point

from floorplan import LARGEST, Fault, UserError, height_fault, polygon_fault, suggestion

from ..core.closures import Closures, Interval
from ..core.scenario import Scenario
from ..core.work import as_given
from ..machines.agv.lane_parts import last_before, part_behind, part_within


def door_faults(trial: Scenario) -> Iterator[Fault]:
    """Yield what can't be about the times of doors."""
    doors = [door.name for door in trial.floorplan.doors]
    for name, times in trial.doors.items():
        if name not in doors:
            hint = suggestion(name, doors) if doors else "the floor has none"
            yield f"no door is called {name!r}; {hint}", (name,)
        if (times.closed is None) == (times.open is None):
            yield "must have the times at which it is closed, or open", (name,)
        for key, spans in (("closed", times.closed), ("open", times.open)):
            for message, k in _interval_faults(spans or (), trial):
                yield message, (name, key, k)


def obstacle_faults(trial: Scenario) -> Iterator[Fault]:
    """Yield what can't be about obstacles that come and go."""
    taken = names_taken(trial)
    for timed in trial.obstacles:
        one = timed.obstacle
        if one.name in taken:
            yield f"something else is called {one.name!r} already", (one.name,)
        taken.add(one.name)
        if fault := polygon_fault(one.footprint):
            yield fault, (one.name,)
        if fault := height_fault(one):
            yield fault, (one.name, "z")
        for message, k in _interval_faults(timed.there, trial):
            yield message, (one.name, "there", k)


def names_taken(trial: Scenario) -> set[str]:
    """Return the names that no obstacle which comes and goes can have."""
    plan = trial.floorplan
    fixed = (plan.obstacles, plan.lanes, plan.doors, plan.zones, plan.gates)
    taken = {"boundary", *trial.machines, *(one.name for kind in fixed for one in kind)}
    return taken | {person.name for person in trial.people}


def _interval_faults(spans: Sequence[Interval], trial: Scenario) -> Iterator[tuple[str, int]]:
    end = 0.0
    for k, (begin, until) in enumerate(spans):
        if not 0 <= begin < until or (until > LARGEST and until != math.inf):
            given = f"{as_given(begin)} … {as_given(until)}"
            yield f"ends before it begins, or at once: {given}", k
        elif begin < end:
            given = f"begins at {as_given(begin)}, before the one in front of it ends at"
            yield f"{given} {as_given(end)}", k
        elif begin >= trial.duration:
            yield f"begins at {begin:g} s of the trial, which ends at {trial.duration:g} s", k
        end = until


def closed_place_faults(trial: Scenario) -> Iterator[Fault]:
    """Yield who starts where nobody can be then, or would never get where they are to go."""
    plan = trial.floorplan
    height = plan.human.height
    there = Closures(plan, trial.doors, trial.obstacles).at(0.0).values()
    for k, person in enumerate(trial.people):
        place = person.place_on(plan)
        if place is None or person.recorded is not None:
            continue
        at = Point(place)
        radius = person.radius or plan.human.radius
        for one in there:
            if one.overlaps(0.0, height) and one.footprint.distance(at) < radius:
                yield f"{place} is in {one.name}, which is there then", ("people", k, "at")
    for lane in plan.lanes:
        at_q = lane.locations.get(lane.start, 0.0)
        for k, move in enumerate(trial.agvs.get(lane.name, ())):
            try:
                to = lane.lane_position(move.to)
            except UserError:
                break  # told already; where the lane goes on from is not known
            for zone in plan.zones:
                if not (zone.forbidden and zone.is_about(lane.name)):
                    continue
                part = part_within(lane, zone.area)
                if part is not None and last_before(part, at_q, to) is not None:
                    message = f"leads into the zone {zone.name!r}, forbidden to {lane.name}"
                    yield message, ("agvs", lane.name, k, "to")
            for gate in plan.one_ways:
                part = part_behind(lane, gate, at_q, to) if gate.is_about(lane.name) else None
                if part is not None and last_before(part, at_q, to) is not None:
                    message = f"leads through the gate {gate.name!r} against its direction"
                    yield message, ("agvs", lane.name, k, "to")
            at_q = to
