"""Report of a study: charts, sensitivity, and tables."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from ..views.report_page import COLOURS, INK, name_rows, page_chart, write_report_page
from ..views.safety_report.page import Chart, Facts, Part, Points, ReportTable, minus
from .comparison import (
    Comparison,
    Effect,
    Measure,
    RowGroup,
    Spread,
    StudyResults,
    contrasts,
    spread,
)
from .table import Cell

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


WIDTH, ROW_HEIGHT, MARGIN = 5.6, 0.3, 0.75
"""Inches: a chart's width, the height of one group, and what is added for the axis."""

MOST_COUNTS = 40
"""Up to so many different whole numbers are drawn as counts, others as boxes."""


def chart(
    measure: Measure, groups: Sequence[RowGroup], spreads: Sequence[Spread | None]
) -> str | None:
    """The chart of one measure as an SVG element; None if matplotlib is not there."""
    height = MARGIN + ROW_HEIGHT * len(groups)

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        _draw_groups(axes, groups, spreads)
        axes.set_xlabel(measure.label)

    return page_chart(measure.column, (WIDTH, height), draw)


def _draw_groups(axes: Axes, groups: Sequence[RowGroup], spreads: Sequence[Spread | None]) -> None:
    colours = _colours(groups)
    axes.use_sticky_edges = False  # a box without a width would lie on the edge
    everything = np.concatenate([s.values for s in spreads if s is not None] or [np.zeros(1)])
    counted = bool((everything == everything.round()).all())
    counted = counted and len(np.unique(everything)) <= MOST_COUNTS
    for place, (one, colour) in enumerate(zip(spreads, colours, strict=True)):
        if one is None:
            continue
        if counted:
            _counts(axes, place, one, colour)
        else:
            _box(axes, place, one, colour)
        axes.plot([one.low, one.high], [place, place], color=INK, linewidth=2.2)
        axes.plot(one.mean, place, "o", color=INK, markersize=4.5)
    if counted:
        axes.locator_params(axis="x", integer=True)
    name_rows(axes, [group.label for group in groups])


def _counts(axes: Axes, place: int, spread: Spread, colour: str) -> None:
    """A disc at every whole number, as large as its share of the rows."""
    counts = Counter(spread.values.tolist())
    numbers = sorted(counts)
    shares = [counts[number] / len(spread.values) for number in numbers]
    sizes = [260 * share for share in shares]
    axes.scatter(numbers, [place] * len(numbers), s=sizes, color=colour, alpha=0.45, linewidth=0)


def _box(axes: Axes, place: int, spread: Spread, colour: str) -> None:
    """The middle half of the rows as a box, nine tenths of them as a line."""
    ends = np.quantile(spread.values, [0.05, 0.25, 0.75, 0.95])
    axes.plot(ends[[0, 3]], [place, place], color=colour, alpha=0.6, linewidth=1.2)
    box: dict[str, Any] = {"height": 0.55, "color": colour, "alpha": 0.45, "linewidth": 0}
    axes.barh(place, ends[2] - ends[1], left=ends[1], **box)


def _colours(groups: Sequence[RowGroup]) -> list[str]:
    """One colour for each value of the first factor."""
    firsts = list(dict.fromkeys(group.values[:1] for group in groups))
    return [COLOURS[firsts.index(group.values[:1]) % len(COLOURS)] for group in groups]


PANEL, HEIGHT = 2.6, 2.5
"""Inches: the width of one factor's panel, and the height of a chart."""

MOST_LINES = 24
"""Of so many combinations of the other factors each has a line of its own."""

LONGEST_NAME = 14
"""Characters of a value that fit below an axis."""


@dataclass(frozen=True)
class Trend:
    """The means of a measure along one factor: of all rows with each of its values.

    `swing` is how far they are from each other, at the most.
    """

    factor: str
    values: tuple[str, ...]
    spreads: tuple[Spread, ...]

    @property
    def swing(self) -> float:
        """The largest mean less the least."""
        means = [one.mean for one in self.spreads]
        return max(means) - min(means)


def sensitivities(compared: Comparison) -> Iterator[tuple[Measure, list[Trend]]]:
    """Yield the `telling` measures, with the trends of all factors on them."""
    for measure in compared.telling:
        trends = [_trend(compared, measure, k) for k in range(len(compared.factors))]
        found = [one for one in trends if one is not None]
        if found:
            yield measure, found


def _trend(compared: Comparison, measure: Measure, factor: int) -> Trend | None:
    """Return the means along a factor; None where a value has no figures."""
    rows: dict[str, list[int]] = {}
    for group in compared.groups:
        rows.setdefault(group.values[factor], []).extend(group.rows.tolist())
    spreads = [spread(compared.values[measure][lines]) for lines in rows.values()]
    known = [one for one in spreads if one is not None]
    if len(known) < len(spreads):
        return None
    return Trend(compared.factors[factor], tuple(rows), tuple(known))


