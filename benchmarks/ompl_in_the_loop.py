"""CPU time of the main job with people's paths out of OMPL, over that of asking the roadmap itself.

    python benchmarks/ompl_in_the_loop.py [--trial ariac2023] [--rounds 15]

Both run in turn in one process, so that what else the machine does falls on both alike.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable

import navigation.planner
import sim
from floorplan import Point
from navigation.roadmap_planner import Links, RoadmapSearch, roadmap_path
from navigation.world import CollisionWorld


def directly(
    world: CollisionWorld, start: Point, goal: Point, radius: float, step: float
) -> list[Point] | None:
    """The same search, without OMPL around it."""
    links = Links(world, radius)
    return RoadmapSearch(links, start, goal, step, links.free).path()


def cpu_seconds(trial: sim.Trial, plan: Callable[..., list[Point] | None]) -> float:
    """CPU seconds of a run with paths by `plan`."""
    navigation.planner.roadmap_path = plan
    begin = time.process_time()
    sim.run(trial)
    return time.process_time() - begin


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--trial", default="ariac2023")
    parser.add_argument("--rounds", type=int, default=15)
    options = parser.parse_args()
    trial = sim.Trial.load(options.trial)
    cpu_seconds(trial, directly)
    through, without = [], []
    for _ in range(options.rounds):
        through.append(cpu_seconds(trial, roadmap_path))
        without.append(cpu_seconds(trial, directly))
    one, other = statistics.median(through), statistics.median(without)
    print(f"through OMPL {1000 * one:.1f} ms, directly {1000 * other:.1f} ms: {one / other:.3f}")


if __name__ == "__main__":
    main()
