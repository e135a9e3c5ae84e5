"""Values of a trial by paths such as `people.ann.max_speed` or `blackouts.0.seconds`.

A part of a path is the name of a field, key or entry, the index of an entry, or `*` for all
entries. Names may contain dots.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass, replace
from functools import cache
from typing import Any, TypeVar

from floorplan import UserError
from floorplan.files.fields import Keyed
from floorplan.files.forms import form_keys
from floorplan.files.problems import suggestion

from ..core.entries import Start
from ..core.schedule import TimedObstacle, WorkList
from ..core.stage import MachineEntry

_Owner = TypeVar("_Owner")

ALL = "*"
"""Part of a path that matches all entries."""

OMITTED = {MachineEntry: "keys", WorkList: "tasks"}
"""Fields that a path may omit, because files omit them."""

Change = Callable[[Any, Any], Any]
"""Function that returns the new value for a value and the type of its field (None if it is in no
`Keyed`)."""


def value_at(owner: Any, path: str) -> Any:
    """Return the value at a path without `*`. `UserError` names a part that does not exist."""
    while path:
        key, path = _step(owner, path)
        owner = _inner(owner, key)
    return owner


def places(owner: Any, path: str, above: str = "") -> list[str]:
    """Return the paths without `*` that match `path`. `UserError` if there is none.

    `*` matches the entries that have the rest of the path.
    """
    if not path:
        return [above]
    head, _, rest = path.partition(".")
    if head == ALL and type(owner) in OMITTED:
        return places(owner, f"{OMITTED[type(owner)]}.{path}", above)
    if head != ALL:
        key, rest = _step(owner, path)
        return places(_inner(owner, key), rest, f"{above}.{key}".lstrip("."))
    matches, fault = [], UserError(f"there is nothing in {above!r}")
    for key in reversed(_names(owner).values()):
        try:
            matches.append(places(_inner(owner, key), rest, f"{above}.{key}"))
        except UserError as why:
            fault = why
    if not matches:
        raise fault
    return [place for of_one in reversed(matches) for place in of_one]


def changed(owner: _Owner, path: str, change: Change) -> _Owner:
    """Return the `owner` with changed values at all places of a path."""
    for place in places(owner, path):
        owner = _changed(owner, place, change, None)
    return owner


def with_value(owner: _Owner, path: str, value: Any) -> _Owner:
    """Return the `owner` with a value at all places of a path. `UserError` if there is none."""
    return changed(owner, path, lambda before, kind: value)


def _changed(owner: Any, path: str, change: Change, kind: Any) -> Any:
    if not path:
        return change(owner, kind)
    key, rest = _step(owner, path)
    value = _changed(_inner(owner, key), rest, change, _field_type(owner.__class__, key))
    if isinstance(key, int):
        return type(owner)(value if k == key else one for k, one in enumerate(owner))
    return {**owner, key: value} if isinstance(owner, Mapping) else replace(owner, **{key: value})


def _step(owner: Any, path: str) -> tuple[Any, str]:
    """Return the key of the first part of a path in its `owner`, and the rest of the path."""
    names = _names(owner)
    for name in sorted(names, key=len, reverse=True):
        if path == name or path.startswith(f"{name}."):
            return names[name], path[len(name) + 1 :]
    head, _, rest = path.partition(".")
    if isinstance(owner, tuple | list) and head.isdecimal() and int(head) < len(owner):
        return int(head), rest
    if type(owner) in OMITTED:
        return OMITTED[type(owner)], path
    hint = f"; {suggestion(head, [*names])}" if names else ""
    raise UserError(f"there is no {head!r}{hint}")


def _names(owner: Any) -> dict[str, Any]:
    """Return the keys of the entries of a value, by their names in a path."""
    if isinstance(owner, Mapping):
        return {str(key): key for key in owner}
    if isinstance(owner, tuple | list):
        named = [one.obstacle if isinstance(one, TimedObstacle) else one for one in owner]
        return {str(getattr(one, "name", k)): k for k, one in enumerate(named)}
    if not is_dataclass(owner):
        return {}
    starts_by_event = isinstance(owner, Start) and owner.time is None
    names = (field.name for field in fields(owner))
    return {name: name for name in names if not (starts_by_event and name == "time")}


def _inner(owner: Any, key: Any) -> Any:
    return getattr(owner, key) if is_dataclass(owner) else owner[key]


@cache
def _field_type(owner: type, key: Any) -> Any:
    """Return the type with which a field is read from a file, or None if files do not have it."""
    return dict(form_keys(owner)).get(key) if issubclass(owner, Keyed) else None
