"""Charts of a benchmark: how answers are distributed, and how they come about over time."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from navigation.benchmark import Attempt, Curve, cost_over_time, success_over_time

from ..page_charts import COLOURS, INK, draw_grid, name_rows, page_chart

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, ROW_HEIGHT, MARGIN = 5.6, 0.26, 0.75
"""Inches: a chart's width, the height of one planner's row, and what is added for the axis."""

CURVES = 3.4
"""Inches. Height of the axes of curves."""

DASHES = ("solid", (0, (5, 2)), (0, (1, 1.5)), (0, (5, 1.5, 1, 1.5)))
"""Each colour comes once with each of these before looks are used again."""

MOST_SHADES = 6
"""Of more curves the intervals are left out: nobody could tell them apart."""

_UNMEASURED = "no time could be measured"

PERFECT = 0.01
"""Per cent. Below, the axis of excess lengths is linear, so that the shortest path has a place."""


@dataclass(frozen=True)
class Look:
    """A planner's looks on the page, the same in all of its pictures."""

    colour: str
    dashes: str | tuple[float, tuple[float, ...]]

    @property
    def svg_dashes(self) -> str:
        """The dashes as SVG has them; empty for a solid line."""
        if isinstance(self.dashes, str):
            return ""
        return " ".join(f"{2 * length:g}" for length in self.dashes[1])


