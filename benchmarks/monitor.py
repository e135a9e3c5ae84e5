"""Cost of monitoring a person beside a gantry: CPU milliseconds, medians over repetitions.

    python benchmarks/monitor.py [--repetitions N] [--changes N]

Both change their mind `--changes` times in 275 s: the person turns towards another place, the
gantry is sent elsewhere on its way. Beside the monitor stand two that sample at 1 kHz, with the
linear law between centres: one of whole arrays, and a loop as a controller would have it. The
result is how often they are wrong: violations that they miss, and the delay of the others.
"""

from __future__ import annotations

import argparse
import math
import random
import statistics
import time
from collections.abc import Callable

import numpy as np

import floorplan
import navigation
from navigation import IntegralLaw, Motion, SeparationLaw, Shapes

SPAN = 275.0
LAW = SeparationLaw(t1=1.0, t2=1.5, stopping=0.0, intrusion=1.0)
INTEGRAL = IntegralLaw(t1=1.0, t2=1.5, stopping=0.0, intrusion=1.0)


def pair(changes: int, seed: int = 0, *, span: float = SPAN) -> tuple[Motion, Motion]:
    """A person and a gantry that change course together, `changes` times in `span` seconds."""
    rng = random.Random(seed)
    instants = [span * k / changes for k in range(changes)]
    moves: list[Motion] = []
    for t in instants:
        current = moves[-1].state(t) if moves else (-7.0, 0.0, 0.0)
        target = (rng.uniform(-14, 0), rng.uniform(-7, 7), rng.uniform(-3, 3))
        moves.append(navigation.gantry_move(current, target, t))
    walks: list[Motion] = []
    for t in instants:
        at = walks[-1].state(t).at if walks else (-15.0, -10.0)
        walks.append(navigation.walk([at, (rng.uniform(-15, 0), rng.uniform(-7, 7))], t))
    return navigation.join(walks, end=span), navigation.join(moves, end=span)


def sampled_arrays(person: Motion, machine: Motion) -> list[tuple[float, float]]:
    """Violations as 275 001 samples in arrays show them."""
    ts = np.arange(int(SPAN * 1000) + 1) / 1000
    apart = np.hypot(*(person.position(ts) - machine.position(ts)).T)
    human, robot = (np.hypot(*motion.velocity(ts).T) for motion in (person, machine))
    close = apart < LAW.distance(human, robot)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], close, [False]])))
    return [(float(ts[a]), float(ts[b - 1])) for a, b in edges.reshape(-1, 2)]


def sampled_loop(person: Motion, machine: Motion) -> list[tuple[float, float]]:
    """The same in a plain loop, one state after another."""
    violations: list[tuple[float, float]] = []
    since: float | None = None
    t = 0.0
    for k in range(int(SPAN * 1000) + 1):
        t = k / 1000
        one, other = person.state(t), machine.state(t)
        close = math.dist(one.at, other.at) < LAW.distance(one.speed, other.speed)
        if close and since is None:
            since = t
        elif not close and since is not None:
            violations.append((since, t))
            since = None
    return violations if since is None else [*violations, (since, t)]


def milliseconds(job: Callable[[], object], repetitions: int) -> tuple[float, float]:
    """Median and least CPU time of a job."""
    taken = []
    for _ in range(repetitions):
        begin = time.process_time()
        job()
        taken.append((time.process_time() - begin) * 1e3)
    return statistics.median(taken), min(taken)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--repetitions", type=int, default=15)
    parser.add_argument("--changes", type=int, default=100)
    options = parser.parse_args()
    person, machine = pair(options.changes)
    gantry = floorplan.load("ariac2023").gantry
    if gantry is None:
        raise SystemExit("the floorplan has no gantry")
    torso = Shapes(machine=(navigation.Box.of_torso(gantry),))
    span = (0.0, SPAN)
    jobs: dict[str, Callable[[], object]] = {
        "violations, linear law": lambda: navigation.violations(person, machine, LAW, *span),
        "violations, integral law": lambda: navigation.violations(person, machine, INTEGRAL, *span),
        "violations, linear law, surfaces": lambda: navigation.violations(
            person, machine, LAW, *span, shapes=torso
        ),
        "minimum_separation": lambda: navigation.minimum_separation(person, machine, *span),
        "minimum_separation, surfaces": lambda: navigation.minimum_separation(
            person, machine, *span, shapes=torso
        ),
        "minimum_margin, linear law": lambda: navigation.minimum_margin(
            person, machine, LAW, *span
        ),
        "minimum_margin, integral law": lambda: navigation.minimum_margin(
            person, machine, INTEGRAL, *span
        ),
        "minimum_margin, linear law, surfaces": lambda: navigation.minimum_margin(
            person, machine, LAW, *span, shapes=torso
        ),
        "1 kHz, arrays": lambda: sampled_arrays(person, machine),
    }
    print(f"{len(person.pieces)} pieces of the person, {len(machine.pieces)} of the gantry")
    print(f"{'275 s':40} {'median ms':>10} {'least ms':>10}")
    for name, job in jobs.items():
        median, least = milliseconds(job, options.repetitions)
        print(f"{name:40} {median:10.1f} {least:10.1f}")
    median, least = milliseconds(lambda: sampled_loop(person, machine), 3)
    print(f"{'1 kHz, loop':40} {median:10.1f} {least:10.1f}")
    exact = navigation.violations(person, machine, LAW, *span)
    sampled = sampled_arrays(person, machine)
    late = [
        min((a - begin for a, b in sampled if a <= end and begin <= b), default=None)
        for begin, end in exact
    ]
    lags = [lag for lag in late if lag is not None]
    print(
        f"{len(exact)} violations; sampling misses {len(exact) - len(lags)}"
        f" and is up to {max(lags, default=0.0) * 1e3:.2f} ms late"
    )


if __name__ == "__main__":
    main()
