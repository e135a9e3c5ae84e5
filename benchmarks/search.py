"""How a worst-case search compares with random trials, and what it costs.

    python benchmarks/search.py [--seeds N] [--evaluations N] [--jobs N] [--long]

The studies are those of `examples/planted_faults`, whose two controllers have a planted fault each.
For every seed it counts the evaluations that break, of random trials and of the sampler `tpe`, and
the runs that each minimisation takes. With --long it also measures the processor time of 2,000
evaluations.
"""

from __future__ import annotations

import argparse
import resource
import shutil
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import sim
from sim.searches import SearchResults

STUDIES = ("short_sighted", "impatient")
FOLDER = Path(__file__).parents[1] / "examples" / "planted_faults"


def searched(name: str, seed: int, **options: object) -> SearchResults:
    """Search a copy of one of the studies with a seed, in a folder that vanishes."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(shutil.copytree(FOLDER, Path(folder) / "planted_faults"))
        study = replace(sim.Study.load(copy / f"{name}.study.yaml"), seed=seed)
        return sim.search(study, copy / "out", minimise="least_margin_moving", **options)


def first(results: SearchResults) -> int | None:
    """Return the number of evaluations until the first that breaks."""
    return min((one.number + 1 for one in results.broken), default=None)


def main() -> None:
    """Print a table for each study."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--evaluations", type=int, default=200)
    parser.add_argument("--jobs", type=int, default=None)
    parser.add_argument("--long", action="store_true")
    options = parser.parse_args()
    budget = {"evaluations": options.evaluations, "jobs": options.jobs}
    for name in STUDIES:
        print(f"{name}: breaking evaluations of {options.evaluations}, first at")
        ratios = [0, 0]
        for seed in range(options.seeds):
            random = searched(name, seed, sampler="random", cases=0, **budget)
            tpe = searched(name, seed, cases=3, **budget)
            ratios[0] += len(random.broken)
            ratios[1] += len(tpe.broken)
            runs = [case.minimised for case in tpe.cases if case.minimised is not None]
            sizes = [
                f"{one.runs} runs: {len(one.trial.people)} people,"
                f" {len(one.trial.gantry.jobs)} jobs, {one.trial.duration:g} s"
                for one in runs
            ]
            print(
                f"  seed {seed}: random {len(random.broken)} ({first(random)}),"
                f" tpe {len(tpe.broken)} ({first(tpe)}); {'; '.join(sizes)}",
                flush=True,
            )
        print(f"  in all: random {ratios[0]}, tpe {ratios[1]}")
    if options.long:
        for sampler in ("random", "tpe"):
            print(f"2,000 evaluations, {sampler}: {long(sampler, options.jobs):.0f} s", flush=True)


def long(sampler: str, jobs: int | None) -> float:
    """Return the processor time of 2,000 evaluations in seconds, of the command's processes."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(shutil.copytree(FOLDER, Path(folder) / "planted_faults"))
        command = [sys.executable, "-m", "floorwalker", "search", copy / f"{STUDIES[0]}.study.yaml"]
        options = ["--sampler", sampler, "--evaluations", "2000", "--cases", "0"]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(
            [*map(str, command), *options, "--jobs", str(jobs or 2)],
            check=False,  # it exits with 1, because trials break
            stdout=subprocess.DEVNULL,
        )
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


if __name__ == "__main__":
    main()
