"""Parts of a program with something inside them replaced."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, is_dataclass, replace
from typing import Any

from .terms import Var, rebuilt


def transformed(part: Any, change: Callable[[Any], Any]) -> Any:
    """Return a part of a program with everything replaced for which `change` returns not None."""
    changed = change(part)
    if changed is not None:
        return changed

    def inside(inner: Any) -> Any:
        return transformed(inner, change)

    if isinstance(part, tuple):
        return tuple(map(inside, part))
    if is_dataclass(part) and not isinstance(part, type):
        return replace(part, **{f.name: inside(getattr(part, f.name)) for f in fields(part)})
    return rebuilt(part, inside)


def has_variables(part: Any) -> bool:
    """Return True if there is a variable somewhere in a part of a program."""
    found = False

    def look(inner: Any) -> None:
        nonlocal found
        found = found or isinstance(inner, Var)

    transformed(part, look)
    return found
