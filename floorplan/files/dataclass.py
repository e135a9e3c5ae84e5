"""Dataclasses that the standard library completes at their first use.

Its decorator finds the fields of every class and compiles up to six methods during the import. Most
classes are not used in a run, and most methods are never called.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from functools import partial
from threading import RLock
from typing import TYPE_CHECKING, Any

_LOCK = RLock()


class _Placeholder:
    """Attribute of a class, which `make` replaces at its first use."""

    def __init__(self, kind: type, name: str, make: Callable[[], None]) -> None:
        self._kind = kind
        self._name = name
        self._make = make
        setattr(kind, name, self)

    def __get__(self, value: object, owner: type | None = None) -> Any:
        with _LOCK:
            if vars(self._kind)[self._name] is self:
                self._make()
        made = vars(self._kind)[self._name]
        return made.__get__(value, owner) if hasattr(made, "__get__") else made


_FOUND = ("__dataclass_fields__", "__dataclass_params__", "__match_args__")
"""Attributes that follow from the fields."""


def _find_fields(kind: Any, repr: bool, eq: bool, frozen: bool, kw_only: bool) -> None:
    """Set the attributes that follow from the fields."""
    dataclasses.dataclass(init=False, repr=False, eq=False, match_args=False, kw_only=kw_only)(kind)
    parameters = kind.__dataclass_params__
    parameters.init, parameters.repr, parameters.eq, parameters.frozen = True, repr, eq, frozen
    fields = dataclasses.fields(kind)
    positional = tuple(field.name for field in fields if field.init and not field.kw_only)
    setattr(kind, _FOUND[-1], positional)


def _compile(kind: Any, name: str, frozen: bool) -> None:
    """Set a method that the standard library compiles for another class with the same fields."""
    fields: dict[str, Any] = kind.__dataclass_fields__
    body = {
        "__module__": kind.__module__,
        "__qualname__": kind.__qualname__,
        "__doc__": kind.__doc__,
        "__annotations__": {field.name: field.type for field in fields.values()},
        **fields,
    }
    if hasattr(kind, "__post_init__"):
        body["__post_init__"] = kind.__post_init__
    is_constructor = name == "__init__"
    compiled = dataclasses.dataclass(
        init=is_constructor,
        repr=name == "__repr__",
        eq=name == "__eq__",
        unsafe_hash=name == "__hash__",
        frozen=is_constructor and frozen,
        match_args=False,
    )
    setattr(kind, name, vars(compiled(type(kind.__name__, (), body)))[name])


def _freeze(kind: Any) -> None:
    """Make the fields of a class read-only, and all attributes of its direct instances."""

    def assign(self: Any, name: str, value: Any) -> None:
        if type(self) is kind or name in kind.__dataclass_fields__:
            raise dataclasses.FrozenInstanceError(f"cannot assign to field {name!r}")
        super(kind, self).__setattr__(name, value)

    def delete(self: Any, name: str) -> None:
        if type(self) is kind or name in kind.__dataclass_fields__:
            raise dataclasses.FrozenInstanceError(f"cannot delete field {name!r}")
        super(kind, self).__delattr__(name)

    for name, method in {"__setattr__": assign, "__delattr__": delete}.items():
        method.__name__, method.__qualname__ = name, f"{kind.__qualname__}.{name}"
        setattr(kind, name, method)


def _declare(
    kind: Any,
    *,
    repr: bool = True,
    eq: bool = True,
    frozen: bool = False,
    kw_only: bool = False,
    **others: bool,
) -> Any:
    """Make a class a dataclass with placeholders."""
    if others or hasattr(kind, "__dataclass_fields__"):
        # The standard library compares the options of a class with those of its bases.
        standard = dataclasses.dataclass(repr=repr, eq=eq, frozen=frozen, kw_only=kw_only, **others)
        return standard(kind)
    own = vars(kind)
    # Python sets the hash of a class with `__eq__` to None.
    is_hash_declared = "__hash__" in own and not (own["__hash__"] is None and "__eq__" in own)
    for name, is_wanted in {"__init__": True, "__repr__": repr, "__eq__": eq}.items():
        if is_wanted and name not in own:
            _Placeholder(kind, name, partial(_compile, kind, name, frozen))
    if eq and not is_hash_declared:
        kind.__hash__ = None
        if frozen:
            _Placeholder(kind, "__hash__", partial(_compile, kind, "__hash__", frozen))
    if frozen:
        _freeze(kind)
    if "__replace__" not in own:
        kind.__replace__ = dataclasses.replace
    find_fields = partial(_find_fields, kind, repr, eq, frozen, kw_only)
    for name in _FOUND:
        _Placeholder(kind, name, find_fields)
    return kind


if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass
else:

    def dataclass(kind=None, /, **options):
        """Make a class a dataclass. The options are those of `dataclasses.dataclass`."""
        return partial(_declare, **options) if kind is None else _declare(kind, **options)
