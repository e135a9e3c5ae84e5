"""Whether a message is of its type: each field checked, those left out filled in with zeros."""

from __future__ import annotations

import math
from typing import Any

from .message_types import MESSAGES, Field, MessageType

_INTEGERS = {
    f"{sign}int{bits}": ((0, 2**bits - 1) if sign else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1))
    for sign in ("", "u")
    for bits in (8, 16, 32, 64)
}
_LONGEST_ARRAY = 10_000
"""Elements. The longest array in a message."""


class MessageError(ValueError):
    """A message that is not of its type; says at which field."""


def conform(type_: MessageType, message: Any) -> dict[str, Any]:
    """`message` as one of `type_`, complete; `MessageError` names the field that is wrong."""
    return _message(type_, message, "")


def blank(type_: MessageType) -> dict[str, Any]:
    """The message of that type with nothing in it."""
    return {field.name: _default(field) for field in type_.fields}


def _message(type_: MessageType, value: Any, place: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise MessageError(
            f"{place or 'the message'} should be a {type_.name}, not {_shown(value)}"
        )
    known = {field.name for field in type_.fields}
    for name in value:
        if name not in known:
            has = ", ".join(sorted(known)) or "none"
            raise MessageError(
                f"{type_.name} has no field {_shown(name)}{_at(place)} (there are: {has})"
            )
    return {
        field.name: _field(field, value[field.name], _join(place, field.name))
        if field.name in value
        else _default(field)
        for field in type_.fields
    }


def _field(field: Field, value: Any, place: str) -> Any:
    if not field.is_array:
        return _single(field.type, value, place)
    if not isinstance(value, list):
        raise MessageError(f"{place} should be a list of {field.type}, not {_shown(value)}")
    if len(value) > _LONGEST_ARRAY:
        raise MessageError(f"{place} has {len(value)} elements; {_LONGEST_ARRAY} is the most")
    return [_single(field.type, one, f"{place}[{k}]") for k, one in enumerate(value)]


def _single(type_: str, value: Any, place: str) -> Any:
    if "/" in type_:
        return _message(MESSAGES[type_], value, place)
    if type_ == "bool":
        if isinstance(value, bool):
            return value
    elif type_ == "string":
        if isinstance(value, str):
            return value
    elif isinstance(value, int | float) and not isinstance(value, bool):
        return _number(type_, value, place)
    raise MessageError(f"{place} should be a {type_}, not {_shown(value)}")


def _number(type_: str, value: int | float, place: str) -> int | float:
    if type_ in ("float32", "float64"):
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise MessageError(f"{place} is not a finite number")
        return number
    low, high = _INTEGERS[type_]
    if isinstance(value, float) and not value.is_integer():
        raise MessageError(f"{place} should be a whole number, not {_shown(value)}")
    if not low <= value <= high:
        raise MessageError(f"{place} = {_shown(value)} is outside {low} … {high}")
    return int(value)


def _default(field: Field) -> Any:
    if field.is_array:
        return []
    if "/" in field.type:
        return blank(MESSAGES[field.type])
    if field.type == "bool":
        return False
    if field.type == "string":
        return ""
    return 0.0 if field.type.startswith("float") else 0


def _join(place: str, name: str) -> str:
    return f"{place}.{name}" if place else name


def _at(place: str) -> str:
    return f" at {place}" if place else ""


def _shown(value: Any) -> str:
    """A value in an error: short, whatever it is."""
    if isinstance(value, dict):
        return "an object"
    if isinstance(value, list):
        return "a list"
    text = repr(value) if not isinstance(value, int) or abs(value) < 10**20 else "a huge number"
    return text if len(text) <= 60 else f"{text[:57]}…"
