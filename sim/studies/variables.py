"""Variables of a study: keys and paths of a trial, and how a value is set."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from pathlib import Path
from typing import Any

from floorplan import UserError, check
from floorplan.files.problems import suggestion
from floorplan.files.reading import is_file
from floorplan.files.values import require_fields
from navigation.catalog import PlannerChoice

from ..core.custom_code import CodeFolder
from ..core.entries import Start, is_number
from ..core.scenario import Job, PersonEntry
from ..core.stage import MachineEntry
from ..machines.kinds import keys_of, with_controller
from ..people.programs import planner_source
from ..trials.building import lasting
from ..trials.rules_file import find_rules
from ..trials.trial import Trial

ROOTS = ("rules", "people", "gantry", "machines", "fields", "floorplan")
"""First parts of a path."""

OF_AXES = ("max_speed", "max_acceleration", "max_jerk")
"""Figures of the gantry that both of its axes along the floor have, as `gantry.max_speed`."""

EVERYBODY = "*"
"""The name that stands for all people, or all of what else has names."""


def put_at(trial: Trial, path: str, value: Any) -> Trial:
    """Return `trial` with `value` at `path`; `ValueError` says why there is no such figure."""
    parts = path.split(".")
    if parts[0] == "gantry" and parts[1:] and parts[1] in OF_AXES and len(parts) == 2:
        for axis in ("x", "y"):
            trial = put_at(trial, f"floorplan.gantry.{axis}.{parts[1]}", value)
        return trial
    changed: Trial = _put(_with_key(trial, parts, path), parts, value, path)
    law, before = changed.rules.gantry_law, trial.rules
    if before.notice.law.law == before.gantry_law != law:
        # People notice by the law itself unless the rules give another one, and still do.
        notice = replace(before.notice, law=replace(before.notice.law, law=law))
        changed = replace(changed, rules=replace(changed.rules, notice=notice))
    if changed.floorplan is not trial.floorplan:
        check(changed.floorplan)
        changed = replace(changed, floorplan_source="")
    try:
        require_fields(changed)
    except TypeError as why:
        raise UserError(str(why)) from None
    return changed


def _with_key(trial: Trial, parts: Sequence[str], path: str) -> Trial:
    """Return `trial` in which a machine of `machines` has the key at `path`, None if left out."""
    match parts:
        case ["machines", name, key] if name in trial.machines:
            entry = trial.machines[name]
            if key not in entry.keys:
                known = keys_of(entry, trial)
                if known is not None:
                    _require(key, known, path)
                entry = replace(entry, keys={**entry.keys, key: None})
                return replace(trial, machines={**trial.machines, name: entry})
    return trial


def _put(owner: Any, parts: Sequence[str], value: Any, path: str) -> Any:
    """Return `owner` with `value` where `parts` lead to."""
    if not parts:
        return _figure(owner, value, path)
    head, *rest = parts
    if isinstance(owner, MachineEntry):
        return replace(owner, keys=_put(owner.keys, parts, value, path))
    if is_dataclass(owner) and not isinstance(owner, type):
        names = [field.name for field in fields(owner)]
        _require(head, names, path)
        return replace(owner, **{head: _put(getattr(owner, head), rest, value, path)})
    if isinstance(owner, Mapping):
        if head == EVERYBODY and rest and owner and all(map(is_dataclass, owner.values())):
            return {name: _put(one, rest, value, path) for name, one in owner.items()}
        _require(head, [*owner], path)
        return {**owner, head: _put(owner[head], rest, value, path)}
    if isinstance(owner, tuple) and all(hasattr(one, "name") for one in owner):
        _require(head, [EVERYBODY, *(one.name for one in owner)], path)
        return tuple(
            _put(one, rest, value, path) if head in (EVERYBODY, one.name) else one for one in owner
        )
    raise UserError(f"there is no {'.'.join(parts)!r} at the end of {path!r}")


def _require(name: str, known: Sequence[str], path: str) -> None:
    if name not in known:
        hint = suggestion(name, known) if known else "there is nothing"
        raise UserError(f"there is no {name!r} in {path!r}; {hint}")


def _figure(before: Any, value: Any, path: str) -> Any:
    """Return `value` as it takes the place of the figure `before`."""
    if isinstance(before, bool) or isinstance(value, bool):
        if isinstance(before, bool) and isinstance(value, bool):
            return value
        if before is not None:
            form = "true or false" if isinstance(before, bool) else "a number"
            raise UserError(f"expected {form}")
    if is_number(before) or (before is None and is_number(value)):
        if not is_number(value):
            raise UserError(f"expected a finite number, found {value!r}")
        return float(value) if not isinstance(before, int) else value
    if is_dataclass(before) or isinstance(before, Mapping):
        raise UserError(f"{path!r} is no single figure")
    return value


Value = str | float | tuple[float, ...]
"""One value of a variable: a name, a number, or numbers that belong together."""

Change = Callable[[Trial, Any, str, Path], Trial]
"""Puts a value into a trial: for one person or AGV by name, or for all ("").

