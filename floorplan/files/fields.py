"""Field types of files: numbers in range, angles, flags, and dataclasses of keys."""

import math
from collections.abc import Callable
from dataclasses import MISSING, fields
from math import radians, tau
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import GetCoreSchemaHandler, ValidationInfo, model_validator
from pydantic_core import CoreSchema, PydanticCustomError
from pydantic_core.core_schema import (
    bool_schema,
    float_schema,
    int_schema,
    no_info_after_validator_function,
    no_info_before_validator_function,
    tuple_schema,
    with_info_after_validator_function,
)

from .forms import ALIASED_KEYS, KEYS, composed, has_fields
from .problems import UserError

LARGEST = 1e10
"""Largest number in a file, in its unit. Readers reject larger ones.

Unix times are smaller. Beyond it, rounding loses steps of a millimetre or a millisecond.
"""

SMALLEST = 1e-6
"""Smallest positive number in a file, in its unit."""


def size_fault(value: float) -> str:
    """Return the reason why `value` is no length, speed or duration, or an empty text."""
    if SMALLEST <= value <= LARGEST:
        return ""
    if 0 < value < SMALLEST:
        return f"must be at least {SMALLEST:g}, not {value!r}"
    return f"must be more than 0 and at most {LARGEST:g}, not {value!r}"


def time_fault(value: float) -> str:
    """Return the reason why `value` is no time of a trial (s), or an empty text."""
    if 0 <= value <= LARGEST:
        return ""
    return f"must be a time from 0 to {LARGEST:g} s, not {value!r}"


