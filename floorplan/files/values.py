"""Dataclass values made in Python: type checks of their fields, and tuples indexed by name."""

from __future__ import annotations

import dataclasses
import types
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from numbers import Integral, Real
from pathlib import Path
from typing import (
    Annotated,
    Any,
    Generic,
    Literal,
    Protocol,
    SupportsIndex,
    TypeVar,
    Union,
    get_args,
    get_origin,
    get_type_hints,
    overload,
)

import numpy as np
from pydantic import GetCoreSchemaHandler
from pydantic_core import CoreSchema, core_schema

from .fields import Judged, Keyed, Reads
from .problems import Fault, field_name, shown, suggestion


class _HasName(Protocol):
    @property
    def name(self) -> str: ...


Thing = TypeVar("Thing", bound=_HasName)


SHOWN = 5
"""Names that a tuple of named things shows."""


class Named(tuple[Thing, ...]):
    """A tuple that also accepts the names of its elements: `stations["dock"]`.

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

    def __repr__(self) -> str:
        some = [repr(thing.name) for thing in self[:SHOWN]]
        more = len(self) - SHOWN
        return f"<{', '.join([*some, f'{more} more'] if more > 0 else some) or 'none'}>"

    def __contains__(self, key: object) -> bool:
        if isinstance(key, str):
            return any(thing.name == key for thing in self)
        return super().__contains__(key)


class NamedField(Generic[Thing]):
    """Field of a dataclass that is set by any sequence, and read as `Named`."""

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


_PLAIN: dict[Any, tuple[Any, str]] = {
    float: (Real, "a number"),
    int: (Integral, "a whole number"),
    str: (str, "text"),
    bool: (bool | np.bool_, "True or False"),
}
"""Values that count as a plain type, and the name of that type. Whole numbers are numbers."""

SOUND = "_sound"
"""Mark of a floorplan that was checked: it never changes, so once is enough."""

_FIT = "_fit"
"""Mark of a value that never changes, and of which the fields were found to be of their types."""


def require(value: object, kind: type, reader: str = "", name: str = "") -> None:
    """Check that `value` is a `kind`; `TypeError` says what it is instead.

    It also names the `reader` of such values where `value` may be the name of a file. The kind is
    called by its `name` where that is not the one its users know.
    """
    if not isinstance(value, kind):
        message = f"expected {name or _article(kind)}, found {shown(value)}"
        if reader and isinstance(value, str | Path):
            message += f"; {reader}({str(value)!r}) reads one"
        raise TypeError(message)


def require_fields(value: object) -> None:
    """Check that the fields of `value`, a dataclass, and of those within it are of their types.

    `TypeError` says which is not. Lists and arrays count as tuples, whole numbers as floats.
    """
    for message, place in _field_faults(value):
        raise TypeError(f"{type(value).__name__}.{field_name(place)}: {message}")


def _field_faults(value: Any) -> Iterator[Fault]:
    kept = getattr(value, "__dict__", {})
    if SOUND in kept or _FIT in kept:
        return
    fit = True
    for name, hint in _fields(value.__class__):
        held = getattr(value, name)
        if held.__class__ is not hint or _fields(hint):
            for message, rest in _faults(held, hint):
                fit = False
                yield message, (name, *rest)
    if fit and _never_changes(value):
        kept[_FIT] = True


def _never_changes(value: Any) -> bool:
    """Return whether a value is frozen throughout: only then all in it can be hashed."""
    try:
        hash(value)
    except TypeError:
        return False
    kind = value.__dataclass_params__
    return bool(kind.frozen and kind.eq)


@cache
def _fields(kind: type) -> tuple[tuple[str, Any], ...]:
    """Return the fields that a dataclass is compared by, with their types.

    All are Any where one of them is imported for type checkers only.
    """
    found = []
    try:
        hints = get_type_hints(kind)
    except NameError:
        hints = {}
    for field in dataclasses.fields(kind) if dataclasses.is_dataclass(kind) else ():
        if not field.compare:
            continue
        hint = hints.get(field.name, Any)
        if get_origin(hint) is NamedField:
            hint = types.GenericAlias(tuple, (*get_args(hint), ...))
        found.append((field.name, hint))
    return tuple(found)


def _faults(value: object, hint: Any) -> Iterator[Fault]:
    origin = get_origin(hint)
    if origin is Annotated:
        yield from _faults(value, get_args(hint)[0])
        return
    if origin in (Union, types.UnionType):
        options = [option for option in get_args(hint) if option is not type(None)]
        if value is None and len(options) < len(get_args(hint)):
            return
        found = [list(_faults(value, option)) for option in options]
        if all(found):
            wanted = " or ".join(map(_article, options))
            misfit = f"expected {wanted}, found {shown(value)}", ()
            # Of the right kind, but not right: its faults say more.
            near = found
            if len(found) > 1:
                near = [f for o, f in zip(options, found, strict=True) if f[0] != _misfit(value, o)]
            yield from near[0] if len(near) == 1 else [misfit]
    elif hint is Any:
        return
    elif origin is Literal:
        if not isinstance(value, str):
            yield _misfit(value, hint)
    elif hint in _PLAIN:
        kind, _ = _PLAIN[hint]
        odd = isinstance(value, bool) and hint is not bool
        if odd or not isinstance(value, kind):
            yield _misfit(value, hint)
    elif origin is tuple:
        yield from _tuple_faults(value, hint)
    elif isinstance(origin, type) and issubclass(origin, Mapping):
        if not isinstance(value, Mapping):
            yield _misfit(value, hint)
            return
        for key, one in value.items():
            for message, rest in _faults(one, get_args(hint)[1]):
                yield message, (str(key), *rest)
    # Python 3.10 takes list[str] for a type, which it then can't look for; its origin tells.
    elif origin is None and isinstance(hint, type) and not getattr(hint, "_is_protocol", False):
        if not isinstance(value, hint):
            yield _misfit(value, hint)
        elif dataclasses.is_dataclass(hint):
            yield from _field_faults(value)


def range_faults(value: object) -> Iterator[Fault]:
    """Yield what in a dataclass, and in the keyed ones within it, its annotations exclude.

    Fields of the types in `floorplan.files.fields` have ranges; of a `Literal` there are few.
    """
    kind: type = type(value)
    for name, hint in _ranged_fields(kind):
        for message, rest in _out_of_range(getattr(value, name), hint):
            yield message, (name, *rest)


@cache
def _ranged_fields(kind: type) -> tuple[tuple[str, Any], ...]:
    hints = get_type_hints(kind, include_extras=True)
    fields = dataclasses.fields(kind) if dataclasses.is_dataclass(kind) else ()
    found = ((field.name, hints[field.name]) for field in fields)
    return tuple((name, hint) for name, hint in found if _has_range(hint))


def _has_range(hint: Any) -> bool:
    if isinstance(hint, Reads | Judged) or get_origin(hint) is Literal:
        return True
    if isinstance(hint, type) and issubclass(hint, Keyed):
        return True
    return any(map(_has_range, get_args(hint)))


def _out_of_range(value: Any, hint: Any) -> Iterator[Fault]:
    if value is None:
        return
    inner = get_args(hint)
    if get_origin(hint) is Annotated:
        judges = Reads | Judged if isinstance(value, Real) else Judged
        ranges = [one for one in inner[1:] if isinstance(one, judges)]
        yield from ((fault, ()) for one in ranges if (fault := one.fault(value)))
        yield from _out_of_range(value, inner[0])
    elif get_origin(hint) in (Union, types.UnionType):
        for option in inner:
            yield from _out_of_range(value, option)
    elif get_origin(hint) is Literal:
        if value not in inner:
            yield f"must be one of {', '.join(map(str, inner))}, not {value!r}", ()
    elif isinstance(value, Mapping):
        for key, one in value.items():
            for message, rest in _out_of_range(one, inner[-1]):
                yield message, (key, *rest)
    elif get_origin(hint) is tuple and inner[-1] is Ellipsis:
        for k, one in enumerate(value):
            for message, rest in _out_of_range(one, inner[0]):
                yield message, (k, *rest)
    elif isinstance(value, Keyed) and type(value) is hint:
        yield from range_faults(value)


def _tuple_faults(value: object, hint: Any) -> Iterator[Fault]:
    inner = get_args(hint)
    if isinstance(value, str) or not isinstance(value, Sequence | np.ndarray):
        yield _misfit(value, hint)
        return
    if inner[-1] is Ellipsis:
        inner = inner[:1] * len(value)
    elif len(value) != len(inner):
        yield f"expected {len(inner)} of them, found {len(value)}", ()
        return
    for k, (one, wanted) in enumerate(zip(value, inner, strict=True)):
        for message, rest in _faults(one, wanted):
            yield message, (k, *rest)


def _misfit(value: object, hint: Any) -> Fault:
    return f"expected {_article(hint)}, found {shown(value)}", ()


def _article(hint: Any) -> str:
    if hint in _PLAIN:
        return _PLAIN[hint][1]
    if get_origin(hint) is Literal:
        return " or ".join(map(repr, get_args(hint)))
    name = getattr(get_origin(hint) or hint, "__name__", str(hint))
    return f"{'an' if name[0] in 'AEIOUaeiou' else 'a'} {name}"
