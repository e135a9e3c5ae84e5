"""The built-in steering beside social force and ORCA of `examples/steering`, in the same scenes.

    python benchmarks/steering_baselines.py [--crowds 10] [--patrols 1] [--only STEERING ...]

The scenes are the random crowds and the patrol of `avoidance_rules.py`. The time lost of
a person in the crowds is the time until the last of two arrivals, or until the end of the trial,
minus that of the two planned paths at top speed. Overlaps are pairs of people who come closer than
the sum of their radii, found in continuous time.
"""

from __future__ import annotations

import argparse
import itertools
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from avoidance_rules import PATROL
from random_crowds import Point, nearest, trial as crowd

import navigation
import sim

BUILT_IN = "built-in"

STEERINGS = {BUILT_IN: None, "social_force": "social_force:SocialForce", "orca": "orca:Orca"}

EXAMPLES = Path(__file__).parents[1] / "examples" / "steering"


@dataclass
class Found:
    """Results of scenes of one kind: numbers of legs, people and pairs, seconds, and metres."""

    legs: int = 0
    late: int = 0
    lost: float = 0.0
    overlaps: int = 0
    deepest: float = 0.0
    cpu: float = 0.0


def measured(
    steering: str, scenes: Sequence[sim.Trial], free: Sequence[Mapping[str, float]]
) -> Found:
    """Run scenes with a steering, and return what came of them.

    `free` has the times of the paths at top speed (s) in each scene, of people who go to two places
    only.
    """
    result = Found()
    for scene, times in zip(scenes, free, strict=True):
        begin = time.process_time()
        run = sim.run(replace(scene, steering=STEERINGS[steering], folder=EXAMPLES))
        result.cpu += time.process_time() - begin
        result.overlaps += run.summary["overlaps"]
        result.deepest = max(result.deepest, -nearest(run))
        arrivals: dict[str, list[float]] = {name: [] for name in run.summary["people"]}
        for event in run.events:
            if event["kind"] == "arrived":
                arrivals[event["person"]].append(event["t"])
        result.legs += sum(map(len, arrivals.values()))
        for name, seconds in times.items():
            is_late = len(arrivals[name]) < 2
            result.late += is_late
            result.lost += (run.duration if is_late else arrivals[name][1]) - seconds
    return result


def free_times(scene: sim.Trial) -> dict[str, float]:
    """Return the time of both planned paths of each person of a crowd, at top speed (s)."""
    times = {}
    human = scene.floorplan.human
    planner = navigation.PathPlanner(navigation.CollisionWorld(scene.floorplan), human.radius)
    for person in scene.people:
        alone = sim.run(replace(scene, people=(person,)))
        assert person.at is not None
        goals: list[Point] = [event["at"] for event in alone.events if event["kind"] == "goal"]
        legs = itertools.pairwise([person.at, *goals])
        times[person.name] = sum(planner.plan(*leg).length for leg in legs) / human.max_speed
    return times


def main() -> None:
    """Measure, and print the table of `docs/people-among-people.md`."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("--crowds", type=int, default=10, help="number of random crowds")
    parser.add_argument("--patrols", type=int, default=1, help="number of patrols")
    parser.add_argument("--only", nargs="+", choices=STEERINGS, default=[*STEERINGS])
    options = parser.parse_args()
    crowds = [crowd(number) for number in range(options.crowds)]
    patrols = [replace(sim.Trial.parse(PATROL), seed=seed) for seed in range(options.patrols)]
    print("| scenes | steering | legs | late | time lost | overlaps | deepest | CPU |")
    print("|---|---|---|---|---|---|---|---|")
    crowds_free, patrols_free = [*map(free_times, crowds)], [{} for _ in patrols]
    for kind, scenes, free in (
        ("random crowds", crowds, crowds_free),
        ("patrol of 50", patrols, patrols_free),
    ):
        for steering in options.only if scenes else ():
            results = measured(steering, scenes, free)
            late = (str(results.late), f"{results.lost:,.0f} s") if scenes is crowds else ("–", "–")
            print(
                f"| {kind} | {steering} | {results.legs} | {' | '.join(late)} "
                f"| {results.overlaps:,} | {results.deepest:.2f} m | {results.cpu:,.1f} s |",
                flush=True,
            )


if __name__ == "__main__":
    main()
