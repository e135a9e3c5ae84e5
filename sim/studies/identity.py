"""Identity of a study's results: digests of all that they depend on."""

from __future__ import annotations

import hashlib
import inspect
import json
from collections.abc import Iterator
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path

from shapely.geometry.base import BaseGeometry

from floorplan import LEFT_OUT_IF_EMPTY

from ..core.recorded_track import RecordedTrack
from ..core.scenario import PersonalityChange, PersonEntry
from ..machines.gantry.controllers import controller_source, find_controller
from ..machines.kinds import is_own, own_kind
from ..people.own_actions import modules_of, sources_of
from ..people.planners import planner_of, planner_source
from ..people.programs import load_program
from ..people.steering.own_steering import steering_source
from ..people.tracks.bags import files_of
from ..trials.trial import Trial
from .study import Study


def identity(study: Study) -> dict[str, str]:
    """Digests of all that decides the results of `study`, by what it is."""
    found = {"floorwalker": version("floorwalker"), "the study": _digest(_definition(study))}
    for trial in study.trials:
        found[f"the trial {trial.name}"] = _digest(trial.to_yaml(trial.folder))
    for combination in study.combinations:
        found |= dict(_parts(combination.trial))
    return found


def _definition(study: Study) -> str:
    parts = [
        [trial.name for trial in study.trials],
        [[what.name, values] for what, values in study.grid.items()],
        [[what.name, repr(distribution)] for what, distribution in study.random.items()],
        study.repeat,
        study.seed,
        study.metrics,
    ]
    return json.dumps(parts)


def _parts(trial: Trial) -> Iterator[tuple[str, str]]:
    """Return what a trial names and doesn't contain: floorplan, programs, orders, controller."""
    plan = trial.floorplan
    empty = {name for name in LEFT_OUT_IF_EMPTY if not getattr(plan, name)}
    facts = {k: value for k, value in asdict(plan).items() if k not in {"notices", *empty}}
    yield f"the floorplan {plan.name}", _digest(json.dumps(facts, default=_wkt))
    for person in trial.people:
        modules = modules_of(person.actions, trial.actions)
        named: list[PersonEntry | PersonalityChange] = [person, *person.changes]
        for one in named:
            program = load_program(one.personality, trial.folder, modules, own_code=trial.own_code)
            yield f"the program {one.personality_name}", _digest(str(program))
            if program is not None:
                for module in sources_of(program, modules, trial.folder, own_code=True):
                    text = module.file.read_text(encoding="utf-8")
                    yield f"the actions {module.module}", _digest(text)
        if isinstance(person.recorded, RecordedTrack):
            track = hashlib.sha256()
            for part in files_of(trial.folder / person.recorded.file):
                track.update(part.read_bytes())
            yield f"the track {person.recorded.file}", track.hexdigest()[:16]
        choice = planner_of(person, trial)
        source = planner_source(choice, trial.folder)
        if source is not None:
            yield f"the planner {choice.name}", _digest(source.file.read_text(encoding="utf-8"))
    if trial.steering is not None:
        source = steering_source(trial.steering, trial.folder)
        yield f"the steering {trial.steering}", _digest(source.file.read_text(encoding="utf-8"))
    if trial.workload is not None:
        yield f"the orders of {trial.name}", _digest(repr(trial.workload))
    controller = trial.gantry.controller
    own = controller_source(controller, trial.folder)
    file = own.file if own else inspect.getsourcefile(find_controller(controller, trial.folder))
    if file is not None:
        name = trial.gantry.controller_name
        yield f"the controller {name}", _digest(Path(file).read_text(encoding="utf-8"))
    for name, entry in trial.machines.items():
        if is_own(entry):
            kind = own_kind(entry, trial.folder).file.read_text(encoding="utf-8")
            yield f"the machine {name}", _digest(kind)


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _wkt(value: object) -> str:
    assert isinstance(value, BaseGeometry)  # all else in a floorplan is plain
    return str(value.wkt)
