"""How the cost grows with people, machines, obstacles, pieces of motion and hours: a plot of each.

    python benchmarks/scaling.py docs/images/scaling.svg

CPU seconds, the least of several repetitions where they are short. The exponent of each curve is
the slope of a straight line through the right half of its points, where both axes are logarithmic.
"""

from __future__ import annotations

import argparse
import math
import random
import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from big_floors import hall
from matplotlib.ticker import NullLocator
from monitor import INTEGRAL, LAW, SPAN, pair
from random_crowds import errands

import floorplan
import navigation
import sim
from navigation.separation import AnyLaw
from sim.views.plots.style import new_figure, save, styled
from sim.views.report_page import BLUE, VERMILION

Curve = list[tuple[float, float]]
"""Points: how many there are, and CPU seconds."""

SHORT = 0.5
"""Seconds. Work that takes less is done again and again for so long."""


def spent(work: Callable[[], object]) -> float:
    """Return the CPU seconds of `work`, the least of several if it is short."""
    each: list[float] = []
    while not each or (sum(each) < SHORT and len(each) < 20):
        begin = time.process_time()
        work()
        each.append(time.process_time() - begin)
    return min(each)


def measured(counts: Sequence[float], work: Callable[[float], Callable[[], object]]) -> Curve:
    """Return the cost of the work for each of the counts, without its preparation."""
    return [(count, spent(work(count))) for count in counts]


def running(text: str, *, warm: bool = True) -> Callable[[], object]:
    """Return the run of a trial. If `warm`, the analysis of its floor is not counted."""
    trial = sim.Trial.parse(text)
    if warm:
        sim.run(trial)
    return lambda: sim.run(trial)


def people() -> dict[str, Curve]:
    """People for 60 s: on patrol on the ARIAC floor, and in a hall of 20 m² for each of them."""

    def crowd(count: float) -> Callable[[], object]:
        return running(
            "floorplan: ariac2023\nduration: 60\nrules: observe\n"
            f"people: [{{name: p, count: {count:g}, at: anywhere}}]\n"
        )

    def hall_of(count: float) -> Callable[[], object]:
        trial = strollers(round(count))
        sim.run(trial)
        return lambda: sim.run(trial)

    return {
        "on patrol, 60 s": measured((1, 2, 4, 8, 16, 32, 64), crowd),
        "20 m² each": measured((10, 20, 50, 100, 200), hall_of),
    }


def strollers(count: int) -> sim.Trial:
    """Return a trial of people on legs of 2 to 8 m, in an empty hall of 20 m² per person."""
    chance, side = random.Random(count), math.sqrt(20.0 * count)

    def anywhere() -> tuple[float, float]:
        return (chance.uniform(0.5, side - 0.5), chance.uniform(0.5, side - 0.5))

    starts: list[tuple[float, float]] = []
    while len(starts) < count:
        at = anywhere()
        if all(math.dist(at, other) > 0.7 for other in starts):
            starts.append(at)
    crowd = []
    for k, start in enumerate(starts):
        goals = [start]
        while len(goals) < 20:
            at = anywhere()
            if 2.0 < math.dist(at, goals[-1]) < 8.0:
                goals.append(at)
        crowd.append(sim.PersonEntry(f"p{k}", personality=errands(goals[1:]), at=start))
    floor = f"boundary: [[0, 0], [{side}, 0], [{side}, {side}], [0, {side}]]"
    return sim.Trial(
        floorplan=floorplan.parse(floor),
        duration=60.0,
        rules=sim.RULE_SETS["observe"],
        people=tuple(crowd),
    )


def machines() -> dict[str, Curve]:
    """AGVs that shuttle on one lane each beside one person on patrol, for 600 s."""

    def fleet(count: float, yielding: bool) -> Callable[[], object]:
        lanes = round(count)
        side = 4.0 * lanes + 6.0
        lines = [
            f"boundary: [[0, 0], [30, 0], [30, {side}], [0, {side}]]",
            "stations: {west: [2.0, 2.0], east: [28.0, 2.0]}",
            "safe_zone: {at: [2.0, 2.0]}",
            "agvs:\n  size: [1.2, 0.7]\n  height: 1.0\n  max_speed: 1.5\n  max_acceleration: 1.0",
            "  limits: [0.0, 20.0]\n  locations: {home: 0.0, far: 20.0}\n  start: home\n  lanes:",
        ]
        lines += [f"    v{k}: {{origin: [5.0, {6 + 4 * k}], heading: 0.0}}" for k in range(lanes)]
        moves = "[{time: 0, to: far, every: 60}, {time: 30, to: home, every: 60}]"
        floor = "\n".join(f"  {line}" for line in "\n".join(lines).splitlines())
        yields = str(yielding).lower()
        agvs = "".join(f"  v{k}: {{yield: {yields}, moves: {moves}}}\n" for k in range(lanes))
        return running(
            f"floorplan:\n{floor}\nduration: 600\nrules: observe\npeople: [{{name: p}}]\n"
            f"agvs:\n{agvs}"
        )

    counts = (1, 2, 4, 8, 16, 32)
    return {
        "AGVs, 600 s": measured(counts, lambda count: fleet(count, False)),
        "AGVs that yield": measured(counts, lambda count: fleet(count, True)),
    }


