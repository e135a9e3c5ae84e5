"""How fast trials run: CPU seconds, medians over repetitions.

    python benchmarks/simulation.py [--repetitions N]

The main job is the trial `ariac2023`: 275 s, one person, the gantry parked, one AGV that moves.
Beside it are trials with more to do (`TRIALS`): by `sim.run` in a process that knows the floor, and
as `floorwalker run` prints it, which works out the floor's roadmap and writes a recording. Loading
files is not counted. Whole processes count everything, the interpreter's start included.
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Generator
from dataclasses import replace
from pathlib import Path
from typing import Any

import bdi
import navigation
import sim

ONE = "people: [{name: p, personality: helpful}]\n"
FIVE = "people:\n" + "".join(
    f"  - {{name: p{k}, personality: {name}, start: {{time: {20 * k}}}}}\n"
    for k, name in enumerate(("helpful", "indifferent", "curious", "antagonistic", "scared"))
)
WORK = """\
gantry:
  controller: {controller}
  jobs:
    - {{pick: bin2, place: agv1, part: purple pump}}
    - {{pick: bin6, place: agv4, part: blue battery}}
    - {{pick: bin3, place: agv2, part: green sensor}}
  repeat: true
agvs:
  agv1: [{{time: 60.0, to: as1}}, {{time: 120.0, to: kitting}}]
  agv4: [{{time: 90.0, to: as4}}, {{time: 150.0, to: kitting}}]
"""
CONTROLLERS = ("oblivious", "pausing", "avoiding")
BESIDE = ("indifferent", "antagonistic", "helpful")
"""Personalities of the one person beside a controller, in the pairs of both."""

FOUR_AGVS = """\
  agv2: [{time: 30.0, to: as2}, {time: 150.0, to: kitting}]
  agv3: [{time: 45.0, to: as3}, {time: 180.0, to: kitting}]
