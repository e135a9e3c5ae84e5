"""Trials written as YAML text from which the same trial can be read."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

import floorplan
from floorplan import UserError
from floorplan.files.documents import yaml_text
from floorplan.files.forms import Data, written
from floorplan.plan import floor_keys
from navigation import FieldSet, Motion
from navigation.catalog import PlannerChoice

from ..core.entries import Command, OrderedWork, Start
from ..core.fields import keys_of_set
from ..core.scenario import (
    USUAL_PLANNER,
    Job,
    PersonalityChange,
    PersonEntry,
    Scenario,
    controller_name,
)
from ..core.schedule import Duration
from ..core.stage import MachineEntry
from ..machines.amr.controllers import VEHICLE_CONTROLLERS
from ..machines.gantry.controllers import CONTROLLERS
from ..machines.kinds import KINDS
from ..people.programs import written_personality
from .keys import TrialKeys
from .names import own_names
from .rules_file import written_rules


def out_of_reach(trial: Scenario, folder: Path) -> str:
    """Return why a file in `folder` cannot hold `trial`, or an empty text.

    Custom code must be in the folder of the trial file, or in a folder below or above it, so that
    no file names installed or unrelated code.
    """
    here, there = folder.resolve(), trial.folder.resolve()
    names = ", ".join(own_names(trial))
    if not names or here.is_relative_to(there) or there.is_relative_to(here):
        return ""
    return f"its code, {names}, stands in {there}: so does a trial that names it, or below"


def to_yaml(trial: Scenario, folder: Path) -> str:
    """See `Trial.to_yaml`."""
    data = _trial(trial)
    if fault := out_of_reach(trial, folder):
        raise UserError(f"the trial {trial.name!r} can't be written into {folder}: {fault}")
    if trial.folder.resolve() != folder.resolve():
        data["folder"] = Path(os.path.relpath(trial.folder, folder)).as_posix()
    return yaml_text(data)


def _trial(trial: Scenario) -> Data:
    special: Data = {
        "folder": None,
        "floorplan": _floorplan(trial),
        "rules": written_rules(trial.rules),
        "planner": None if trial.planner == USUAL_PLANNER else _value(trial.planner, trial),
        "gantry": _value(
            replace(
                trial.gantry,
                controller=_controller(trial.gantry.controller, "gantry", trial),
            ),
            trial,
        ),
        "agvs": {
            name: _agv(trial, name)
            for name in (*trial.agvs, *sorted(trial.yielding - {*trial.agvs}))
        },
        "machines": {name: _machine(name, entry, trial) for name, entry in trial.machines.items()},
        "until_submitted": trial.until_submitted or None,
        "obstacles": {one.obstacle.name: _value(one, trial) for one in trial.obstacles},
        "warm_up": trial.warm_up or None,
        "traffic": None if trial.traffic else False,
        "expect": trial.expect,
    }
    order = dict.fromkeys(("name", *(field.name for field in fields(Scenario))))
    data: Data = {
        key: special[key] if key in special else _value(getattr(trial, key), trial)
        for key in order
        if key in TrialKeys.model_fields
    }
    data = _without(data, None, [], {})
    return data if trial.workload is None else data | _orders(trial, trial.workload)


def _orders(trial: Scenario, workload: OrderedWork) -> Data:
    """Return the keys of the orders, and the keys that would otherwise come from the order file."""
    if not workload.source:
        raise UserError(
            f"the trial {trial.name!r} can't be written: its orders came from no file; give source"
        )
    return {
        "duration": trial.duration,
        "people": _value(trial.people, trial),
        "ariac": workload.source,
        "until_submitted": trial.until_submitted,
    }


def _floorplan(trial: Scenario) -> str | Data:
    """Return the name or file of the floorplan, or its keys if it has no file."""
    if trial.floorplan_source:
        return trial.floorplan_source
    plan = trial.floorplan
    if plan.name in floorplan.builtin() and floorplan.load(plan.name) == plan:
        return plan.name
    floorplan.check(plan)
    return floor_keys(plan)


def command_keys(command: Command) -> Data:
    """Return the keys of a command in a file."""
    return written(command, write=_plain)


def _personality(one: PersonEntry | PersonalityChange, trial: Scenario) -> str:
    try:
        return written_personality(one.personality, trial.folder)
    except UserError as why:
        raise UserError(
            f"the trial {trial.name!r} can't be written: the program {one.personality_name!r} {why}"
        ) from None


def _value(value: Any, trial: Scenario) -> Any:
    """Return the value of a field in the form of a file."""
    match value:
        case Job() | Duration():
            return value.written()
        case FieldSet():
            return keys_of_set(value)
        case Motion():
            raise UserError(
                f"the trial {trial.name!r} can't be written: a recorded motion came from no file"
            )
        case Start():
            return _fields(value, trial) if value.time is None else {"time": value.time}
        case PersonEntry() | PersonalityChange():
            return _fields(replace(value, personality=_personality(value, trial)), trial)
        case PlannerChoice():
            return _planner(value, trial)
        case (begin, math.inf):
            return [begin]
        case tuple():
            return [_value(one, trial) for one in value]
        case dict():
            return {name: _value(one, trial) for name, one in value.items()}
        case _ if is_dataclass(value):
            return _fields(value, trial)
    return value


def _fields(value: Any, trial: Scenario) -> Data:
    """Return the keys of a value that differ from their defaults."""
    return written(value, write=lambda inner: _plain(_value(inner, trial)))


def _agv(trial: Scenario, name: str) -> Any:
    moves = _value(trial.agvs.get(name, ()), trial)
    return {"yield": True, "moves": moves} if name in trial.yielding else moves


def _machine(name: str, entry: MachineEntry, trial: Scenario) -> Data:
    kinds = [kind for kind, model in KINDS.items() if entry.kind in (kind, model)]
    if not (kinds or isinstance(entry.kind, str)):
        raise UserError(f"the machine {name!r} can't be written: give its kind by name")
    keys = dict(entry.keys)
    if callable(keys.get("controller")):
        keys["controller"] = _controller(keys["controller"], "vehicle", trial)
    return {"kind": kinds[0] if kinds else entry.kind, **keys}


def _planner(choice: PlannerChoice, trial: Scenario) -> Any:
    name = choice.name
    if choice.kind is not None:
        name = _found_again(choice.kind, choice.kind.__qualname__, "planner", trial)
    return {"name": name, **dict(choice.parameters)} if choice.parameters else name


def _controller(controller: str | Callable[[Any], Any], whose: str, trial: Scenario) -> str:
    """Return the name of a controller in a file. Raises `ValueError` if it has none."""
    if isinstance(controller, str):
        return controller
    for name, builtin in (*CONTROLLERS.items(), *VEHICLE_CONTROLLERS.items()):
        if builtin is controller:
            return name
    return _found_again(controller, controller_name(controller), f"{whose} controller", trial)


def _found_again(made: Any, name: str, kind: str, trial: Scenario) -> str:
    """Return the name with which a function or class in the trial's folder is imported again."""
    folder = trial.folder.resolve()
    module = sys.modules.get(getattr(made, "__module__", ""))
    file = getattr(module, "__file__", None)
    # A script that is imported by name runs again as another module.
    is_script = module is sys.modules["__main__"]
    if file and not is_script and getattr(module, name, None) is made:
        path = Path(file).resolve().with_suffix("")
        path = path.parent if path.name == "__init__" else path
        if path.is_relative_to(folder):
            return f"{'.'.join(path.relative_to(folder).parts)}:{name}"
    raise UserError(
        f"the trial {trial.name!r} can't be written: its {kind} {name} is in no module"
        f" in its folder, {folder}; put it into a file there, and give its name, as in"
        " 'mine:shy' for the function shy in mine.py"
    )


def _without(data: Data, *usual: object) -> Data:
    """Return `data` without keys with the `usual` values."""
    return {key: value for key, value in _plain(data).items() if value not in usual}


def _plain(value: Any) -> Any:
    """Return `value` with lists and Python's own numbers instead of tuples and NumPy's."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Mapping):
        return {key: _plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(inner) for inner in value]
    return float(value) if isinstance(value, float) else value
