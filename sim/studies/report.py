"""Report of a study: charts, sensitivity, and tables."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from floorplan.files.dataclass import dataclass

from ..core.wording import digits_after, figure, signed
from ..views.report_page import (
    COLOURS,
    INK,
    draw_box,
    draw_interval,
    name_rows,
    page_chart,
    write_report_page,
)
from .comparison import (
    Comparison,
    Measure,
    RowGroup,
    Spread,
    StudyResults,
    Trend,
    contrasts,
)
from .table import Cell

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


WIDTH, ROW_HEIGHT, MARGIN = 5.6, 0.3, 0.75
"""Inches: width of a chart, height of one group, and height of the axis."""

MOST_COUNTS = 40
"""Maximum number of different whole numbers that are drawn as counts instead of boxes."""


def chart(
    measure: Measure, groups: Sequence[RowGroup], spreads: Sequence[Spread | None]
) -> str | None:
    """Return the chart of one measure as an SVG element, or None without matplotlib."""
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
            draw_box(axes, place, one.values, colour)
        draw_interval(axes, (one.low, one.high), (place, place), (one.mean, place))
    if counted:
        axes.locator_params(axis="x", integer=True)
    name_rows(axes, [group.label for group in groups])


def _counts(axes: Axes, place: int, spread: Spread, colour: str) -> None:
    """Draw a disc at each whole number, with an area proportional to its share of rows."""
    counts = Counter(spread.values.tolist())
    numbers = sorted(counts)
    shares = [counts[number] / len(spread.values) for number in numbers]
    sizes = [260 * share for share in shares]
    axes.scatter(numbers, [place] * len(numbers), s=sizes, color=colour, alpha=0.45, linewidth=0)


def _colours(groups: Sequence[RowGroup]) -> list[str]:
    """Return the colour of each group, by the value of the first factor."""
    firsts = list(dict.fromkeys(group.values[:1] for group in groups))
    return [COLOURS[firsts.index(group.values[:1]) % len(COLOURS)] for group in groups]


PANEL, HEIGHT = 2.6, 2.5
"""Inches: width of one factor's panel, and height of a chart."""

MOST_LINES = 24
"""Maximum number of combinations of the other factors that have a line each."""

LONGEST_NAME = 14
"""Maximum number of characters of a value below an axis."""


def sensitivity_chart(
    compared: Comparison, measure: Measure, trends: Sequence[Trend]
) -> str | None:
    """Return a chart with a panel for each factor as SVG, or None without matplotlib.

    Dots are means of all rows with a value, with intervals. Faint lines are the means of each
    combination of the other factors.
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
        draw_interval(axes, (x, x), (one.low, one.high), (x, one.mean))
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
    """Return the positions of values on an axis: numbers as such, names one after the other."""
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
"""Maximum number of rows listed for an extreme value of one measure."""

MOST_CONTRASTS = 200
"""Maximum number of pairs of combinations that are compared."""

MOST_ERRORS = 50
"""Maximum number of failed rows that are listed."""


@dataclass(frozen=True)
class Remarkable:
    """A row with an extreme value, and the reason."""

    number: int
    why: str
    combination: str


def write_report(results: StudyResults, path: Path) -> None:
    """Write the page about a study to `path`."""
    columns, compared = results.columns, results.comparison
    shown = measures_shown(compared)
    write_report_page(
        path,
        "study.html",
        {"figure": figure, "signed": signed},
        study=results.study,
        count=len(results),
        hours=results.hours,
        charts={
            measure: chart(measure, compared.groups, compared.spreads[measure])
            for measure in shown["varying"]
        },
        remarkable=list(_remarkable(columns, compared)),
        errors=list(results.failed.items())[:MOST_ERRORS],
        error_count=len(results.failed),
        **shown,
    )


def measures_shown(compared: Comparison) -> dict[str, Any]:
    """Return the values of `measures.html`: varying and constant measures, and contrasts."""
    constant = {measure: compared.constant(measure) for measure in compared.spreads}
    with_effects = (one for one in contrasts(compared) if any(one.effects.values()))
    return {
        "compared": compared,
        "varying": {
            measure: digits_of(compared.spreads[measure])
            for measure, value in constant.items()
            if value is None
        },
        "constant": [
            (measure.words, f"{figure(value)} {measure.unit if value == value else ''}".strip())
            for measure, value in constant.items()
            if value is not None
        ],
        "contrasts": [*itertools.islice(with_effects, MOST_CONTRASTS)],
        "most_contrasts": MOST_CONTRASTS,
    }


def digits_of(spreads: Sequence[Spread | None]) -> int:
    """Return the decimals for the largest figure, or 0 if all are whole numbers."""
    shown = [end for s in spreads if s is not None for end in (s.mean, s.low, s.high)]
    if all(value == round(value) for value in shown):
        return 0
    return digits_after(max(map(abs, shown)))


def _remarkable(
    columns: Mapping[str, Sequence[Cell]], compared: Comparison
) -> Iterator[Remarkable]:
    """Yield the rows with extreme values, each once."""
    named: set[int] = set()
    counted = {k for group in compared.groups for k in group.rows}  # no identical repeats
    for measure in compared.spreads:
        values = measure.values(columns)
        if not measure.worst or values is None or compared.constant(measure) is not None:
            continue
        order = np.argsort(measure.worst * values, kind="stable")
        fresh = [k for k in order.tolist() if k in counted - named and values[k] == values[k]]
        for k in fresh[:STANDING_OUT]:
            named.add(k)
            unit = f" {measure.unit}" if measure.unit else ""
            why = f"{measure.words}: {figure(float(values[k]))}{unit}"
            yield Remarkable(int(columns["row"][k] or 0), why, compared.label_of(k))