def sensitivity_chart(
    compared: Comparison, measure: Measure, trends: Sequence[Trend]
) -> str | None:
    """Return a chart with a panel for each factor as SVG; None if matplotlib is not there.

    Dots are means of all rows with a value, with the interval of each; faint lines are the means
    of each combination of the other factors.
    """

    def draw(figure: Figure) -> None:
        panels = figure.subplots(1, len(trends), sharey=True, squeeze=False)[0]
        for axes, trend in zip(panels, trends, strict=True):
            _draw_trend(axes, compared, measure, trend)
        panels[0].set_ylabel(measure.label)

    size = (max(PANEL * len(trends), 1.6 * PANEL), HEIGHT)
    return page_chart(f"sensitivity {measure.column}", size, draw)


def _draw_trend(axes: Axes, compared: Comparison, measure: Measure, trend: Trend) -> None:
    places = _places(trend.values)
    lines = list(_lines(compared, measure, trend))
    for k, line in enumerate(lines if len(lines) <= MOST_LINES else ()):
        at = [places[value] for value in line]
        axes.plot(at, [*line.values()], color=COLOURS[k % len(COLOURS)], alpha=0.45, linewidth=0.9)
    at = [places[value] for value in trend.values]
    order = np.argsort(at)
    means = np.array([one.mean for one in trend.spreads])
    if not _is_named(trend.values):
        axes.plot(np.array(at)[order], means[order], color=INK, linewidth=1.2)
    for x, one in zip(at, trend.spreads, strict=True):
        axes.plot([x, x], [one.low, one.high], color=INK, linewidth=2.2)
        axes.plot(x, one.mean, "o", color=INK, markersize=4.5)
    axes.set_xticks(at, [_short(value) for value in trend.values])
    if _is_named(trend.values):
        axes.tick_params(axis="x", rotation=25)
        axes.margins(x=0.2)
    axes.set_xlabel(trend.factor)
    axes.spines[["right", "top"]].set_visible(False)
    axes.grid(axis="y", alpha=0.2, color=INK)


def _lines(compared: Comparison, measure: Measure, trend: Trend) -> Iterator[Mapping[str, float]]:
    """Yield the means by value of the factor, for each combination of the others."""
    factor = compared.factors.index(trend.factor)
    lines: dict[tuple[str, ...], dict[str, float]] = {}
    for group, one in zip(compared.groups, compared.spreads[measure], strict=True):
        if one is not None:
            others = (*group.values[:factor], *group.values[factor + 1 :])
            lines.setdefault(others, {})[group.values[factor]] = one.mean
    return (line for line in lines.values() if len(line) > 1 and len(lines) > 1)


def _places(values: Sequence[str]) -> dict[str, float]:
    """Return where on its axis each value stands: numbers as such, names one after the other."""
    if _is_named(values):
        return {value: float(k) for k, value in enumerate(values)}
    return {value: float(value) for value in values}


def _is_named(values: Sequence[str]) -> bool:
    try:
        return not all(np.isfinite(float(value)) for value in values)
    except ValueError:
        return True


def _short(value: str) -> str:
    return value if len(value) <= LONGEST_NAME else f"{value[: LONGEST_NAME - 1]}…"


STANDING_OUT = 3
"""So many rows are named for what makes them stand out."""

MOST_CONTRASTS = 200
"""So many pairs of combinations are set against each other."""

MOST_ERRORS = 50
"""So many failed rows are listed."""


@dataclass(frozen=True)
class Remarkable:
    """A row to look at, and why."""

    number: int
    why: str
    combination: str


def write_report(results: StudyResults, path: Path) -> None:
    """Write the page about a study to `path`."""
    columns, compared = results.columns, results.comparison
    charts = {
        measure: chart(measure, compared.groups, spreads)
        for measure, spreads in compared.spreads.items()
        if compared.constant(measure) is None
    }
    write_report_page(
        path,
        "study.html",
        {"figure": figure, "signed": signed},
        study=results.study,
        count=len(results),
        hours=sum(float(t) for t in columns.get("duration", ()) if t is not None) / 3600,
        compared=compared,
        charts=charts,
        varying={measure: digits_of(compared.spreads[measure]) for measure in charts},
        constant={
            measure: value
            for measure in compared.spreads
            if (value := compared.constant(measure)) is not None
        },
        contrasts=[*itertools.islice(contrasts(compared), MOST_CONTRASTS)],
        most_contrasts=MOST_CONTRASTS,
        remarkable=list(_remarkable(columns, compared)),
        errors=list(results.failed.items())[:MOST_ERRORS],
        error_count=len(results.failed),
    )


def signed(value: float) -> str:
    """A difference with two digits after the point, and its sign unless it is 0."""
    return "0.00" if round(value, 2) == 0 else minus(f"{value:+.2f}")


def figure(value: float | None, digits: int | None = None) -> str:
    """A number as people read it: three or four digits that count, or `digits` after the point."""
    if value is None or value != value:
        return "–"
    if digits is None:
        digits = 0 if value == round(value) else _after_the_point(abs(value))
    return minus(f"{round(value, digits) + 0.0:,.{digits}f}")  # no negative zero


