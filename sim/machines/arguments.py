"""Checks of the arguments of commands, whose errors name the argument."""

from __future__ import annotations

import math
from typing import TypeVar

from floorplan import UserError

T = TypeVar("T")


def number(name: str, value: object, low: float = -math.inf) -> float:
    """Return an argument as a float. `UserError` unless it is finite and at least `low`."""
    argument = float(value) if hasattr(value, "__float__") else math.nan
    if math.isfinite(argument) and argument >= low:
        return argument
    least = "" if low == -math.inf else f" of at least {low:g}"
    raise UserError(f"{name} must be a finite number{least}, not {value!r}")


def target(
    command: str, x: float, y: float, rotation: float | None, speed_share: float
) -> tuple[float, ...]:
    """Return the target of a command: x, y and the rotation, if there is one."""
    if not 0 < number(f"{command}(speed_share)", speed_share) <= 1:
        raise UserError(f"speed_share must be more than 0 and at most 1, not {speed_share}")
    at = number(f"{command}(x)", x), number(f"{command}(y)", y)
    return at if rotation is None else (*at, number(f"{command}(rotation)", rotation))


def instance(name: str, value: object, kind: type[T]) -> T:
    """Return an argument of this kind. `UserError` for another kind."""
    if not isinstance(value, kind):
        raise UserError(f"{name} must be a {kind.__name__}, not {value!r}")
    return value
