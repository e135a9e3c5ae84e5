"""Report of a planner benchmark: tables, charts, and pictures of paths."""

from __future__ import annotations

import math
import os
import platform
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from datetime import date
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import shapely

from floorplan import Floorplan, Point
from floorplan.files.dataclass import dataclass
from navigation.benchmark import (
    PEERS,
    SHORTFALL,
    TOUCHES,
    Attempt,
    Curve,
    Estimate,
    PlannerRow,
    cost_over_time,
    groups,
    success_over_time,
    summary,
)

from ..core.wording import figure, interval, trimmed
from .report_page import COLOURS, INK, draw_box, draw_grid, name_rows, page_chart, write_report_page

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


__all__ = ["write_page"]


WIDTH, ROW_HEIGHT, MARGIN = 5.6, 0.26, 0.75
"""Inches: width of a chart, height of one planner's row, and height of the axis."""

CURVES = 3.4
"""Inches. Height of the axes of curves."""

DASHES = ("solid", (0, (5, 2)), (0, (1, 1.5)), (0, (5, 1.5, 1, 1.5)))
"""Dashes of lines. Each is used once with every colour before looks repeat."""

MOST_SHADES = 6
"""Maximum number of curves with intervals, because more would be indistinguishable."""

_UNMEASURED = "no time could be measured"

PERFECT = 0.01
"""Per cent. The axis of excess lengths is linear below, so that 0 has a place."""


@dataclass(frozen=True)
class Look:
    """Look of a planner in all pictures of the page."""

    colour: str
    dashes: str | tuple[float, tuple[float, ...]]

    @property
    def svg_dashes(self) -> str:
        """Dashes in the notation of SVG, empty for a solid line."""
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
class BenchmarkChart:
    """A picture with its words. `svg` is None without matplotlib."""

    title: str
    words: str
    svg: str | None


