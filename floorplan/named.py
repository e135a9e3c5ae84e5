"""Tuples of named things that also answer to names."""

from __future__ import annotations

import types
from collections.abc import Sequence
from typing import Any, Generic, Protocol, SupportsIndex, TypeVar, get_args, overload

from pydantic import GetCoreSchemaHandler
from pydantic_core import CoreSchema, core_schema

from .problems import suggestion


class _HasName(Protocol):
    @property
    def name(self) -> str: ...


Thing = TypeVar("Thing", bound=_HasName)


class Named(tuple[Thing, ...]):
    """A tuple of things that also answers to their names: `stations["dock"]`.

    A name may also stand before `in`. `KeyError` that suggests a name where there is none; of
    several with one name, the first is meant.
    """

    __slots__ = ()

    @overload
    def __getitem__(self, key: str) -> Thing: ...

    @overload
    def __getitem__(self, key: SupportsIndex) -> Thing: ...

    @overload
    def __getitem__(self, key: slice) -> tuple[Thing, ...]: ...

    def __getitem__(self, key: str | SupportsIndex | slice) -> Thing | tuple[Thing, ...]:
        if not isinstance(key, str):
            return super().__getitem__(key)
        for thing in self:
            if thing.name == key:
                return thing
        if not self:
            raise KeyError(f"nothing is called {key!r}: there are none")
        kind = type(self[0]).__name__.lower()
        raise KeyError(
            f"no {kind} is called {key!r}; {suggestion(key, [thing.name for thing in self])}"
        )

    def __contains__(self, key: object) -> bool:
        if isinstance(key, str):
            return any(thing.name == key for thing in self)
        return super().__contains__(key)


class NamedField(Generic[Thing]):
    """A field of a dataclass that takes any sequence of things, and gives them as `Named`."""

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, value: object, owner: type | None = None) -> Named[Thing]:
        if value is None:
            return Named()  # the field's default
        held: Named[Thing] = vars(value)[self._name]
        return held

    def __set__(self, value: object, things: Sequence[Thing]) -> None:
        # What is no sequence is left for `check` to refuse, with the field's name.
        vars(value)[self._name] = Named(things) if isinstance(things, list | tuple) else things

    @classmethod
    def __get_pydantic_core_schema__(cls, kind: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        # Pydantic puts what it has read into the value's dictionary, past `__set__`.
        read = handler(types.GenericAlias(tuple, (*get_args(kind), ...)))
        return core_schema.no_info_after_validator_function(Named, read)
