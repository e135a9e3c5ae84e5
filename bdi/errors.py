"""Errors of programs, before they run and while they run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

MOST_SHOWN = 20
"""Number of problems in the text of an error; of the others it gives the number."""

LONGEST = 600
"""Number of characters of a problem in the text of an error."""


@dataclass(frozen=True, kw_only=True)
class ProgramProblem:
    """One mistake and its place.

    Attributes:
        file: file, or name of the text.
        line: line, from 1; 0 for none.
        column: column, from 1; 0 for none.
        message: what is wrong, and what would be right.
    """

    file: str
    line: int = 0
    column: int = 0
    message: str

    def __str__(self) -> str:
        place = [clipped(self.file), *(str(n) for n in (self.line, self.column) if n)]
        return f"{':'.join(place)}: {clipped(self.message)}"


def clipped(text: str) -> str:
    """Return a text, cut off where it is too long to be read: names and terms may be endless."""
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 1]}…"


class ProgramError(ValueError):
    """Program that cannot be loaded or cannot go on; `problems` are all its mistakes."""

    def __init__(self, problems: Sequence[ProgramProblem]) -> None:
        self.problems = tuple(problems)
        lines = [str(problem) for problem in self.problems[:MOST_SHOWN]]
        if len(self.problems) > MOST_SHOWN:
            lines.append(f"and {len(self.problems) - MOST_SHOWN:,} more")
        super().__init__("\n".join(lines))

    def __reduce__(self) -> tuple[type[ProgramError], tuple[tuple[ProgramProblem, ...]]]:
        """Return how to make a copy: of the problems, not of the text that is made of them."""
        return type(self), (self.problems,)


class EndlessProgramError(ProgramError):
    """Agent that was stopped: it exceeded its budget of cycles, goals, depth or intentions."""


class TooDeepError(Exception):
    """More goals, terms or intentions than are allowed; reported as EndlessProgramError."""
