"""Charts of a study's measures as SVG: every group's rows, and their mean with its interval."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..views.page_charts import COLOURS, INK, name_rows, page_chart
from .comparison import Group, Measure, Spread

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, ROW_HEIGHT, MARGIN = 5.6, 0.3, 0.75
"""Inches: a chart's width, the height of one group, and what is added for the axis."""

MOST_COUNTS = 40
"""Up to so many different whole numbers are drawn as counts, others as boxes."""


def chart(
    measure: Measure, groups: Sequence[Group], spreads: Sequence[Spread | None]
) -> str | None:
    """The chart of one measure as an SVG element; None if matplotlib is not there."""
    height = MARGIN + ROW_HEIGHT * len(groups)

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        _draw(axes, groups, spreads)
        axes.set_xlabel(measure.label)

    return page_chart(measure.column, (WIDTH, height), draw)


def _draw(axes: Axes, groups: Sequence[Group], spreads: Sequence[Spread | None]) -> None:
    colours = _colours(groups)
    axes.use_sticky_edges = False  # a box without a width would lie on the edge
    everything = np.concatenate([s.values for s in spreads if s is not None] or [np.zeros(1)])
    counted = bool((everything == everything.round()).all())
    counted = counted and len(np.unique(everything)) <= MOST_COUNTS
    for place, (spread, colour) in enumerate(zip(spreads, colours, strict=True)):
        if spread is None:
            continue
        if counted:
            _counts(axes, place, spread, colour)
        else:
            _box(axes, place, spread, colour)
        axes.plot([spread.low, spread.high], [place, place], color=INK, linewidth=2.2)
        axes.plot(spread.mean, place, "o", color=INK, markersize=4.5)
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


def _colours(groups: Sequence[Group]) -> list[str]:
    """One colour for each value of the first factor."""
    firsts = list(dict.fromkeys(group.values[:1] for group in groups))
    return [COLOURS[firsts.index(group.values[:1]) % len(COLOURS)] for group in groups]
