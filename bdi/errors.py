"""What can be wrong with a program, before it runs and while it runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Problem:
    """One thing wrong, and where. Lines and columns count from 1; 0 when there is none."""

    file: str
    line: int
    column: int
    message: str

    def __str__(self) -> str:
        place = [self.file, *(str(n) for n in (self.line, self.column) if n)]
        return f"{':'.join(place)}: {self.message}"


class ProgramError(ValueError):
    """A program that cannot be loaded or cannot go on; `problems` has every place."""

    def __init__(self, problems: Sequence[Problem]) -> None:
        self.problems = tuple(problems)
        super().__init__("\n".join(map(str, self.problems)))


class EndlessProgramError(ProgramError):
    """An agent was stopped: it ran out of its budget of cycles in one instant, or of depth."""


class TooDeepError(Exception):
    """Goals or rules call themselves more deeply than is allowed; told as EndlessProgramError."""
