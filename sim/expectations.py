"""What a trial expects of its run, checked against the summary.

An expectation is a field of the summary and what it should be: a number, a comparison such as
">= 1.0", or for `visits` the stations in the order of the first visits. A field of one person
is found by its bare name where the trial has one person, or as `people.NAME.field`.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from .rules import suggestion

FIELDS = ("penalties", "agv_teleports", "gantry_disabled_time", "jobs_done", "minimum_separation")
PERSON_FIELDS = ("visits", "distance_walked", "time_standing", "replans", "minimum_separation")

_COMPARISON = re.compile(r"\s*(<=|>=|==|!=|<|>)\s*([-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?)\s*")
_OPERATORS: dict[str, Callable[[float, float], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}


def expectation_problems(expect: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """What can't be checked in `expect`: a message and the key it stands at."""
    for key, wanted in expect.items():
        field = key.rsplit(".", 1)[-1]
        if field not in FIELDS + PERSON_FIELDS:
            yield f"the summary has no such field; {suggestion(key, FIELDS + PERSON_FIELDS)}", key
        elif field == "visits":
            if not (isinstance(wanted, list) and all(isinstance(one, str) for one in wanted)):
                yield f"expected a list of stations, found {wanted!r}", key
        elif isinstance(wanted, str):
            if not _COMPARISON.fullmatch(wanted):
                yield f"expected a number or a comparison such as '>= 1.0', found {wanted!r}", key
        elif isinstance(wanted, bool) or not isinstance(wanted, int | float):
            yield f"expected a number or a comparison such as '>= 1.0', found {wanted!r}", key


def unmet(expect: Mapping[str, Any], summary: Mapping[str, Any]) -> list[str]:
    """The expectations that `summary` does not meet, each in words."""
    return [
        f"expected {key} {_shown(wanted)}, but it is {found}"
        for key, wanted in expect.items()
        for found in [_found(key, summary)]
        if not _met(wanted, found)
    ]


def _found(key: str, summary: Mapping[str, Any]) -> Any:
    people = summary["people"]
    if key.startswith("people."):
        name, _, field = key.removeprefix("people.").rpartition(".")
        value = people.get(name, {}).get(field)
    elif key in summary:
        value = summary[key]
    else:
        value = next(iter(people.values()))[key] if len(people) == 1 else None
    return value["distance"] if isinstance(value, Mapping) else value


def _met(wanted: Any, found: Any) -> bool:
    if found is None:
        return False
    if isinstance(wanted, list):
        return bool(found[: len(wanted)] == wanted)
    if isinstance(wanted, str) and (comparison := _COMPARISON.fullmatch(wanted)):
        return _OPERATORS[comparison[1]](found, float(comparison[2]))
    return bool(found == wanted)


def _shown(wanted: Any) -> str:
    if isinstance(wanted, list):
        return f"to begin with {wanted}"
    return wanted if isinstance(wanted, str) else f"= {wanted}"
