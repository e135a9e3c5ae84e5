"""Results of a study."""

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
    """Results of a study: their folder, and their table column by column."""

    study: Study
    folder: Path
    columns: dict[str, list[Cell]]

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.columns["row"])

    @cached_property
    def comparison(self) -> Comparison:
        """The rows in groups, one for each combination, and how their figures are spread."""
        return compare(self.columns, factors(self.study))

    @cached_property
    def contrasts(self) -> tuple[Contrast, ...]:
        """Effects of one factor alone: Cliff's delta with intervals."""
        return tuple(contrasts(self.comparison))

    @property
    def failed(self) -> dict[int, str]:
        """Errors of the rows that have no figures, by number."""
        errors = zip(self.columns["row"], self.columns["error"], strict=True)
        return {int(row or 0): str(error) for row, error in errors if error is not None}