def obstacles() -> dict[str, Curve]:
    """One person on patrol for 60 s through a hall with this number of obstacles, one in 100 m²."""
    counts = (30, 100, 300, 1000, 3000)
    first: Curve = []
    again: Curve = []
    running("floorplan: ariac2023\nduration: 10\n")
    for count in counts:
        text = hall(count, 10.0)
        side = float(floorplan.parse(text).boundary.bounds[2])
        text += f"stations: {{a: [5.0, 0.5], b: [{side - 5.0}, {side - 0.5}]}}\n"
        text += "safe_zone: {at: [0.5, 0.5]}\n"
        floor = "\n".join(f"  {line}" for line in text.splitlines())
        trial = f"floorplan:\n{floor}\nduration: 60\npeople: [{{name: p}}]\n"
        begin = time.process_time()
        work = running(trial)
        first.append((count, time.process_time() - begin))
        again.append((count, spent(work)))
    return {"read and run once": first, "run again": again}


def pieces() -> dict[str, Curve]:
    """All violations of a person and a gantry that change their mind every 2.75 s."""

    def watched(law: AnyLaw) -> Curve:
        return [
            (
                sum(len(motion.pieces) for motion in motions),
                spent(partial(navigation.violations, *motions, law, 0.0, span)),
            )
            for span in (SPAN / 8, SPAN / 4, SPAN / 2, SPAN, SPAN * 2, SPAN * 4, SPAN * 8)
            for motions in [pair(round(span / 2.75), span=span)]
        ]

    return {"linear law": watched(LAW), "integral law": watched(INTEGRAL)}


def hours() -> dict[str, Curve]:
    """One person on patrol on the ARIAC floor."""

    def day(count: float) -> Callable[[], object]:
        return running(
            f"floorplan: ariac2023\nduration: {count * 3600:g}\npeople: [{{name: p}}]\n", warm=False
        )

    sim.run(sim.Trial.parse("floorplan: ariac2023\nduration: 60\npeople: [{name: p}]\n"))
    return {"one person": measured((0.25, 0.5, 1.0, 2.0, 4.0, 8.0), day)}


PANELS: Mapping[str, Callable[[], dict[str, Curve]]] = {
    "people": people,
    "machines": machines,
    "obstacles": obstacles,
    "pieces of motion": pieces,
    "hours": hours,
}


def exponent(curve: Curve) -> float:
    """Return the slope of the right half of a curve where both axes are logarithmic."""
    late = curve[len(curve) // 2 - (len(curve) < 4) :]
    return float(np.polyfit(*np.log(late).T, 1)[0])


@styled()
def picture(panel_curves: Mapping[str, Mapping[str, Curve]], path: Path) -> None:
    """Draw a panel of each, with the exponents."""
    figure = new_figure("double", 3.6)
    panels = figure.subplots(2, 3).ravel()
    for axes, (name, curves) in zip(panels, panel_curves.items(), strict=False):
        for (label, curve), colour in zip(curves.items(), (BLUE, VERMILION), strict=False):
            power = f"exponent {exponent(curve):.1f}"
            axes.loglog(
                *zip(*curve, strict=True), "o-", ms=3, color=colour, label=f"{label}: {power}"
            )
        axes.set_xlabel(name)
        counts = [count for count, _ in next(iter(curves.values()))]
        axes.set_xticks(counts, [f"{count:,g}" for count in counts], rotation=30)
        axes.xaxis.set_minor_locator(NullLocator())
        axes.legend(loc="upper left")
        low, high = axes.get_ylim()
        axes.set_ylim(low, high * (high / low) ** 0.4)
    for axes in panels[::3]:
        axes.set_ylabel("CPU time, s")
    for axes in panels[len(panel_curves) :]:
        axes.remove()
    save(figure, path)


def main() -> None:
    """Print the figures, and draw the picture if a path is given for it."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("picture", nargs="?", type=Path)
    parser.add_argument("--only", choices=PANELS, nargs="+", default=list(PANELS))
    options = parser.parse_args()
    curves = {}
    for name in options.only:
        curves[name] = PANELS[name]()
        for label, curve in curves[name].items():
            points = ", ".join(f"{count:g}: {seconds:.3g}" for count, seconds in curve)
            print(f"{name}, {label}: exponent {exponent(curve):.2f} ({points})", flush=True)
    if options.picture is not None:
        picture(curves, options.picture)


if __name__ == "__main__":
    main()
