"""Results of the planner benchmark: estimates with confidence intervals, tables, and OMPL's log.

Answers to the same question are alike, and so a question counts once, however often it is asked:
of its runs the share or the median is taken, and the questions are the sample.
"""

from __future__ import annotations

import csv
import math
import platform
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, fields
from datetime import datetime
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from .measuring import Attempt

CONFIDENCE = 0.95

_Z = 1.959963984540054
"""Of the normal distribution: 2.5 % lie above it."""

Floats = NDArray[np.float64]
_Value = TypeVar("_Value")


@dataclass(frozen=True)
class Estimate:
    """A figure, and the interval that holds its true value with 95 % confidence."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, kw_only=True)
class Curve:
    """A figure over time: from each of `seconds` on it has its value, until the next."""

    seconds: Floats
    value: Floats
    low: Floats
    high: Floats


def share(values: Sequence[float]) -> Estimate:
    """Return the mean of shares, each from 0 to 1, with Wilson's score interval.

    E. B. Wilson, Probable inference, the law of succession, and statistical inference, Journal of
    the American Statistical Association 22, 1927. Unlike the normal one it holds where all or none
    succeed.
    """
    n = len(values)
    if not n:
        return Estimate(math.nan, math.nan, math.nan)
    p = math.fsum(values) / n
    # p (1 - p) is the variance of successes and failures, and the largest that any values from 0 to
    # 1 with this mean can have (R. Bhatia and C. Davis, A better bound on the variance, American
    # Mathematical Monthly 107, 2000): of shares between, the interval is rather too wide.
    middle = (p + _Z**2 / (2 * n)) / (1 + _Z**2 / n)
    half = _Z / (1 + _Z**2 / n) * math.sqrt(p * (1 - p) / n + _Z**2 / (4 * n**2))
    # Where all or none succeed the interval ends at p, but for rounding.
    return Estimate(p, max(0.0, min(p, middle - half)), min(1.0, max(p, middle + half)))


def median(values: Sequence[float]) -> Estimate:
    """Return the median, with the interval between two of the sorted values.

    How many of n values lie below the true median is binomial with n and 1/2, whatever they are
    distributed like: H. A. David and H. N. Nagaraja, Order statistics, 3rd edition 2003, 7.1. Of
    fewer than six values no two are far enough apart: it is then from -inf to inf.
    """
    ordered = np.sort(np.asarray(values, dtype=float))
    if not len(ordered) or np.isnan(ordered).any():
        return Estimate(math.nan, math.nan, math.nan)
    low, high = _ranks(len(ordered))
    if low < 0:
        return Estimate(_middle(ordered), -math.inf, math.inf)
    return Estimate(_middle(ordered), float(ordered[low]), float(ordered[high]))


def by_question(attempts: Iterable[Attempt], values: Iterable[_Value]) -> list[list[_Value]]:
    """Return the values of each question, in the order that the questions were asked."""
    groups: dict[int, list[_Value]] = {}
    for attempt, value in zip(attempts, values, strict=True):
        groups.setdefault(attempt.asked.query, []).append(value)
    return list(groups.values())


def success_over_time(attempts: Sequence[Attempt]) -> Curve:
    """Return the share of the questions for which there was a path after so many seconds."""
    first = [a.first_seconds if a.right else math.inf for a in attempts]
    seconds = _instants(first)
    questions = by_question(attempts, first)
    shares = [
        share([sum(one <= t for one in question) / len(question) for question in questions])
        for t in seconds
    ]
    return _curve(seconds, shares)


def cost_over_time(attempts: Sequence[Attempt]) -> Curve:
    """Return the median of the best length so far over the shortest, after so many seconds.

    A question without a path so far counts as infinitely long, so that no planner gains by
    answering only the easy ones: J. D. Gammell, M. P. Strub and V. N. Hartmann, Planner Developer
    Tools (PDT), 2022. Those that no path answers are left out.
    """
    attempts = [attempt for attempt in attempts if attempt.asked.shortest != math.inf]
    seconds = _instants(one.cpu_seconds for a in attempts for one in a.progress)
    if not len(seconds):
        return _curve(seconds, [])
    ratios = by_question(attempts, [_ratios(attempt, seconds) for attempt in attempts])
    per_question = np.array([[_middle(c) for c in np.sort(runs, axis=0).T] for runs in ratios])
    return _curve(seconds, [median(column) for column in per_question.T])


MOST_INSTANTS = 120
"""So many points a curve has at most."""


def _instants(times: Iterable[float]) -> Floats:
    """Return finite times, sorted; of many those that part them evenly."""
    finite = np.unique([t for t in times if math.isfinite(t)])
    if len(finite) > MOST_INSTANTS:
        finite = finite[np.linspace(0, len(finite) - 1, MOST_INSTANTS).astype(int)]
    return finite.astype(float)


def _ratios(attempt: Attempt, seconds: Floats) -> Floats:
    """Return the best length over the shortest after each of `seconds`; infinite without one."""
    times = [one.cpu_seconds for one in attempt.progress] if attempt.right else []
    shortest = attempt.asked.shortest
    lengths = [one.length / shortest if shortest else 1.0 for one in attempt.progress]
    best = np.array([math.inf, *lengths[: len(times)]])
    return best[np.searchsorted(times, seconds, side="right")]


def _curve(seconds: Floats, estimates: Sequence[Estimate]) -> Curve:
    figures = np.array([(e.value, e.low, e.high) for e in estimates]).reshape(-1, 3)
    value, low, high = figures.T
    return Curve(seconds=seconds, value=value, low=low, high=high)


def _middle(ordered: Floats) -> float:
    """Return the median of sorted values, which may be infinite."""
    low, high = float(ordered[(len(ordered) - 1) // 2]), float(ordered[len(ordered) // 2])
    return low if low == high else (low + high) / 2


@cache
def _ranks(n: int) -> tuple[int, int]:
    """Return the places (from 0) of the ends of the interval; -1 where there are too few."""
    # The true median is below the value at the place k (from 0) if at most k of the n lie below it.
    # The innermost place at which that has a probability of at most 2.5 % is the lower end; the
    # upper one mirrors it.
    below = 0.0
    for k in range(n):
        below += math.comb(n, k) / 2**n
        if below > (1 - CONFIDENCE) / 2:
            return k - 1, n - k
    return -1, n


@dataclass(frozen=True, kw_only=True)
class PlannerRow:
    """Results of one planner on one floor: milliseconds of CPU, metres.

    Of what a question's runs differ in, their median (or share) is taken first.
    """

    floorplan: str
    planner: str
    queries: int
    runs: int
    solved: Estimate
    """A share of 1: by a path that nothing is wrong with, or by the proof where there is none."""
    wrong: int
    """Answers."""
    faults: str
    """What is wrong with these, and how many times."""
    cpu: Estimate
    """The median."""
    cpu_99: float
    scene: float
    """Median of what it takes to look at where the AGVs stand."""
    planning: float
    """The median of the time before simplification."""
    simplification: float
    memory: float
    """MB, the most that the process grew by in one answer."""
    checks: float
    """The median."""
    length: Estimate
    """The median."""
    ratio: Estimate
    """The median of length over that of the shortest path."""
    ratio_most: float
    listed_ratio: Estimate
    """The median of length over that which a scenario lists; NaN without one."""
    clearance_least: float
    turning: float
    """The median of the radians that a path turns by."""
    ompl_clearance: float
    """The median."""
    ompl_smoothness: float
    """The median."""


def summary(attempts: Sequence[Attempt]) -> list[PlannerRow]:
    """Return one row for each floor and planner, in the order they were asked."""
    return [_row(group) for group in groups(attempts)]


def groups(attempts: Sequence[Attempt]) -> list[list[Attempt]]:
    """Return the attempts of each planner on each floor, in the order they were asked."""
    found: dict[tuple[str, str], list[Attempt]] = {}
    for attempt in attempts:
        found.setdefault((attempt.asked.floorplan, attempt.asked.planner), []).append(attempt)
    return list(found.values())


def _row(group: Sequence[Attempt]) -> PlannerRow:
    found = [attempt for attempt in group if attempt.solved]
    faults = Counter(attempt.wrong for attempt in group if attempt.wrong)
    cpu = [1000 * attempt.cpu_seconds for attempt in group]
    right = by_question(group, [float(attempt.right) for attempt in group])

    def middle(of: Callable[[Attempt], float], among: Sequence[Attempt] = found) -> Estimate:
        values = by_question(among, [of(attempt) for attempt in among])
        return median([float(np.median(runs)) for runs in values])

    return PlannerRow(
        floorplan=group[0].asked.floorplan,
        planner=group[0].asked.planner,
        queries=len({attempt.asked.query for attempt in group}),
        runs=len({attempt.asked.run for attempt in group}),
        solved=share([sum(runs) / len(runs) for runs in right]),
        wrong=faults.total(),
        faults=", ".join(f"{fault} {count}" for fault, count in faults.items()),
        cpu=middle(lambda a: 1000 * a.cpu_seconds, group),
        cpu_99=float(np.percentile(cpu, 99)),
        scene=float(np.median([1000 * attempt.scene_seconds for attempt in group])),
        planning=middle(lambda a: 1000 * a.planning_seconds, group).value,
        simplification=middle(lambda a: 1000 * a.simplification_seconds, group).value,
        memory=float(max(attempt.memory for attempt in group)),
        checks=middle(lambda a: a.checks, group).value,
        length=middle(lambda a: a.length),
        ratio=middle(lambda a: a.ratio),
        # As of the median: unknown if any is, since numpy's max of NaN and others is NaN.
        ratio_most=float(np.max([attempt.ratio for attempt in found])) if found else math.nan,
        listed_ratio=middle(lambda a: a.listed_ratio),
        clearance_least=min([attempt.clearance for attempt in found], default=math.nan),
        turning=middle(lambda a: a.turning).value,
        ompl_clearance=middle(lambda a: a.ompl_clearance).value,
        ompl_smoothness=middle(lambda a: a.ompl_smoothness).value,
    )


_INNER = ("asked", "points", "progress")
"""Fields of an attempt that have columns of their own, or none."""


def write_csv(attempts: Sequence[Attempt], path: Path) -> None:
    """Write every answer as a line of `path`; lengths in metres, times in seconds of CPU."""
    _write(path, (_answer_columns(attempt) for attempt in attempts))


def _answer_columns(attempt: Attempt) -> dict[str, object]:
    asked = attempt.asked
    own = [field.name for field in fields(Attempt) if field.name not in _INNER]
    return {
        "floorplan": asked.floorplan,
        "planner": asked.planner,
        "query": asked.query,
        "run": asked.run,
        "seed": asked.seed,
        **dict(zip(("x0", "y0", "x1", "y1"), (*asked.start, *asked.goal), strict=True)),
        **{name: getattr(attempt, name) for name in own},
        "shortest": asked.shortest,
        "listed": asked.listed,
        "ratio": attempt.ratio,
    }


def write_summary(rows: Sequence[PlannerRow], path: Path) -> None:
    """Write every row as a line of `path`; `_low` and `_high` end columns of an interval."""
    _write(path, (_row_columns(row) for row in rows))


def _row_columns(row: PlannerRow) -> dict[str, object]:
    columns: dict[str, object] = {}
    for name, value in vars(row).items():
        if isinstance(value, Estimate):
            columns |= {name: value.value, f"{name}_low": value.low, f"{name}_high": value.high}
        else:
            columns[name] = value
    return columns


def _write(path: Path, rows: Iterable[dict[str, object]]) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        for number, row in enumerate(rows):
            if number == 0:
                writer.writerow(row)
            writer.writerow(row.values())


def write_ompl_log(
    attempts: Sequence[Attempt], path: Path, *, seed: int, seconds: float | None = None
) -> None:
    """Write the answers on one floor as OMPL's benchmark log.

    `ompl_benchmark_statistics` and Planner Arena read it. What bears the name of one of OMPL's
    properties is that property, but that times are of the CPU; the others are this benchmark's
    own. `seconds` is the budget of an answer, where there was one.
    """
    lines = "".join(f"{line}\n" for line in _log(attempts, seed, seconds))
    path.write_text(lines, encoding="utf-8")


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
    "collision checks INTEGER": lambda attempt: attempt.checks,
    "query INTEGER": lambda attempt: attempt.asked.query,
    "run INTEGER": lambda attempt: attempt.asked.run,
}
"""Names and kinds of the properties of each run."""

_PROGRESS = ("time REAL", "iterations INTEGER", "best cost REAL")


def _log(attempts: Sequence[Attempt], seed: int, seconds: float | None) -> Iterator[str]:
    planners = groups(attempts)
    most = max(attempt.cpu_seconds for attempt in attempts)
    yield f"OMPL version {version('ompl')}"
    yield f"Experiment {'_'.join(attempts[0].asked.floorplan.split())}"
    yield "0 experiment properties"
    yield f"Running on {'_'.join(platform.node().split()) or 'UNKNOWN'}"
    yield f"Starting at {datetime.now().isoformat(timespec='seconds')}"
    yield "<<<|"
    yield "Floorwalker's planner benchmark. Runs go through all queries; times are of the CPU."
    yield "|>>>"
    yield "<<<|"
    yield platform.processor() or platform.machine()
    yield "|>>>"
    yield f"{seed} is the random seed"
    # Without a budget of time, and of memory, these are no limits.
    yield f"{most if seconds is None else seconds:.6f} seconds per run"
    yield "0 MB per run"
    yield f"{len(attempts) // len(planners)} runs per planner"
    spent = sum(attempt.cpu_seconds for attempt in attempts)
    yield f"{spent:.6f} seconds spent to collect the data"
    yield "0 enum types"
    yield f"{len(planners)} planners"
    for runs in planners:
        yield f"geometric_{runs[0].asked.planner}"
        yield "0 common properties"
        yield f"{len(_PROPERTIES)} properties for each run"
        yield from _PROPERTIES
        yield f"{len(runs)} runs"
        for attempt in runs:
            yield "".join(f"{value(attempt)}; " for value in _PROPERTIES.values())
        yield f"{len(_PROGRESS)} progress properties for each run"
        yield from _PROGRESS
        yield f"{len(runs)} runs"
        for attempt in runs:
            yield "".join(
                f"{one.cpu_seconds},{one.iterations},{one.length},;" for one in attempt.progress
            )
        yield "."
