"""Sensitivity of a study's measures: how their means change along each factor."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..views.page_charts import COLOURS, INK, page_chart
from .comparison import Comparison, Measure, Spread, spread

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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
            _draw(axes, compared, measure, trend)
        panels[0].set_ylabel(measure.label)

    size = (max(PANEL * len(trends), 1.6 * PANEL), HEIGHT)
    return page_chart(f"sensitivity {measure.column}", size, draw)


def _draw(axes: Axes, compared: Comparison, measure: Measure, trend: Trend) -> None:
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
