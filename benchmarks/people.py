"""CPU time of crowds in Floorwalker and in JuPedSim.

    python benchmarks/people.py [--scene ariac hall] [--people 10 50 100] [--duration 275]
                                [--repetitions 3] [--in-reach 1.25]

Scenes:

- `ariac`: all people patrol the stations of the ARIAC floor in the trial's order.
- `hall`: the floor is empty and grows with the number of people. Each person walks to and fro
  through its middle, between the start and the opposite position.

Both programs have the same starts, goals, bodies and top speeds. JuPedSim (`pip install jupedsim`)
runs its collision-free speed model at 0.05 s. A person there has reached a goal within `--in-reach`
metres. Each program runs once before the measurement, so that precomputed data of the floor do not
count. The runs take turns in one process. Floorwalker's times include agents, the separation
monitor and the record.
"""

from __future__ import annotations

import argparse
import itertools
import math
import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import jupedsim
import shapely

import bdi
import floorplan
import sim

IN_REACH = 1.25
"""Distance from an occupied station at which people of Floorwalker have arrived, m."""

STEP = 0.05
"""Time step of JuPedSim, s."""

CHECKED = 20
"""Number of steps between two checks of the goals in JuPedSim. A walk takes much longer."""

AREA = 9.0
"""Area of the hall per person, m²."""

SMALLEST = 20.0
"""Minimum length of the sides of the hall, m."""

TO_AND_FRO = """
+human_start : there(X, Y) <- move(X, Y, 0).
+work_completed(N) : N mod 2 == 0 & back(X, Y) <- move(X, Y, 0).
+work_completed(_) : there(X, Y) <- move(X, Y, 0).
"""

Point = tuple[float, float]


@dataclass(frozen=True)
class Scene:
    """A trial, and the goals of each person, who walks from one to the next, again and again."""

    trial: sim.Trial
    goals: Sequence[Sequence[Point]]

    def starts(self) -> list[Point]:
        """Return the start of each person, which may be random."""
        scene = sim.Simulation(self.trial).scene
        return [scene.starts[entry.name][:2] for entry in self.trial.people]


def ariac(people: int, duration: float) -> Scene:
    """Return the patrol of the ARIAC floor."""
    trial = sim.Trial.parse(
        f"floorplan: ariac2023\nduration: {duration}\nrules: observe\n"
        f"people: [{{name: p, count: {people}, at: anywhere}}]\n"
    )
    stations = [station.position for station in trial.floorplan.patrolled]
    return Scene(trial, [stations] * people)