def looks(names: Sequence[str]) -> dict[str, Look]:
    """Return the looks of each planner."""
    count = len(COLOURS)
    return {
        name: Look(COLOURS[k % count], DASHES[k // count % len(DASHES)])
        for k, name in enumerate(names)
    }


@dataclass(frozen=True)
class Chart:
    """A picture with its words; `svg` is None where matplotlib is missing."""

    title: str
    words: str
    svg: str | None


def charts(floor: str, groups: Sequence[Sequence[Attempt]], styles: dict[str, Look]) -> list[Chart]:
    """Return the charts of all planners on one floor, their attempts in `groups`."""
    height = MARGIN + ROW_HEIGHT * len(groups)
    legend = 0.19 * math.ceil(len(groups) / 2) + 0.15

    known = not any(math.isnan(one.asked.shortest) for group in groups for one in group)

    def boxes(of: Callable[[Attempt], float], label: str, scale: str) -> Callable[[Figure], None]:
        return lambda figure: _boxes(figure, groups, styles, of, label, scale)

    def curves(of: Callable[[Sequence[Attempt]], Curve], label: str) -> Callable[[Figure], None]:
        return lambda figure: _curves(figure, groups, styles, of, label)

    def if_known(draw: Callable[[Figure], None]) -> Callable[[Figure], None]:
        unknown = "shortest lengths are not known"
        return draw if known else lambda figure: _say_instead(figure.subplots(), unknown)

    drawn = (
        (
            "CPU time",
            "Of one answer, simplification included.",
            (WIDTH, height),
            boxes(lambda a: 1000 * a.cpu_seconds, "CPU time (ms)", "log"),
        ),
        (
            "Length",
            "How much longer than the shortest path, of what was found.",
            (WIDTH, height),
            if_known(boxes(lambda a: 100 * (a.ratio - 1), "excess length (%)", "symlog")),
        ),
        (
            "Success over time",
            "Questions with a path that nothing is wrong with, after so much time on each.",
            (WIDTH, CURVES + legend),
            curves(success_over_time, "share of questions"),
        ),
        (
            "Cost over time",
            "Median of the best length so far over the shortest; it begins when half of the"
            " questions have a path.",
            (WIDTH, CURVES + legend),
            if_known(curves(cost_over_time, "length ÷ shortest")),
        ),
    )
    return [
        Chart(title, words, page_chart(f"{floor}: {title}", size, draw))
        for title, words, size, draw in drawn
    ]


def _boxes(
    figure: Figure,
    groups: Sequence[Sequence[Attempt]],
    styles: dict[str, Look],
    of: Callable[[Attempt], float],
    label: str,
    scale: str,
) -> None:
    """Draw the middle half of each planner's values as a box, nine tenths of them as a line."""
    axes = figure.subplots()
    everything = np.array([of(attempt) for group in groups for attempt in group])
    if not np.isfinite(everything).any():
        return _say_instead(axes, "no path was found")
    if scale == "log" and not (everything > 0).any():
        return _say_instead(axes, _UNMEASURED)
    names = [group[0].asked.planner for group in groups]
    for place, group in enumerate(groups):
        values = np.array([of(attempt) for attempt in group])
        values = values[np.isfinite(values)]
        if scale == "symlog":  # the reference may be a hair too long
            values = np.maximum(values, 0.0)
        if not len(values):
            continue
        colour = styles[names[place]].colour
        ends = np.quantile(values, [0.05, 0.25, 0.5, 0.75, 0.95])
        axes.plot(ends[[0, 4]], [place, place], color=colour, linewidth=1.2)
        width = ends[3] - ends[1]
        axes.barh(place, width, left=ends[1], height=0.6, color=colour, alpha=0.45, linewidth=0)
        axes.plot(ends[[2, 2]], [place - 0.3, place + 0.3], color=INK, linewidth=1.8)
        beyond = values[(values < ends[0]) | (values > ends[4])]
        axes.plot(beyond, [place] * len(beyond), ".", color=colour, markersize=2.5)
    if scale == "symlog":
        axes.set_xscale("symlog", linthresh=PERFECT, linscale=0.5)
        axes.set_xlim(left=-PERFECT / 5)
        axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    else:
        axes.set_xscale("log")
    axes.set_xlabel(label)
    name_rows(axes, names)
    return None


def _curves(
    figure: Figure,
    groups: Sequence[Sequence[Attempt]],
    styles: dict[str, Look],
    of: Callable[[Sequence[Attempt]], Curve],
    label: str,
) -> None:
    """Draw a step for each change, with its interval around it, and the names below."""
    axes = figure.subplots()
    found = [(group[0].asked.planner, of(group)) for group in groups]
    changes = [curve.seconds for _, curve in found if len(curve.seconds)]
    if not changes:
        return _say_instead(axes, "no path was found")
    if not any(np.isfinite(curve.value).any() for _, curve in found):
        return _say_instead(axes, "fewer than half of the questions have a path")
    last = max(seconds[-1] for seconds in changes)
    if not last > 0:  # a logarithmic axis has no place for it
        return _say_instead(axes, _UNMEASURED)
    tops = []
    for name, curve in found:
        look = styles[name]
        seconds = np.append(curve.seconds, last) * 1000
        value, low, high = (
            np.append(figures, figures[-1:] if len(figures) else [math.nan])
            for figures in (curve.value, curve.low, curve.high)
        )
        value = np.where(np.isfinite(value), value, math.nan)
        tops += value[np.isfinite(value)].tolist()
        axes.step(
            seconds,
            value,
            where="post",
            label=name,
            color=look.colour,
            linestyle=look.dashes,
            linewidth=1.5,
        )
        if len(found) > MOST_SHADES:
            continue
        known = np.isfinite(value) & np.isfinite(low)
        top = np.where(np.isfinite(high), high, 1e9)
        axes.fill_between(
            seconds, low, top, where=known, step="post", color=look.colour, alpha=0.13, linewidth=0
        )
    axes.set_xscale("log")
    axes.set_xlabel("CPU time (ms)")
    axes.set_ylabel(label)
    if of is success_over_time:
        axes.set_ylim(-0.03, 1.03)
        axes.yaxis.set_major_formatter(lambda value, _: f"{value:.0%}")
    elif tops:
        room = 0.06 * max(max(tops) - 1, 0.01)
        axes.set_ylim(min(1, *tops) - room, max(tops) + room)
    axes.spines[["right", "top"]].set_visible(False)
    draw_grid(axes, "both")
    figure.legend(loc="outside lower center", ncols=2, frameon=False, fontsize=9)
    return None


def _say_instead(axes: Axes, words: str) -> None:
    """Write into a chart why it shows nothing."""
    axes.set_axis_off()
    axes.text(0.5, 0.5, words, ha="center", va="center", color=INK)
