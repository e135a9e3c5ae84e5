"""How much doors and their schedules cost while nothing changes: ratios of CPU time.

    python benchmarks/places.py [--runs 9] [--people 5]

The same people patrol the same floor for ten minutes, with and without each of them. Runs take
turns, and medians of the ratios to the run without any are printed.
"""

from __future__ import annotations

import argparse
import statistics
import time

import sim

FLOOR = """\
floorplan:
  base: warehouse
{keys}
duration: 600
people: [{{name: eve, personality: indifferent, count: {people}, at: anywhere}}]
{times}
"""
AWAY = "between: [[{x}, 0.2], [{x}, 0.4]], thickness: 0.01"


def doors(count: int) -> str:
    """Doors beside all paths, along the south wall of the floor."""
    keys = (f"    d{k}: {{{AWAY.format(x=1 + k / 2)}}}\n" for k in range(count))
    return "  doors:\n" + "".join(keys)


CASES = {
    "nothing": ("", ""),
    "20 open doors": (doors(20), ""),
    "20 doors that close at the end": (
        doors(20),
        "doors: {" + ", ".join(f"d{k}: {{closed: [[599.5]]}}" for k in range(20)) + "}",
    ),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--runs", type=int, default=9)
    parser.add_argument("--people", type=int, default=5)
    options = parser.parse_args()
    trials = {
        name: sim.Trial.parse(FLOOR.format(keys=keys, times=times, people=options.people))
        for name, (keys, times) in CASES.items()
    }
    took: dict[str, list[float]] = {name: [] for name in trials}
    for _ in range(options.runs + 1):
        for name, trial in trials.items():
            begin = time.process_time()
            sim.run(trial)
            took[name].append(time.process_time() - begin)
    print("| | CPU time beside nothing of it |\n|---|---|")
    for name, seconds in took.items():
        pairs = zip(seconds[1:], took["nothing"][1:], strict=True)
        print(f"| {name} | {statistics.median(a / b for a, b in pairs):.2f} |")


if __name__ == "__main__":
    main()
