"""Keys of files: how annotations of dataclass fields map them, and how they are written."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import MISSING
from functools import cache, partial, reduce
from operator import or_
from typing import Annotated, Any, NamedTuple, get_args, get_type_hints

import numpy as np
from pydantic import ConfigDict, GetCoreSchemaHandler
from pydantic_core import CoreSchema
from pydantic_core.core_schema import (
    no_info_after_validator_function,
    tagged_union_schema,
)

Data = dict[str, Any]
"""Keys and values of a file. Keys with their defaults are left out."""

CALLED = "\0name"
"""Key for the name of an entry, under which a file has its other keys. No file can contain it."""

BY_FIELDS = "by fields"
"""Key in the validation context if values have the names of fields, as in a recording."""


class Written:
    """Annotation of the `form` in which a file has a value, as a type that pydantic reads."""

    def __init__(self, form: Any) -> None:
        self.form = form

    def __get_pydantic_core_schema__(self, kind: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return handler.generate_schema(self.form)


class Composed(Written):
    """Annotation of a field that a file gives by the keys of a `form`, beside other keys.

    Several fields may have the same form. The field needs an alias, which errors leave out.

    Parameters
    ----------
    form : type
        Dataclass with the keys.
    read : callable, optional
        Function that returns the value of the field for a `form`.
    written : callable, optional
        Function that returns the keys for the object with the field.
    only_with : str, optional
        Key of a field with a default. If it is missing, the other keys of the form are unknown.
    """

    def __init__(
        self,
        form: Any,
        read: Callable[[Any], Any] = lambda form: form,
        written: Callable[[Any], Data] = lambda owner: {},
        only_with: str = "",
    ) -> None:
        super().__init__(form)
        self.read, self.written, self.only_with = read, written, only_with

    def __get_pydantic_core_schema__(self, kind: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        keys = no_info_after_validator_function(self.read, handler.generate_schema(self.form))
        return tagged_union_schema(
            {"\0keys": keys, "\0value": handler(kind)},
            discriminator=lambda value: "\0keys" if isinstance(value, _Keys) else "\0value",
        )


class Tagged(Written):
    """Annotation of the `forms` of a value by tag. `tag` returns the tag of a value."""

    def __init__(self, tag: Callable[[Any], str], forms: Mapping[str, Any]) -> None:
        super().__init__(reduce(or_, forms.values()))
        self._tag, self._forms = tag, forms

    def __get_pydantic_core_schema__(self, kind: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        choices = {tag: handler.generate_schema(form) for tag, form in self._forms.items()}
        return tagged_union_schema(choices, discriminator=self._tag)


class Alias:
    """Annotation of a field with another name in files."""

    def __init__(self, alias: str) -> None:
        self.alias = alias


KEYS = ConfigDict(extra="forbid", str_strip_whitespace=True, arbitrary_types_allowed=True)
"""Pydantic configuration of dataclasses in files, which rejects unknown keys."""


class _AliasedKeys:
    """Pydantic configuration of a dataclass in files whose fields have an `Alias`.

    The aliases are not those of `pydantic.Field`, because its import takes long.
    """

    def __get__(self, value: object, owner: type) -> ConfigDict:
        return {**KEYS, "alias_generator": lambda name: _aliases(owner)[name]}


ALIASED_KEYS = _AliasedKeys()


@cache
def _aliases(form: type) -> dict[str, str]:
    return {key.field: key.name for key in fields_of(form)}


class _Keys(dict[str, Any]):
    """Keys of a composed field, taken from among those of its owner."""


class Key(NamedTuple):
    """Key of a file, the dataclass field that it gives, and the type and default of its value.

    Fields that are not `compared` are not in files.
    """

    name: str
    field: str
    kind: Any
    composed: Composed | None
    default: Any
    compared: bool


@cache
def fields_of(form: type) -> tuple[Key, ...]:
    """Return a key for each field of a dataclass that files give. `MISSING` is no default."""
    hints = get_type_hints(form, include_extras=True)
    keys = []
    for field in dataclasses.fields(form):
        marks = getattr(hints[field.name], "__metadata__", ())
        alias = next((key for mark in marks if (key := getattr(mark, "alias", None))), field.name)
        composed = next((mark for mark in marks if isinstance(mark, Composed)), None)
        make = field.default_factory
        default = field.default if make is MISSING else make()
        kind = hints[field.name]
        keys.append(Key(alias, field.name, kind, composed, default, field.compare))
    return tuple(keys)


def form_keys(form: type) -> Iterator[tuple[str, Any]]:
    """Yield the keys of a form, each with the type of its value."""
    if hasattr(form, "model_fields"):
        for name, info in form.model_fields.items():
            kind: Any = info.annotation
            if info.alias != CALLED:
                kind = Annotated[(kind, *info.metadata)] if info.metadata else kind
                yield info.alias or name, kind
    elif dataclasses.is_dataclass(form):
        composed = dict.fromkeys(key.composed.form for key in fields_of(form) if key.composed)
        for key in fields_of(form):
            if key.composed is None and key.name != CALLED:
                yield key.name, key.kind
        for inner in composed:
            yield from form_keys(inner)


def forms(kind: object) -> Iterator[type]:
    """Yield the models and dataclasses in a type, including options of unions and elements."""
    is_model = hasattr(kind, "model_fields") or dataclasses.is_dataclass(kind)
    if isinstance(kind, type) and is_model:
        yield kind
    inner = get_args(kind)
    written = [one.form for one in inner if isinstance(one, Written)]
    for one in written or inner:
        yield from forms(one)


def keys_below(form: type, above: Iterable[str | int]) -> list[str]:
    """Return the keys that may stand below the keys `above` in a `form`, sorted."""
    outer = [form]
    for part in above:
        inner = [one for each in outer for one in forms(dict(form_keys(each)).get(str(part)))]
        outer = inner or outer
    return sorted({key for one in outer for key, _ in form_keys(one)})


def called(entries: Any) -> Any:
    """Return the keys of entries, each with the name under which a file has them."""
    if not isinstance(entries, dict):
        return entries
    return {
        name: {**keys, CALLED: str(name)} if isinstance(keys, dict) else keys
        for name, keys in entries.items()
    }


def has_fields(context: Any) -> bool:
    """Return whether the validated values have the names of fields instead of keys."""
    return bool(context) and BY_FIELDS in context


def composed(owner: type, keys: Any) -> Any:
    """Return the `keys` of an `owner` with those of its composed fields gathered by field."""
    if not isinstance(keys, dict):
        return keys
    gathered: dict[str, Any] = {}
    taken: set[str] = set()
    for key in fields_of(owner):
        if key.composed is None:
            continue
        names = _names(key.composed.form)
        if key.default is MISSING or (key.composed.only_with or min(names)) in keys:
            taken |= names
            gathered[key.name] = _Keys({name: keys[name] for name in names if name in keys})
    return {name: value for name, value in keys.items() if name not in taken} | gathered


@cache
def _names(form: type) -> frozenset[str]:
    """Return the keys of a form, including those of its composed fields."""
    inner = (_names(key.composed.form) if key.composed else {key.name} for key in fields_of(form))
    return frozenset[str]().union(*inner)


def written(value: Any, *, every: bool = False, write: Callable[[Any], Any] | None = None) -> Data:
    """Return the keys of a dataclass in a file. Defaults are written only if `every` is true.

    `write` returns the form of a field's value in the file. By default it is `plain`.
    """
    write = write or partial(plain, every=every)
    data: Data = {}
    kind: Any = type(value)
    for key in fields_of(kind):
        if key.composed is not None:
            data |= key.composed.written(value)
        elif key.name != CALLED:
            form = write(getattr(value, key.field))
            usual = () if every or key.default is MISSING else (write(key.default),)
            if form not in (None, *usual):
                data[key.name] = form
    return data


def plain(value: Any, every: bool = False) -> Any:
    """Return a value as a file has it: tuples and arrays as lists, numbers as floats.

    Keys of dataclasses with their defaults are left out unless `every` is true.
    """
    if value is None or isinstance(value, str):
        return value
    if isinstance(value, bool | np.bool_):
        return bool(value)
    if isinstance(value, Mapping):
        return {name: plain(inner) for name, inner in value.items()}
    if dataclasses.is_dataclass(value):
        return written(value, every=every)
    return [plain(inner) for inner in value] if hasattr(value, "__len__") else float(value)
