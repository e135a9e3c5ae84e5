"""How fast crowds run, beside JuPedSim: CPU seconds of one process, one after the other.

    python benchmarks/people.py [--people 10 50 100] [--duration 275] [--repetitions 3]
                                [--in-reach 1.25]

All people are on patrol on the ARIAC floor: from station to station in the trial's order, from the
same starts in both. JuPedSim (`pip install jupedsim`) runs its collision-free speed model at 0.05 s
with bodies and top speeds of the floor's people. There, a person has reached a station at
`--in-reach` metres from it. Both do one run before the first that counts, so that the
floor has been analysed. Minds, the separation monitor and the record are in ours. Medians of
several.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable, Sequence

import jupedsim
import shapely

import floorplan
import sim

IN_REACH = 1.25
"""Metres. So near to a station our people, who else stop at it, have arrived if it is taken."""

STEP = 0.05
"""Seconds. JuPedSim's step."""

LOOK = 20
"""Steps between two looks at where JuPedSim's people go; a leg takes much longer."""

PLAN = floorplan.load("ariac2023")

Start = tuple[float, float]


def trial(people: int, duration: float) -> sim.Trial:
    """The patrol of this number of people."""
    return sim.Trial.parse(
        f"floorplan: ariac2023\nduration: {duration}\nrules: observe\n"
        f"people: [{{name: p, count: {people}, at: anywhere}}]\n"
    )


def ours(given: sim.Trial) -> tuple[int, list[Start]]:
    """Run a patrol. Return the number of finished legs, and the starts of the people."""
    run = sim.run(given)
    if run.summary.get("overlaps"):  # one alone has no such figure
        raise AssertionError(f"{run.summary['overlaps']} pairs of people overlap")
    starts = [tuple(run.motions[name].position(0.0).tolist()) for name in run.summary["people"]]
    return sum(len(person["visits"]) for person in run.summary["people"].values()), starts


def jupedsims(starts: Sequence[Start], duration: float, in_reach: float) -> int:
    """Run the same patrol in JuPedSim. Return the number of finished legs."""
    human = PLAN.human
    floor = max(shapely.get_parts(PLAN.free(0.0, human.height)), key=lambda part: part.area)
    world = jupedsim.Simulation(model=jupedsim.CollisionFreeSpeedModel(), geometry=floor, dt=STEP)
    stages = [world.add_waypoint_stage(station.position, in_reach) for station in PLAN.patrolled]
    journey = jupedsim.JourneyDescription(stages)
    for stage, following in zip(stages, [*stages[1:], stages[0]], strict=True):
        journey.set_transition_for_stage(
            stage, jupedsim.Transition.create_fixed_transition(following)
        )
    patrol = world.add_journey(journey)
    bound_for = {}
    for start in starts:
        agent = world.add_agent(
            jupedsim.CollisionFreeSpeedModelAgentParameters(
                position=start,
                radius=human.radius,
                desired_speed=human.max_speed,
                journey_id=patrol,
                stage_id=stages[0],
            )
        )
        bound_for[agent] = stages[0]
    legs = 0
    for step in range(round(duration / STEP)):
        world.iterate()
        if step % LOOK == 0:
            for agent in world.agents():
                if agent.stage_id != bound_for[agent.id]:
                    legs += 1
                    bound_for[agent.id] = agent.stage_id
    return legs


def timed(run: Callable[[], int], repetitions: int) -> tuple[float, int]:
    """The median CPU seconds of a run, and the legs that it finished."""
    seconds, legs = [], 0
    for _ in range(repetitions):
        begin = time.process_time()
        legs = run()
        seconds.append(time.process_time() - begin)
    return statistics.median(seconds), legs


def _three(figure: float) -> str:
    """Return a figure by the three digits that count."""
    return f"{float(f'{figure:.3g}'):,.10g}"


def legs(counts: Sequence[int], duration: float = 275.0) -> str:
    """Return the table of legs that these numbers of people finish, the same on every machine."""
    lines = ["| people | Floorwalker | JuPedSim |", "|---|---|---|"]
    for people in counts:
        finished, starts = ours(trial(people, duration))
        figures = (finished, jupedsims(starts, duration, IN_REACH))
        cells = [f"{figure / people / duration * 60:.2f}" for figure in figures]
        lines.append(f"| {people} | {' | '.join(cells)} |")
    return "\n".join(lines)


def main() -> None:
    """Measure, and print the table of `docs/performance.md`."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--people", type=int, nargs="+", default=[10, 50, 100])
    parser.add_argument("--duration", type=float, default=275.0)
    parser.add_argument("--repetitions", type=int, default=3)
    parser.add_argument("--in-reach", type=float, default=IN_REACH, help="metres")
    asked = parser.parse_args()
    ours(trial(2, 10.0))
    print("| people | | × real time | legs per person and minute | legs per CPU second |")
    print("|---|---|---|---|---|")
    for people in asked.people:
        given = trial(people, asked.duration)
        _, starts = ours(trial(people, 0.1))
        jupedsims(starts, 1.0, asked.in_reach)
        for name, run in (
            ("Floorwalker", lambda given=given: ours(given)[0]),
            ("JuPedSim", lambda starts=starts: jupedsims(starts, asked.duration, asked.in_reach)),
        ):
            seconds, legs = timed(run, asked.repetitions)
            each = legs / people / asked.duration * 60
            print(
                f"| {people} | {name} | {_three(asked.duration / seconds)} | {each:.2f}"
                f" | {_three(legs / seconds)} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
