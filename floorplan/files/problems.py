"""Problems of files with their places, and validation errors in plain words."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable
from typing import Any, TypeAlias, TypeVar

from pydantic import ValidationError

from .dataclass import dataclass
from .forms import keys_below

_Error = TypeVar("_Error", bound="InputError")

MOST_SHOWN = 20
"""Maximum number of problems in the text of an error."""

LONGEST = 600
"""Maximum number of characters of a problem in the text of an error."""


@dataclass(frozen=True)
class Problem:
    """Problem of a file or value.

    Parameters
    ----------
    message : str
        Description.
    field : str, optional
        Field with the problem, as in `stations.dock`.
    line : int, optional
        Line of the file.
    """

    message: str
    field: str = ""
    line: int | None = None

    def __str__(self) -> str:
        place = [f"line {self.line}"] if self.line is not None else []
        place += [clipped(self.field)] if self.field else []
        message = clipped(self.message)
        return f"{', '.join(place)}: {message}" if place else message


def clipped(text: str, most: int = LONGEST) -> str:
    """Return `text`, shortened to `most` characters."""
    return text if len(text) <= most else f"{text[: most - 1]}…"


def shown(value: object) -> str:
    """Return the short representation of `value` for messages."""
    return clipped(repr(value), 60)


def metres(value: float, below: float = math.inf) -> str:
    """Return a length with three decimals, or more if it is small or just less than `below`."""
    texts = (f"{value:.{decimals}f}" for decimals in range(3, 18))
    fit = (t for t in texts if abs(float(t) - value) <= 5e-3 * abs(value) and float(t) < below)
    return next(fit, f"{value:g}")


class UserError(ValueError):
    """Mistake of the user. Its text says what is wrong, where, and what would be right.

    The command line shows these errors, and errors of the system, as a sentence. Any other
    `ValueError` there is a defect.
    """


class InputError(UserError):
    """File that cannot be used.

    Parameters
    ----------
    file : str
        Name of the file.
    problems : iterable of Problem
        All problems. The attribute `problems` has them in the order of their lines.
    """

    def __init__(self, file: str, problems: Iterable[Problem]) -> None:
        self.file = file
        self.problems = tuple(sorted(problems, key=lambda problem: problem.line or 0))
        lines = [str(problem) for problem in self.problems]
        place = clipped(file)
        if len(lines) == 1:
            text = f"{place}: {lines[0]}"
        else:
            shown = lines[:MOST_SHOWN]
            if len(lines) > MOST_SHOWN:
                shown.append(f"and {len(lines) - MOST_SHOWN:,} more")
            text = "\n  ".join([f"{place}: {len(lines):,} problems", *shown])
        super().__init__(text)

    @classmethod
    def of(cls: type[_Error], file: object, message: str, line: int | None = None) -> _Error:
        """Return the error about `file` with a single problem, at `line` if given."""
        return cls(str(file), [Problem(message, line=line)])

    def __reduce__(self) -> tuple[type[InputError], tuple[str, tuple[Problem, ...]]]:
        return (type(self), (self.file, self.problems))


class FloorplanError(InputError):
    """Floorplan that cannot be used."""


def suggestion(name: str, known: Iterable[object]) -> str:
    """Return a hint for an unknown `name`: the most similar known name, all of them, or none."""
    names = [str(one) for one in known]
    near = difflib.get_close_matches(name, names, 1)
    return f"did you mean {near[0]!r}?" if near else f"there are: {', '.join(names) or 'none'}"


def refuse(about: str, faults: Iterable[Fault], error: type[InputError]) -> None:
    """Raise `error` with all `faults` of a value called `about`, if there are any."""
    problems = [Problem(message, field_name(place)) for message, place in faults]
    if problems:
        raise error(about, problems)


Place: TypeAlias = tuple[str | int, ...]
"""Keys and indices that lead to a value."""

Fault: TypeAlias = tuple[str, Place]
"""Message about a value, and its place."""

EXPONENT = re.compile(r"[-+]?[0-9.]+[eE][-+]?[0-9]+")
"""Numbers with exponents that YAML 1.1 reads as text."""

MOST_MISFITS = 1_000
"""Maximum number of errors of pydantic that are reported."""

EXPECTED = {
    "bool_type": "true or false",
    "dataclass_type": "keys with values",
    "dict_type": "keys with values",
    "finite_number": "a finite number",
    "float_parsing": "a number",
    "float_type": "a number",
    "form": "{forms}",
    "greater_than": "more than {gt:g}",
    "greater_than_equal": "at least {ge:g}",
    "int_type": "a whole number",
    "less_than": "less than {lt:g}",
    "less_than_equal": "at most {le:g}",
    "list_type": "a list",
    "literal_error": "{expected}",
    "model_type": "keys with values",
    "string_pattern_mismatch": "a name of letters, digits, _ and - that begins with a letter",
    "string_type": "text",
    "too_long": "a list of {max_length}",
    "too_short": "a list of at least {min_length}",
    "tuple_type": "a list",
}
"""Expected values by pydantic's error types. Patterns are those of names."""