Files are seen from the folder. `ValueError` or `OSError` say why it can't be done.
"""


@dataclass(frozen=True)
class Variable:
    """One thing to vary: `max_speed` of everybody, or of one person (`whose`).

    Of kind "path" it is any figure of the trial, and `whose` is its path.
    """

    name: str
    kind: str
    whose: str = ""

    @property
    def is_controller(self) -> bool:
        """Whether its values are controllers."""
        return self.kind == "controller" or self.whose.endswith(".controller")

    def put(
        self, trial: Trial, value: Value, folder: Path, others: Iterable[Variable] = ()
    ) -> Trial:
        """`trial` with this value, which may be out of range; files are seen from `folder`.

        A value for everybody leaves out those for whom one of the `others` has its own.
        `ValueError` or `OSError` say why there is nothing to put it in, or what it should be.
        """
        changed = _CHANGES[self.kind](trial, value, self.whose, folder)
        own = {other.whose for other in others if other.kind == self.kind}
        return changed if self.whose else _spared(trial, changed, own)


def variable(name: str) -> Variable:
    """Return the variable called `name`. Raises `ValueError` that lists the known ones.

    A path is a variable whether or not there is something at its end: that depends on the trial.
    """
    if name in KINDS:
        return Variable(name, KINDS[name])
    group, _, rest = name.partition(".")
    whose, _, last = rest.rpartition(".")
    if whose and last in _PARTS.get(group, {}):
        return Variable(name, _PARTS[group][last], "" if whose == EVERYBODY else whose)
    if rest and group in ROOTS:
        return Variable(name, "path", name)
    if name == "seed":
        raise UserError("seeds are not varied: each of the runs of `repeat: N` has one of its own")
    known = [*KINDS, *(f"{g}.NAME.{last}" for g, parts in _PARTS.items() for last in parts)]
    paths = f"a path begins with one of {', '.join(ROOTS)}"
    raise UserError(f"nothing is called {name!r} to vary; {suggestion(name, known)}; {paths}")


def _personality(trial: Trial, value: Any, whose: str, folder: Path) -> Trial:
    name = _seen_from(trial.folder, folder, _text(value))
    everybody = trial.with_personality(name).people
    return _people(trial, whose, lambda person: everybody[trial.people.index(person)])


def _planner(trial: Trial, value: Any, whose: str, folder: Path) -> Trial:
    choice = PlannerChoice.of(_text(value))
    planner_source(choice, trial.code_folder)
    return _people(trial, whose, lambda person: replace(person, planner=choice))


def _max_speed(trial: Trial, value: Any, whose: str, folder: Path) -> Trial:
    speed = _number(value)
    return _people(trial, whose, lambda person: replace(person, max_speed=speed))


def _start_time(trial: Trial, value: Any, whose: str, folder: Path) -> Trial:
    time = _number(value)
    if not any(p.start.time is not None for p in trial.people if whose in ("", p.name)):
        raise UserError("no person in it starts at a time")
    return _people(
        trial,
        whose,
        lambda p: p if p.start.time is None else replace(p, start=Start(time=time)),
    )


def _controller(trial: Trial, value: Any, whose: str, folder: Path) -> Trial:
    return with_controller(trial, _text(value))


def _gantry_at(trial: Trial, value: Any, whose: str, folder: Path) -> Trial:
    x, y, rotation = _numbers(value, 3, "x, y and a rotation")
    return replace(trial, gantry=replace(trial.gantry, at=(x, y, rotation)))


def _job_order(trial: Trial, value: Any, whose: str, folder: Path) -> Trial:
    jobs = trial.gantry.jobs
    if value == "given":
        return trial
    if value == "reversed":
        order = reordered(jobs, lambda stretch: stretch[::-1])
    else:
        order = tuple(int(k) for k in _numbers(value, len(jobs), "the number of every job"))
    if sorted(order) != list(range(len(jobs))):
        raise UserError(
            f"expected given, reversed, or an order of 0 to {len(jobs) - 1}, found {value!r}"
        )
    return replace(trial, gantry=replace(trial.gantry, jobs=tuple(jobs[k] for k in order)))


def _agv_delay(trial: Trial, value: Any, whose: str, folder: Path) -> Trial:
    delay = _number(value)
    if whose and whose not in trial.agvs:
        raise UserError(f"no AGV called {whose!r} moves in it")
    if not trial.agvs:
        raise UserError("no AGV moves in it")
    agvs = {
        name: tuple(replace(move, time=max(move.time + delay, 0.0)) for move in moves)
        if whose in ("", name)
        else moves
        for name, moves in trial.agvs.items()
    }
    return replace(trial, agvs=agvs)


def _rules(trial: Trial, value: Any, whose: str, folder: Path) -> Trial:
    rules = find_rules(_text(value), CodeFolder(folder, trial.own_code))
    return replace(trial, rules=rules)


def _duration(trial: Trial, value: Any, whose: str, folder: Path) -> Trial:
    seconds = _number(value)
    return replace(lasting(trial, seconds), until_submitted=trial.until_submitted)


_CHANGES: dict[str, Change] = {
    "path": lambda trial, value, path, folder: put_at(trial, path, value),
    "personality": _personality,
    "planner": _planner,
    "max_speed": _max_speed,
    "start_time": _start_time,
    "controller": _controller,
    "gantry_at": _gantry_at,
    "job_order": _job_order,
    "agv_delay": _agv_delay,
    "rules": _rules,
    "duration": _duration,
}
KINDS = {kind: kind for kind in _CHANGES if kind != "path"}
"""Variables of a whole trial, by name."""

_PARTS = {
    "people": {kind: kind for kind in ("personality", "planner", "max_speed", "start_time")},
    "agvs": {"delay": "agv_delay"},
}


def reordered(jobs: tuple[Job, ...], arrange: Callable[[list[int]], list[int]]) -> tuple[int, ...]:
    """Return `jobs` with each stretch between submitted orders in a new order.

    An order is handed in when everything that stood before it is done, in any order of the jobs.
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


def _people(trial: Trial, whose: str, change: Callable[[PersonEntry], PersonEntry]) -> Trial:
    if not trial.people:
        raise UserError("there is no person in it")
    names = [person.name for person in trial.people]
    if whose not in ("", *names):
        raise UserError(f"no person in it is called {whose!r}; {suggestion(whose, names)}")
    return trial.with_people(lambda one: change(one) if whose in ("", one.name) else one)


def _spared(trial: Trial, changed: Trial, names: set[str]) -> Trial:
    """Return the `changed` trial with these people and AGVs as they were in `trial`."""
    people = tuple(
        before if before.name in names else after
        for before, after in zip(trial.people, changed.people, strict=True)
    )
    agvs = {name: trial.agvs[name] if name in names else changed.agvs[name] for name in trial.agvs}
    return replace(changed, people=people, agvs=agvs)


def _seen_from(trial_folder: Path, folder: Path, name: str) -> str:
    """Return the path of the file `name` beside the study from the trial, or `name` itself."""
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


def _numbers(value: Any, count: int, what: str) -> list[float]:
    if not isinstance(value, list | tuple) or len(value) != count:
        raise UserError(f"expected {what}, found {value!r}")
    return [_number(one) for one in value]
