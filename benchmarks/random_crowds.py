"""Random trials of 2 to 50 people on ten floors: overlaps, bodies in walls, late people.

    python benchmarks/random_crowds.py [--trials 1000] [--first 0] [--again 5]

Each trial follows from its number: a floor in turn, how many people, where they start, and two
places that each goes to, one after the other. Machines stand. The finished run shows the least
distance of two bodies in continuous time, people nearer to a wall than their radius, and people who
had not been at both places in `DURATION`. Every `--again`th trial runs twice: its events and
motions must be the same bytes.
"""

from __future__ import annotations

import argparse
import hashlib
import itertools
import math
import random
import sys
import time
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import shapely
from joblib import Parallel, delayed

import bdi
import floorplan
import navigation
import sim

DURATION = 400.0
"""Seconds; a path across the largest floor takes a tenth of it."""

LEAST, MOST = 2, 50
"""People of a trial."""

APART = 0.05
"""Metres between two bodies where they start, and where they go at a time."""

HAIR = 1e-6
"""Metres. What figures may be off by."""

EXAMPLES = Path(__file__).parent.parent / "examples"

Point = tuple[float, float]
Wall = tuple[float, float, float, float]


def hall(width: float, depth: float, walls: Sequence[Wall] = ()) -> floorplan.Floorplan:
    """Return a floor from the origin on, with walls as (x0, y0, x1, y1) in metres."""
    obstacles = tuple(
        floorplan.Obstacle(name=f"wall{k}", footprint=shapely.box(*wall), bottom=0.0, top=2.5)
        for k, wall in enumerate(walls)
    )
    return floorplan.Floorplan(
        name="hall", boundary=shapely.box(0, 0, width, depth), obstacles=obstacles
    )


FLOORS = {
    "ariac2023": lambda: floorplan.load("ariac2023"),
    "warehouse": lambda: floorplan.load("warehouse"),
    "machine_shop": lambda: floorplan.load("machine_shop"),
    "press hall": lambda: floorplan.load(EXAMPLES / "press_hall" / "hall.yaml"),
    "picking hall": lambda: floorplan.load(EXAMPLES / "picking_hall" / "hall.yaml"),
    "press shop": lambda: floorplan.load(EXAMPLES / "press_shop.yaml"),
    "empty hall": lambda: hall(14, 14),
    "columns": lambda: hall(
        20, 14, [(x, y, x + 1, y + 1) for x in range(2, 19, 3) for y in range(2, 12, 3)]
    ),
    "door of 1 m": lambda: hall(20, 9, [(9.9, 0, 10.1, 4), (9.9, 5, 10.1, 9)]),
    "aisle of 1.5 m": lambda: hall(22, 9, [(9.5, 0, 12.5, 3.75), (9.5, 5.25, 12.5, 9)]),
}
"""Built-in ones, those of the worked examples, and halls."""


class Found(NamedTuple):
    """Result of a trial: metres between two bodies, and names of people with each fault.

    `legs` places were reached, by `last` (seconds).
    """

    people: int
    nearest: float
    in_walls: list[str]
    stuck: list[str]
    same: bool
    legs: int
    last: float


@cache
def floor(name: str) -> tuple[floorplan.Floorplan, navigation.CollisionWorld]:
    """Return a floor, and its collision world."""
    plan = FLOORS[name]()
    return plan, navigation.CollisionWorld(plan)


def places(
    chance: random.Random, world: navigation.CollisionWorld, radius: float, count: int
) -> list[Point]:
    """Return this number of free places apart from each other, connected by paths."""
    west, south, east, north = world.plan.boundary.bounds
    space, points = world.free_space(radius), list[Point]()
    largest = max(space.pieces, key=lambda piece: piece.area).representative_point()
    middle = (largest.x, largest.y)
    while len(points) < count:
        at = (round(chance.uniform(west, east), 3), round(chance.uniform(south, north), 3))
        if (
            world.free(at, radius + 0.01)
            and space.together(at, middle)
            and all(math.dist(at, other) > 2 * radius + APART for other in points)
        ):
            points.append(at)
    return points


def trial(number: int) -> sim.Trial:
    """Return the trial of this number."""
    chance = random.Random(number)
    plan, world = floor([*FLOORS][number % len(FLOORS)])
    count, radius = chance.randint(LEAST, MOST), plan.human.radius
    starts, *goals = (places(chance, world, radius, count) for _ in range(3))
    return sim.Trial(
        plan,
        duration=DURATION,
        seed=number,
        rules=sim.RULE_SETS["observe"],
        people=tuple(
            sim.PersonEntry(f"p{k}", personality=errands(ways), at=at)
            for k, (at, *ways) in enumerate(zip(starts, *goals, strict=True))
        ),
    )


