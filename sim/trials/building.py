"""Trials built from their files, shortened, and checked for likely mistakes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, TypeVar

import bdi
import floorplan
from floorplan import Floorplan, Problem
from floorplan.files.documents import Document, read_yaml
from floorplan.files.problems import Fault, Place, suggestion
from floorplan.files.reading import is_there
from floorplan.loading import build as build_floor

from ..core.custom_code import CodeFolder, OwnCodeError
from ..core.scenario import PersonEntry, Scenario, TrialError, spot
from ..core.schedule import DoorTimes, Interval
from ..core.stage import MachineEntry
from ..machines.agv.model import MOST_MOVES, number_of
from ..machines.gantry.controllers import CONTROLLER
from ..machines.gantry.robot import GANTRY
from ..machines.kinds import KINDS, far_laws, is_own
from ..machines.rated import find_program
from ..machines.supervision import ControllerError
from ..people.programs import load_program, modules_of
from ..people.tracks.recorded_walks import bodies_of
from .checks import faults, keep_sound
from .feasibility import people_fault
from .field_checks import field_slips
from .keys import DerivedKeys, PersonKeys, TrialKeys, commanded, read_keys
from .reachability import unreachable_stations
from .rules_file import build_rules
from .writing import out_of_reach

_Made = TypeVar("_Made", bound=Scenario)


def lasting(trial: _Made, seconds: float) -> _Made:
    """Return the trial with this duration (s), without entries that would begin after its end."""
    if seconds >= trial.duration:
        return replace(trial, duration=seconds, until_submitted=False)
    timed = ((one, _begun(one.there, seconds)) for one in trial.obstacles)
    return replace(
        trial.with_people(lambda person: _of_person(person, seconds)),
        duration=seconds,
        until_submitted=False,
        warm_up=trial.warm_up if trial.warm_up < seconds else 0.0,
        work={
            name: replace(work, tasks=tuple(task for task in work.tasks if task.time < seconds))
            for name, work in trial.work.items()
        },
        doors={name: _of_door(times, seconds) for name, times in trial.doors.items()},
        obstacles=tuple(replace(one, there=there) for one, there in timed if there),
    )


def _of_person(person: PersonEntry, end: float) -> PersonEntry:
    return replace(
        person,
        schedule=tuple(task for task in person.schedule if task.time < end),
        breaks=tuple(task for task in person.breaks if task.time < end),
        shifts=_begun(person.shifts, end),
    )


def _of_door(times: DoorTimes, end: float) -> DoorTimes:
    closed, opened = (
        None if spans is None else _begun(spans, end) for spans in (times.closed, times.open)
    )
    return DoorTimes(closed, opened)


def _begun(intervals: tuple[Interval, ...], end: float) -> tuple[Interval, ...]:
    return tuple(one for one in intervals if one[0] < end)


FASTEST = 4.0
"""m/s. Largest plausible walking speed."""

VISITOR = "visitor"
"""Built-in personality that goes to its sink."""


def likely_slips(trial: Scenario, document: Document) -> tuple[Problem, ...]:
    """Return notices of likely mistakes: unknown names, unused sinks and implausible numbers.

    Names in rule sets and floors of separate files may belong to other trials, and are skipped.
    """
    faults = [*_laws(trial, document.data.get("rules")), *_places(trial, document.data)]
    entries = document.data.get("people") or ()
    faults += [*_sinks(trial, entries), *_speeds(entries), *_far_laws(trial)]
    faults += [(message, ("fields", *place)) for message, place in field_slips(trial)]
    faults += unreachable_stations(trial)
    return tuple(document.problem(message, *place) for message, place in faults)


def _laws(trial: Scenario, rules: Any) -> Iterator[Fault]:
    """Yield the laws for unknown machines and kinds."""
    if not isinstance(rules, dict) or any(is_own(entry) for entry in trial.machines.values()):
        return  # custom code defines the kind of its machine
    lanes = [lane.name for lane in trial.floorplan.lanes]
    machines = [*([GANTRY] if trial.floorplan.gantry else []), *lanes, *trial.machines]
    names = dict.fromkeys((*machines, *KINDS))
    for name in rules.get("laws", ()):
        if name not in names:
            hint = suggestion(name, names)
            yield f"no machine and no kind is called {name!r}; {hint}", ("rules", "laws", name)


def _speeds(entries: Iterable[dict[str, Any]]) -> Iterator[Fault]:
    """Yield implausible walking speeds."""
    for k, keys in enumerate(entries):
        speed = keys.get("max_speed")
        if isinstance(speed, int | float) and speed > FASTEST:
            message = f"{speed:g} m/s are {3.6 * speed:g} km/h, and nobody walks so fast"
            yield message, ("people", k, "max_speed")


def _far_laws(trial: Scenario) -> Iterator[Fault]:
    """Yield the laws whose distances are larger than the floor."""
    for key, metres in far_laws(trial).items():
        message = f"{key} asks for {metres:,.0f} m, far more than the floor is long"
        yield f"{message}; its terms are in seconds and metres", ("rules", *key.split("."))


def _sinks(trial: Scenario, entries: Iterable[dict[str, Any]]) -> Iterator[Fault]:
    """Yield sinks away from stations of people who only visit stations."""
    stations = {station.position for station in trial.floorplan.patrolled}
    for k, keys in enumerate(entries):
        personality = keys.get("personality", PersonEntry.personality)
        if "sink" not in keys or personality == VISITOR or personality not in bdi.programs():
            continue
        if spot(trial.floorplan, keys["sink"]) not in stations:
            message = f"no station is there, and {personality} people go to no other place"
            yield f"{message}; those of the personality {VISITOR} do", ("people", k, "sink")


def _places(trial: Scenario, data: dict[str, Any]) -> Iterator[Fault]:
    """Yield the zones and gates with names or patterns that match no person or machine."""
    floor = data["floorplan"]
    if not isinstance(floor, dict):
        return
    bodies = [person.name for person in trial.people]
    bodies += [lane.name for lane in trial.floorplan.lanes] + [*trial.machines]
    for key, places in (("zones", trial.floorplan.zones), ("gates", trial.floorplan.gates)):
        for place in places:
            if place.name not in floor.get(key, ()):
                continue
            for k, pattern in enumerate(place.concerns):
                alone = replace(place, concerns=(pattern,))
                if bodies and not any(map(alone.is_about, bodies)):
                    message = f"nobody is called {pattern!r}; {suggestion(pattern, bodies)}"
                    yield message, ("floorplan", key, place.name, "concerns", k)


def build(form: type[_Made], document: Document, code: CodeFolder) -> _Made:
    """Return the trial in `document`, with its code in a folder. Errors as of `Trial.load`."""
    if is_ariac(document):
        from ..orders import reading

        return replace(reading.build(form, document, code.path), own_code=code.allowed)
    if other := _something_else(document):
        raise TrialError(document.file, [Problem(f"is {other}")])
    schema = read_keys(document)
    _refuse_crowds(schema, document)
    folder = code.path / schema.folder
    name = Path(document.file).name.split(".")[0] if schema.name is None else schema.name
    plan = _floorplan(schema.floorplan, folder, document, name)
    lanes = {lane.name: lane for lane in plan.lanes}
    alike = {key.name for key in fields(Scenario)} & TrialKeys.model_fields.keys()
    values: dict[str, Any] = {name: getattr(schema, name) for name in alike}
    duration = values["duration"]
    moves = sum(number_of(agv.moves, duration) for agv in schema.agvs.values())
    if moves > MOST_MOVES:
        lanes = {}  # not expanded, because they are rejected
    people = people_of(schema.people, values["actions"], folder)
    rules, rule_problems = build_rules(schema.rules, document, replace(code, path=folder), "rules")
    values |= {
        "floorplan": plan,
        "name": name,
        "rules": rules,
        "people": tuple(person for many in people for person in many),
        "agvs": {
            name: agv.moves_until(duration, lanes.get(name)) for name, agv in schema.agvs.items()
        },
        "yielding": frozenset(name for name, agv in schema.agvs.items() if agv.yields),
        "machines": {name: _machine(keys) for name, keys in schema.machines.items()},
        "folder": folder,
        "floorplan_source": schema.floorplan if isinstance(schema.floorplan, str) else "",
        "until_submitted": bool(schema.until_submitted),
        "obstacles": tuple(schema.obstacles.values()),
        "commands": () if isinstance(schema.commands, str) else schema.commands,
    }
    trial = form(**values, own_code=code.allowed)
    if schema.ariac is not None:
        trial = _with_orders(trial, schema, schema.ariac, document)
    if isinstance(schema.commands, str):
        trial = commanded(trial, _named_file(folder, schema.commands, document, "commands"))
    owners = [k for k, many in enumerate(people) for _ in many]
    problems = [*rule_problems, *_problems(trial, document, owners)]
    if fault := out_of_reach(trial, code.path):
        problems.append(document.problem(fault, "folder"))
    if problems:
        raise TrialError(document.file, problems)
    trial = replace(trial, notices=(*trial.notices, *likely_slips(trial, document)))
    keep_sound(trial)
    return trial


ARIAC_KEYS = {"time_limit", "kitting_trays", "parts", "orders"}
"""Keys that only trial files of the ARIAC competition have."""


def is_ariac(document: Document) -> bool:
    """Return True if a document is a trial file of the ARIAC competition."""
    data = document.data
    return isinstance(data, dict) and "floorplan" not in data and not ARIAC_KEYS.isdisjoint(data)


def _refuse_crowds(schema: DerivedKeys, document: Document) -> None:
    """Raise `TrialError` if there are more people than the budget allows, before creating them."""
    if fault := people_fault(person.many or 1 for person in schema.people):
        k, message = fault
        person = schema.people[k]
        key = ("count",) if person.count else ("source", "count") if person.source else ()
        raise TrialError(document.file, [document.problem(message, "people", k, *key)])


def _something_else(document: Document) -> str:
    """Return the kind of a file that is no trial, and its relation to trials, or an empty text."""
    keys = {*document.data} if isinstance(document.data, dict) else set()
    if "floorplan" in keys:
        return ""
    if "trials" in keys:
        return "a study, not a trial; `floorwalker study` runs it"
    if keys & {"boundary", "base", "image"}:
        return "a floorplan, not a trial; a trial names it as its `floorplan`"
    return ""


def _with_orders(trial: _Made, schema: DerivedKeys, name: str, document: Document) -> _Made:
    """Return the trial with the orders, parts and challenges of an ARIAC trial file."""
    from ..orders import reading

    orders = read_yaml(_named_file(trial.folder, name, document, "ariac"), TrialError)
    workload, notices = reading.read_workload(orders, trial.floorplan)
    keys = schema.model_fields_set
    until_submitted = schema.until_submitted
    return replace(
        trial,
        workload=replace(workload, source=name),
        notices=notices,
        people=trial.people if "people" in keys else reading.people_of(workload),
        duration=trial.duration if "duration" in keys else reading.duration_of(workload),
        until_submitted="duration" not in keys if until_submitted is None else until_submitted,
    )


def people_of(
    entries: Sequence[PersonKeys], actions: str | None, folder: Path
) -> list[list[PersonEntry]]:
    """Return the people of each entry, with programs from `folder` if they exist.

    Each program is read once for all of its people.
    """
    people = [
        [one for person in keys.values() for one in bodies_of(person, folder)] for keys in entries
    ]
    named = [
        (personality, keys.actions)
        for keys in entries
        for personality in (keys.personality, *(change.personality for change in keys.changes))
    ]
    for personality, own in dict.fromkeys(named):
        # A missing program is reported together with all other faults.
        with suppress(TrialError, OwnCodeError):
            load_program(personality, CodeFolder(folder), modules_of(own, actions))
    return people


def _machine(keys: dict[str, Any]) -> MachineEntry:
    return MachineEntry(str(keys.get("kind", "")), {k: v for k, v in keys.items() if k != "kind"})


def _named_file(folder: Path, name: str, document: Document, key: str) -> Path:
    """Return the path of the file named by a key. `TrialError` if it does not exist."""
    path = folder / name
    if not is_there(path):
        raise TrialError(document.file, [document.problem(f"no such file: {name!r}", key)])
    return path


def _floorplan(
    name: str | dict[str, Any], folder: Path, document: Document, trial: str
) -> Floorplan:
    if not isinstance(name, str):
        return build_floor(document.part("floorplan"), folder, trial)
    if name in floorplan.builtin():
        return floorplan.load(name)
    path = folder / name
    if not is_there(path):
        message = (
            f"no such file, nor a built-in floorplan: {name!r};"
            f" {suggestion(name, floorplan.builtin())}"
        )
        raise TrialError(document.file, [document.problem(message, "floorplan")])
    return floorplan.load(path)


def _problems(trial: Scenario, document: Document, owners: list[int]) -> Iterator[Problem]:
    """Yield the problems of a trial beyond its keys and types, such as unknown names.

    `owners` are the numbers of the entries of people in the file.
    """
    problems = (
        document.problem(text, *_in_file(at, document.data, owners))
        for text, at in faults(trial, was_read=True)
    )
    yield from dict.fromkeys(problems)  # an entry that is many people has its faults but once
    if trial.floorplan.gantry is not None:
        try:
            find_program(trial.gantry.controller, trial.gantry.rate, CONTROLLER, trial.code_folder)
        except ControllerError as why:
            yield document.problem(str(why), "gantry", "controller")


def _in_file(place: Place, data: Any, owners: list[int]) -> Place:
    """Return the place in the file. Moves and tasks may have a key, and people share entries."""
    match place:
        case ("agvs", name, int(k), key) if not isinstance(data["agvs"][name], list):
            return ("agvs", name, "moves", k, key)
        case ("work", name, "tasks", *key) if isinstance(data["work"][name], list):
            return ("work", name, *key)
        case ("people", int(k), *key) if isinstance(data.get("people"), list):
            return ("people", owners[k], *key)
    return place
