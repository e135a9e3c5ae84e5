"""What a study came to."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from .comparison import Comparison, compare, factors
from .effects import Contrast, contrasts
from .study import Study
from .table import Cell


@dataclass(frozen=True)
class StudyResults:
    """What a study came to: the folder it is in, and its table column by column."""

    study: Study
    folder: Path
    columns: dict[str, list[Cell]]

    def __len__(self) -> int:
        """How many rows there are."""
        return len(self.columns["row"])

    @cached_property
    def comparison(self) -> Comparison:
        """The rows in groups, one for each combination, and how their figures are spread."""
        return compare(self.columns, factors(self.study))

    @cached_property
    def contrasts(self) -> tuple[Contrast, ...]:
        """How much combinations that differ in one factor do so: Cliff's delta with intervals."""
        return tuple(contrasts(self.comparison))

    @property
    def failed(self) -> dict[int, str]:
        """What went wrong in the rows that have no figures, by number."""
        told = zip(self.columns["row"], self.columns["error"], strict=True)
        return {int(row or 0): str(error) for row, error in told if error is not None}
