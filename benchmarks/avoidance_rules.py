"""Effect of each rule of avoidance: people without it in random crowds, on patrol, and in jams.

    python benchmarks/avoidance_rules.py [--crowds 90] [--draws 3] [--only RULE ...]

Each rule is switched off by its parameters (see `AvoidanceParameters`), in a separate process.
Four changes of the gap by tenths of a millimetre show what is due to chance.
The crowds are those of `random_crowds.py`. On patrol, 50 people walk the ARIAC floor for 275 s. In
the jams, people on both sides of a narrow place go to the other side and back within 240 s. People
are late if they have not been at both of their places by the end.
"""

from __future__ import annotations

import argparse
import json
import math
import random
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import random_crowds
from random_crowds import Point, errands, hall

import floorplan
import sim
from sim.people.crowd import parameters

Value = float | Sequence[float]

RULES: Mapping[str, Mapping[str, Value]] = {
    "none": {},
    "requests": {"tries": 0},
    "forwarded requests": {"longest_chain": 1},
    "requests to higher ranks": {"rank_counts": math.inf},
    "courses beside, for requests": {"shifts": ()},
    "arrival beside an occupied goal": {"in_reach": 0.0, "beside": 0.0},
    "ring around an occupied goal": {"beside": 0.0},
    "detours around stationary people": {"detour_costs": -math.inf},
    "narrow places": {"abreast_inside": 1, "abreast_outside": 1},
    "stops short": {"parts": ()},
    "partial stops": {"parts": (1.0,)},
    "phantom share": {"phantom": 1.0},
    "paces": {"paces": ()},
    "delays": {"delays": ()},
    "wide shifts": {"detours": ()},
    "both aside": {"worth": math.inf},
    "following": {"same_way": 2.0},
    "closing up to oncoming people": {"closes_up": 0.0},
    "files": {"files": ()},
    "unusual side": {"other_side": 0.0},
    "comfort distance": {"brush": 0.0},
}
"""Parameters without each rule."""

UNCHANGED: Mapping[str, Mapping[str, Value]] = {
    f"no rule, gap of {gap} mm": {"gap": gap / 1000} for gap in (6.1, 6.2, 6.3, 6.4)
}
"""Parameters that change no rule. Their results differ by chance, so they show the noise."""

CASES = {**RULES, **UNCHANGED}

PATROL = """
floorplan: ariac2023
duration: 275
rules: observe
people: [{name: p, count: 50, at: anywhere}]
"""

Corner = tuple[Point, Point]
"""Minimum and maximum corner of the places on one side, metres."""


def two_rooms(gap: float, thickness: float, width: float) -> tuple[floorplan.Floorplan, Corner]:
    """Return two square rooms, joined by a gap in a wall, and the places in the first (metres)."""
    low, high, far = (width - gap) / 2, (width + gap) / 2, width + thickness
    walls = [(width, 0.0, far, low), (width, high, far, width)]
    return hall(far + width, width, walls), ((0.4, 0.4), (width - 0.9, width - 0.4))


def corridor(length: float, width: float) -> tuple[floorplan.Floorplan, Corner]:
    """Return a closed corridor, and the places in one half of it (metres)."""
    return hall(length, width), ((0.4, 0.35), (0.42 * length, width - 0.35))


JAMS: Mapping[str, tuple[int, tuple[floorplan.Floorplan, Corner]]] = {
    "aisle of 1.5 m": (15, two_rooms(1.5, 10.0, 6.0)),
    "aisle of 1 m": (8, two_rooms(1.0, 10.0, 6.0)),
    "door of 0.8 m": (20, two_rooms(0.8, 0.2, 7.0)),
    "corridor of 2 m": (15, corridor(30.0, 2.0)),
    "closed aisle of 1.5 m": (3, corridor(10.0, 1.5)),
}
"""How many people there are on each side, and the floor."""


