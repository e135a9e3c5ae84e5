"""Comparison of groups of rows: measures, bootstrap intervals and effect sizes."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from floorplan.files.dataclass import dataclass
from floorplan.files.fields import brief

from ..core.wording import figure as in_words
from ..machines.kinds import KINDS
from ..record.figures import FIGURES
from .design import Study
from .repeats import are_identical, column_of, repetitions_needed
from .table import Cell, TableError

CONFIDENCE = 0.95
"""Share of studies like this one whose interval contains the true mean."""

RESAMPLES = 2000
"""Number of resamples of a group for an interval."""

SLACK = "slack"
"""First part of the columns with the slack of an expectation."""

Columns = Mapping[str, Sequence[Cell]]
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Measure:
    """One figure by which rows are compared, and the columns that are summed.

    `NAME` in a column stands for each person: a figure of all people is the sum of theirs. With
    `NAME` in the title there is one `of_each` instead. A `rare` measure is omitted if it is 0 in
    all rows. The rows with the least (1) or the most (-1) are the `worst`, if any are.
    """

    title: str
    column: str
    unit: str = ""
    meaning: str = ""
    chief: bool = False
    rare: bool = False
    worst: int = 0

    @property
    def label(self) -> str:
        """Title and unit."""
        return f"{self.title}, {self.unit}" if self.unit else self.title

    @property
    def words(self) -> str:
        """Title inside a sentence."""
        return self.title if self.title[:2].isupper() else self.title[:1].lower() + self.title[1:]

    def of_each(self, columns: Columns) -> Iterator[Measure]:
        """Yield the measure itself, or one for each name if its title contains `NAME`."""
        if "NAME" not in self.title:
            yield self
            return
        for key in columns:
            if match := self._pattern.fullmatch(key):
                title = self.title.replace("NAME", match[1])
                yield replace(self, title=title, column=key)

    @property
    def _pattern(self) -> re.Pattern[str]:
        return re.compile(re.escape(self.column).replace("NAME", r"([^.]+)"))

    def values(self, columns: Columns) -> Floats | None:
        """Return the value of every row (NaN if it has none), or None if the measure is omitted."""
        matching = [column for key, column in columns.items() if self._pattern.fullmatch(key)]
        if not matching:
            return None
        if any(isinstance(value, str) for column in matching for value in column):
            raise TableError(f"the results have a text where {self.column} should be a number")
        figures = np.array([[math.nan if v is None else float(v) for v in c] for c in matching])
        there = ~np.isnan(figures)
        if self.rare and not np.any(figures[there]):
            return None
        return np.where(there.any(axis=0), np.nansum(figures, axis=0), math.nan)


def measures() -> tuple[Measure, ...]:
    """Return the declared measures of reports."""
    return tuple(
        Measure(
            figure.label[:1].upper() + figure.label[1:],
            figure.path,
            figure.unit,
            figure.meaning,
            chief=figure.measure == "chief",
            rare=figure.measure == "rare",
            worst=figure.worst,
        )
        for figure in FIGURES.values()
        if figure.measure
    )


def of_machines(columns: Columns) -> tuple[Measure, ...]:
    """Return the figures of added machines. Figures of custom kinds are chief."""
    names = [*columns]
    begin = names.index("error") if "error" in columns else 0  # varied values come before
    parts = {name: name.split(".") for name in names[begin:] if name.startswith("machines.")}
    kinds = {name: {*columns[c]} for c, (_, name, *last) in parts.items() if last == ["kind"]}
    return tuple(
        Measure(
            f"{name}: {' '.join(figure).replace('_', ' ')}",
            column,
            chief=not kinds[name] <= {*KINDS, None},
        )
        for column, (_, name, *figure) in parts.items()
        if name in kinds and figure != ["kind"] and all(map(_is_figure, columns[column]))
    )


def of_expectations(columns: Columns) -> tuple[Measure, ...]:
    """Return the slacks of expectations, which are negative if an expectation is not met."""
    return tuple(
        Measure(
            f"Slack of {column.removeprefix(f'{SLACK}.')}",
            column,
            meaning="how far the expectation was from not being met; negative if it was not",
            worst=1,
        )
        for column in columns
        if column.startswith(f"{SLACK}.")
    )


def _is_figure(value: Cell) -> bool:
    return value is None or (isinstance(value, int | float) and not isinstance(value, bool))


@dataclass(frozen=True)
class Spread:
    """Spread of the figures of one group, and the interval of their mean."""

    values: Floats
    mean: float
    low: float
    high: float

    @property
    def median(self) -> float:
        """Median of the values."""
        return float(np.median(self.values))

    @property
    def least(self) -> float:
        """Minimum of the values."""
        return float(self.values.min())

    @property
    def most(self) -> float:
        """Maximum of the values."""
        return float(self.values.max())


@dataclass(frozen=True)
class RowGroup:
    """The rows of one combination: its value of each factor, and the indices of the rows.

    Of identical repeats only the first is a row, and `repeats` is their number. It is 1 otherwise.
    """

    values: tuple[str, ...]
    rows: NDArray[np.intp]
    repeats: int = 1

    @property
    def label(self) -> str:
        """The values, separated by dots."""
        return " · ".join(self.values) or "all rows"


@dataclass(frozen=True)
class Comparison:
    """Groups of rows, and the spread of each measure in each group (None: no figures).

    `values` contains the figure of every row, NaN where there is none.
    """

    factors: tuple[str, ...]
    groups: tuple[RowGroup, ...]
    spreads: dict[Measure, tuple[Spread | None, ...]]
    values: dict[Measure, Floats]

    __repr__ = brief

    def constant(self, measure: Measure) -> float | None:
        """Return the value if it is equal in all rows, or NaN if no row has one."""
        there = [spread for spread in self.spreads[measure] if spread is not None]
        ends = {end for spread in there for end in (spread.least, spread.most)}
        return None if len(ends) > 1 else min(ends, default=math.nan)

    @property
    def telling(self) -> list[Measure]:
        """The measures that differ between rows: the chief ones, or all if no chief one differs."""
        varying = [one for one in self.spreads if self.constant(one) is None]
        return [one for one in varying if one.chief] or varying

    @property
    def identical(self) -> str:
        """Sentence about identical repeats, empty if there are none."""
        groups = [group for group in self.groups if group.repeats > 1]
        if not groups:
            return ""
        return (
            f"The {groups[0].repeats} repeats of {len(groups)} of {len(self.groups)} combinations"
            " are identical, because nothing is drawn in them. Each is counted once, and has no"
            " interval."
        )

    def label_of(self, line: int) -> str:
        """Return the label of the group of a line of the table."""
        return next(group.label for group in self.groups if line in group.rows)


def factors(study: Study) -> list[str]:
    """Return the variables with several values, by which rows are grouped."""
    several = [what.name for what, values in study.grid.items() if len(values) > 1]
    return ["trial", *several] if len(study.trials) > 1 else several


def compare(columns: Columns, factors: Sequence[str], *, once: bool = False) -> Comparison:
    """Return the rows in groups by their values of `factors`, in the order of first occurrence.

    With `once`, identical repeats are counted once, because nothing is drawn.
    """
    keys = list(zip(*(map(_shown, columns[factor]) for factor in factors), strict=True))
    keys = keys or [()] * len(columns["row"])
    groups = tuple(
        _group(columns, key, [k for k, other in enumerate(keys) if other == key], once)
        for key in dict.fromkeys(keys)
    )
    named = (one for measure in measures() for one in measure.of_each(columns))
    compared = (*named, *of_machines(columns), *of_expectations(columns))
    all_values = {measure: measure.values(columns) for measure in compared}
    values = {measure: figures for measure, figures in all_values.items() if figures is not None}
    spreads = {
        measure: tuple(spread(figures[group.rows]) for group in groups)
        for measure, figures in values.items()
    }
    return Comparison(tuple(factors), groups, spreads, values)


def _group(columns: Columns, key: tuple[str, ...], rows: list[int], once: bool) -> RowGroup:
    if once and are_identical(columns, rows):
        return RowGroup(key, np.array(rows[:1]), len(rows))
    return RowGroup(key, np.array(rows))


def spread(values: Floats) -> Spread | None:
    """Return the spread of `values` without NaNs, or None if there are no others.

    The interval of the mean is the percentile bootstrap (B. Efron, "Bootstrap Methods: Another Look
    at the Jackknife", Annals of Statistics 7, 1979) with a fixed seed.
    """
    there = values[~np.isnan(values)]
    if not len(there):
        return None
    # The bootstrap assumes nothing about the distribution of the rows.
    drawn = np.random.default_rng(0).integers(len(there), size=(RESAMPLES, len(there)))
    tail = (1 - CONFIDENCE) / 2
    low, high = np.quantile(there[drawn].mean(axis=1), [tail, 1 - tail])
    return Spread(there, float(there.mean()), float(low), float(high))


def _shown(value: Cell) -> str:
    return "" if value is None else f"{value:g}" if isinstance(value, float) else str(value)


@dataclass(frozen=True)
class Effect:
    """Cliff's delta of two groups, and the ends of its interval."""

    delta: float
    low: float
    high: float


@dataclass(frozen=True)
class Contrast:
    """Two groups that differ in one factor only, and the effect on each telling measure.

    An effect is None if no repetition has the figure in both groups.
    """

    one: RowGroup
    other: RowGroup
    effects: dict[Measure, Effect | None]


def contrasts(compared: Comparison) -> Iterator[Contrast]:
    """Yield every pair of groups that differ in one factor, in the order of factors.

    They are compared by the `telling` measures.
    """
    measures = compared.telling
    for factor in range(len(compared.factors)):
        for one, other in itertools.combinations(compared.groups, 2):
            pairs = zip(one.values, other.values, strict=True)
            differing = [k for k, (a, b) in enumerate(pairs) if a != b]
            if differing == [factor]:
                effects = {
                    measure: None
                    if one.repeats > 1 or other.repeats > 1  # a single pair has no frequency
                    else cliffs_delta(
                        compared.values[measure][one.rows], compared.values[measure][other.rows]
                    )
                    for measure in measures
                }
                yield Contrast(one, other, effects)


def cliffs_delta(one: Floats, other: Floats) -> Effect | None:
    """Return how often figures of `one` exceed those of `other`, minus how often they are less.

    That is P(X > Y) - P(X < Y) over all pairs of rows, from -1 to 1: N. Cliff, "Dominance
    statistics: Ordinal analyses to answer ordinal questions", Psychological Bulletin 114, 1993. The
    k-th figures of both belong to one repetition, with the same draws in all combinations.
    Repetitions in which either is missing (NaN) are omitted. The result is None if none is left.
    The interval is the percentile bootstrap over repetitions, as in `spread`.
    """
    count = min(len(one), len(other))
    there = ~(np.isnan(one[:count]) | np.isnan(other[:count]))
    x, y = one[:count][there], other[:count][there]
    n = len(x)
    if not n:
        return None
    order = np.argsort(y, kind="stable")
    below = np.searchsorted(y[order], x, "left")
    up_to = np.searchsorted(y[order], x, "right")

    def deltas(times: Floats) -> Floats:
        """Return the delta of each row of `times`, the multiplicities of the repetitions."""
        passed = np.concatenate([np.zeros((len(times), 1)), times[:, order].cumsum(axis=1)], axis=1)
        # A value x exceeds the sorted others before `below` and is less than those from `up_to` on:
        # passed[below] - (n - passed[up_to]).
        above_less_below: Floats = passed[:, below] + passed[:, up_to] - n
        dominance: Floats = (times * above_less_below).sum(axis=1)
        return dominance / n**2

    drawn = np.random.default_rng(0).multinomial(n, np.full(n, 1 / n), size=RESAMPLES)
    tail = (1 - CONFIDENCE) / 2
    low, high = np.quantile(deltas(drawn.astype(float)), [tail, 1 - tail])
    return Effect(float(deltas(np.ones((1, n)))[0]), float(low), float(high))


@dataclass(frozen=True)
class Trend:
    """Means of a measure along one factor, each over all rows with a value of it.

    `swing` is their greatest difference.
    """

    factor: str
    values: tuple[str, ...]
    spreads: tuple[Spread, ...]

    @property
    def swing(self) -> float:
        """Largest mean minus least mean."""
        means = [one.mean for one in self.spreads]
        return max(means) - min(means)


def sensitivities(compared: Comparison) -> Iterator[tuple[Measure, list[Trend]]]:
    """Yield the `telling` measures with the trends of all factors."""
    for measure in compared.telling:
        trends = [_trend(compared, measure, k) for k in range(len(compared.factors))]
        complete = [one for one in trends if one is not None]
        if complete:
            yield measure, complete


def _trend(compared: Comparison, measure: Measure, factor: int) -> Trend | None:
    """Return the means along a factor, or None if a value has no figures."""
    rows: dict[str, list[int]] = {}
    for group in compared.groups:
        rows.setdefault(group.values[factor], []).extend(group.rows.tolist())
    spreads = [spread(compared.values[measure][lines]) for lines in rows.values()]
    complete = [one for one in spreads if one is not None]
    if len(complete) < len(spreads):
        return None
    return Trend(compared.factors[factor], tuple(rows), tuple(complete))


@dataclass(frozen=True)
class StudyResults:
    """Results of a study.

    Parameters
    ----------
    study : Study
        The study.
    folder : Path
        Folder of the results.
    columns : dict of str to list
        Table of the results by column.
    """

    study: Study
    folder: Path
    columns: dict[str, list[Cell]]

    def __repr__(self) -> str:
        return f"<Results of the study {self.study.name!r}: {len(self)} rows in {self.folder}>"

    def _repr_html_(self) -> str:
        """Return the means of all combinations as a table for notebooks."""
        from ..record.notebook import html_table

        compared = self.comparison
        means = (
            [in_words(one.mean) if one else "–" for one in compared.spreads[measure]]
            for measure in compared.telling
        )
        rows = zip(
            (group.label for group in compared.groups),
            (f"{len(group.rows):,}" for group in compared.groups),
            *means,
            strict=True,
        )
        labels = (measure.label for measure in compared.telling)
        return html_table(rows, (", ".join(compared.factors), "runs", *labels))

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.columns["row"])

    @cached_property
    def comparison(self) -> Comparison:
        """Statistics of the rows of each combination."""
        return compare(self.columns, factors(self.study), once=not self.study.random)

    def width(self, figure: str) -> float:
        """Return the greatest width of the intervals of the mean of a figure.

        Parameters
        ----------
        figure : str
            Name of the figure, such as `penalties`.

        Returns
        -------
        float
            Width with 95 % confidence in the combination with the widest interval.

        Raises
        ------
        UserError
            If no row has the figure.
        """
        return max((one.high - one.low for one in self._spreads(figure)), default=math.inf)

    def repetitions_needed(self, figure: str, width: float) -> int:
        """Return how many repetitions a width of the interval of a figure's mean needs.

        Parameters
        ----------
        figure : str
            Name of the figure, such as `penalties`.
        width : float
            Wanted width with 95 % confidence, from end to end, in every combination.

        Returns
        -------
        int
            Number of repetitions, by the normal approximation.

        Raises
        ------
        UserError
            If no row has the figure, or if a combination has fewer than two rows.
        """
        spreads = self._spreads(figure)
        return max((repetitions_needed(one.values.tolist(), width) for one in spreads), default=0)

    def _spreads(self, figure: str) -> list[Spread]:
        """Return the spread of a figure in each combination that has it."""
        values = Measure("", column_of(figure, [*self.columns])).values(self.columns)
        groups = self.comparison.groups if values is not None else ()
        all_spreads = [spread(values[group.rows]) for group in groups if values is not None]
        return [one for one in all_spreads if one is not None]

    @cached_property
    def contrasts(self) -> tuple[Contrast, ...]:
        """Effect of each factor: Cliff's delta with intervals."""
        return tuple(contrasts(self.comparison))

    @property
    def hours(self) -> float:
        """Total simulated time in hours."""
        return sum(float(t) for t in self.columns.get("duration", ()) if t is not None) / 3600

    @property
    def failed(self) -> dict[int, str]:
        """Errors of rows without results, by row number."""
        errors = zip(self.columns["row"], self.columns["error"], strict=True)
        return {int(row or 0): str(error) for row, error in errors if error is not None}
