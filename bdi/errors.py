"""Errors of programs, before they run and while they run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

MOST_SHOWN = 20
"""Maximum number of problems in the text of an error. The text then gives the number of others."""

LONGEST = 600
"""Maximum number of characters of a problem in the text of an error."""


@dataclass(frozen=True, kw_only=True)
class ProgramProblem:
    """One error in a program, with its location.

    Parameters
    ----------
    file : str
        File, or name of the text.
    line : int, optional
        Line, counted from 1, or 0 if unknown.
    column : int, optional
        Column, counted from 1, or 0 if unknown.
    message : str
        What is wrong and what would be right.
    """

    file: str
    line: int = 0
    column: int = 0
    message: str

    def __str__(self) -> str:
        place = [clipped(self.file), *(str(n) for n in (self.line, self.column) if n)]
        return f"{':'.join(place)}: {clipped(self.message)}"


def clipped(text: str) -> str:
    """Return a text shortened to `LONGEST`, because names and terms may be very long."""
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 1]}…"


class ProgramError(ValueError):
    """Error of a program that cannot be loaded or continued.

    Parameters
    ----------
    problems : sequence of ProgramProblem
        All problems of the program.

    Attributes
    ----------
    problems : tuple of ProgramProblem
        All problems of the program.
    """

    def __init__(self, problems: Sequence[ProgramProblem]) -> None:
        self.problems = tuple(problems)
        lines = [str(problem) for problem in self.problems[:MOST_SHOWN]]
        if len(self.problems) > MOST_SHOWN:
            lines.append(f"and {len(self.problems) - MOST_SHOWN:,} more")
        super().__init__("\n".join(lines))

    def __reduce__(self) -> tuple[type[ProgramError], tuple[tuple[ProgramProblem, ...]]]:
        """Return how to copy the problems, because the text is derived from them."""
        return type(self), (self.problems,)


class EndlessProgramError(ProgramError):
    """Error of an agent that exceeded its maximum number of cycles, goals, plans or intentions."""


class TooDeepError(Exception):
    """More goals, terms or intentions than allowed. It is reported as `EndlessProgramError`."""
