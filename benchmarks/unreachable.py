"""How long it takes to prove that there is no way: CPU milliseconds.

    python benchmarks/unreachable.py [--queries 200]

On `ariac2023`, the goal is in a pen whose only gap is narrower than the person. Every query has
another start, and other positions of all four AGVs on their lanes. The wording of the reason, which
is worked out when it is read, is timed apart.
"""

from __future__ import annotations

import argparse
import random
import time

import numpy as np
import shapely

import floorplan
from navigation import CollisionWorld, PathPlanner, PlanningError

GOAL = (-10.5, -6.8)
PEN = {
    "south": (-12.0, -8.0, -9.0, -7.7),
    "north": (-12.0, -5.9, -9.0, -5.6),
    "west": (-12.0, -7.7, -11.7, -5.9),
    "east": (-9.3, -7.2, -9.0, -5.9),
}
"""Walls around the goal; a gap of 0.5 m is left in the south-east."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--queries", type=int, default=200)
    queries = parser.parse_args().queries
    plan = floorplan.load("ariac2023")
    world = CollisionWorld(plan)
    for name, walls in PEN.items():
        world.place(name, shapely.box(*walls))
    planner = PathPlanner(world, plan.human.radius)
    planner.prepare()
    rng = random.Random(0)
    proofs, wordings = [], []
    while len(proofs) < queries:
        for lane in plan.lanes:
            world.move_agv(lane.name, rng.uniform(*lane.limits))
        start = (rng.uniform(-15.0, 1.5), rng.uniform(-11.5, 11.5))
        if not world.free(start, plan.human.radius + 1e-3) or shapely.box(
            -12.0, -8.0, -9.0, -5.6
        ).contains(shapely.Point(start)):
            continue
        begin = time.process_time()
        try:
            planner.plan(start, GOAL)
            raise SystemExit(f"there is a way from {start}")
        except PlanningError as why:
            proofs.append(time.process_time() - begin)
            if why.reason != "unreachable":
                raise SystemExit(f"{why.reason}: {why}") from None
            begin = time.process_time()
            words = str(why)
            wordings.append(time.process_time() - begin)
    for title, seconds in (("proof", proofs), ("wording", wordings)):
        ms = 1000 * np.array(seconds)
        print(f"{title:8} median {np.median(ms):.2f} ms, 99 % {np.percentile(ms, 99):.2f} ms")
    print(words)


if __name__ == "__main__":
    main()
