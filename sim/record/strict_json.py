"""JSON as it is defined, with figures that can be reckoned with."""

from __future__ import annotations

from typing import Any

from pydantic_core import from_json

from floorplan import UserError

LARGEST = 1e30
"""No figure of a run is larger; with much larger ones nothing could be worked out."""


def parse_json(text: str) -> Any:
    """Return the value in `text`; `ValueError` if it is no JSON, or has a larger number."""
    value = from_json(text, allow_inf_nan=False)
    _require_figures(value)
    return value


def _require_figures(value: Any) -> None:
    if isinstance(value, dict):
        value = [*value.values()]
    if isinstance(value, list):
        for inner in value:
            _require_figures(inner)
    elif isinstance(value, int | float) and abs(value) > LARGEST:
        raise UserError(f"a number is larger than {LARGEST:g}")
