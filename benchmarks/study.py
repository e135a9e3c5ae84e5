"""How fast studies run: what a row costs beyond its run, rows a minute, and memory.

    python benchmarks/study.py [--rows N] [--memory-rows N]

The rows are of 275 s on the ARIAC floor: one person (indifferent, antagonistic, helpful), a gantry
that fetches parts all the time (oblivious, pausing), AGVs that set out at other times. CPU seconds
count the main process and its workers, their start included. Wall seconds depend on other load on
the machine. The cost of a row on several processes is the slope between a third of the rows and all
of them, without the start of processes and the report.
"""

from __future__ import annotations

import argparse
import os
import resource
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import sim
from sim.studies import running as many

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


def end_workers() -> None:
    from joblib.externals.loky import get_reusable_executor

    get_reusable_executor().shutdown(wait=True)


def slope(work: Callable[[int], None], rows: int) -> float:
    """CPU seconds of one row more."""
    spent = []
    for count in (rows // 3, rows):
        begun = cpu_seconds()
        work(count)
        end_workers()
        spent.append(cpu_seconds() - begun)
    return (spent[1] - spent[0]) / (rows - rows // 3)


def overhead(folder: Path, rows: int) -> None:
    """Print the share of a study's CPU time, row after row, that is not its runs' own."""
    study, marks, runs = a_study(folder, rows), [], []

    def timed(trial: sim.Trial) -> sim.Run:
        begun = time.process_time()
        finished = sim.run(trial)
        runs.append(time.process_time() - begun)
        return finished

    def mark(_: int) -> None:
        marks.append(time.process_time())

    usual, many.run = many.run, timed
    sim.run_study(study, folder / "timed", jobs=1, begin=mark, progress=mark)
    many.run = usual
    share = (marks[-1] - marks[0]) / sum(runs) - 1
    each = sum(runs) / len(runs)
    print(f"{len(runs)} rows in one process: {each * 1e3:.1f} ms each and {share:.1%} more")


def compare(folder: Path, rows: int, repeat: int) -> None:
    """Print what a row costs on one process and on several."""
    numbers = iter(range(1_000_000))
    kinds = {
        "one process": (1, "loky"),
        "two processes": (2, "loky"),
        "two Dask workers": (2, "dask"),
    }
    spent: dict[str, list[float]] = {kind: [] for kind in kinds}
    for _ in range(repeat):
        for kind, (jobs, backend) in kinds.items():

            def work(count: int, jobs: int = jobs, backend: str = backend) -> None:
                out = folder / f"out-{next(numbers)}"
                sim.run_study(a_study(folder, count), out, jobs=jobs, backend=backend)

            spent[kind].append(slope(work, rows))
    alone = statistics.median(spent["one process"])
    for kind, each in spent.items():
        row = statistics.median(each)
        print(f"{kind:18} {row * 1e3:8.1f} ms of CPU time a row {row / alone - 1:+8.1%}")


def speeds(folder: Path, rows: int) -> None:
    """Print how long a study takes on one process and on two."""
    study = a_study(folder, rows)
    print(f"{len(study)} rows {'CPU s':>12} {'wall s':>8} {'1,000 rows, min':>16}")
    for jobs in (1, 2):
        cpu, wall = cpu_seconds(), time.perf_counter()
        sim.run_study(study, folder / str(jobs), jobs=jobs)
        end_workers()
        cpu, wall = cpu_seconds() - cpu, time.perf_counter() - wall
        print(f"{jobs} process{'es' if jobs > 1 else '':3} {cpu:8.1f}", end="")
        print(f" {wall:8.1f} {wall / len(study) * 1000 / 60:16.1f}")


def memory(folder: Path, rows: int) -> None:
    """Print how much memory a process takes after more and more rows."""

    def trials() -> Iterator[sim.Trial]:
        return (row.trial for row in a_study(folder, rows).rows())

    for count, _ in enumerate(sim.run_many(trials(), jobs=1)):
        if count % 100 == 0:
            print(f"{resident_megabytes():8.1f} MB after {count} rows in one process")
    print(f"{resident_megabytes():8.1f} MB after {count + 1} rows in one process")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--rows", type=int, default=300)
    parser.add_argument("--memory-rows", type=int, default=1000)
    parser.add_argument("--repeat", type=int, default=3)
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        overhead(folder, chosen.rows)
        compare(folder, chosen.rows, chosen.repeat)
        speeds(folder, chosen.rows)
        memory(folder, chosen.memory_rows)


if __name__ == "__main__":
    main()
