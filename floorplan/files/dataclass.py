"""Dataclasses whose methods are compiled at their first use.

The decorator of the standard library compiles up to six methods of every class during the import,
and most of them are never called.
"""

from __future__ import annotations

import dataclasses
from functools import partial
from typing import TYPE_CHECKING, Any


class _Method:
    """Placeholder of a method of a dataclass."""

    def __init__(self, kind: type, name: str) -> None:
        self._kind = kind
        self._name = name

    def __get__(self, value: object, owner: type | None = None) -> Any:
        method = _compiled(self._kind, self._name)
        setattr(self._kind, self._name, method)
        return method.__get__(value, owner)


def _compiled(kind: Any, name: str) -> Any:
    """Return the method that the standard library compiles for a class with the same fields."""
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
        frozen=is_constructor and kind.__dataclass_params__.frozen,
        match_args=False,
    )
    return vars(compiled(type(kind.__name__, (), body)))[name]


def _freeze(kind: Any) -> None:
    """Make the fields of a class read-only, and all attributes of its direct instances."""
    names = frozenset(kind.__dataclass_fields__)

    def assign(self: Any, name: str, value: Any) -> None:
        if type(self) is kind or name in names:
            raise dataclasses.FrozenInstanceError(f"cannot assign to field {name!r}")
        super(kind, self).__setattr__(name, value)

    def delete(self: Any, name: str) -> None:
        if type(self) is kind or name in names:
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
    """Make a class a dataclass, with placeholders of its methods."""
    if others or hasattr(kind, "__dataclass_fields__"):
        # The standard library compares the options of a class with those of its bases.
        standard = dataclasses.dataclass(repr=repr, eq=eq, frozen=frozen, kw_only=kw_only, **others)
        return standard(kind)
    own = vars(kind)
    # Python sets the hash of a class with `__eq__` to None.
    is_hash_declared = "__hash__" in own and not (own["__hash__"] is None and "__eq__" in own)
    dataclasses.dataclass(init=False, repr=False, eq=False, kw_only=kw_only)(kind)
    parameters = kind.__dataclass_params__
    parameters.init, parameters.repr, parameters.eq, parameters.frozen = True, repr, eq, frozen
    for name, is_wanted in {"__init__": True, "__repr__": repr, "__eq__": eq}.items():
        if is_wanted and name not in own:
            setattr(kind, name, _Method(kind, name))
    if eq and not is_hash_declared:
        kind.__hash__ = _Method(kind, "__hash__") if frozen else None
    if frozen:
        _freeze(kind)
    return kind


if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass
else:

    def dataclass(kind=None, /, **options):
        """Make a class a dataclass. The options are those of `dataclasses.dataclass`."""
        return partial(_declare, **options) if kind is None else _declare(kind, **options)
