"""How the gantry controllers do beside each personality: the table of docs/controllers.md.

Every trial is 275 s of kitting on the ARIAC floor beside one person, with jobs, start and walking
speed drawn from its seed. All controllers get the same trials.

    python benchmarks/controllers.py [--trials 100] [--jobs 2]
"""

from __future__ import annotations

import argparse
import random
import statistics
from collections.abc import Sequence
from typing import Any

from joblib import Parallel, delayed

import sim

PERSONALITIES = ("indifferent", "antagonistic", "helpful")
CONTROLLERS = ("oblivious", "pausing", "avoiding")


def kitting_trial(personality: str, controller: str, seed: int) -> sim.Trial:
    """One person, and a gantry with more parts to fetch than it can in 275 s."""
    chance = random.Random(seed)
    jobs = [
        f"    - {{pick: bin{chance.randint(1, 8)}, place: agv{chance.randint(1, 4)}, part: p{k}}}"
        for k in range(40)
    ]
    at = f"[{chance.uniform(-12.0, 0.0):.2f}, {chance.uniform(-5.0, 5.0):.2f}, 0.0]"
    start, speed = f"{chance.uniform(0.0, 20.0):.1f}", f"{chance.uniform(0.7, 1.0):.2f}"
    person = f"{{name: operator, personality: {personality}, start: {{time: {start}}}"
    text = [
        f"floorplan: ariac2023\nduration: 275.0\nseed: {seed}",
        f"people: [{person}, max_speed: {speed}}}]",
        f"gantry:\n  controller: {controller}\n  at: {at}\n  jobs:",
        *jobs,
    ]
    return sim.Trial.parse("\n".join(text))


def figures(personality: str, controller: str, seed: int) -> dict[str, Any]:
    """Figures of one run for the table."""
    run = sim.run(kitting_trial(personality, controller, seed))
    summary = run.summary
    return {
        "penalties": summary["penalties"],
        "by the gantry": summary["violations"]["gantry"],
        "by the person": summary["violations"]["person"],
        "jobs": summary["jobs_done"],
        "nearest": summary["minimum_separation"]["distance"],
    }


def row(name: str, runs: Sequence[dict[str, Any]]) -> str:
    """One line of the table: means, and the median of the jobs."""

    def mean(key: str) -> float:
        return statistics.fmean(run[key] for run in runs)

    return (
        f"| {name} | {mean('penalties'):.2f} | {mean('by the gantry'):.2f} |"
        f" {mean('by the person'):.2f} | {statistics.median(r['jobs'] for r in runs):g} |"
        f" {mean('nearest'):.2f} |"
    )


def table(trials: int, jobs: int) -> str:
    """Run this number of trials of each pair, and return the table."""
    lines = [
        "| person, controller | penalties | by the gantry | by the person | jobs (median)"
        " | minimum distance, m |",
        "|---|---|---|---|---|---|",
    ]
    for personality in PERSONALITIES:
        for controller in CONTROLLERS:
            runs = Parallel(n_jobs=jobs)(
                delayed(figures)(personality, controller, seed) for seed in range(trials)
            )
            lines.append(row(f"{personality}, {controller}", list(runs)))
    return "\n".join(lines)


def main() -> None:
    """Run all trials and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=100)
    parser.add_argument("--jobs", type=int, default=2)
    chosen = parser.parse_args()
    print(table(chosen.trials, chosen.jobs))


if __name__ == "__main__":
    main()
