"""CPU time of the main job with people's paths out of OMPL, over that of asking the roadmap itself.

    python benchmarks/ompl_in_the_loop.py [--trial ariac2023] [--rounds 15]

Both run in turn in one process, so that other load on the machine slows both.
"""

from __future__ import annotations

import argparse
import statistics
import time

import navigation.planner
import sim
from floorplan import Point
from navigation.roadmap_planner import RoadmapQuestions, RoadmapSearch


class Directly(RoadmapQuestions):
    """The same search, without OMPL around it."""

    def path(self, start: Point, goal: Point, step: float) -> list[Point] | None:
        return RoadmapSearch(self.links, start, goal, step, self.links.free).path()


def cpu_seconds(trial: sim.Trial, questions: type[RoadmapQuestions]) -> float:
    """CPU seconds of a run with paths by `questions`."""
    navigation.planner.RoadmapQuestions = questions
    begin = time.process_time()
    sim.run(trial)
    return time.process_time() - begin


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--trial", default="ariac2023")
    parser.add_argument("--rounds", type=int, default=15)
    options = parser.parse_args()
    trial = sim.Trial.load(options.trial)
    cpu_seconds(trial, Directly)
    through, without = [], []
    for _ in range(options.rounds):
        through.append(cpu_seconds(trial, RoadmapQuestions))
        without.append(cpu_seconds(trial, Directly))
    one, other = statistics.median(through), statistics.median(without)
    print(f"through OMPL {1000 * one:.1f} ms, directly {1000 * other:.1f} ms: {one / other:.3f}")


if __name__ == "__main__":
    main()
