"""How long Floorwalker takes to start, as a multiple of the import of its libraries alone.

    python benchmarks/startup.py [--repetitions N]

Each line is the median CPU time of a separate process. The processes take turns, so that a busy
machine slows all of them.
"""

from __future__ import annotations

import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

LIBRARIES = "numpy, shapely, ompl.base, ompl.geometric, fcl, ruckig, simpy, pydantic, yaml"
COMMAND = Path(sys.executable).with_name("floorwalker")
PROGRAMS = {
    "libraries": [sys.executable, "-c", f"import {LIBRARIES}"],
    "import sim; sim.Trial": [sys.executable, "-c", "import sim; sim.Trial"],
    "floorwalker --help": [sys.executable, str(COMMAND), "--help"],
    "floorwalker run": [sys.executable, str(COMMAND), "run", "--out", "run"],
}


def cpu_seconds(command: list[str]) -> float:
    """Return the CPU time of a command in a new folder, the children of its process included."""
    with tempfile.TemporaryDirectory() as folder:
        environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(command, cwd=folder, env=environment, stdout=subprocess.DEVNULL, check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Print the medians and their ratios to the import of the libraries."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repetitions", type=int, default=9)
    repetitions = parser.parse_args().repetitions
    for command in PROGRAMS.values():
        cpu_seconds(command)  # writes the compiled modules
    seconds: dict[str, list[float]] = {name: [] for name in PROGRAMS}
    for _ in range(repetitions):
        for name, command in PROGRAMS.items():
            seconds[name].append(cpu_seconds(command))
    base = statistics.median(seconds["libraries"])
    for name, measured in seconds.items():
        middle = statistics.median(measured)
        print(f"{name:24}{1000 * middle:6.0f} ms{middle / base:6.2f} ×")


if __name__ == "__main__":
    main()
