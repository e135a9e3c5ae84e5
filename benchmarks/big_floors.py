"""How long floors of many obstacles take to load and to plan on: CPU seconds.

    python benchmarks/big_floors.py [--obstacles 100 1000 10000] [--queries 20] [--plot FILE]

Bins and tables stand at random in a square hall that grows with their number: one in 100 m² or one
in 12 m². Paths lead from one random place to another. Each number is one run in a fresh process.
Beside the roadmap, RRTConnect and JuPedSim (if installed) answer the same questions. `--plot` draws
the median over the number of obstacles in the denser halls (with matplotlib).
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
from typing import TYPE_CHECKING, Any, TypeVar

import shapely

if TYPE_CHECKING:
    from navigation import CollisionWorld

SPACINGS = {"loose": 10.0, "dense": 3.5}
"""Metres from one thing to the next, on average."""

RADIUS = 0.3

MOST_CORNERS = 20_000
"""Floors of more corners, when shrunk, are not given to JuPedSim: it takes minutes to look."""

COLUMNS = (
    "load",
    "world",
    "prepare",
    "first path",
    "median path",
    "slowest path",
    "RRTConnect, median",
    "JuPedSim, look",
    "JuPedSim, median",
)
"""CPU seconds of each row."""

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
    questions = list(zip(places[::2], places[1::2], strict=True))
    ways = [timed(lambda a=a, b=b: planner.plan(a, b))[0] for a, b in questions]
    sampled = [
        timed(lambda a=a, b=b: planner.plan(a, b, planner="RRTConnect"))[0] for a, b in questions
    ]
    figures = [load, build, prepare, ways[0], statistics.median(ways), max(ways)]
    figures += [statistics.median(sampled), *peer(world, questions)]
    print(" | ".join(f"{figure:.6f}" for figure in figures))


def peer(world: CollisionWorld, questions: list[Any]) -> tuple[float, float]:
    """Seconds that JuPedSim takes to load a floor, and for a path. NaN without JuPedSim."""
    from navigation.benchmark import PEERS

    jupedsim = PEERS["JuPedSim"]
    corners = shapely.get_num_coordinates(world.free_space(RADIUS).pieces).sum()
    if corners > MOST_CORNERS or not jupedsim.installed:
        return math.nan, math.nan
    look, search = timed(lambda: jupedsim.prepare(world, RADIUS))
    return look, statistics.median(timed(lambda a=a, b=b: search(a, b))[0] for a, b in questions)


def draw(file: str, counts: list[int], rows: list[list[float]]) -> None:
    """Draw the medians (see `COLUMNS`) over the number of obstacles."""
    from matplotlib.figure import Figure

    from sim.views.plots import save

    figure = Figure(figsize=(6, 4), layout="constrained")
    axes = figure.add_subplot(xlabel="obstacles", ylabel="CPU time of a path, median, ms")
    for name, column in (("Roadmap", 4), ("RRTConnect", 6), ("JuPedSim", 8)):
        axes.loglog(counts, [1000 * row[column] for row in rows], "o-", label=name)
    axes.legend()
    save(figure, file)


def timed(work: Callable[[], _T]) -> tuple[float, _T]:
    begin = time.process_time()
    result = work()
    return time.process_time() - begin, result


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--obstacles", type=int, nargs="+", default=[100, 1000, 10_000])
    parser.add_argument("--queries", type=int, default=20)
    parser.add_argument("--plot", metavar="FILE")
    parser.add_argument("--one", nargs=2, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        measure(int(options.one[0]), float(options.one[1]), options.queries)
        return
    print(f"| obstacles | | {' | '.join(COLUMNS)} |")
    print("|---|---" + "|---" * len(COLUMNS) + "|")
    drawn = []
    for count in options.obstacles:
        for title, spacing in SPACINGS.items():
            again = [sys.executable, __file__, "--queries", str(options.queries)]
            again += ["--one", str(count), str(spacing)]
            row = subprocess.run(again, capture_output=True, text=True, check=True).stdout
            print(f"| {count:,} | {title} | {row.strip()} |", flush=True)
        drawn.append([float(figure) for figure in row.split("|")])
    if options.plot:
        draw(options.plot, options.obstacles, drawn)


if __name__ == "__main__":
    main()
