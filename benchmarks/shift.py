"""Figures of a shift of eight hours with thirty people, and of a sweep of 500 runs of ten minutes.

    python benchmarks/shift.py [--hours H] [--rows N]

The shift is that of examples/picking_hall, with its four tugs that yield and without any. A few
rows of the sweep, in which two people work beside a gantry, are run in one process. All is CPU
time.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from pathlib import Path

import sim
from sim.studies.running import figures_of
from sim.trials.building import lasting

HALL = Path(__file__).resolve().parents[1] / "examples" / "picking_hall" / "shift.trial.yaml"

SWEPT = """\
floorplan: ariac2023
duration: 600
rules: protective_stop
people: [{name: ann, personality: antagonistic}, {name: bob, personality: curious, at: [-8, -8]}]
gantry:
  controller: pausing
  repeat: true
  jobs:
    - {pick: bin2, place: agv1, part: purple pump}
    - {pick: bin6, place: agv4, part: blue battery}
"""

GRID = """\
trials: [swept.trial.yaml]
grid: {rules.gantry_law.t1: [0.25, 0.5, 0.75, 1.0, 1.25], gantry.max_speed: [0.25, 0.5, 0.75, 1.0]}
repeat: 25
"""


def shift(hours: float, *, tugs: bool) -> None:
    """Print what a part of the shift costs, and all of it at that rate."""
    trial = lasting(sim.Trial.load(HALL), 3600.0 * hours)
    if not tugs:
        trial = replace(trial, agvs={}, yielding=frozenset())
    begin = time.process_time()
    run = sim.run(trial)
    spent = time.process_time() - begin
    what = "four tugs that yield" if tugs else "no tug under way"
    print(f"{hours:g} h, {what}: {spent:.1f} s, {run.summary['tasks_done']} tasks", end="")
    print(f"; 8 h at that rate {8 * spent / hours:.0f} s")


def sweep(folder: Path, rows: int) -> None:
    """Print what rows of the sweep cost, each on average, and all of it on two cores."""
    (folder / "swept.trial.yaml").write_text(SWEPT, encoding="utf-8")
    study = sim.Study.parse(GRID, file="sweep.study.yaml", folder=folder)
    sim.run(study.row(0).trial)
    begin = time.process_time()
    for k in range(rows):
        figures_of(sim.run(study.row(k * len(study) // rows).trial))
    each = (time.process_time() - begin) / rows
    minutes = each * len(study) / 2 / 60
    print(f"{len(study)} rows of 10 min: {each:.2f} s each, {minutes:.1f} min on two cores")


def main() -> None:
    from tempfile import TemporaryDirectory

    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--hours", type=float, default=8.0)
    parser.add_argument("--rows", type=int, default=20)
    arguments = parser.parse_args()
    shift(arguments.hours, tugs=False)
    shift(arguments.hours, tugs=True)
    with TemporaryDirectory() as name:
        sweep(Path(name), arguments.rows)


if __name__ == "__main__":
    main()
