"""The report of a benchmark: one HTML page that needs nothing else."""

from __future__ import annotations

import math
import os
import platform
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from importlib.metadata import version
from pathlib import Path

from floorplan import Floorplan
from navigation.benchmark import PEERS, SHORTFALL, TOUCHES, Attempt, Estimate, Row, groups, summary

from ..report_page import write_report_page
from .charts import Chart, charts, looks
from .pictures import Picture, picture, telling


@dataclass(frozen=True)
class Floor:
    """What the page shows of one floor."""

    plan: Floorplan
    rows: tuple[Row, ...]
    charts: tuple[Chart, ...]
    picture: Picture

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

    `terms` says how they were made, by name; they depend on the machine if `on_the_clock`.
    """
    styles = looks(list(dict.fromkeys(attempt.asked.planner for attempt in attempts)))
    floors = []
    for plan in plans:
        there = [group for group in groups(attempts) if group[0].asked.floorplan == plan.name]
        everything = [attempt for group in there for attempt in group]
        query = telling(everything)
        drawn = [a for a in everything if a.asked.query == query and a.asked.run == 0]
        floors.append(
            Floor(
                plan,
                tuple(summary(everything)),
                tuple(charts(plan.name, there, styles)),
                picture(plan, drawn, styles),
            )
        )
    write_report_page(
        path,
        "benchmark.html",
        {"figure": figure, "ms": milliseconds, "interval": interval},
        floors=floors,
        answers=len(attempts),
        terms={**terms, **_machine(styles)},
        on_the_clock=on_the_clock,
        shortfall=100 * SHORTFALL,
        touches=1000 * TOUCHES,
        day=date.today().isoformat(),
    )


def figure(value: float, digits: int = 2) -> str:
    """Return a number as people read it, or a dash for none."""
    return f"{value:,.{digits}f}" if math.isfinite(value) else "–"


def milliseconds(value: float) -> str:
    """Return a time with two or three digits that count."""
    digits = 0 if value >= 100 else 1 if value >= 10 else 2 if value >= 0.1 else 3
    return figure(value, digits if value else 0)


def interval(estimate: Estimate, digits: int = 2) -> str:
    """Return the interval of a figure, empty where it has none or no width."""
    if not (math.isfinite(estimate.low) and math.isfinite(estimate.high)):
        return ""
    low, high = figure(estimate.low, digits), figure(estimate.high, digits)
    return f"{low} … {high}" if low != high else ""


def _machine(planners: Collection[str]) -> dict[str, str]:
    """Return what the times of these planners depend on, by name."""
    peers = [peer for peer in PEERS if peer.name in planners]
    return {
        "machine": f"{_processor()}, {os.cpu_count()} cores, {platform.system()}",
        "software": ", ".join(
            [
                f"Floorwalker {version('floorwalker')}",
                f"OMPL {version('ompl')}",
                f"Python {platform.python_version()}",
                *(f"{peer.name} {version(peer.name)}" for peer in peers if peer.module != "ompl"),
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
