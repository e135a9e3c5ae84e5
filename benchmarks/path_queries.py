"""How long the default planner takes for a path: CPU milliseconds, median and 99 %.

    python benchmarks/path_queries.py [FLOORPLAN] [--queries 200] [--radius 0.3] [--rounds 5]

The questions are those of `floorwalker benchmark`, seed 0, after `prepare`. Where the floor has
AGVs, they are asked with these standing still, and again with all of them moved before each. Every
query runs once a round. Its time is the median over the rounds.
"""

from __future__ import annotations

import argparse
import itertools
import time

import numpy as np

import floorplan
from navigation import CollisionWorld, PathPlanner, PlanningError
from navigation.benchmark import Question, drawn_questions


def milliseconds(planner: PathPlanner, questions: list[Question], moved: bool) -> list[float]:
    """Return CPU milliseconds for each question, in turn one of each placement of the AGVs."""
    taken = []
    placements = [
        list(group) for _, group in itertools.groupby(questions, key=lambda one: one.agvs)
    ]
    turns = itertools.chain(*itertools.zip_longest(*placements))
    for question in filter(None, turns):
        for name, at in question.agvs if moved else ():
            planner.world.move_agv(name, at)
        begin = time.process_time()
        try:
            planner.plan(question.start, question.goal)
        except PlanningError:
            if moved:
                raise
        taken.append(1000 * (time.process_time() - begin))
    return taken


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("floorplan", nargs="?", default="ariac2023")
    parser.add_argument("--queries", type=int, default=200)
    parser.add_argument("--radius", type=float, default=0.3)
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    plan = floorplan.load(options.floorplan)
    questions = [*drawn_questions(plan, queries=options.queries, seed=0, radius=options.radius)]
    for moved in (False, True) if plan.lanes else (False,):
        planner = PathPlanner(CollisionWorld(plan), options.radius)
        planner.prepare()
        rounds = [milliseconds(planner, questions, moved) for _ in range(options.rounds)]
        median, high = np.percentile(np.median(rounds, axis=0), [50, 99])
        how = ", AGVs moved before each" if moved else ", AGVs where they start" * bool(plan.lanes)
        print(f"{plan.name}{how}: median {median:.2f} ms, 99 % {high:.2f} ms")


if __name__ == "__main__":
    main()