def charts(
    floor: str, groups: Sequence[Sequence[Attempt]], styles: dict[str, Look]
) -> list[BenchmarkChart]:
    """Return the charts of all planners on one floor, their attempts in `groups`."""
    height = MARGIN + ROW_HEIGHT * len(groups)
    legend = 0.19 * math.ceil(len(groups) / 2) + 0.15

    is_complete = not any(math.isnan(one.asked.shortest) for group in groups for one in group)

    def boxes(of: Callable[[Attempt], float], label: str, scale: str) -> Callable[[Figure], None]:
        return lambda figure: _boxes(figure, groups, styles, of, label, scale)

    def curves(of: Callable[[Sequence[Attempt]], Curve], label: str) -> Callable[[Figure], None]:
        return lambda figure: _curves(figure, groups, styles, of, label)

    def if_known(draw: Callable[[Figure], None]) -> Callable[[Figure], None]:
        unknown = "shortest lengths are not known"
        return draw if is_complete else lambda figure: _say_instead(figure.subplots(), unknown)

    drawn = (
        (
            "CPU time",
            "Of one answer, simplification included.",
            (WIDTH, height),
            boxes(lambda a: 1000 * a.cpu_seconds, "CPU time (ms)", "log"),
        ),
        (
            "Length",
            "Excess length of the paths that were found.",
            (WIDTH, height),
            if_known(boxes(lambda a: 100 * (a.ratio - 1), "excess length (%)", "symlog")),
        ),
        (
            "Success over time",
            "Share of queries with a valid path after a given time.",
            (WIDTH, CURVES + legend),
            curves(success_over_time, "share of queries"),
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
        BenchmarkChart(title, words, page_chart(f"{floor}: {title}", size, draw))
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
        if scale == "symlog":  # the reference may be slightly too long
            values = np.maximum(values, 0.0)
        if not len(values):
            continue
        colour = styles[names[place]].colour
        least, middle, most = draw_box(axes, place, values, colour, 0.6)
        axes.plot([middle, middle], [place - 0.3, place + 0.3], color=INK, linewidth=1.8)
        beyond = values[(values < least) | (values > most)]
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
    curves = [(group[0].asked.planner, of(group)) for group in groups]
    changes = [curve.seconds for _, curve in curves if len(curve.seconds)]
    if not changes:
        return _say_instead(axes, "no path was found")
    if not any(np.isfinite(curve.value).any() for _, curve in curves):
        return _say_instead(axes, "fewer than half of the queries have a path")
    last = max(seconds[-1] for seconds in changes)
    if not last > 0:  # a logarithmic axis has no place for it
        return _say_instead(axes, _UNMEASURED)
    tops = []
    for name, curve in curves:
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
        if len(curves) > MOST_SHADES:
            continue
        is_finite = np.isfinite(value) & np.isfinite(low)
        top = np.where(np.isfinite(high), high, 1e9)
        axes.fill_between(
            seconds,
            low,
            top,
            where=is_finite,
            step="post",
            color=look.colour,
            alpha=0.13,
            linewidth=0,
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
    """Write into a chart why it is empty."""
    axes.set_axis_off()
    axes.text(0.5, 0.5, words, ha="center", va="center", color=INK)


@dataclass(frozen=True)
class PathLine:
    """A planner's path, as an attribute of SVG."""

    planner: str
    points: str
    look: Look
    words: str


@dataclass(frozen=True)
class PathPicture:
    """A floor with the paths of one query. y points down, as in SVG."""

    query: int
    view: str
    walls: str
    blocks: str
    agvs: str
    start: Point
    goal: Point
    lines: tuple[PathLine, ...]
    unit: float
    """Metres. Length that looks the same on every floor."""


def picture(plan: Floorplan, attempts: Sequence[Attempt], styles: dict[str, Look]) -> PathPicture:
    """Return the first answers of `attempts`, all to one query, on `plan`."""
    first = attempts[0].asked
    west, south, east, north = plan.boundary.bounds
    extent = max(east - west, north - south)
    margin = 0.02 * extent
    standing = [o.footprint for o in plan.obstacles if o.overlaps(0.0, plan.human.height)]
    lanes = [plan.lane(name).footprint(at) for name, at in first.agvs]
    return PathPicture(
        query=first.query,
        view=_numbers(
            west - margin, -north - margin, east - west + 2 * margin, north - south + 2 * margin
        ),
        walls=_outlines([plan.boundary]),
        blocks=_outlines(standing),
        agvs=_outlines(lanes),
        start=(first.start[0], -first.start[1]),
        goal=(first.goal[0], -first.goal[1]),
        lines=tuple(_lines(attempts, styles)),
        unit=extent / 100,
    )


def telling(attempts: Sequence[Attempt]) -> int:
    """Return the query whose paths differ most in length, and of equal ones the longest."""
    by_query: dict[int, list[float]] = {}
    for attempt in attempts:
        if attempt.solved and attempt.asked.run == 0:
            by_query.setdefault(attempt.asked.query, []).append(attempt.length)

    def spread(query: int) -> tuple[float, float]:
        lengths = by_query[query]
        return (round(max(lengths) - min(lengths), 2), max(lengths))

    return max(by_query, key=spread, default=attempts[0].asked.query)


def _lines(attempts: Sequence[Attempt], styles: dict[str, Look]) -> Iterator[PathLine]:
    for attempt in attempts:
        name = attempt.asked.planner
        if attempt.points is None:
            yield PathLine(name, "", styles[name], attempt.reason.replace("_", " ") or "no path")
            continue
        words = f"{attempt.length:.2f} m"
        if math.isfinite(attempt.ratio):
            longer = round(100 * (attempt.ratio - 1), 2) + 0.0  # and no -0.00
            words += f", {longer:+.2f} %"
        if attempt.wrong:
            words += f", {attempt.wrong}"
        corners = " ".join(_numbers(x, -y, between=",") for x, y in attempt.points.tolist())
        yield PathLine(name, corners, styles[name], words)


def _outlines(areas: Sequence[shapely.Polygon]) -> str:
    """Return the rings of all areas as the data of one path."""
    rings = [ring for area in areas for ring in (area.exterior, *area.interiors)]
    return "".join(f"M{_corners(ring)}Z" for ring in rings)


def _corners(ring: shapely.LinearRing) -> str:
    points = shapely.get_coordinates(ring)[:-1] * np.array([1.0, -1.0])
    return "L".join(_numbers(x, y) for x, y in points.tolist())


def _numbers(*values: float, between: str = " ") -> str:
    return between.join(trimmed(value) for value in values)


@dataclass(frozen=True)
class BenchmarkFloor:
    """Contents of the page about one floor."""

    plan: Floorplan
    rows: tuple[PlannerRow, ...]
    charts: tuple[BenchmarkChart, ...]
    picture: PathPicture

    @property
    def listed(self) -> bool:
        """True if a scenario listed lengths to compare with."""
        return any(not math.isnan(row.listed_ratio.value) for row in self.rows)


def write_page(
    attempts: Sequence[Attempt],
    plans: Sequence[Floorplan],
    path: Path,
    *,
    terms: Mapping[str, str],
    on_the_clock: bool,
) -> None:
    """Write the page about `attempts` on `plans` to `path`.

    `terms` describes the conditions by name. They include the machine if `on_the_clock`.
    """
    styles = looks(list(dict.fromkeys(attempt.asked.planner for attempt in attempts)))
    floors = []
    for plan in plans:
        there = [group for group in groups(attempts) if group[0].asked.floorplan == plan.name]
        everything = [attempt for group in there for attempt in group]
        query = telling(everything)
        drawn = [a for a in everything if a.asked.query == query and a.asked.run == 0]
        floors.append(
            BenchmarkFloor(
                plan,
                tuple(summary(everything)),
                tuple(charts(plan.name, there, styles)),
                picture(plan, drawn, styles),
            )
        )
    write_report_page(
        path,
        "benchmark.html",
        {"figure": figure, "ms": milliseconds, "interval": interval_of},
        floors=floors,
        answers=len(attempts),
        terms={**terms, **_machine(styles)},
        on_the_clock=on_the_clock,
        shortfall=100 * SHORTFALL,
        touches=1000 * TOUCHES,
        day=date.today().isoformat(),
    )


def milliseconds(value: float) -> str:
    """Return a time with two or three digits that count."""
    digits = 0 if value >= 100 else 1 if value >= 10 else 2 if value >= 0.1 else 3
    return figure(value, digits if value else 0)


def interval_of(estimate: Estimate, digits: int = 2) -> str:
    """Return the interval of a figure, empty if it has none or no width."""
    if not (math.isfinite(estimate.low) and math.isfinite(estimate.high)):
        return ""
    low, high = figure(estimate.low, digits), figure(estimate.high, digits)
    return interval(estimate.low, estimate.high, digits) if low != high else ""


def _machine(planners: Collection[str]) -> dict[str, str]:
    """Return the conditions on which the times of these planners depend, by name."""
    others = [name for name in planners if name in PEERS and PEERS[name].module != "ompl"]
    return {
        "machine": f"{_processor()}, {os.cpu_count()} cores, {platform.system()}",
        "software": ", ".join(
            [
                f"Floorwalker {version('floorwalker')}",
                f"OMPL {version('ompl')}",
                f"Python {platform.python_version()}",
                *(f"{name} {version(name)}" for name in others),
            ]
        ),
    }


def _processor() -> str:
    """Return the name of the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return next(iter(names), "") or platform.processor() or platform.machine()
