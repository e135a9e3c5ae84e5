"""A benchmark's answers as files: CSV, and the log that OMPL's benchmark tools read."""

from __future__ import annotations

import csv
import math
import platform
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, fields
from datetime import datetime
from importlib.metadata import version
from pathlib import Path

import numpy as np

from .measuring import Attempt


@dataclass(frozen=True)
class Row:
    """Results of one planner on one floor: milliseconds of CPU, metres."""

    floorplan: str
    planner: str
    queries: int
    solved: float
    """A share of 1, of questions that all have an answer."""
    cpu_median: float
    cpu_99: float
    checks: float
    """The median."""
    ratio_median: float
    """Length over that of the shortest path."""
    ratio_most: float
    clearance_least: float
    turning: float
    """The median of the radians that a path turns by."""


def summary(attempts: Sequence[Attempt]) -> list[Row]:
    """Return one row for each floor and planner, in the order they were asked."""
    groups: dict[tuple[str, str], list[Attempt]] = {}
    for attempt in attempts:
        groups.setdefault((attempt.floorplan, attempt.planner), []).append(attempt)
    return [_row(group) for group in groups.values()]


def _row(group: Sequence[Attempt]) -> Row:
    solved = [attempt for attempt in group if attempt.solved]
    cpu = 1000 * np.array([attempt.cpu_seconds for attempt in group])
    ratios = [attempt.ratio for attempt in solved] or [math.nan]
    return Row(
        floorplan=group[0].floorplan,
        planner=group[0].planner,
        queries=len(group),
        solved=len(solved) / len(group),
        cpu_median=float(np.median(cpu)),
        cpu_99=float(np.percentile(cpu, 99)),
        checks=float(np.median([attempt.checks for attempt in group])),
        ratio_median=float(np.median(ratios)),
        ratio_most=max(ratios),
        clearance_least=min([attempt.clearance for attempt in solved], default=math.nan),
        turning=float(np.median([attempt.turning for attempt in solved] or [math.nan])),
    )


def write_csv(attempts: Sequence[Attempt], path: Path) -> None:
    """Write every answer as a line of `path`; lengths in metres, times in seconds."""
    with path.open("w", encoding="utf-8", newline="") as file:
        names = [field.name for field in fields(Attempt)]
        writer = csv.DictWriter(file, names, lineterminator="\n")
        writer.writeheader()
        writer.writerows(asdict(attempt) for attempt in attempts)


def write_ompl_log(attempts: Sequence[Attempt], path: Path, *, seed: int) -> None:
    """Write the answers on one floor as OMPL's benchmark log.

    `ompl_benchmark_statistics.py` and Planner Arena read it. What bears the name of one of
    OMPL's properties is that property, but for the time, which is CPU time; the others are
    this benchmark's own.
    """
    path.write_text("".join(f"{line}\n" for line in _log(attempts, seed)), encoding="utf-8")


_PROPERTIES = (
    "time REAL",
    "solved BOOLEAN",
    "solution length REAL",
    "solution clearance REAL",
    "solution smoothness REAL",
    "solution segments INTEGER",
    "least clearance REAL",
    "turning REAL",
    "shortest length REAL",
    "length ratio REAL",
    "collision checks INTEGER",
)


def _log(attempts: Sequence[Attempt], seed: int) -> Iterator[str]:
    planners = list(dict.fromkeys(attempt.planner for attempt in attempts))
    most = max(attempt.cpu_seconds for attempt in attempts)
    yield f"OMPL version {version('ompl')}"
    yield f"Experiment {attempts[0].floorplan}"
    yield "0 experiment properties"
    yield f"Running on {platform.node() or 'UNKNOWN'}"
    yield f"Starting at {datetime.now().isoformat(timespec='seconds')}"
    yield "<<<|"
    yield "Floorwalker's planner benchmark. Every run is another query; times are of the CPU."
    yield "|>>>"
    yield "<<<|"
    yield platform.processor() or platform.machine()
    yield "|>>>"
    yield f"{seed} is the random seed"
    # Budgets are counts, and memory is not measured: these are no limits.
    yield f"{most:.6f} seconds per run"
    yield "0 MB per run"
    yield f"{len(attempts) // len(planners)} runs per planner"
    spent = sum(attempt.cpu_seconds for attempt in attempts)
    yield f"{spent:.6f} seconds spent to collect the data"
    yield "0 enum types"
    yield f"{len(planners)} planners"
    for planner in planners:
        runs = [attempt for attempt in attempts if attempt.planner == planner]
        yield f"geometric_{planner}"
        yield "0 common properties"
        yield f"{len(_PROPERTIES)} properties for each run"
        yield from _PROPERTIES
        yield f"{len(runs)} runs"
        yield from (_run(attempt) for attempt in runs)
        yield "."


def _run(attempt: Attempt) -> str:
    values: list[float | str] = [attempt.cpu_seconds, int(attempt.solved)]
    if attempt.solved:
        values += [attempt.length, attempt.ompl_clearance, attempt.ompl_smoothness]
        values += [attempt.bends + 1, attempt.clearance, attempt.turning]
        values += [attempt.shortest, attempt.ratio]
    else:
        values += ["", "", "", "", "", "", attempt.shortest, ""]
    return "".join(f"{value}; " for value in [*values, attempt.checks])
