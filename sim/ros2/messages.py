"""Messages of ROS as values by field, and back."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import Any

from ..competition import Values


def values_of(message: Any) -> Any:
    """Return the values of a message by field. Nested messages are values by field, too."""
    if hasattr(message, "get_fields_and_field_types"):
        names = message.get_fields_and_field_types()
        return {name: values_of(getattr(message, name)) for name in names}
    if isinstance(message, str | bytes | bool | int | float):
        return message
    return [values_of(one) for one in message]


def filled(message: Any, values: Values) -> Any:
    """Set those fields that a message has in this distribution of ROS, and return it."""
    for name, value in values.items():
        if not hasattr(message, name):
            continue
        if isinstance(value, dict):
            filled(getattr(message, name), value)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            element = _element(message.get_fields_and_field_types()[name])
            setattr(message, name, [filled(element(), one) for one in value])
        else:
            setattr(message, name, value)
    return message


@cache
def _element(type_: str) -> Any:
    """Return the class of the messages in a list, such as "sequence<geometry_msgs/Pose>"."""
    package, _, name = type_.removeprefix("sequence<").rstrip(">").partition("/")
    return getattr(import_module(f"{package}.msg"), name)
