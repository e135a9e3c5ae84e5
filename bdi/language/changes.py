"""Parts of a program: what is inside them, and themselves with some of that replaced."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass, replace
from typing import Any

from .terms import Var, parts, rebuilt


def transformed(part: Any, change: Callable[[Any], Any]) -> Any:
    """Return a part of a program with everything replaced for which `change` returns not None.

    Its place in the file stays, as all that does not count when parts are compared.
    """
    changed = change(part)
    if changed is not None:
        return changed

    def inside(inner: Any) -> Any:
        return transformed(inner, change)

    if isinstance(part, tuple):
        return tuple(map(inside, part))
    if is_dataclass(part) and not isinstance(part, type):
        counted = [field.name for field in fields(part) if field.compare]
        return replace(part, **{name: inside(getattr(part, name)) for name in counted})
    return rebuilt(part, inside)


def all_parts(part: Any) -> Iterator[Any]:
    """Yield a part of a program and everything inside it."""
    pending = [part]
    while pending:
        one = pending.pop()
        yield one
        if isinstance(one, tuple):
            pending += one
        elif is_dataclass(one) and not isinstance(one, type):
            pending += [getattr(one, field.name) for field in fields(one)]
        else:
            pending += parts(one)


def has_variables(part: Any) -> bool:
    """Return True if there is a variable somewhere in a part of a program."""
    return any(isinstance(inner, Var) for inner in all_parts(part))
