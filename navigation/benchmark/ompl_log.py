"""The log of OMPL's benchmarks: its `ompl_benchmark_statistics` makes a database of it."""

from __future__ import annotations

import platform
from collections.abc import Iterator, Sequence
from datetime import datetime
from importlib.metadata import version
from pathlib import Path

from .attempts import Attempt
from .reports import groups


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


_PROPERTIES = (
    "time REAL",
    "solved BOOLEAN",
    "simplification time REAL",
    "memory REAL",
    "solution length REAL",
    "solution clearance REAL",
    "solution smoothness REAL",
    "solution segments INTEGER",
    "least clearance REAL",
    "turning REAL",
    "shortest length REAL",
    "length ratio REAL",
    "correct solution BOOLEAN",
    "collision checks INTEGER",
    "query INTEGER",
    "run INTEGER",
)

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
        yield from (_run(attempt) for attempt in runs)
        yield f"{len(_PROGRESS)} progress properties for each run"
        yield from _PROGRESS
        yield f"{len(runs)} runs"
        yield from (_progress(attempt) for attempt in runs)
        yield "."


def _run(attempt: Attempt) -> str:
    asked = attempt.asked
    values: list[float | str] = [attempt.planning_seconds, int(attempt.solved)]
    values += [attempt.simplification_seconds, attempt.memory]
    if attempt.solved:
        values += [attempt.length, attempt.ompl_clearance, attempt.ompl_smoothness]
        values += [attempt.bends + 1, attempt.clearance, attempt.turning]
        values += [asked.shortest, attempt.ratio]
    else:
        values += ["", "", "", "", "", "", asked.shortest, ""]
    values += [int(attempt.right), attempt.checks, asked.query, asked.run]
    return "".join(f"{value}; " for value in values)


def _progress(attempt: Attempt) -> str:
    samples = [(one.cpu_seconds, one.iterations, one.length) for one in attempt.progress]
    return "".join("".join(f"{value}," for value in sample) + ";" for sample in samples)