def hall(people: int, duration: float) -> Scene:
    """Return the walks through the middle of an empty hall, from a regular grid of starts."""
    side = max(SMALLEST, math.sqrt(AREA * people))
    rows = math.ceil(math.sqrt(people))
    starts = [
        (round((k % rows + 0.25) * side / rows, 3), round((k // rows + 0.25) * side / rows, 3))
        for k in range(people)
    ]
    goals = [((round(side - x, 3), round(side - y, 3)), (x, y)) for x, y in starts]
    program = bdi.parse(TO_AND_FRO)
    entries = [
        sim.PersonEntry(
            f"p{k}",
            personality=program,
            at=start,
            beliefs=(f"there({x}, {y})", f"back({start[0]}, {start[1]})"),
        )
        for k, (start, ((x, y), _)) in enumerate(zip(starts, goals, strict=True))
    ]
    plan = floorplan.Floorplan(name="hall", boundary=shapely.box(0.0, 0.0, side, side))
    rules = sim.RULE_SETS["observe"]
    return Scene(sim.Trial(plan, duration=duration, rules=rules, people=tuple(entries)), goals)


SCENES = {"ariac": ariac, "hall": hall}


def floorwalkers(scene: Scene) -> int:
    """Run a scene in Floorwalker. Return the number of finished walks."""
    run = sim.run(scene.trial)
    if run.summary.get("overlaps"):  # a single person has no such value
        raise AssertionError(f"{run.summary['overlaps']} pairs of people overlap")
    return sum(event["kind"] == "arrived" for event in run.events)


def jupedsims(scene: Scene, starts: Sequence[Point], duration: float, in_reach: float) -> int:
    """Run a scene in JuPedSim. Return the number of finished walks."""
    plan = scene.trial.floorplan
    human = plan.human
    floor = max(shapely.get_parts(plan.free(0.0, human.height)), key=lambda part: part.area)
    world = jupedsim.Simulation(model=jupedsim.CollisionFreeSpeedModel(), geometry=floor, dt=STEP)
    journeys: dict[tuple[Point, ...], tuple[int, int]] = {}
    bound_for = {}
    for start, goals in zip(starts, map(tuple, scene.goals), strict=True):
        if goals not in journeys:
            stages = [world.add_waypoint_stage(goal, in_reach) for goal in goals]
            journey = jupedsim.JourneyDescription(stages)
            for stage, following in itertools.pairwise([*stages, stages[0]]):
                fixed = jupedsim.Transition.create_fixed_transition(following)
                journey.set_transition_for_stage(stage, fixed)
            journeys[goals] = world.add_journey(journey), stages[0]
        patrol, first = journeys[goals]
        agent = world.add_agent(
            jupedsim.CollisionFreeSpeedModelAgentParameters(
                position=start,
                radius=human.radius,
                desired_speed=human.max_speed,
                journey_id=patrol,
                stage_id=first,
            )
        )
        bound_for[agent] = first
    walks = 0
    for step in range(round(duration / STEP)):
        world.iterate()
        if step % CHECKED == 0:
            for agent in world.agents():
                if agent.stage_id != bound_for[agent.id]:
                    walks += 1
                    bound_for[agent.id] = agent.stage_id
    return walks


def timed(run: Callable[[], int]) -> tuple[float, int]:
    """Return the CPU time of a run (s), and its finished walks."""
    begin = time.process_time()
    walks = run()
    return time.process_time() - begin, walks


def legs(counts: Sequence[int], duration: float = 275.0) -> str:
    """Return the table of walks per person and minute, which does not depend on the machine."""
    lines = ["| people | Floorwalker | JuPedSim |", "|---|---|---|"]
    for people in counts:
        scene = ariac(people, duration)
        walks = floorwalkers(scene), jupedsims(scene, scene.starts(), duration, IN_REACH)
        cells = [f"{count / people / duration * 60:.2f}" for count in walks]
        lines.append(f"| {people} | {' | '.join(cells)} |")
    return "\n".join(lines)


def measure(scene: Scene, duration: float, repetitions: int, in_reach: float) -> list[str]:
    """Return the cells of a row for one scene: medians of Floorwalker and JuPedSim in turn."""
    starts = scene.starts()
    jupedsims(scene, starts, 1.0, in_reach)
    ours, theirs = [], []
    for _ in range(repetitions):
        ours.append(timed(lambda: floorwalkers(scene)))
        theirs.append(timed(lambda: jupedsims(scene, starts, duration, in_reach)))
    seconds = [statistics.median(cpu for cpu, _ in runs) for runs in (ours, theirs)]
    ratios = [other / own for (own, _), (other, _) in zip(ours, theirs, strict=True)]
    per_second = [runs[0][1] / cpu for runs, cpu in zip((ours, theirs), seconds, strict=True)]
    return [
        *(f"{cpu:.3g}" for cpu in seconds),
        f"{statistics.median(ratios):.2f}",
        *(f"{walks:,.0f}" for walks in per_second),
    ]


def main() -> None:
    """Measure, and print one table per scene."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scene", nargs="+", choices=SCENES, default=[*SCENES])
    parser.add_argument("--people", type=int, nargs="+", default=[10, 50, 100])
    parser.add_argument("--duration", type=float, default=275.0, help="seconds")
    parser.add_argument("--repetitions", type=int, default=3)
    parser.add_argument("--in-reach", type=float, default=IN_REACH, help="metres")
    options = parser.parse_args()
    for name in options.scene:
        print(
            f"\n{name}: CPU time (s) and walks per CPU second of Floorwalker (F) and JuPedSim (J)\n"
        )
        print("| people | F, s | J, s | J / F | walks/s F | walks/s J |")
        print("|---|---|---|---|---|---|")
        floorwalkers(SCENES[name](2, 10.0))
        for people in options.people:
            scene = SCENES[name](people, options.duration)
            cells = measure(scene, options.duration, options.repetitions, options.in_reach)
            print(f"| {people} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
