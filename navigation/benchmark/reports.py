"""Results of the planner benchmark: estimates with confidence intervals, tables, and OMPL's log.

Answers to the same question are similar, so each question counts once, with the share or the median
of its runs. The questions are the sample.
"""

from __future__ import annotations

import csv
import math
import platform
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import fields
from datetime import datetime
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from floorplan.files.dataclass import dataclass

from .measuring import Attempt
from .questions import ENDS

CONFIDENCE = 0.95

_Z = 1.959963984540054
"""Quantile of the normal distribution: 2.5 % are above."""

Floats = NDArray[np.float64]
_Value = TypeVar("_Value")


@dataclass(frozen=True)
class Estimate:
    """Value with its interval of 95 % confidence."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, kw_only=True)
class Curve:
    """Step function of time with intervals: each value is valid until the next of `seconds`."""

    seconds: Floats
    value: Floats
    low: Floats
    high: Floats


def share(values: Sequence[float]) -> Estimate:
    """Return the mean of shares, each from 0 to 1, with Wilson's score interval.

    E. B. Wilson, "Probable inference, the law of succession, and statistical inference", Journal of
    the American Statistical Association 22, 1927. Unlike the normal interval, it is valid if all or
    none succeed.
    """
    n = len(values)
    if not n:
        return Estimate(math.nan, math.nan, math.nan)
    p = math.fsum(values) / n
    # p (1 - p) is the variance of successes and failures, and the maximum variance of any values
    # from 0 to 1 with this mean (R. Bhatia and C. Davis, "A better bound on the variance", American
    # Mathematical Monthly 107, 2000). For other shares the interval is wider than necessary.
    middle = (p + _Z**2 / (2 * n)) / (1 + _Z**2 / n)
    half = _Z / (1 + _Z**2 / n) * math.sqrt(p * (1 - p) / n + _Z**2 / (4 * n**2))
    # If all or none succeed, the interval ends at p, apart from rounding.
    return Estimate(p, max(0.0, min(p, middle - half)), min(1.0, max(p, middle + half)))


def median(values: Sequence[float]) -> Estimate:
    """Return the median, with the interval between two of the sorted values.

    The number of values below the true median is binomial with n and 1/2 for any distribution
    (H. A. David and H. N. Nagaraja, "Order statistics", 3rd edition 2003, 7.1). Fewer than six
    values give the interval from -inf to inf.
    """
    if not len(values) or np.isnan(values).any():
        return Estimate(math.nan, math.nan, math.nan)
    low, high = _ranks(len(values))
    bounded = [-math.inf, *sorted(map(float, values)), math.inf]
    return Estimate(float(np.median(values)), bounded[low], bounded[high])


def by_question(attempts: Iterable[Attempt], values: Iterable[_Value]) -> list[list[_Value]]:
    """Return the values of each question, in the order of the questions."""
    groups: dict[int, list[_Value]] = {}
    for attempt, value in zip(attempts, values, strict=True):
        groups.setdefault(attempt.asked.query, []).append(value)
    return list(groups.values())


def success_over_time(attempts: Sequence[Attempt]) -> Curve:
    """Return the share of questions that have a path, over the CPU time."""
    first = [a.first_seconds if a.right else math.inf for a in attempts]
    seconds = _sorted_times(first)
    after = np.less_equal.outer(first, seconds)
    shares = np.array([np.mean(runs, axis=0) for runs in by_question(attempts, after)])
    return _curve(seconds, [share(column) for column in shares.T.tolist()])


def cost_over_time(attempts: Sequence[Attempt]) -> Curve:
    """Return the median of the best length over the shortest length, over the CPU time.

    A question without a path so far counts as infinitely long, so that no planner gains by
    answering only the easy ones (J. D. Gammell, M. P. Strub and V. N. Hartmann, "Planner Developer
    Tools (PDT)", 2022). Questions that have no path are left out.
    """
    attempts = [attempt for attempt in attempts if attempt.asked.shortest != math.inf]
    seconds = _sorted_times(one.cpu_seconds for a in attempts for one in a.progress)
    if not len(seconds):
        return _curve(seconds, [])
    ratios = by_question(attempts, [_ratios(attempt, seconds) for attempt in attempts])
    per_question = np.array([np.median(runs, axis=0) for runs in ratios])
    return _curve(seconds, [median(column) for column in per_question.T])


MOST_TIMES = 120
"""Maximum number of points of a curve."""


def _sorted_times(times: Iterable[float]) -> Floats:
    """Return the finite times, sorted, and thinned evenly if they are many."""
    finite = np.unique([t for t in times if math.isfinite(t)])
    if len(finite) > MOST_TIMES:
        finite = finite[np.linspace(0, len(finite) - 1, MOST_TIMES).astype(int)]
    return finite.astype(float)


def _ratios(attempt: Attempt, seconds: Floats) -> Floats:
    """Return the best length over the shortest after each of `seconds`, infinite without one."""
    progress = attempt.progress if attempt.right else ()
    shortest = attempt.asked.shortest
    best = [math.inf, *(one.length / shortest if shortest else 1.0 for one in progress)]
    times = [one.cpu_seconds for one in progress]
    return np.array(best)[np.searchsorted(times, seconds, side="right")]


def _curve(seconds: Floats, estimates: Sequence[Estimate]) -> Curve:
    columns = np.array([(e.value, e.low, e.high) for e in estimates]).reshape(-1, 3).T
    return Curve(seconds=seconds, value=columns[0], low=columns[1], high=columns[2])


@cache
def _ranks(n: int) -> tuple[int, int]:
    """Return the ranks (from 1) of the ends of the interval, or 0 and n + 1 for few values."""
    # The true median is below the value of rank k + 1 if at most k of the n values are below it.
    # The lower end has the highest rank at which that has a probability of at most 2.5 %. The upper
    # end mirrors it.
    below = np.cumsum([math.comb(n, k) / 2**n for k in range(n)])
    low = int(np.searchsorted(below, (1 - CONFIDENCE) / 2, side="right"))
    return low, n + 1 - low


@dataclass(frozen=True, kw_only=True)
class PlannerRow:
    """Results of one planner on one floor, in milliseconds of CPU time and metres.

    A field without a comment is the median over the questions of the median of their runs.
    """

    floorplan: str
    planner: str
    queries: int
    runs: int
    solved: Estimate
    """Share of correct answers."""
    wrong: int
    """Number of wrong answers."""
    faults: str
    """Kinds of wrong answers with their numbers."""
    cpu: Estimate
    cpu_99: float
    """99th percentile of all answers."""
    scene: float
    """Median time of updating the planner after AGVs have moved."""
    planning: float
    """Time before simplification."""
    simplification: float
    memory: float
    """Maximum growth of the process in one answer in MB."""
    length: Estimate
    ratio: Estimate
    """Length over the shortest length."""
    ratio_most: float
    """Maximum."""
    listed_ratio: Estimate
    """Length over the length in a scenario, NaN without one."""
    clearance_least: float
    """Minimum."""
    turning: float
    """Radians."""
    ompl_clearance: float
    ompl_smoothness: float


def summary(attempts: Sequence[Attempt]) -> list[PlannerRow]:
    """Return one row for each floor and planner, in the order they were asked."""
    return [_row(group) for group in groups(attempts)]


def groups(attempts: Sequence[Attempt]) -> list[list[Attempt]]:
    """Return the attempts of each planner on each floor, in the order they were asked."""
    grouped: dict[tuple[str, str], list[Attempt]] = {}
    for attempt in attempts:
        grouped.setdefault((attempt.asked.floorplan, attempt.asked.planner), []).append(attempt)
    return list(grouped.values())


def _row(group: Sequence[Attempt]) -> PlannerRow:
    solved = [attempt for attempt in group if attempt.solved]
    faults = Counter(attempt.wrong for attempt in group if attempt.wrong)
    right = by_question(group, [float(attempt.right) for attempt in group])

    def typical(name: str, among: Sequence[Attempt], scale: float = 1) -> Estimate:
        runs = by_question(among, [scale * getattr(attempt, name) for attempt in among])
        return median([float(np.median(values)) for values in runs])

    return PlannerRow(
        floorplan=group[0].asked.floorplan,
        planner=group[0].asked.planner,
        queries=len({attempt.asked.query for attempt in group}),
        runs=len({attempt.asked.run for attempt in group}),
        solved=share([sum(runs) / len(runs) for runs in right]),
        wrong=faults.total(),
        faults=", ".join(f"{fault} {count}" for fault, count in faults.items()),
        cpu=typical("cpu_seconds", group, 1000),
        cpu_99=float(np.percentile([1000 * attempt.cpu_seconds for attempt in group], 99)),
        scene=float(np.median([1000 * attempt.scene_seconds for attempt in group])),
        planning=typical("planning_seconds", group, 1000).value,
        simplification=typical("simplification_seconds", group, 1000).value,
        memory=float(max(attempt.memory for attempt in group)),
        length=typical("length", solved),
        ratio=typical("ratio", solved),
        # Unknown if any is, as the median, because NumPy's maximum of NaN and others is NaN.
        ratio_most=float(np.max([attempt.ratio for attempt in solved])) if solved else math.nan,
        listed_ratio=typical("listed_ratio", solved),
        clearance_least=min([attempt.clearance for attempt in solved], default=math.nan),
        turning=typical("turning", solved).value,
        ompl_clearance=typical("ompl_clearance", solved).value,
        ompl_smoothness=typical("ompl_smoothness", solved).value,
    )


_INNER = ("asked", "points", "progress")
"""Fields of an attempt that are no columns."""


def write_csv(attempts: Sequence[Attempt], path: Path) -> None:
    """Write every answer as a line of `path`, in metres and seconds of CPU time."""
    measures = [field.name for field in fields(Attempt) if field.name not in _INNER]
    rows = []
    for attempt in attempts:
        asked = attempt.asked
        columns = {name: getattr(asked, name) for name in _ASKED}
        columns |= zip(ENDS, (*asked.start, *asked.goal), strict=True)
        columns |= {name: getattr(attempt, name) for name in measures}
        columns |= {"shortest": asked.shortest, "listed": asked.listed, "ratio": attempt.ratio}
        rows.append(columns)
    _write(path, rows)


_ASKED = ("floorplan", "planner", "query", "run", "seed")
"""First columns of an answer."""


def write_summary(rows: Sequence[PlannerRow], path: Path) -> None:
    """Write every row as a line of `path`, with ends of intervals in `_low` and `_high`."""
    lines = []
    for row in rows:
        columns: dict[str, object] = {}
        for name, value in vars(row).items():
            if isinstance(value, Estimate):
                columns |= {name: value.value, f"{name}_low": value.low, f"{name}_high": value.high}
            else:
                columns[name] = value
        lines.append(columns)
    _write(path, lines)


def _write(path: Path, rows: Sequence[dict[str, object]]) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, rows[0] if rows else (), lineterminator="\n")
        if rows:
            writer.writeheader()
        writer.writerows(rows)


def _if_solved(name: str) -> Callable[[Attempt], object]:
    return lambda attempt: getattr(attempt, name) if attempt.solved else ""


_PROPERTIES: dict[str, Callable[[Attempt], object]] = {
    "time REAL": lambda attempt: attempt.planning_seconds,
    "solved BOOLEAN": lambda attempt: int(attempt.solved),
    "simplification time REAL": lambda attempt: attempt.simplification_seconds,
    "memory REAL": lambda attempt: attempt.memory,
    "solution length REAL": _if_solved("length"),
    "solution clearance REAL": _if_solved("ompl_clearance"),
    "solution smoothness REAL": _if_solved("ompl_smoothness"),
    "solution segments INTEGER": lambda attempt: attempt.bends + 1 if attempt.solved else "",
    "least clearance REAL": _if_solved("clearance"),
    "turning REAL": _if_solved("turning"),
    "shortest length REAL": lambda attempt: attempt.asked.shortest,
    "length ratio REAL": _if_solved("ratio"),
    "correct solution BOOLEAN": lambda attempt: int(attempt.right),
    "query INTEGER": lambda attempt: attempt.asked.query,
    "run INTEGER": lambda attempt: attempt.asked.run,
}
"""Properties of each run: name and type, and value."""

_LOG_HEAD = """\
OMPL version {ompl}
Experiment {experiment}
0 experiment properties
Running on {host}
Starting at {now}
<<<|
Floorwalker's planner benchmark. Runs go through all queries; times are of the CPU.
|>>>
<<<|
{processor}
|>>>
{seed} is the random seed
{limit:.6f} seconds per run
0 MB per run
{runs} runs per planner
{spent:.6f} seconds spent to collect the data
0 enum types
{planners} planners
"""


def write_ompl_log(
    attempts: Sequence[Attempt], path: Path, *, seed: int, seconds: float | None = None
) -> None:
    """Write the answers on one floor as OMPL's benchmark log.

    `ompl_benchmark_statistics` and Planner Arena read it. Columns with names of OMPL's properties
    contain these properties, except that times are of the CPU. `seconds` is the budget of an
    answer, if there was one.
    """
    planners = groups(attempts)
    times = [attempt.cpu_seconds for attempt in attempts]
    head = _LOG_HEAD.format(
        ompl=version("ompl"),
        experiment="_".join(attempts[0].asked.floorplan.split()),
        host="_".join(platform.node().split()) or "UNKNOWN",
        now=datetime.now().isoformat(timespec="seconds"),
        processor=platform.processor() or platform.machine(),
        seed=seed,
        limit=max(times) if seconds is None else seconds,  # without a budget, this is no limit
        runs=len(attempts) // len(planners),
        spent=sum(times),
        planners=len(planners),
    )
    lines = [line for runs in planners for line in _log_of(runs)]
    path.write_text(head + "\n".join([*lines, ""]), encoding="utf-8")


def _log_of(runs: Sequence[Attempt]) -> Iterator[str]:
    """Yield the lines about one planner."""
    yield f"geometric_{runs[0].asked.planner}"
    yield "0 common properties"
    yield f"{len(_PROPERTIES)} properties for each run"
    yield from _PROPERTIES
    yield f"{len(runs)} runs"
    for attempt in runs:
        yield "".join(f"{value(attempt)}; " for value in _PROPERTIES.values())
    yield "3 progress properties for each run"
    yield from ("time REAL", "iterations INTEGER", "best cost REAL")
    yield f"{len(runs)} runs"
    for attempt in runs:
        yield "".join(f"{p.cpu_seconds},{p.iterations},{p.length},;" for p in attempt.progress)
    yield "."