def is_figure(value: object) -> bool:
    """Return whether `value` is a number from -`LARGEST` to `LARGEST`, and not true or false."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) <= LARGEST


def are_figures(values: ArrayLike) -> NDArray[np.bool_]:
    """Return a mask of the `values` from -`LARGEST` to `LARGEST`, in their shape."""
    with np.errstate(invalid="ignore"):
        fit: NDArray[np.bool_] = np.abs(np.asarray(values, dtype=float)) <= LARGEST
    return fit


def figure(text: str) -> float:
    """Return the number in `text`, or NaN if it is no number from -`LARGEST` to `LARGEST`."""
    try:
        value = float(text)
    except ValueError:
        return math.nan
    return value if is_figure(value) else math.nan


LARGEST_ANGLE = 2 * tau
"""Radians. Larger angles in a file are probably degrees."""


def _checked_size(value: float) -> float:
    if fault := size_fault(value):
        raise UserError(fault)
    return value


def _checked_angle(value: float, info: ValidationInfo) -> float:
    # A rotated floor adds its rotation to the angles, and a recording has the sums.
    if abs(value) > LARGEST_ANGLE and not has_fields(info.context):
        raise UserError(f"expected radians, found {value:g}: {value:g}° are {radians(value):.4f}")
    return value


class Reads:
    """Annotation with the pydantic schema of a value.

    Fields share one schema, which is computed once. `fault` returns the reason why a number given
    in Python is out of range, or an empty text.
    """

    def __init__(self, schema: CoreSchema, fault: Callable[[Any], str] = lambda value: "") -> None:
        self._schema = schema
        self.fault = fault

    def __get_pydantic_core_schema__(self, kind: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return dict(self._schema)


class Expected:
    """Annotation of the types of a value in a file, with a `hint` for errors."""

    def __init__(self, hint: str, *types: type) -> None:
        self._types = types
        names: dict[type, str] = {
            list: "a list",
            tuple: "a list",
            dict: "keys with values",
            str: "text",
        }
        self._context = {
            "forms": " or ".join(dict.fromkeys(names[one] for one in types)),
            "hint": hint,
        }

    def __get_pydantic_core_schema__(self, kind: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return no_info_before_validator_function(self._of_type, handler(kind))

    def _of_type(self, value: object) -> object:
        if not isinstance(value, self._types):
            raise PydanticCustomError("form", "expected {forms}; give {hint}", self._context)
        return value


class Constrained:
    """Annotation of constraints of pydantic for a value from a file, such as `min_length`."""

    def __init__(self, **constraints: int | str) -> None:
        self._constraints = constraints

    def __get_pydantic_core_schema__(self, kind: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return {**handler(kind), **self._constraints}


class Fits:
    """Annotation of a rule for values from files and from Python.

    `fault` returns the reason why a value breaks the rule, or an empty text. None is always valid.
    """

    def __init__(self, fault: Callable[[Any], str]) -> None:
        self.fault = fault

    def __get_pydantic_core_schema__(self, kind: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return no_info_after_validator_function(self._checked, handler(kind))

    def _checked(self, value: Any) -> Any:
        if value is not None and (fault := self.fault(value)):
            raise UserError(fault)
        return value


_NUMBER = float_schema(strict=True, ge=-LARGEST, le=LARGEST, allow_inf_nan=False)
_POSITIVE = float_schema(strict=True, gt=0, le=LARGEST, allow_inf_nan=False)
_NOT_NEGATIVE = float_schema(strict=True, ge=0, le=LARGEST, allow_inf_nan=False)
_PAIR = tuple_schema([_NUMBER, _NUMBER])

Number = Annotated[float, Reads(_NUMBER)]
"""Number from -`LARGEST` to `LARGEST`."""

Positive = Annotated[
    float, Reads(no_info_after_validator_function(_checked_size, _POSITIVE), size_fault)
]
"""Number from 1e-6 to `LARGEST`."""

Angle = Annotated[float, Reads(with_info_after_validator_function(_checked_angle, _NUMBER))]
"""Angle in radians of at most two turns."""

NotNegative = Annotated[float, Reads(_NOT_NEGATIVE, time_fault)]
"""Number from 0 to `LARGEST`."""

Flag = Annotated[bool, Reads(bool_schema(strict=True))]
"""True or false."""


def whole(
    least: int | None = None, most: int | None = None, fault: Callable[[int], str] | None = None
) -> Reads:
    """Return the annotation of a whole number from `least` to `most`, with its own `fault`."""

    def too_small(value: int) -> str:
        short = least is not None and value < least
        return f"must be {least} or more, not {value!r}" if short else ""

    return Reads(int_schema(strict=True, ge=least, le=most), fault or too_small)


Pair = Annotated[tuple[float, float], Reads(_PAIR)]
"""Two numbers from -`LARGEST` to `LARGEST`."""


Position = Annotated[
    tuple[float, float], Reads(_PAIR), Expected("a position [x, y] in metres", list, tuple)
]
"""Position (x, y) in metres."""


def _rising(pair: tuple[float, float]) -> tuple[float, float]:
    if pair[0] >= pair[1]:
        raise UserError(f"must be [low, high] with low < high, found {list(pair)}")
    return pair


Range = Annotated[tuple[float, float], Reads(no_info_after_validator_function(_rising, _PAIR))]
"""Range [low, high] with low < high, from -`LARGEST` to `LARGEST`."""


SHOWN = 60
"""Maximum number of characters of a field's value in a short text."""


def brief(value: Any) -> str:
    """Return a short text of a dataclass: abbreviated fields that differ from defaults."""
    shown = []
    for field in fields(value):
        made = field.default_factory
        usual = field.default if made is MISSING else made()
        current = getattr(value, field.name)
        if field.repr and (usual is MISSING or current != usual):
            text = repr(current)
            shown.append(f"{field.name}={text if len(text) <= SHOWN else text[: SHOWN - 1] + '…'}")
    return f"{type(value).__qualname__}({', '.join(shown)})"


class Keyed:
    """Base of dataclasses whose fields are the keys of a part of a file.

    In Python they are plain dataclasses. Files with unknown keys are rejected.
    """

    __pydantic_config__ = KEYS

    def __init_subclass__(cls) -> None:
        """Shorten the representation. `dataclass` does not replace an existing one."""
        super().__init_subclass__()
        cls.__repr__ = brief  # type: ignore[method-assign]


class ComposedKeys:
    """Base of dataclasses with fields that a file gives by several keys: see `Composed`."""

    __pydantic_config__ = ALIASED_KEYS

    @model_validator(mode="before")
    @classmethod
    def _compose(cls, keys: Any, info: ValidationInfo) -> Any:
        return keys if has_fields(info.context) else composed(cls, keys)