def errands(goals: Sequence[Point]) -> bdi.Program:
    """Return the program of a person who walks to places, one after the other."""
    heads = ["+human_start", *(f"+work_completed({k})" for k in range(len(goals) - 1))]
    return bdi.parse(
        "\n".join(
            f"{head} <- move({x}, {y}, 0)." for head, (x, y) in zip(heads, goals, strict=True)
        )
    )


def tried(number: int, again: bool) -> Found:
    """Run the trial of a number, and find out what came of it."""
    scene = trial(number)
    run = sim.run(scene)
    arrivals = [event for event in run.events if event["kind"] == "arrived"]
    left = dict.fromkeys(run.summary["people"], 2)
    for event in arrivals:
        left[event["person"]] -= 1
    return Found(
        len(left),
        nearest(run),
        [name for name in left if in_wall(run, name)],
        [name for name, legs in left.items() if legs > 0],
        not again or digest(run) == digest(sim.run(scene)),
        len(arrivals),
        max((event["t"] for event in arrivals), default=0.0),
    )


def nearest(run: sim.Run) -> float:
    """Return the least distance between two bodies, metres: of each pair in continuous time."""
    entries, human = run.trial.people, run.trial.floorplan.human
    bodies = [(run.motions[one.name], one.radius or human.radius) for one in entries]
    return min(
        navigation.minimum_separation(a, b, 0.0, run.duration)[1] - r - s
        for (a, r), (b, s) in itertools.combinations(bodies, 2)
    )


def in_wall(run: sim.Run, name: str) -> bool:
    """Return whether a person came nearer to a static obstacle than their radius."""
    plan, motion = run.trial.floorplan, run.motions[name]
    world = navigation.CollisionWorld(plan).as_if(away=[lane.name for lane in plan.lanes])
    line = motion.position(np.array([0.0, *(piece.end for piece in motion.pieces[:-1])]))
    return bool(world.clearance(line) < plan.human.radius - HAIR)


def digest(run: sim.Run) -> bytes:
    """Return a digest of all events and motions of a run."""
    sha = hashlib.sha256(repr([*run.events]).encode())
    for name, motion in run.motions.items():
        sha.update(repr((name, [*motion.pieces])).encode())
    return sha.digest()


def table(numbers: range, every: int, jobs: int) -> str:
    """Run the trials of these numbers, some of each twice, and return the table.

    Failures are named on stderr.
    """
    names = [[*FLOORS][number % len(FLOORS)] for number in numbers]
    runs = Parallel(n_jobs=jobs)(
        delayed(tried)(number, again=(number // len(FLOORS)) % every == 0) for number in numbers
    )
    results: list[Found] = list(runs)
    for number, name, one in zip(numbers, names, results, strict=True):
        if one.nearest < 0.0 or one.in_walls or one.stuck or not one.same:
            print(f"{number} ({name}): {one}", file=sys.stderr, flush=True)
    lines = [
        "| result | number |",
        "|---|---|",
        f"| trials | {len(results):,} |",
        f"| people | {sum(one.people for one in results):,} |",
        f"| trials with an overlap, in continuous time | {sum(o.nearest < 0.0 for o in results)} |",
        f"| people closer to a wall than their radius | {sum(len(o.in_walls) for o in results)} |",
        f"| people who do not reach their destination | {sum(len(o.stuck) for o in results)} |",
        f"| trials whose repetition differs in any byte | {sum(not o.same for o in results)} |",
        f"| minimum gap between two bodies, m | {min(o.nearest for o in results):.4f} |",
    ]
    return "\n".join(lines)


def main() -> None:
    """Run the selected trials. Print the table of `docs/people-validation.md`."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("--trials", type=int, default=1000, help="how many")
    parser.add_argument("--first", type=int, default=0, help="number of the first")
    parser.add_argument("--again", type=int, default=5, help="each so many runs twice")
    options = parser.parse_args()
    begin = time.process_time()
    print(table(range(options.first, options.first + options.trials), options.again, jobs=1))
    print(f"{time.process_time() - begin:.0f} s of CPU")


if __name__ == "__main__":
    main()
