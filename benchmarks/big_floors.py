"""How long floors of many obstacles take to load and to plan on: CPU seconds.

    python benchmarks/big_floors.py [--obstacles 100 1000 10000] [--queries 20]

Bins and tables stand at random in a square hall that grows with their number: one in 100 m² or one
in 12 m². Ways lead from one random place to another. Each number is one run in a fresh process.
"""

from __future__ import annotations

import argparse
import math
import random
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from typing import TypeVar

SPACINGS = {"loose": 10.0, "dense": 3.5}
"""Metres from one thing to the next, on average."""

RADIUS = 0.3

_T = TypeVar("_T")


def hall(count: int, spacing: float) -> str:
    """A floorplan file of `count` things, in the YAML format."""
    rng = random.Random(count)
    across = math.ceil(math.sqrt(count))
    side = across * spacing
    lines = [f"boundary: [[0, 0], [{side}, 0], [{side}, {side}], [0, {side}]]", "obstacles:"]
    for k in range(count):
        x, y = (
            (cell + 0.5 + rng.uniform(-0.2, 0.2)) * spacing for cell in (k % across, k // across)
        )
        size = [round(rng.uniform(0.5, 1.5), 3), round(rng.uniform(0.5, 1.0), 3)]
        lines.append(f"  thing{k}: {{center: [{x:.3f}, {y:.3f}], size: {size}, z: [0, 1]}}")
    return "\n".join(lines) + "\n"


def measure(count: int, spacing: float, queries: int) -> None:
    import floorplan
    from navigation import CollisionWorld, PathPlanner

    text = hall(count, spacing)
    load, plan = timed(lambda: floorplan.parse(text))
    build, world = timed(lambda: CollisionWorld(plan))
    planner = PathPlanner(world, RADIUS)
    prepare, _ = timed(planner.prepare)
    rng = random.Random(0)
    side = plan.boundary.bounds[2]
    places: list[tuple[float, float]] = []
    while len(places) < 2 * queries:
        at = (rng.uniform(0, side), rng.uniform(0, side))
        if world.free(at, RADIUS + 1e-3):
            places.append(at)
    ways = [
        timed(lambda a=a, b=b: planner.plan(a, b))[0]
        for a, b in zip(places[::2], places[1::2], strict=True)
    ]
    figures = [load, build, prepare, ways[0], statistics.median(ways), max(ways)]
    print(" | ".join(f"{figure:.2f}" for figure in figures))


def timed(work: Callable[[], _T]) -> tuple[float, _T]:
    begin = time.process_time()
    result = work()
    return time.process_time() - begin, result


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--obstacles", type=int, nargs="+", default=[100, 1000, 10_000])
    parser.add_argument("--queries", type=int, default=20)
    parser.add_argument("--one", nargs=2, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.one:
        measure(int(given.one[0]), float(given.one[1]), given.queries)
        return
    print("| obstacles | | load | world | prepare | first way | median way | slowest way |")
    print("|---|---|---|---|---|---|---|---|")
    for count in given.obstacles:
        for title, spacing in SPACINGS.items():
            again = [sys.executable, __file__, "--queries", str(given.queries)]
            again += ["--one", str(count), str(spacing)]
            found = subprocess.run(again, capture_output=True, text=True, check=True).stdout
            print(f"| {count:,} | {title} | {found.strip()} |", flush=True)


if __name__ == "__main__":
    main()
