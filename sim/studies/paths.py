"""Figures of a trial by their paths: `rules.gantry_law.t1`, `people.eve.noticing.field_of_view`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any

from floorplan import UserError, check, require_fields, suggestion

from ..core.machine_model import MachineEntry
from ..core.numbers import is_number
from ..machines.kinds import keys_of
from ..trials.trial import Trial

ROOTS = ("rules", "people", "gantry", "machines", "floorplan")
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