def jam(name: str, draw: int) -> sim.Trial:
    """Return the trial of a jam, with places drawn at random."""
    count, (floor, ((low_x, low_y), (high_x, high_y))) = JAMS[name]
    length = floor.boundary.bounds[2]
    chance = random.Random(draw)

    def places() -> list[Point]:
        points: list[Point] = []
        while len(points) < count:
            at = (chance.uniform(low_x, high_x), chance.uniform(low_y, high_y))
            if all(math.dist(at, other) > 0.65 for other in points):
                points.append(at)
        return points

    def mirrored(places: Sequence[Point]) -> list[Point]:
        return [(length - x, y) for x, y in places]

    pairs = [*zip(places(), mirrored(places()), strict=True)]
    pairs += zip(mirrored(places()), places(), strict=True)
    return sim.Trial(
        floor,
        duration=240.0,
        rules=sim.RULE_SETS["observe"],
        people=tuple(
            sim.PersonEntry(f"p{k}", personality=errands([goal, start]), at=start)
            for k, (start, goal) in enumerate(pairs)
        ),
    )


def trials(crowds: int, draws: int) -> Iterator[tuple[str, sim.Trial]]:
    """Yield the trials, and what each belongs to."""
    for number in range(crowds):
        yield "crowds", random_crowds.trial(number)
    for draw in range(draws):
        yield "patrol", replace(sim.Trial.parse(PATROL), seed=draw)
        for name in JAMS:
            yield "jams", jam(name, draw)


def measured(crowds: int, draws: int) -> dict[str, float]:
    """Run all trials, and return what came of them."""
    from sim.people.crowd.crowd import Crowd

    results = dict.fromkeys(("lost", "legs", "overlaps", "decisions"), 0.0)
    results |= {"late_crowds": 0.0, "late_jams": 0.0, "cpu": 0.0}
    decide: Callable[..., None] = Crowd.decide

    def counted(*arguments: object) -> None:
        results["decisions"] += 1
        decide(*arguments)

    Crowd.decide = counted  # type: ignore[method-assign]
    for kind, trial in trials(crowds, draws):
        begin = time.process_time()
        run = sim.run(trial)
        results["cpu"] += time.process_time() - begin
        people = run.summary["people"].values()
        results["overlaps"] += run.summary["overlaps"]
        if kind == "patrol":
            results["legs"] += sum(len(one["visits"]) for one in people) / draws
        else:
            left = dict.fromkeys(run.summary["people"], 2)
            for event in run.events:
                if event["kind"] == "arrived":
                    left[event["person"]] -= 1
            results[f"late_{kind}"] += sum(legs > 0 for legs in left.values())
        if kind == "crowds":
            results["lost"] += sum(one["time_lost_to_others"] for one in people)
    return results


def without(rule: str, crowds: int, draws: int) -> dict[str, float]:
    """Return what comes of all trials without a rule, in another process."""
    command = [sys.executable, __file__, "--crowds", str(crowds), "--draws", str(draws)]
    done = subprocess.run([*command, "--measure", rule], stdout=subprocess.PIPE, check=True)
    results: dict[str, float] = json.loads(done.stdout)
    return results


def main() -> None:
    """Measure, and print the table of `docs/avoidance.md`."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("--crowds", type=int, default=90, help="number of random crowds")
    parser.add_argument("--draws", type=int, default=3, help="patrols, and draws of each jam")
    parser.add_argument("--only", nargs="+", choices=CASES, default=[*CASES])
    parser.add_argument("--measure", choices=CASES, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.measure:
        changed = replace(parameters.PARAMETERS, **CASES[options.measure])
        parameters.PARAMETERS = changed  # type: ignore[misc]
        print(json.dumps(measured(options.crowds, options.draws)))
        return
    print("| rule off | time lost | late | legs | late in jams | decisions | CPU | overlaps |")
    print("|---|---|---|---|---|---|---|---|")
    base: dict[str, float] = {}
    for rule in dict.fromkeys(("none", *options.only)):
        results = without(rule, options.crowds, options.draws)
        base = base or results
        change = {key: results[key] / base[key] - 1 for key in ("lost", "decisions", "cpu")}
        lost = f"{results['lost']:,.0f} s" if rule == "none" else f"{change['lost']:+.0%}"
        print(
            f"| {rule} | {lost} | {results['late_crowds']:.0f} | {results['legs']:.0f} "
            f"| {results['late_jams']:.0f} | {change['decisions']:+.0%} | {change['cpu']:+.0%} "
            f"| {results['overlaps']:.0f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
