"""JSON as it is defined: Python's own parser also takes NaN, infinities and numbers without end."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any, NoReturn

LARGEST = 1e30
"""No figure of a run is larger; with much larger ones nothing could be worked out."""


def parse_json(text: str, object_hook: Callable[[dict[str, Any]], Any] | None = None) -> Any:
    """Return the value in `text`; `ValueError` if it is no JSON, or asks for too much.

    `object_hook` makes something else of an object, as that of `json.loads`.
    """
    try:
        return json.loads(
            text,
            object_hook=object_hook,
            parse_constant=_refuse,
            parse_float=_finite,
            parse_int=_integer,
        )
    except RecursionError:
        raise ValueError("it is nested too deeply") from None


def _refuse(constant: str) -> NoReturn:
    raise ValueError(f"{constant} is no number in JSON")


def _finite(number: str) -> float:
    value = float(number)
    if abs(value) > LARGEST:
        raise ValueError(f"the number {number[:20]} is too large")
    return value


def _integer(number: str) -> int:
    if len(number) > 30:
        raise ValueError(f"the number {number[:20]}… is too large")
    return int(number)
