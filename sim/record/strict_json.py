"""JSON as it is defined, with figures that can be reckoned with."""

from __future__ import annotations

from typing import Any

from pydantic_core import from_json

from floorplan import UserError

LARGEST_OF_ALL = 1e30
"""No figure of a run is larger, coefficients and seeds among them."""


def parse_json(text: str) -> Any:
    """Return the value in `text`; `ValueError` if it is no JSON, or has a larger number."""
    value = from_json(text, allow_inf_nan=False)
    require_figures(value, LARGEST_OF_ALL)
    return value


def require_figures(value: Any, most: float) -> None:
    """Raise `UserError` if a number in `value`, or in what it holds, is not within ±`most`."""
    if isinstance(value, dict):
        value = [*value.values()]
    if isinstance(value, list):
        for inner in value:
            require_figures(inner, most)
    elif isinstance(value, int | float) and not abs(value) <= most:
        raise UserError(f"a number is larger than {most:g}")
