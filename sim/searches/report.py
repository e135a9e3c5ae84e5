"""Report of a search: its cases, the objective over evaluations, and the coverage of pairs."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from floorplan.files.dataclass import dataclass

from ..core.wording import counted, figure, minus, percent
from ..views.report_page import (
    BLUE,
    GREY,
    INK,
    VERMILION,
    draw_grid,
    page_chart,
    write_report_page,
)
from .evaluations import Evaluation
from .objective import Situation
from .results import Case, SearchResults
from .space import Dimension

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BINS = 6
"""Parts of the range of numbers in the coverage."""

MOST_DIMENSIONS = 8
"""So many dimensions are paired in the coverage, those of several values first."""

MOST_LISTED = 30
"""So many of the worst evaluations, and of those that make no trial, are listed."""

SMALL = 0.001
"""Values of the objective that are smaller are shown with their first digit."""

WIDTH, HEIGHT = 8.0, 3.2
"""Inches of the chart of the objective."""

FEWEST_COLUMNS = 4
"""Number of columns in the grid of the coverage, at least, so that letters keep their size."""

VALUES = 8
"""Size of the values at the axes of the coverage, points."""


@dataclass(frozen=True)
class CoveredPair:
    """Coverage of two dimensions: evaluations in each cell, and the least value there."""

    one: Dimension
    other: Dimension
    counts: np.ndarray[Any, Any]
    least: np.ndarray[Any, Any]

    @property
    def share(self) -> float:
        """Share of cells in which something was tried."""
        return float((self.counts > 0).mean())


def coverage(results: SearchResults) -> list[CoveredPair]:
    """Return the coverage of each pair of dimensions."""
    several = [one for one in results.space.dimensions if one.values or one.low < one.high]
    tried = [one for one in results.evaluations if one.result != "no trial"]
    return [
        _pair(one, other, tried)
        for one, other in itertools.combinations(several[:MOST_DIMENSIONS], 2)
    ]


def _pair(one: Dimension, other: Dimension, tried: list[Evaluation]) -> CoveredPair:
    shape = (_size(one), _size(other))
    counts, least = np.zeros(shape, dtype=int), np.full(shape, math.inf)
    for evaluation in tried:
        cell = (_cell(one, evaluation), _cell(other, evaluation))
        counts[cell] += 1
        least[cell] = min(least[cell], evaluation.rank)
    return CoveredPair(one, other, counts, least)


def _size(one: Dimension) -> int:
    return len(one.values) or BINS


def _cell(one: Dimension, evaluation: Evaluation) -> int:
    coordinate = evaluation.point[one.name]
    if one.values:
        return one.values.index(coordinate)
    return min(int(one.share(coordinate) * BINS), BINS - 1)


def objective_chart(results: SearchResults) -> str | None:
    """Return the objective over the evaluations as SVG, or None without matplotlib."""
    tried = [
        one for one in results.evaluations if one.value is not None and math.isfinite(one.value)
    ]

    def draw(drawn: Figure) -> None:
        axes = drawn.subplots()
        for label, colour, some in (
            ("random", GREY, [one for one in tried if one.is_random]),
            (results.sampler, BLUE, [one for one in tried if not one.is_random]),
        ):
            if some:
                at = [one.number for one in some]
                axes.scatter(at, [_number(one) for one in some], s=9, color=colour, label=label)
        least = np.minimum.accumulate([_number(one) for one in tried])
        axes.step([one.number for one in tried], least, where="post", color=INK, linewidth=1.2)
        axes.axhline(results.objective.below, color=VERMILION, linewidth=0.9)
        axes.set_xlabel("evaluation")
        axes.set_ylabel(str(results.objective))
        axes.spines[["right", "top"]].set_visible(False)
        axes.legend(frameon=False, fontsize=8)
        draw_grid(axes, "y")

    return page_chart("objective", (WIDTH, HEIGHT), draw) if tried else None


def _number(one: Evaluation) -> float:
    assert one.value is not None
    return one.value


def coverage_chart(results: SearchResults, pairs: list[CoveredPair]) -> str | None:
    """Return the grid of pairs as SVG: dark where much was tried, a cross where something broke."""
    names = [*dict.fromkeys(name for pair in pairs for name in (pair.one.name, pair.other.name))]
    below = results.objective.below

    def draw(drawn: Figure) -> None:
        side = len(names) - 1
        grid = drawn.add_gridspec(side, max(side, FEWEST_COLUMNS))
        for pair in pairs:
            column, row = names.index(pair.one.name), names.index(pair.other.name) - 1
            axes = drawn.add_subplot(grid[row, column])
            axes.imshow(
                np.log1p(pair.counts.T), origin="lower", aspect="auto", cmap="Greys", vmin=0.0
            )
            x, y = np.nonzero(pair.least < below)
            axes.plot(x, y, "x", color=VERMILION, markersize=6, markeredgewidth=1.5)
            axes.set_xticks([], [])
            axes.set_yticks([], [])
            if row == side - 1:
                axes.set_xticks(*_ticks(pair.one), fontsize=VALUES, rotation=90)
                axes.set_xlabel(_in_lines(pair.one.name))
            if column == 0:
                axes.set_yticks(*_ticks(pair.other), fontsize=VALUES)
                axes.set_ylabel(_in_lines(pair.other.name))

    side = max(len(names) - 1, 1)
    height = side * WIDTH / max(side, FEWEST_COLUMNS) + 1.0
    return page_chart("coverage", (WIDTH, height), draw) if pairs else None


def _ticks(one: Dimension) -> tuple[list[float], list[str]]:
    """Return places and labels at an axis: all values of a choice, or both ends of a range."""
    if one.values:
        return [*map(float, range(len(one.values)))], [short(value) for value in one.values]
    return [-0.5, BINS - 0.5], [short(one.low), short(one.high)]


def _in_lines(name: str) -> str:
    """Return the name of a dimension with each part of its path on a line."""
    return name.replace(".", ".\n")


def write_report(results: SearchResults, path: Path) -> None:
    """Write the page about a search to `path`."""
    pairs = coverage(results)
    ranked = sorted(results.evaluations, key=lambda one: (one.rank, one.number))
    names = varying(results)
    write_report_page(
        path,
        "search.html",
        {"figure": figure},
        results=results,
        name=results.study.name,
        below=rounded(results.objective.below),
        cases=[_case(case, results) for case in results.cases],
        film=next((case.film for case in results.cases if case.film), ""),
        chart=objective_chart(results),
        grid=coverage_chart(results, pairs),
        shares=[(pair.one.name, pair.other.name, percent(pair.share)) for pair in pairs],
        names=names,
        listed=[
            (one, shown(one), [short(one.values.get(name)) for name in names])
            for one in ranked[:MOST_LISTED]
            if one.result != "no trial"
        ],
        no_trial=results.no_trial[:MOST_LISTED],
    )


def _case(case: Case, results: SearchResults) -> Mapping[str, Any]:
    minimised = case.minimised
    trial = case.path.relative_to(results.folder).as_posix() if case.path else ""
    replay = case.replay
    return {
        "found": shown(case.evaluation),
        "number": case.evaluation.number,
        "where": where(case.situation),
        "trial": trial,
        "replay": replay.relative_to(results.folder).as_posix()
        if replay is not None and replay.exists()
        else "",
        "value": "" if minimised is None else _minimised_value(minimised.value),
        "size": "" if minimised is None else ", ".join(size(case)),
        "runs": 0 if minimised is None else minimised.runs,
    }


def _minimised_value(value: float | None) -> str:
    return "error" if value is None else rounded(value)


def size(case: Case) -> Iterator[str]:
    """Yield what a minimised trial consists of, in words."""
    assert case.minimised is not None
    trial = case.minimised.trial
    people, jobs = len(trial.people), len(trial.gantry.jobs)
    moves = sum(len(moves) for moves in trial.agvs.values())
    yield counted(people, "person")
    yield counted(jobs, "job")
    if moves:
        yield counted(moves, "AGV move")
    yield f"{trial.duration:g} s"


def shown(one: Evaluation) -> str:
    """Return the value of an evaluation in words, or that it failed."""
    if one.result != "run":
        return one.result
    return "–" if one.value is None else rounded(one.value)


def rounded(value: float) -> str:
    """Return a value of the objective with three decimals, or with its first digit if less."""
    if value == round(value):
        return minus(f"{value:g}")
    return minus(f"{value:.3f}" if abs(value) >= SMALL else f"{value:.1g}")


def varying(results: SearchResults) -> list[str]:
    """Return the names of what differs between evaluations, without the seed."""
    values: dict[str, set[str]] = {}
    for one in results.evaluations:
        if one.result != "no trial":
            for name, value in one.values.items():
                values.setdefault(name, set()).add(str(value))
    return [name for name, different in values.items() if len(different) > 1 and name != "seed"]


def short(value: Any) -> str:
    """Return a value of a variable in words."""
    if isinstance(value, tuple):
        return " ".join(map(short, value))
    if not isinstance(value, float):
        return minus(str(value)) if isinstance(value, int) else str(value)
    return minus(f"{round(value, 2):g}" if abs(value) >= 1.0 else f"{value:.2g}")


def where(at: Situation) -> str:
    """Return a situation in words."""
    if at.error:
        return at.error
    parts = [f"{at.person} and {at.machine}" if at.machine else at.person]
    if at.x is not None and at.y is not None:
        parts.append(minus(f"at ({at.x:.1f}, {at.y:.1f})"))
    if at.time is not None:
        parts.append(f"t = {at.time:.1f} s")
    return ", ".join(filter(None, parts))
