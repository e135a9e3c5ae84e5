"""Repeats of a study: identical ones, sequential stopping, and the number needed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Annotated

import numpy as np

from floorplan import UserError
from floorplan.files.fields import Positive, whole
from floorplan.files.models import Strictly
from floorplan.files.problems import suggestion

FEWEST = 10
"""Minimum number of repetitions before stopping, because intervals of fewer are too narrow."""

NOT_FIGURES = ("row", "repetition", "seed")
"""Columns that differ between identical repeats."""

NORMAL = 1.959964
"""Half the width of the interval of 95 % of a normal distribution, in standard deviations."""


class UntilKeys(Strictly):
    """The keys of sequential stopping in a study file.

    The study ends when the interval of the mean of the figure `of` is no wider than `width` in
    every combination, but not before `at_least` repetitions.
    """

    width: Positive
    of: str
    at_least: Annotated[int, whole(2)] = FEWEST


def are_identical(columns: Mapping[str, Sequence[object]], rows: Sequence[int]) -> bool:
    """Return True if several rows have the same figures despite different seeds."""
    if len(rows) < 2:
        return False
    return all(
        len({column[row] for row in rows}) == 1
        for name, column in columns.items()
        if name not in NOT_FIGURES
    )


def repetitions_needed(values: Sequence[float], width: float) -> int:
    """Return the number of repetitions whose interval of the mean is about as wide as `width`.

    Parameters
    ----------
    values : sequence of float
        Figures of the repetitions so far, at least two.
    width : float
        Wanted width of the interval with 95 % confidence, from end to end.

    Returns
    -------
    int
        Number of repetitions in all, by the normal approximation with the standard deviation of
        `values`.

    Raises
    ------
    UserError
        If there are fewer than two values, or if the width is not positive.
    """
    if len(values) < 2:
        raise UserError(f"the needed repetitions follow from two values or more, not {len(values)}")
    if not width > 0:
        raise UserError(f"width must be more than 0, not {width!r}")
    spread = float(np.std(values, ddof=1))
    return max(math.ceil((2 * NORMAL * spread / width) ** 2), 2)


def column_of(figure: str, columns: Sequence[str]) -> str:
    """Return the column of a figure, whose name may lack its last part.

    `UserError` if no row has it.
    """
    for name in (figure, f"{figure}.value", f"{figure}.distance", f"{figure}.count"):
        if name in columns:
            return name
    raise UserError(f"until: no row has a figure {figure!r}; {suggestion(figure, columns)}")
