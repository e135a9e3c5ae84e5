"""A benchmark's answers as tables: a row for each planner, and CSV of rows and answers."""

from __future__ import annotations

import csv
import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from .attempts import Asked, Attempt
from .statistics import Estimate, by_question, median, share


@dataclass(frozen=True)
class Row:
    """Results of one planner on one floor: milliseconds of CPU, metres.

    Of what a question's runs differ in, their median (or share) is taken first; see `statistics`.
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


def summary(attempts: Sequence[Attempt]) -> list[Row]:
    """Return one row for each floor and planner, in the order they were asked."""
    return [_row(group) for group in groups(attempts)]


def groups(attempts: Sequence[Attempt]) -> list[list[Attempt]]:
    """Return the attempts of each planner on each floor, in the order they were asked."""
    found: dict[tuple[str, str], list[Attempt]] = {}
    for attempt in attempts:
        found.setdefault((attempt.asked.floorplan, attempt.asked.planner), []).append(attempt)
    return list(found.values())


def _row(group: Sequence[Attempt]) -> Row:
    found = [attempt for attempt in group if attempt.solved]
    faults = Counter(attempt.wrong for attempt in group if attempt.wrong)
    cpu = [1000 * attempt.cpu_seconds for attempt in group]
    right = by_question(group, [float(attempt.right) for attempt in group])

    def middle(of: Callable[[Attempt], float], among: Sequence[Attempt] = found) -> Estimate:
        values = by_question(among, [of(attempt) for attempt in among])
        return median([float(np.median(runs)) for runs in values])

    return Row(
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


_ASKED = ("floorplan", "planner", "query", "run", "seed")
_KNOWN = ("shortest", "listed")
_INNER = ("asked", "points", "progress")
"""Fields of an attempt that have columns of their own, or none."""


def write_csv(attempts: Sequence[Attempt], path: Path) -> None:
    """Write every answer as a line of `path`; lengths in metres, times in seconds of CPU."""
    own = [field.name for field in fields(Attempt) if field.name not in _INNER]
    header = [*_ASKED, "x0", "y0", "x1", "y1", *own, *_KNOWN, "ratio"]
    _write(path, header, (_line(attempt, own) for attempt in attempts))


def _line(attempt: Attempt, own: Sequence[str]) -> list[object]:
    asked: Asked = attempt.asked
    return [
        *(getattr(asked, name) for name in _ASKED),
        *asked.start,
        *asked.goal,
        *(getattr(attempt, name) for name in own),
        *(getattr(asked, name) for name in _KNOWN),
        attempt.ratio,
    ]


def write_summary(rows: Sequence[Row], path: Path) -> None:
    """Write every row as a line of `path`; `_low` and `_high` end columns of an interval."""
    header: list[str] = []
    lines: list[list[object]] = [[] for _ in rows]
    for field in fields(Row):
        values = [getattr(row, field.name) for row in rows]
        interval = bool(values) and isinstance(values[0], Estimate)
        header += [field.name, *([f"{field.name}_low", f"{field.name}_high"] if interval else [])]
        for line, value in zip(lines, values, strict=True):
            line += [value.value, value.low, value.high] if interval else [value]
    _write(path, header, lines)


def _write(
    path: Path, header: Sequence[str], lines: Iterator[list[object]] | list[list[object]]
) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(lines)
