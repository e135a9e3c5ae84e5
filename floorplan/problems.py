"""Problems of files, with their places: all of one file in one error."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TypeVar

_Error = TypeVar("_Error", bound="InputError")

MOST_SHOWN = 20
"""Most problems in the text of an error; it says how many more there are."""

LONGEST = 600
"""Most characters of one problem in the text of an error."""


@dataclass(frozen=True)
class Problem:
    """One problem, with its place in the file where it has one."""

    message: str
    field: str = ""
    line: int | None = None

    def __str__(self) -> str:
        place = [f"line {self.line}"] if self.line is not None else []
        place += [clipped(self.field)] if self.field else []
        message = clipped(self.message)
        return f"{', '.join(place)}: {message}" if place else message


def clipped(text: str, most: int = LONGEST) -> str:
    """Return `text` at a length that people read: values of files may be endless."""
    return text if len(text) <= most else f"{text[: most - 1]}…"


def shown(value: object) -> str:
    """Return `value` as a message shows it."""
    return clipped(repr(value), 60)


class UserError(ValueError):
    """A mistake of the user's; its text says what is wrong, where, and what would be right.

    Only errors of this kind, and the system's, reach a user as a sentence. A plain `ValueError`
    that gets as far as the command line is a defect.
    """


class InputError(UserError):
    """A file that can't be used: `file` and all of its `problems`, in order of their lines."""

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
    """A floorplan that can't be used."""


def suggestion(name: str, known: Iterable[object]) -> str:
    """Return a hint for a `name` that is none of `known`: the nearest of these, or all."""
    names = [str(one) for one in known]
    near = difflib.get_close_matches(name, names, 1)
    return f"did you mean {near[0]!r}?" if near else f"there are: {', '.join(names)}"