"""
INTEGRAL = """\
rules: {gantry_law: {iso_ts_15066_integral: {t1: 1.0, t2: 1.5, intrusion: 1.0}}}
people: [{name: p, personality: antagonistic}]
"""
TRIALS = {
    "one person": ONE,
    "one person, 10 s": f"duration: 10\n{ONE}",
    "five people": FIVE,
    "one person, antagonistic, integral law": INTEGRAL,
}
for crowd, people in (("one person", ONE), ("five people", FIVE)):
    for controller in CONTROLLERS:
        work = WORK.format(controller=controller)
        TRIALS[f"{crowd}, {controller} gantry, AGVs"] = people + work
"""Trials on the ARIAC floor, 275 s if not told otherwise, the gantry parked or at work."""


def cpu_of_run(trial: sim.Trial) -> float:
    begin = time.process_time()
    sim.run(trial)
    return time.process_time() - begin


def pairs(repetitions: int) -> list[float]:
    """How many times as fast as real time: three controllers at work, beside three personalities.

    Medians of each pair, with four moving AGVs.
    """
    factors = []
    for controller in CONTROLLERS:
        work = WORK.format(controller=controller) + FOUR_AGVS
        for personality in BESIDE:
            person = f"people: [{{name: p, personality: {personality}}}]\n"
            trial = sim.Trial.parse(f"floorplan: ariac2023\n{person}{work}")
            seconds = [cpu_of_run(trial) for _ in range(repetitions)]
            factors.append(trial.duration / statistics.median(seconds))
    return factors


def looking_around(gantry: Any) -> Generator[Any, Any, None]:
    """Read the positions of people ten times a second, and go to another place each time."""
    for x, y in itertools.cycle([(-2.3, 3.0), (-9.0, 0.0), (-5.0, -3.0)]):
        yield gantry.look(after=0.05)
        gantry.move_to(x, y)


def decisions(repetitions: int) -> float:
    """Decisions in a second of CPU time of a gantry that is `looking_around`."""
    trial = sim.Trial.parse(f"floorplan: ariac2023\n{ONE}")
    trial = replace(trial, gantry=sim.GantryEntry(controller=looking_around))
    return 10 * trial.duration / statistics.median(cpu_of_run(trial) for _ in range(repetitions))


def cost_of_a_day() -> tuple[float, float]:
    """24 hours of one helpful person: seconds, and by how many megabytes it grows in 23 of them."""
    trial = sim.Trial.parse(
        "floorplan: ariac2023\nduration: 86400\n"
        "people: [{name: operator, personality: helpful}]\ngantry: {at: [-2.5, 0.5, 0.0]}\n"
    )
    begin = time.process_time()
    simulation = sim.Simulation(trial)
    simulation.advance(3600.0)
    after_an_hour = _resident()
    simulation.advance(trial.duration)
    grown = _resident() - after_an_hour
    simulation.finish()
    return time.process_time() - begin, grown


def _resident() -> float:
    """Memory of this process now, in megabytes, or nan if the system has no /proc."""
    try:
        pages = Path("/proc/self/statm").read_text(encoding="ascii").split()[1]
    except OSError:
        return math.nan
    return int(pages) * resource.getpagesize() / 1e6


def speeds(text: str, repetitions: int) -> tuple[float, float]:
    """How many times as fast as real time: by `sim.run`, and as `floorwalker run` prints it."""
    text = f"floorplan: ariac2023\n{text}"
    trial = sim.Trial.parse(text)
    seconds = statistics.median(cpu_of_run(trial) for _ in range(repetitions))
    factors = []
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "t.trial.yaml").write_text(text, encoding="utf-8")
        for k in range(repetitions):
            cpu_of_process("run", f"{folder}/t.trial.yaml", "--out", f"{folder}/{k}")
            summary = Path(folder, str(k), "summary.json").read_text(encoding="utf-8")
            factors.append(json.loads(summary)["realtime_factor"])
    return trial.duration / seconds, statistics.median(factors)


def cpu_of_process(*arguments: str) -> float:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-m", "floorwalker", *arguments]
    nothing = subprocess.DEVNULL
    # Elsewhere than beside the sources, which Python would take before what is installed.
    elsewhere = tempfile.gettempdir()
    subprocess.run(command, cwd=elsewhere, check=True, stdout=nothing, stderr=nothing)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def cpu_of_monitor(changes: int = 100) -> tuple[float, float]:
    """The monitor on two gantry-like motions of 275 s, and the same pair sampled at 1 kHz."""
    import random

    import numpy as np

    rng = random.Random(0)
    motions = []
    for _ in range(2):
        moves, t, current = [], 0.0, (0.0, 0.0, 0.0)
        for _ in range(changes):
            target = (rng.uniform(-14, 0), rng.uniform(-7, 7), rng.uniform(-3, 3))
            moves.append(navigation.gantry_move(current, target, t))
            t += 275.0 / changes
            current = moves[-1].state(t)
        motions.append(navigation.join(moves, end=275.0))
    law = sim.PAPER.gantry_law
    begin = time.process_time()
    navigation.violations(motions[0], motions[1], law, 0.0, 275.0)
    exact = time.process_time() - begin
    begin = time.process_time()
    for k in range(275_000):
        one, other = (motion.state(k / 1000) for motion in motions)
        apart = np.hypot(one.position[0] - other.position[0], one.position[1] - other.position[1])
        _ = apart < law.distance(one.speed, other.speed)
    return exact, time.process_time() - begin


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--repetitions", type=int, default=15)
    repetitions = parser.parse_args().repetitions
    base = sim.Trial.load("ariac2023")
    print(f"{'first sim.run on the floor':32} {cpu_of_run(base):9.4f}")
    print(f"{'sim.run after it, 275 s':32} {'median s':>9} {'least s':>9} {'× real time':>12}")
    for personality in bdi.programs():
        trial = base.with_personality(personality)
        seconds = [cpu_of_run(trial) for _ in range(repetitions)]
        median = statistics.median(seconds)
        print(f"{personality:32} {median:9.4f} {min(seconds):9.4f} {275 / median:12,.0f}")
    print(f"{'× real time':40} {'sim.run':>9} {'command':>9}")
    for name, text in TRIALS.items():
        by_run, command = speeds(text, repetitions)
        print(f"{name:40} {by_run:9,.0f} {command:9,.0f}", flush=True)
    factors = sorted(pairs(repetitions))
    print(f"{'controllers beside personalities':40} {factors[4]:9,.0f}, least {factors[0]:,.0f}")
    print(f"{'decisions of a controller /s':40} {decisions(repetitions):9,.0f}")
    print(f"{'whole process':32} {'median s':>9}")
    helps = [cpu_of_process("--help") for _ in range(repetitions)]
    print(f"{'floorwalker --help':32} {statistics.median(helps):9.4f}")
    with tempfile.TemporaryDirectory() as folder:
        runs = [cpu_of_process("run", "--out", f"{folder}/{k}") for k in range(repetitions)]
    print(f"{'floorwalker run':32} {statistics.median(runs):9.4f}")
    with tempfile.TemporaryDirectory() as folder:
        path = f"{folder}/t.trial.yaml"
        Path(path).write_text(f"floorplan: ariac2023\n{ONE}", encoding="utf-8")
        checks = [cpu_of_process("check", path) for _ in range(repetitions)]
    print(f"{'floorwalker check':32} {statistics.median(checks):9.4f}")
    day, grown = cost_of_a_day()
    print(f"{'a day of one person':32} {day:9.4f} {86400 / day:,.0f} × real time, {grown:+.1f} MB")
    exact, sampled = cpu_of_monitor()
    print(f"{'monitor, 100 changes a side':32} {exact:9.4f}")
    print(f"{'the same sampled at 1 kHz':32} {sampled:9.4f}")


if __name__ == "__main__":
    main()
