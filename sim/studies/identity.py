"""Identity of a study: digests of all inputs that decide its results."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator
from dataclasses import asdict, fields, is_dataclass
from importlib.metadata import version
from typing import Any

from shapely.geometry.base import BaseGeometry

from floorplan.model import LEFT_OUT_IF_EMPTY

from ..core.custom_code import CodeFolder, is_ours
from ..core.entries import RecordedTrack
from ..core.scenario import PersonalityChange, PersonEntry, controller_name
from ..machines.gantry.controllers import CONTROLLERS, controller_source
from ..machines.kinds import KINDS, is_own, own_kind
from ..people.crowd.custom_steering import STEERING
from ..people.programs import load_program, modules_of, planner_of, planner_source, sources_of
from ..people.tracks.track_files import files_of
from ..safety.laws import LAW, OwnLaw, laws_in
from ..trials.trial import Trial
from .code_files import digest_of_code, digest_of_source
from .design import Study


def identity(study: Study) -> dict[str, str]:
    """Return the digests of all inputs that decide the results of `study`, by name."""
    digests = {"floorwalker": version("floorwalker"), "the study": digest(_definition(study))}
    for trial in study.trials:
        digests[f"the trial {trial.name}"] = digest(trial.to_yaml(trial.folder))
    return digests | parts(one.trial for one in study.combinations)


def parts(trials: Iterable[Trial]) -> dict[str, str]:
    """Return the digests of files and code that trials name, such as floorplans and controllers.

    Parts with the same name, for example from several folders, have one digest.
    """
    named: dict[str, dict[str, None]] = {}
    for trial in trials:
        for what, content in _parts(trial):
            named.setdefault(what, {})[content] = None
    return {
        what: digest(" ".join(all_found)) if len(all_found) > 1 else next(iter(all_found))
        for what, all_found in named.items()
    }


def _definition(study: Study) -> str:
    return json.dumps(
        [
            [trial.name for trial in study.trials],
            [[what.name, values] for what, values in study.grid.items()],
            [[what.name, _whole(distribution)] for what, distribution in study.random.items()],
            study.repeat,
            study.seed,
            study.metrics,
        ]
    )


def _whole(value: object) -> str:
    """Return the text of a value with all fields of its dataclasses, which `repr` abbreviates."""
    match value:
        case tuple():
            return f"({', '.join(map(_whole, value))}{',' * (len(value) == 1)})"
        case dict():
            return f"{{{', '.join(f'{key!r}: {_whole(one)}' for key, one in value.items())}}}"
        case _ if is_dataclass(value):
            inside = (f"{one.name}={_whole(getattr(value, one.name))}" for one in fields(value))
            return f"{type(value).__qualname__}({', '.join(inside)})"
    return repr(value)


def _parts(trial: Trial) -> Iterator[tuple[str, str]]:
    plan = trial.floorplan
    empty = {name for name in LEFT_OUT_IF_EMPTY if not getattr(plan, name)}
    facts = {k: value for k, value in asdict(plan).items() if k not in {"notices", *empty}}
    yield f"the floorplan {plan.name}", digest(json.dumps(facts, default=_wkt))
    for person in trial.people:
        yield from _of_person(person, trial)
    tracks = [one.recorded for one in trial.people if isinstance(one.recorded, RecordedTrack)]
    for file in dict.fromkeys(track.file for track in tracks):
        content = hashlib.sha256()
        for part in files_of(trial.folder / file):
            content.update(part.read_bytes())
        yield f"the track {file}", content.hexdigest()[:16]
    if trial.workload is not None:
        yield f"the orders of {trial.name}", digest(_whole(trial.workload))
    if trial.steering is not None:
        steering = trial.code_folder.find(trial.steering, STEERING)
        yield f"the steering {trial.steering}", digest_of_source(steering)
    for law in laws_in(trial.rules):
        if isinstance(law, OwnLaw):
            source = CodeFolder(law.folder, trial.own_code).find(law.name, LAW)
            yield f"the law {law.name}", digest_of_source(source)
        elif not is_ours(law):
            yield f"the law {type(law).__qualname__}", digest_of_code(law)
    yield from _of_machines(trial)


def _of_person(person: PersonEntry, trial: Trial) -> Iterator[tuple[str, str]]:
    modules = modules_of(person.actions, trial.actions)
    named: list[PersonEntry | PersonalityChange] = [person, *person.changes]
    for one in named:
        program = load_program(one.personality, trial.code_folder, modules)
        yield f"the program {one.personality_name}", digest(str(program))
        if program is not None:
            for module in sources_of(program, modules, trial.code_folder):
                yield f"the actions {module.module}", digest_of_source(module)
    choice = planner_of(person, trial)
    source = planner_source(choice, trial.code_folder)
    if source is not None:
        yield f"the planner {choice.name}", digest_of_source(source)
    elif choice.kind is not None:
        yield f"the planner {choice.name}", digest_of_code(choice.kind)


def _of_machines(trial: Trial) -> Iterator[tuple[str, str]]:
    """Yield the controllers of all machines, and custom kinds of machines."""
    folder = trial.code_folder
    controllers: list[Any] = [] if trial.floorplan.gantry is None else [trial.gantry.controller]
    for name, entry in trial.machines.items():
        if is_own(entry):
            yield f"the machine {name}", digest_of_source(own_kind(entry, folder))
            usual = None
        else:
            kind = KINDS[entry.kind] if isinstance(entry.kind, str) else entry.kind
            usual = getattr(kind, "controller", None)
            if kind not in KINDS.values():
                yield f"the machine {name}", digest_of_code(kind)
        controllers += [one for one in [entry.keys.get("controller", usual)] if one is not None]
    for controller in controllers:
        name = f"the controller {controller_name(controller)}"
        if (source := controller_source(controller, folder)) is not None:
            yield name, digest_of_source(source)
        else:
            yield name, digest_of_code(CONTROLLERS.get(controller, controller))


def digest(text: str) -> str:
    """Return the first 64 bits of the SHA-256 of a text."""
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _wkt(value: object) -> str:
    assert isinstance(value, BaseGeometry)  # the only values of a floorplan that JSON lacks
    return str(value.wkt)