def _after_the_point(size: float) -> int:
    return 0 if size >= 1000 else 1 if size >= 100 else 2 if size >= 1 else 3


def digits_of(spreads: Sequence[Spread | None]) -> int:
    """Return how many digits after the point the largest figure needs; none for whole numbers."""
    shown = [end for s in spreads if s is not None for end in (s.mean, s.low, s.high)]
    if all(value == round(value) for value in shown):
        return 0
    return _after_the_point(max(map(abs, shown)))


def _remarkable(
    columns: Mapping[str, Sequence[Cell]], compared: Comparison
) -> Iterator[Remarkable]:
    """The rows at the far ends, each once; rows that are no different from most aren't."""
    named: set[int] = set()
    for measure in compared.spreads:
        values = measure.values(columns)
        if not measure.worst or values is None or compared.constant(measure) is not None:
            continue
        order = np.argsort(measure.worst * values, kind="stable")
        fresh = [k for k in order.tolist() if k not in named and values[k] == values[k]]
        for k in fresh[:STANDING_OUT]:
            named.add(k)
            unit = f" {measure.unit}" if measure.unit else ""
            why = f"{measure.words}: {figure(float(values[k]))}{unit}"
            yield Remarkable(int(columns["row"][k] or 0), why, compared.label_of(k))


ACROSS = 6
"""Measures in one table: more do not fit on a page."""

MOST_TABLE_CONTRASTS = 60
"""Pairs of combinations that are set against each other."""


def figures(compared: Comparison) -> list[Part]:
    """Return the means of each combination, a few measures at a time, and what differs."""
    varying = [m for m in compared.spreads if compared.constant(m) is None]
    parts: list[Part] = []
    for k in range(0, len(varying), ACROSS):
        some = varying[k : k + ACROSS]
        heads = (*compared.factors, "runs", *(measure.label for measure in some))
        rows = [
            (*group.values, f"{len(group.rows):,}", *_means(compared, some, place))
            for place, group in enumerate(compared.groups)
        ]
        first = len(compared.factors)
        parts.append(ReportTable(heads, rows, figures=frozenset(range(first, len(heads)))))
    same = [
        (measure.words, f"{figure(value)} {measure.unit}".strip())
        for measure in compared.spreads
        if (value := compared.constant(measure)) is not None
    ]
    if same:
        parts.append(Facts(same, "The same in every run"))
    return [*parts, *_differences(compared)]


def _means(compared: Comparison, measures: Sequence[Measure], place: int) -> Iterator[str]:
    for measure in measures:
        one = compared.spreads[measure][place]
        yield "–" if one is None else _mean(one, digits_of(compared.spreads[measure]))


def _mean(one: Spread, digits: int | None = None) -> str:
    """Return a mean, and below it its interval, where it has a width."""
    low, high = figure(one.low, digits), figure(one.high, digits)
    if low == high:
        return figure(one.mean, digits)
    return _above(figure(one.mean, digits), f"{low} … {high}")


def _above(value: str, interval: str) -> str:
    return Markup("{}<small>{}</small>").format(value, interval)


def _differences(compared: Comparison) -> Iterator[ReportTable]:
    found = list(itertools.islice(contrasts(compared), MOST_TABLE_CONTRASTS))
    if not found:
        return
    measures = [*found[0].effects]
    words = (
        "Cliff's delta of combinations that differ in one thing: how often a run of the first has a"
        " higher figure than one of the second, less how often a lower one; with its interval of"
        " 95 % (bootstrap over repetitions)."
    )
    for k in range(0, len(measures), ACROSS):
        some = measures[k : k + ACROSS]
        heads = ("first", "second", *(measure.title for measure in some))
        rows = [
            (one.one.label, one.other.label, *(_delta(one.effects[m]) for m in some))
            for one in found
        ]
        figures = frozenset(range(2, len(heads)))
        yield ReportTable(heads, rows, "" if k else "Differences", "" if k else words, figures)


def _delta(effect: Effect | None) -> str:
    if effect is None:
        return "–"
    return _above(signed(effect.delta), f"{signed(effect.low)} … {signed(effect.high)}")


def sensitivity(compared: Comparison) -> Iterator[Part]:
    """Yield how far the telling measures change along each factor, as a table and as charts."""
    if not compared.factors:
        yield Points(("Nothing was varied on a grid.",))
        return
    found = list(sensitivities(compared))
    rows = [
        (measure.label, *(_swing(effects, factor) for factor in compared.factors))
        for measure, effects in found
    ]
    words = "How far the means of all runs with one value are from those with another, at the most."
    heads = ("figure", *compared.factors)
    yield ReportTable(heads, rows, "Swings", words, frozenset(range(1, len(heads))))
    for measure, effects in found:
        element = sensitivity_chart(compared, measure, effects)
        if element is not None:
            yield Chart(
                measure.title,
                "Dots are means of all runs with that value, with their intervals of 95 %; faint"
                " lines are single combinations of what else was varied.",
                element,
            )


def _swing(trends: Sequence[Trend], factor: str) -> str:
    return next((figure(one.swing) for one in trends if one.factor == factor), "–")
