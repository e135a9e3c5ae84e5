"""Faults of a trial: values out of range, unknown names, and contradictions."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

import shapely

import bdi
from floorplan import Point
from floorplan.checks import starting_fault
from floorplan.files.problems import Fault, Place, refuse, suggestion
from floorplan.files.values import range_faults, require_fields
from navigation import PlannerError
from navigation.catalog import PlannerChoice

from ..core.custom_code import OwnCodeError
from ..core.entries import AT_ONCE, CONDITIONS, Start
from ..core.scenario import (
    ANYWHERE,
    NAME,
    PersonalityChange,
    PersonEntry,
    Scenario,
    TrialError,
    spot,
)
from ..machines.gantry.model import GantryModel
from ..machines.gantry.robot import GANTRY
from ..machines.kinds import machine_faults, on_floor
from ..people.crowd.custom_steering import STEERING, SteeringError
from ..people.programs import EXTERNAL, find_program, modules_of, planner_source, sources_of
from ..people.tracks.recorded_walks import track_faults, with_everybody
from .expectations import expectation_problems
from .feasibility import (
    budget_faults,
    closed_place_faults,
    command_faults,
    door_faults,
    list_faults,
    obstacle_faults,
    person_faults,
)
from .field_checks import field_faults
from .names import (
    agvs,
    event_kinds,
    machines,
    name_faults,
    orders,
    own_names,
    parts,
    people,
    stations,
)
from .reachability import unreachable_goals

MOST_BYTES = 200
"""Maximum number of bytes in UTF-8 of the name of a trial or study, which names folders."""

GROUPS = range(2, 6)
"""Possible numbers of people in a group."""

_SOUND = "_sound"
"""Attribute of a correct trial with copies of its dictionaries at the time of the check."""

DENSEST = 0.9
"""Maximum share of a floor that discs cover, side by side."""


def check(trial: Scenario) -> None:
    """Raise `TrialError` with all faults of `trial`, or `TypeError` for a wrong type.

    A correct trial is checked only once, when it is read or first used.
    """
    if _SOUND in vars(trial) and vars(trial)[_SOUND] == _dictionaries(trial):
        return
    require_fields(trial)
    refuse(f"trial {trial.name!r}", faults(with_everybody(trial)), TrialError)
    keep_sound(trial)


def keep_sound(trial: Scenario) -> None:
    """Mark `trial` as correct, so that `check` need not repeat its work."""
    vars(trial)[_SOUND] = _dictionaries(trial)


def _dictionaries(trial: Scenario) -> list[Any]:
    """Return copies of the dictionaries of a trial, because they can change after a check."""
    keys = {name: entry.keys for name, entry in trial.machines.items()}
    values = (trial.agvs, trial.machines, keys, trial.fields, trial.expect, trial.work, trial.doors)
    return [_copied(value) for value in (*values, trial.sources)]


def _copied(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _copied(one) for key, one in value.items()}
    return [*map(_copied, value)] if isinstance(value, list) else value


def check_own_events(trial: Scenario) -> None:
    """Raise `TrialError` if `trial` names events that its imported custom code does not define."""
    if any(own_names(trial)):
        imported = replace(trial, own_code=False)
        problems = [*_below(expectation_problems(imported), "expect")]
        for place, start in _starts(trial):
            problems += _start_faults(start, imported, *place)
        refuse(f"trial {trial.name!r}", problems, TrialError)


def _starts(trial: Scenario) -> Iterator[tuple[Place, Start]]:
    """Yield all start conditions of a trial with their places."""
    for k, person in enumerate(trial.people):
        yield ("people", k, "start"), person.start
        for n, change in enumerate(person.changes):
            yield ("people", k, "changes", n, "when"), change.when
    for k, blackout in enumerate(trial.blackouts):
        yield ("blackouts", k, "start"), blackout.start


def faults(trial: Scenario, *, was_read: bool = False) -> Iterator[Fault]:
    """Yield all faults of `trial`, except that its controller is not there.

    A trial that exceeds its budget has no other faults, because they would take long to find.
    Unreachable goals are found only if nothing else is wrong. The values of a trial that `was_read`
    from a file are in range.
    """
    if budget := [*budget_faults(trial)]:
        yield from budget
        return
    ranges = [] if was_read else [*range_faults(trial)]
    yield from [*ranges, *_entry_faults(trial)] or unreachable_goals(trial)


def _entry_faults(trial: Scenario) -> Iterator[Fault]:
    """Yield the faults of the entries of a trial."""
    if fault := name_fault(trial.name):
        yield fault, ("name",)
    if trial.warm_up and not 0 < trial.warm_up < trial.duration:
        message = f"must be less than the duration, {trial.duration:g} s, not {trial.warm_up:g} s"
        yield message, ("warm_up",)
    yield from _planner_faults(trial.planner, trial, "planner")
    taken = {GANTRY, *(lane.name for lane in trial.floorplan.lanes), *trial.machines}
    for k, person in enumerate(trial.people):
        yield from _below(_person_faults(person, trial), "people", k)
        if person.name in taken:
            yield f"another body is called {person.name!r} already", ("people", k, "name")
        taken.add(person.name)
    yield from track_faults(with_everybody(trial))
    if trial.steering is not None:
        try:
            trial.code_folder.find(trial.steering, STEERING)
        except SteeringError as why:
            yield str(why), ("steering",)
    try:
        sources_of(EXTERNAL, modules_of(None, trial.actions), trial.code_folder)
    except OwnCodeError as why:
        yield str(why), ("actions",)
    yield from _overlaps(trial)
    yield from _crowding(trial)
    yield from _group_faults(trial)
    for place, start in _starts(trial):
        yield from _start_faults(start, trial, *place)
    yield from _below(list_faults(trial), "work")
    for k, blackout in enumerate(trial.blackouts):
        names = machines(trial)
        yield from name_faults(blackout.machine, "machine", names, "blackouts", k, "machine")
    yield from _below(door_faults(trial), "doors")
    yield from _below(obstacle_faults(trial), "obstacles")
    yield from _below(command_faults(trial), "commands")
    plan = trial.floorplan
    if plan.zones or plan.doors or plan.gates or trial.obstacles:
        yield from closed_place_faults(trial)
    yield from _floor_faults(trial)
    yield from _below(machine_faults(trial), "machines")
    yield from _below(field_faults(trial), "fields")
    yield from _below(expectation_problems(trial), "expect")
    submits = trial.workload is not None or any(job.kind == "submit" for job in trial.gantry.jobs)
    if trial.until_submitted and not submits:
        message = "no order is submitted: there are no ariac orders, and no job is submit"
        yield message, ("until_submitted",)


def name_fault(name: str) -> str:
    """Return why the `name` of a trial or study is no valid folder name, or an empty text."""
    size = len(name.encode(errors="replace"))
    if not re.search(r"[\0\ud800-\udfff]", name) and size <= MOST_BYTES:
        return ""
    return f"invalid folder name; give a name of at most {MOST_BYTES} bytes: {name[:60]!r}"


def _below(inner_faults: Iterable[Fault], *place: str | int) -> Iterator[Fault]:
    for message, rest in inner_faults:
        yield message, (*place, *rest)


def _person_faults(person: PersonEntry, trial: Scenario) -> Iterator[Fault]:
    if not re.fullmatch(NAME, person.name):
        message = f"must begin with a letter, and have letters, digits, _ and -: {person.name!r}"
        yield message, ("name",)
    yield from _personality_faults(person, trial)
    if person.recorded is None:
        yield from _place_faults(person, trial)
    yield from _coming_faults(person, trial)
    if person.agent_lag is not None and person.personality == EXTERNAL:
        message = "a person controlled from outside has no agent; omit it"
        yield message, ("agent_lag",)
    if person.planner is not None:
        yield from _planner_faults(person.planner, trial, "planner")
    yield from person_faults(person, trial)
    for k, belief in enumerate(person.beliefs):
        try:
            bdi.parse_literal(belief)
        except bdi.ProgramError as why:
            problem = why.problems[0]
            at = f"column {problem.column}: " if problem.column else ""
            yield f"is not a belief: {at}{problem.message}", ("beliefs", k)


def _overlaps(trial: Scenario) -> Iterator[Fault]:
    """Yield the starts of people that overlap with another person."""
    usual = trial.floorplan.human.radius
    width = 2 * max((person.radius or usual for person in trial.people), default=usual)
    placed: dict[Point, list[tuple[int, PersonEntry, Point]]] = {}
    for k, person in enumerate(trial.people):
        place = person.place_on(trial.floorplan)
        if place is None:
            continue
        # Only people in neighbouring cells of this width can overlap.
        i, j = place[0] // width, place[1] // width
        cells = [(i + di, j + dj) for di in (-1, 0, 1) for dj in (-1, 0, 1)]
        for _, other, there in sorted(one for cell in cells for one in placed.get(cell, ())):
            needed = (person.radius or usual) + (other.radius or usual)
            apart = math.dist(place, there)
            if apart < needed:
                message = (
                    f"{place} is {apart:.3g} m from where {other.name} starts; two bodies of"
                    f" their size need {needed:g} m between their centres"
                )
                if place == there:
                    message += "; omit at, or give anywhere, for a free position"
                yield message, ("people", k, "at")
                break
        placed.setdefault((i, j), []).append((k, person, place))


def _coming_faults(person: PersonEntry, trial: Scenario) -> Iterator[Fault]:
    """Yield the faults of the source and the sink of a person."""
    source = person.source
    if source is not None:
        if person.at is not None:
            yield "a person with a source has no start position; omit at", ("at",)
        if person.start != AT_ONCE:
            yield "a person with a source starts on entry; omit start", ("start",)
        yield from _spot_faults(person, source.at, trial, "source", "at")
    yield from _spot_faults(person, person.sink, trial, "sink")


def _spot_faults(
    person: PersonEntry, position: Point | str | None, trial: Scenario, *place: str
) -> Iterator[Fault]:
    """Yield why a person cannot be at a place, unless it is None."""
    if position is None:
        return
    plan = trial.floorplan
    at = spot(plan, position, person.radius)
    if at is None:
        names = [*stations(trial), *(door.name for door in plan.doors)]
        if place == ("at",):
            names.append(ANYWHERE)
        yield from name_faults(str(position), "station or door", names, *place)
    elif fault := starting_fault(plan, at, person.radius):
        yield fault, place
    else:
        (x, y), here, radius = at, shapely.Point(at), person.radius or plan.human.radius
        for zone in plan.zones:
            if zone.forbidden and zone.is_about(person.name) and zone.area.distance(here) < radius:
                yield f"({x:g}, {y:g}) is in the zone {zone.name!r}, forbidden to them", place


def _group_faults(trial: Scenario) -> Iterator[Fault]:
    """Yield the groups that are too small or too large."""
    groups = [person.group for person in trial.people]
    for group, count in Counter(groups).items():
        if group is not None and count not in GROUPS:
            least, most = min(GROUPS), max(GROUPS)
            message = f"a group has from {least} to {most} people, and {group!r} has {count}"
            yield message, ("people", groups.index(group), "group")


def _crowding(trial: Scenario) -> Iterator[Fault]:
    """Yield a fault if the people do not fit on the floor."""
    there = [one for one in trial.people if one.source is None and one.recorded is None]
    if len(there) < 2:
        return
    plan = trial.floorplan
    needed = sum(math.pi * (one.radius or plan.human.radius) ** 2 for one in there) / DENSEST
    blocked = plan.blocked(0.0, plan.human.height)
    if needed <= plan.boundary.area - sum(footprint.area for footprint in blocked):
        return  # obstacles may overlap, so there is room for more
    room = plan.free(0.0, plan.human.height).area
    if needed > room:
        message = f"{len(there)} people don't fit on the {room:.0f} m² that are free"
        yield message, ("people",)


def _personality_faults(person: PersonEntry, trial: Scenario) -> Iterator[Fault]:
    named: list[tuple[PersonEntry | PersonalityChange, Place]] = [(person, ("personality",))]
    named += [(change, ("changes", k, "personality")) for k, change in enumerate(person.changes)]
    if len(named) > 1 and any(one.personality == EXTERNAL for one, _ in named):
        yield f"no personality changes to or from {EXTERNAL!r}", ("changes",)
    for one, place in named:
        try:
            if isinstance(one.personality, str) and one.personality != EXTERNAL:
                find_program(one.personality, trial.folder)
        except TrialError as why:
            yield why.problems[0].message, place
            continue
        try:
            personality = one.personality
            modules = modules_of(person.actions, None)
            sources_of(personality, modules, trial.code_folder)
        except OwnCodeError as why:
            yield str(why), ("actions",)


def _start_faults(start: Start, trial: Scenario, *place: str | int) -> Iterator[Fault]:
    if sum(getattr(start, name) is not None for name in CONDITIONS) != 1:
        yield f"must be one of {', '.join(CONDITIONS)}", place
    if start.event is not None:
        known_events = event_kinds(trial, start.event)
        yield from name_faults(start.event, "kind of event", known_events, *place, "event")
    if start.person is not None:
        yield from name_faults(start.person, "person", people(trial), *place, "person")
    if start.order_submitted is not None:
        order = start.order_submitted
        yield from name_faults(order, "order", orders(trial), *place, "order_submitted")
    names_of = {"part": parts, "agv": agvs}
    for key, name in (start.part_placed or {}).items():
        if key in names_of:
            yield from name_faults(name, key, names_of[key](trial), *place, "part_placed", key)
        else:
            yield f"unknown key; {suggestion(key, names_of)}", (*place, "part_placed", key)


def _place_faults(person: PersonEntry, trial: Scenario) -> Iterator[Fault]:
    plan, zone = trial.floorplan, trial.floorplan.safe_zone
    own = None if person.anywhere else person.at
    yield from _spot_faults(person, own, trial, "at")
    yield from _spot_faults(person, person.home, trial, "home")
    if person.at is None and person.home is None and person.home_on(plan) is None:
        yield "the floorplan has no safe zone to start in; give at: [x, y]", ()
    if person.home is None and zone is not None:
        fault = starting_fault(plan, zone.position, person.radius)
        if fault:
            yield f"in the safe zone, {fault}; give home: [x, y]", ()


def _planner_faults(choice: PlannerChoice, trial: Scenario, *place: str) -> Iterator[Fault]:
    try:
        planner_source(choice, trial.code_folder)
    except PlannerError as why:
        yield str(why), place


def _floor_faults(trial: Scenario) -> Iterator[Fault]:
    """Yield the faults of the machines of the floor."""
    plan = trial.floorplan
    lanes = {lane.name: lane for lane in plan.lanes}
    for name in (*trial.agvs, *sorted(trial.yielding - {*trial.agvs})):
        if name not in lanes:
            yield f"no AGV is called {name!r}; {suggestion(name, lanes)}", ("agvs", name)
    carried = any(job.kind == "pick_place" for job in trial.gantry.jobs)
    for k, drop in enumerate(() if carried else trial.gantry.drops):
        where = (GANTRY, "drops", k, "part")
        yield from name_faults(drop.part, "part", parts(trial), *where)
    models = on_floor(trial) | ({} if plan.gantry else {GANTRY: GantryModel(trial.gantry)})
    vehicles = {*lanes, *trial.machines}
    for name, model in models.items():
        place = (GANTRY,) if name == GANTRY else ("agvs", name)
        yield from _below(model.faults(plan, vehicles), *place)
        yield from _below(model.place_faults(name, plan), *place)
