"""Values made in Python: checks of dataclass fields, and tuples indexed by name."""

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
    NamedTuple,
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

from .fields import Fits, Keyed, Reads
from .problems import Fault, Place, field_name, shown, suggestion


class _HasName(Protocol):
    @property
    def name(self) -> str: ...


Thing = TypeVar("Thing", bound=_HasName)


SHOWN = 5
"""Maximum number of names in the representation of a tuple."""


class Named(tuple[Thing, ...]):
    """Tuple that also accepts the names of its elements, as in `stations["dock"]` or with `in`.

    If several elements have a name, it means the first. `KeyError` for an unknown name suggests
    another.
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
    """Dataclass field that accepts any sequence and returns a `Named` tuple."""

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, value: object, owner: type | None = None) -> Named[Thing]:
        if value is None:
            return Named()  # the field's default
        named: Named[Thing] = vars(value)[self._name]
        return named

    def __set__(self, value: object, things: Sequence[Thing]) -> None:
        # `check` rejects other types with the name of the field.
        vars(value)[self._name] = Named(things) if isinstance(things, list | tuple) else things

    @classmethod
    def __get_pydantic_core_schema__(cls, kind: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        # Pydantic sets the dictionary of an object without `__set__`.
        read = handler(types.GenericAlias(tuple, (*get_args(kind), ...)))
        return core_schema.no_info_after_validator_function(Named, read)


_PLAIN: dict[Any, tuple[Any, str]] = {
    float: (Real, "a number"),
    int: (Integral, "a whole number"),
    str: (str, "text"),
    bool: (bool | np.bool_, "True or False"),
}
"""Accepted classes for each plain type, and its name. Whole numbers are numbers."""

SOUND = "_sound"
"""Attribute of a floorplan that was checked. It is immutable, so that one check is enough."""

_FIT = "_fit"
"""Attribute of an immutable value whose fields are valid."""


def require(value: object, kind: type, reader: str = "", name: str = "") -> None:
    """Raise `TypeError` unless `value` is a `kind`.

    If `value` may be the name of a file, the message suggests its `reader`. `name` replaces the
    name of the kind.
    """
    if not isinstance(value, kind):
        message = f"expected {name or _article(kind)}, found {shown(value)}"
        if reader and isinstance(value, str | Path):
            message += f"; {reader}({str(value)!r}) reads one"
        raise TypeError(message)


def require_fields(value: object) -> None:
    """Check that the fields of a dataclass, and of those within it, are of their types.

    `TypeError` says which is not. Lists and arrays count as tuples, whole numbers as floats.
    """
    for fault in _field_faults(value):
        if fault.is_type:
            name = field_name(fault.place)
            raise TypeError(f"{type(value).__name__}.{name}: {fault.message}")


def range_faults(value: object) -> Iterator[Fault]:
    """Yield the values in a dataclass, and in the keyed ones within it, that are out of range.

    The annotations of `floorplan.files.fields` have ranges, and `Literal` has options.
    """
    for fault in _field_faults(value):
        if not fault.is_type:
            yield fault.message, fault.place


class _Misfit(NamedTuple):
    """Value in a dataclass that is of another type, or out of range."""

    message: str
    place: Place
    is_type: bool = True

    def below(self, part: str | int) -> _Misfit:
        return self._replace(place=(part, *self.place))


def _field_faults(value: Any) -> Iterator[_Misfit]:
    marks = getattr(value, "__dict__", {})
    if SOUND in marks or _FIT in marks:
        return
    fit = True
    for name, hint, default in _fields(value.__class__):
        content = getattr(value, name)
        if content is default:
            continue
        if content.__class__ is not hint or _fields(hint):
            for fault in _faults(content, hint):
                fit = False
                yield fault.below(name)
    if fit and _never_changes(value):
        marks[_FIT] = True


def _never_changes(value: Any) -> bool:
    """Return whether a value is deeply frozen, because only then it can be hashed."""
    try:
        hash(value)
    except TypeError:
        return False
    kind = value.__dataclass_params__
    return bool(kind.frozen and kind.eq)


@cache
def _fields(kind: type) -> tuple[tuple[str, Any, Any], ...]:
    """Return the fields that a dataclass is compared by, with their types and valid defaults.

    All types are Any if one of them is imported for type checkers only.
    """
    if not dataclasses.is_dataclass(kind):
        return ()
    try:
        hints = get_type_hints(kind, include_extras=True)
    except NameError:
        hints = {}
    compared = []
    for field in dataclasses.fields(kind):
        hint = hints.get(field.name, Any)
        if get_origin(hint) is NamedField:
            hint = types.GenericAlias(tuple, (*get_args(hint), ...))
        if field.compare:
            default = field.default
            if default is not dataclasses.MISSING and any(_faults(default, hint)):
                default = dataclasses.MISSING
            compared.append((field.name, hint, default))
    return tuple(compared)


def _faults(value: Any, hint: Any) -> Iterator[_Misfit]:
    origin = get_origin(hint)
    if origin is Annotated:
        inner, *marks = get_args(hint)
        faults = [*_faults(value, inner)]
        yield from faults
        if value is not None and not any(fault.is_type for fault in faults):
            rules = (Reads, Fits) if isinstance(value, Real) else (Fits,)
            messages = (mark.fault(value) for mark in marks if isinstance(mark, rules))
            yield from (_Misfit(message, (), False) for message in messages if message)
    elif origin in (Union, types.UnionType):
        yield from _union_faults(value, get_args(hint))
    elif hint is Any:
        return
    elif origin is Literal:
        if not isinstance(value, str):
            yield _misfit(value, hint)
        elif value not in get_args(hint):
            options = ", ".join(map(str, get_args(hint)))
            yield _Misfit(f"must be one of {options}, not {value!r}", (), False)
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
            yield from (fault.below(str(key)) for fault in _faults(one, get_args(hint)[1]))
    # Python 3.10 takes list[str] for a type, but isinstance does not accept it.
    elif origin is None and isinstance(hint, type) and not getattr(hint, "_is_protocol", False):
        if not isinstance(value, hint):
            yield _misfit(value, hint)
        elif dataclasses.is_dataclass(hint):
            has_ranges = isinstance(value, Keyed)
            yield from (fault for fault in _field_faults(value) if fault.is_type or has_ranges)


def _union_faults(value: Any, options: tuple[Any, ...]) -> Iterator[_Misfit]:
    """Yield the faults of the option that a value comes nearest to."""
    if value is None and type(None) in options:
        return
    options = tuple(option for option in options if option is not type(None))
    faults = [[*_faults(value, option)] for option in options]
    fit = [one for one in faults if not any(fault.is_type for fault in one)]
    if fit:
        yield from min(fit, key=len)
        return
    # A value of the right kind with faults inside says more than one of another kind.
    near = faults
    if len(options) > 1:
        near = [f for o, f in zip(options, faults, strict=True) if f[0] != _misfit(value, o)]
    if len(near) == 1:
        yield from near[0]
    else:
        expected = " or ".join(map(_article, options))
        yield _Misfit(f"expected {expected}, found {shown(value)}", ())


def _tuple_faults(value: Any, hint: Any) -> Iterator[_Misfit]:
    inner = get_args(hint)
    if isinstance(value, str) or not isinstance(value, Sequence | np.ndarray):
        yield _misfit(value, hint)
        return
    if inner[-1] is Ellipsis:
        inner = inner[:1] * len(value)
    elif len(value) != len(inner):
        yield _Misfit(f"expected {len(inner)} of them, found {len(value)}", ())
        return
    for k, (one, kind) in enumerate(zip(value, inner, strict=True)):
        yield from (fault.below(k) for fault in _faults(one, kind))


def _misfit(value: object, hint: Any) -> _Misfit:
    return _Misfit(f"expected {_article(hint)}, found {shown(value)}", ())


def _article(hint: Any) -> str:
    """Return the name of a type with its article."""
    if get_origin(hint) is Annotated:
        return _article(get_args(hint)[0])
    if hint in _PLAIN:
        return _PLAIN[hint][1]
    if get_origin(hint) is Literal:
        return " or ".join(map(repr, get_args(hint)))
    name = getattr(get_origin(hint) or hint, "__name__", str(hint))
    return f"{'an' if name[0] in 'AEIOUaeiou' else 'a'} {name}"
