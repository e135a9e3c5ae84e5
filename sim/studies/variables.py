"""Variables of a study: values of a trial by name or path, and how a value is set."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import fields, is_dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import PydanticSchemaGenerationError, TypeAdapter, ValidationError

from floorplan import UserError, check
from floorplan.files.dataclass import dataclass
from floorplan.files.problems import misfits, shown, suggestion
from floorplan.files.reading import is_file
from floorplan.files.values import require_fields

from ..core.custom_code import CodeFolder
from ..core.entries import is_number
from ..core.rules import RuleSet
from ..core.scenario import Job
from ..machines.kinds import keys_of, with_controller
from ..trials.building import lasting
from ..trials.keys import TrialKeys
from ..trials.paths import ALL, changed, places, value_at, with_value
from ..trials.rules_file import find_rules
from ..trials.trial import Trial

ALIASES = {
    "personality": "people.*.personality",
    "planner": "people.*.planner",
    "max_speed": "people.*.max_speed",
    "start_time": "people.*.start.time",
    "controller": "machines.*.controller",
    "gantry_at": "gantry.at",
    "job_order": "gantry.jobs",
    "agv_delay": "agvs.*.*.time",
}
"""Paths of the variables with a name."""

KINDS = (*ALIASES, "rules", "duration")
"""Variables of a whole trial, by name."""

OWN_NAMES = {
    re.compile(r"people\.(.+)\.start_time"): r"people.\1.start.time",
    re.compile(r"agvs\.(.+)\.delay"): r"agvs.\1.*.time",
}
"""Variables of one person or AGV whose names are not paths, and their paths."""

NOT_VARIED = {"name", "seed", "folder", "expect"}
"""Keys of a trial that studies do not vary."""

OF_AXES = re.compile(r"gantry\.(max_speed|max_acceleration|max_jerk)")
"""Values of the gantry that both horizontal axes have."""

OF_CONTROLLERS = ("controller", "rate")
"""Keys of a machine that belong to its controller."""

Value = str | float | tuple[float, ...]
"""Value of a variable: a name, a number, or several numbers that belong together."""


@dataclass(frozen=True)
class Variable:
    """A value to vary, by its path in the trial: for example `max_speed` of one person or all.

    A delay of an AGV is added to the times at its path. An order of jobs sorts them.
    """

    name: str
    path: str

    @property
    def is_controller(self) -> bool:
        """True if its values are controllers."""
        return self.path.endswith(".controller")

    def put(
        self, trial: Trial, value: Value, folder: Path, others: Iterable[Variable] = ()
    ) -> Trial:
        """Return `trial` with this value. Paths of files are relative to `folder`.

        The value may be out of range. A value for all entries does not replace those of entries for
        which one of the `others` has a value. `ValueError` or `OSError` if the trial has no such
        place, or if the value has the wrong type.
        """
        varied = self._put(trial, value, folder)
        for other in others:
            if other.path.count(ALL) < self.path.count(ALL):
                with suppress(UserError):  # the trial may not have it yet
                    for place in places(trial, other.path):
                        varied = with_value(varied, place, value_at(trial, place))
        return varied

    def _put(self, trial: Trial, value: Value, folder: Path) -> Trial:
        if self.name == "job_order":
            return replace(trial, gantry=replace(trial.gantry, jobs=_ordered(trial, value)))
        if self.path.endswith(".*.time") and self.path != self.name:
            delay = _number(value)
            return changed(trial, self.path, lambda time, kind: max(time + delay, 0.0))
        if self.path == "duration":
            return replace(lasting(trial, _number(value)), until_submitted=trial.until_submitted)
        if self.is_controller:
            machine = "" if self.name == "controller" else self.path.split(".")[-2]
            return with_controller(trial, _text(value), machine)
        if axes := OF_AXES.fullmatch(self.path):
            for axis in "xy":
                one = Variable(self.name, f"floorplan.gantry.{axis}.{axes[1]}")
                trial = one._put(trial, value, folder)
            return trial
        return _with(trial, self.path, value, folder)


def variable(name: str) -> Variable:
    """Return the variable called `name`. `ValueError` if there is none, with a list.

    A path is a variable even if the trial has no value there.
    """
    if name == "seed":
        raise UserError("seeds are not varied: each of the runs of `repeat: N` has one of its own")
    path = ALIASES.get(name, name)
    for form, meant in OWN_NAMES.items():
        path = form.sub(meant, path)
    roots = {field.name for field in fields(Trial)} & TrialKeys.model_fields.keys() - NOT_VARIED
    if path.partition(".")[0] in roots and name not in ("people", "gantry", "machines", "agvs"):
        return Variable(name, path)
    paths = f"a path begins with one of {', '.join(sorted(roots))}"
    raise UserError(f"nothing is called {name!r} to vary; {suggestion(name, KINDS)}; {paths}")


def without_controllers(trial: Trial) -> Trial:
    """Return `trial` without the controllers of its machines."""
    machines = {
        name: replace(one, keys={k: v for k, v in one.keys.items() if k not in OF_CONTROLLERS})
        for name, one in trial.machines.items()
    }
    return replace(trial, machines=machines, gantry=replace(trial.gantry, controller=""))


def _with(trial: Trial, path: str, value: Value, folder: Path) -> Trial:
    """Return `trial` with the value of a file at all places of a path."""
    if isinstance(value, str) and (folder / value).suffix:
        value = _seen_from(trial.folder, folder, value) if path != "rules" else value
    code = CodeFolder(folder, trial.own_code)
    varied = changed(
        _with_key(trial, path), path, lambda before, kind: _read(before, value, kind, code)
    )
    if path.endswith(".personality"):
        for place in places(trial, path.removesuffix("personality") + "changes"):
            varied = with_value(varied, place, ())
    law, before = varied.rules.gantry_law, trial.rules
    if path != "rules" and before.notice.law.law == before.gantry_law != law:
        # People notice by the gantry's law unless the rules give another law.
        notice = replace(before.notice, law=replace(before.notice.law, law=law))
        varied = replace(varied, rules=replace(varied.rules, notice=notice))
    if varied.floorplan is not trial.floorplan:
        check(varied.floorplan)
        varied = replace(varied, floorplan_source="")
    try:
        require_fields(varied)
    except TypeError as why:
        raise UserError(str(why)) from None
    return varied


def _with_key(trial: Trial, path: str) -> Trial:
    """Return `trial` with the key at `path` in its machine, None if it was omitted."""
    match path.split("."):
        case ["machines", name, key] if name in trial.machines:
            entry = trial.machines[name]
            if key not in ("kind", *entry.keys):
                all_keys = keys_of(entry, trial)
                if all_keys is not None and key not in all_keys:
                    raise UserError(f"there is no {key!r} in {path!r}; {suggestion(key, all_keys)}")
                entry = replace(entry, keys={**entry.keys, key: None})
                return replace(trial, machines={**trial.machines, name: entry})
    return trial


def _read(before: Any, value: Any, kind: Any, code: CodeFolder) -> Any:
    """Return the value of a study converted to the type of the field that it replaces."""
    if isinstance(before, RuleSet):
        return find_rules(_text(value), code)
    if is_number(before) and isinstance(value, str):
        raise UserError(f"expected a number, found {value!r}")
    if (form := _form(kind)) is not None:
        try:
            return form.validate_python(value)
        except ValidationError as why:
            raise UserError("; ".join(text for text, _ in misfits(why, object, value))) from None
    if isinstance(before, bool) is not isinstance(value, bool) and before is not None:
        raise UserError(f"expected {'true or false' if isinstance(before, bool) else 'a number'}")
    if isinstance(before, float):
        return _number(value)
    if is_dataclass(before) or isinstance(before, Mapping):
        raise UserError(f"a study varies single values, not {shown(before)}")
    return value


@cache
def _form(kind: Any) -> TypeAdapter[Any] | None:
    """Return the reader of a type, or None if it is no single value of a file."""
    try:
        return None if kind is None else TypeAdapter(kind)
    except PydanticSchemaGenerationError:
        return None


def _ordered(trial: Trial, value: Any) -> tuple[Job, ...]:
    """Return the gantry's jobs in the given order."""
    jobs = trial.gantry.jobs
    if value == "given":
        return jobs
    if value == "reversed":
        order = reordered(jobs, lambda stretch: stretch[::-1])
    else:
        order = tuple(int(_number(k)) for k in value) if isinstance(value, tuple) else (-1,)
    if sorted(order) != list(range(len(jobs))):
        raise UserError(
            f"expected given, reversed, or an order of 0 to {len(jobs) - 1}, found {value!r}"
        )
    return tuple(jobs[k] for k in order)


def reordered(jobs: tuple[Job, ...], arrange: Callable[[list[int]], list[int]]) -> tuple[int, ...]:
    """Return the order of `jobs` after `arrange` has sorted each stretch between submissions.

    An order is submitted when all jobs before it are done, in any order.
    """
    order: list[int] = []
    stretch: list[int] = []
    for k, job in enumerate(jobs):
        if job.kind == "submit":
            order += [*arrange(stretch), k]
            stretch = []
        else:
            stretch.append(k)
    return (*order, *arrange(stretch))


def _seen_from(trial_folder: Path, folder: Path, name: str) -> str:
    """Return the path of a file beside the study relative to the trial, or `name` without one."""
    path = folder / name
    if is_file(path) and trial_folder.resolve() != folder.resolve():
        return Path(os.path.relpath(path, trial_folder)).as_posix()
    return name


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise UserError(f"expected a name, found {value!r}")
    return value


def _number(value: Any) -> float:
    if not is_number(value):
        raise UserError(f"expected a finite number, found {value!r}")
    return float(value)
