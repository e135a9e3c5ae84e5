"""How fast studies run: rows a minute, one process beside two, and memory over a thousand rows.

    python benchmarks/study.py [--rows N] [--memory-rows N]

The rows are of 275 s on the ARIAC floor: one person (indifferent, antagonistic, helpful), a gantry
that fetches parts all the time (oblivious, pausing), AGVs that set out at other times. CPU seconds
count the main process and its workers, their start included; wall seconds mean little on a machine
that has other things to do.
"""

from __future__ import annotations

import argparse
import os
import resource
import tempfile
import time
from pathlib import Path

import sim
from sim.studies.measuring import measure

TRIAL = """\
floorplan: ariac2023
people: [{name: operator}]
gantry:
  controller: oblivious
  repeat: true
  jobs:
    - {pick: bin2, place: agv1, part: purple pump}
    - {pick: bin6, place: agv4, part: blue battery}
    - {pick: bin3, place: agv2, part: green sensor}
    - {pick: bin7, place: agv3, part: red regulator}
agvs:
  agv1: [{time: 60.0, to: as1}, {time: 120.0, to: kitting}]
  agv4: [{time: 90.0, to: as4}, {time: 150.0, to: kitting}]
"""

STUDY = """\
trials: [kitting.trial.yaml]
grid:
  personality: [indifferent, antagonistic, helpful]
  controller: [oblivious, pausing]
random:
  max_speed: {{normal: [1.0, 0.15], within: [0.6, 1.4]}}
  job_order: shuffled
  agv_delay: {{uniform: [0, 30]}}
repeat: {repeat}
"""


def a_study(folder: Path, rows: int) -> sim.Study:
    (folder / "kitting.trial.yaml").write_text(TRIAL, encoding="utf-8")
    return sim.Study.parse(STUDY.format(repeat=max(rows // 6, 1)), folder=folder)


def cpu_seconds() -> float:
    """Of this process and of those of its children that have ended."""
    spent = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in spent)


def resident_megabytes() -> float:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def main() -> None:
    from joblib.externals.loky import get_reusable_executor

    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--rows", type=int, default=300)
    parser.add_argument("--memory-rows", type=int, default=1000)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        study = a_study(folder, arguments.rows)
        print(f"{len(study)} rows {'CPU s':>12} {'a row':>8} {'wall s':>8} {'1,000 rows, min':>16}")
        for jobs in (1, 2):
            cpu, wall = cpu_seconds(), time.perf_counter()
            sim.run_study(study, folder / str(jobs), jobs=jobs)
            get_reusable_executor().shutdown(wait=True)
            cpu, wall = cpu_seconds() - cpu, time.perf_counter() - wall
            each, minutes = cpu / len(study), wall / len(study) * 1000 / 60
            print(f"{jobs} process{'es' if jobs > 1 else '':3} {cpu:8.1f}", end="")
            print(f" {each:8.4f} {wall:8.1f} {minutes:16.1f}")
        rows = a_study(folder, arguments.memory_rows).rows()
        for count, row in enumerate(rows):
            if count % 100 == 0:
                print(f"{resident_megabytes():8.1f} MB after {count} rows in one process")
            measure(row)
        print(f"{resident_megabytes():8.1f} MB after {count + 1} rows in one process")


if __name__ == "__main__":
    main()
