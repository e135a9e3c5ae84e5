"""What can be wrong with a program, before it runs and while it runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

MOST_SHOWN = 20
"""An error's text has this many problems, and how many more there are."""

LONGEST = 600
"""Characters of one problem that an error's text has."""


@dataclass(frozen=True)
class Problem:
    """One thing wrong, and where. Lines and columns count from 1; 0 when there is none."""

    file: str
    line: int
    column: int
    message: str

    def __str__(self) -> str:
        place = [clipped(self.file), *(str(n) for n in (self.line, self.column) if n)]
        return f"{':'.join(place)}: {clipped(self.message)}"


def clipped(text: str) -> str:
    """A text of a length that people read: names and terms may be endless."""
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 1]}…"


class ProgramError(ValueError):
    """A program that cannot be loaded or cannot go on; `problems` has every place."""

    def __init__(self, problems: Sequence[Problem]) -> None:
        self.problems = tuple(problems)
        lines = [str(problem) for problem in self.problems[:MOST_SHOWN]]
        if len(self.problems) > MOST_SHOWN:
            lines.append(f"and {len(self.problems) - MOST_SHOWN:,} more")
        super().__init__("\n".join(lines))


class EndlessProgramError(ProgramError):
    """An agent was stopped: it ran out of its budget of cycles, of depth, or of intentions."""


class TooDeepError(Exception):
    """More goals, terms or intentions than are allowed; told as EndlessProgramError."""