UNKNOWN = ("extra_forbidden", "unexpected_keyword_argument")
MISSING = ("missing", "missing_argument")
FORMS = (
    "bool_type",
    "dataclass_type",
    "dict_type",
    "float_type",
    "form",
    "int_type",
    "list_type",
    "literal_error",
    "model_type",
    "string_type",
    "tuple_type",
)
"""Error types of values of a wrong type. Another option of a union may accept them."""


def misfits(error: ValidationError, form: type, data: object) -> list[Fault]:
    """Return the faults of `data`, which pydantic rejected as a `form`, with their places.

    `form` is a pydantic model or a dataclass. For unions, the faults are those of the most similar
    option.
    """
    errors = [
        (_place(one["loc"], data, one["type"] in MISSING), dict(one))
        for one in error.errors(include_url=False)[:MOST_MISFITS]
    ]
    above = {place[:k] for place, _ in errors for k in range(len(place))}
    nearer = above | {place for place, one in errors if one["type"] not in FORMS}
    others: dict[Place, list[str]] = {}
    for place, one in errors:
        if one["type"] in FORMS and place not in nearer:
            others.setdefault(place, []).append(_expected(one))
    faults: dict[Fault, None] = {}
    for place, one in errors:
        if one["type"] == "value_error" and place in above:
            continue  # because a misspelt key also breaks rules about several keys
        if one["type"] not in FORMS:
            faults[_message(one, form), place] = None
        elif place in others:
            faults[_wrong_form(one, others[place]), place] = None
    return list(faults)


def field_name(place: Place) -> str:
    """Return `place` as text, such as `people[0].start` for `("people", 0, "start")`."""
    text = ""
    for part in place:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else part
    return text


def _place(location: Place, data: Any, missing: bool) -> Place:
    """Return `location` without the names of options of unions.

    A `missing` key at its end remains, although it is not in the data.
    """
    place: Place = ()
    for k, part in enumerate(location):
        try:
            data = data[part]
        except (KeyError, IndexError, TypeError):
            if not missing or k < len(location) - 1:
                continue
        place = (*place, part)
    return place


def _message(misfit: dict[str, Any], form: type) -> str:
    """Return the message about a value of the right type."""
    kind = misfit["type"]
    if kind in MISSING:
        return "is missing"
    if kind in UNKNOWN:
        *above, key = misfit["loc"]
        names = keys_below(form, above)
        return f"unknown key; {suggestion(str(key), names)}" if names else "unknown key"
    if kind == "value_error":
        return str(misfit["ctx"]["error"])
    if kind in EXPECTED:
        return f"expected {_expected(misfit)}, found {shown(misfit['input'])}"
    message = str(misfit["msg"])
    return f"{message[:1].lower()}{message[1:]}, found {shown(misfit['input'])}"


def _expected(misfit: dict[str, Any]) -> str:
    return EXPECTED[misfit["type"]].format(**misfit.get("ctx", {}))


def _wrong_form(misfit: dict[str, Any], forms: Iterable[str]) -> str:
    """Return the message about a value of a wrong type."""
    *others, last = dict.fromkeys(forms)
    message = f"expected {', '.join(others)} or {last}" if others else f"expected {last}"
    value = misfit["input"]
    if last == EXPECTED["float_type"] and isinstance(value, str) and EXPONENT.fullmatch(value):
        message += " (to YAML 1e3 is text; write 1.0e+3 or 1000)"
    if last == EXPECTED["string_type"] and isinstance(value, bool):
        message += " (to YAML yes, no, on and off are true or false: put them in quotes)"
    hint = misfit.get("ctx", {}).get("hint")
    return f"{message}, found {shown(value)}" + (f"; give {hint}" if hint else "")
