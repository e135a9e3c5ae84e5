"""Steps of learning environments per CPU second, beside ir-sim.

    python benchmarks/learning.py [--steps 1000] [--repetitions 3]

A vehicle of 0.8 m by 0.6 m gets random twists every 0.2 s in a hall of 14 m by 10 m with two racks,
among people who walk about, and observes them and 36 laser rays. ir-sim (`pip install ir-sim`) has
the same hall, with people who avoid each other by reciprocal velocity obstacles. Resets are
counted. The two take turns, so that a busy machine slows both. Figures are medians.
"""

from __future__ import annotations

import argparse
import os
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import gymnasium
import numpy as np

import sim.gym
from sim.gym.environment import FOLDER

COUNTS = (1, 5, 10)
STEP = 0.2  # seconds
LONGEST = 300  # steps of an episode

WORLD = """\
world: {{height: 10, width: 14, offset: [-7, -5], step_time: {step}, sample_time: {step}}}
robot:
  - kinematics: {{name: diff}}
    shape: {{name: rectangle, length: 0.8, width: 0.6}}
    state: [-5, -4, 0]
    goal: [5, 4, 0]
    vel_max: [1.2, 1.0]
    sensors: [{{name: lidar2d, range_max: 10, number: 36, angle_range: 6.28318}}]
obstacle:
  - number: {count}
    distribution: {{name: random, range_low: [-6, -4, -3.14], range_high: [6, 4, 3.14]}}
    kinematics: {{name: omni}}
    shape: [{{name: circle, radius: 0.25}}]
    behavior:
      - {{name: rvo, wander: true, range_low: [-6, -4, -3.14], range_high: [6, 4, 3.14]}}
    vel_max: [1.3, 1.3]
  - {{shape: {{name: rectangle, length: 3, width: 1}}, state: [-2.5, -1, 0]}}
  - {{shape: {{name: rectangle, length: 3, width: 1}}, state: [2.5, 1, 0]}}
"""

Step = Callable[[], bool]
"""Carries out a random action. Returns whether the episode is over."""


def main() -> None:
    """Print steps per CPU second with each number of people, of a gantry and of two vehicles."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--steps", type=int, default=1000)
    arguments.add_argument("--repetitions", type=int, default=3)
    options = arguments.parse_args()
    beside = find_spec("irsim") is not None
    if not beside:
        print("ir-sim is not installed: pip install ir-sim", file=sys.stderr)
    print("| people | steps per CPU second | reset, ms | ir-sim, steps per CPU second |")
    print("|---|---|---|---|")
    for count in COUNTS:
        ours, theirs, resets = [], [], []
        for _ in range(options.repetitions):
            step, reset = vehicle_among(count)
            ours.append(speed(step, reset, options.steps))
            resets.append(1000 / speed(reset, reset, 20))
            if beside:
                with peer_among(count) as (step, reset):
                    theirs.append(speed(step, reset, options.steps))
        peer = f"{statistics.median(theirs):,.0f}" if beside else "–"
        own = f"{statistics.median(ours):,.0f} | {statistics.median(resets):.1f}"
        print(f"| {count} | {own} | {peer} |", flush=True)
    for name, make in (
        ("gantry, two people", gantry),
        ("two vehicles, three people", two_vehicles),
    ):
        speeds = [speed(*make(), options.steps) for _ in range(options.repetitions)]
        print(f"{name}: {statistics.median(speeds):,.0f} steps per CPU second", flush=True)


def speed(step: Step, reset: Step, steps: int) -> float:
    """Return the number of steps per CPU second, resets included."""
    reset()
    begin = time.process_time()
    for _ in range(steps):
        if step():
            reset()
    return steps / (time.process_time() - begin)


def vehicle_among(count: int) -> tuple[Step, Step]:
    """Return a step and a reset of the vehicle among a number of people."""
    study = sim.Study.load(FOLDER / "amr.study.yaml")
    trial = study.trials[0]
    people = trial.people[:1] * count
    named = tuple(replace(one, name=f"person{k}") for k, one in enumerate(people))
    study = replace(study, trials=(replace(trial, people=named),))
    return single(gymnasium.make("floorwalker/Amr-v0", trial=study))


def gantry() -> tuple[Step, Step]:
    """Return a step and a reset of the gantry among two people."""
    return single(gymnasium.make("floorwalker/Gantry-v0"))


def single(env: gymnasium.Env) -> tuple[Step, Step]:
    """Return a step and a reset of an environment, with seeds from 0 on."""
    seeds = iter(range(sys.maxsize))
    env.action_space.seed(0)

    def step() -> bool:
        _, _, terminated, truncated, _ = env.step(env.action_space.sample())
        return terminated or truncated

    def reset() -> bool:
        env.reset(seed=next(seeds))
        return False

    return step, reset


def two_vehicles() -> tuple[Step, Step]:
    """Return a joint step and a reset of two vehicles with traffic."""
    env = sim.gym.ParallelFloorEnv(FOLDER / "two_amrs.study.yaml")
    seeds = iter(range(sys.maxsize))
    for name in env.possible_agents:
        env.action_space(name).seed(0)

    def step() -> bool:
        env.step({name: env.action_space(name).sample() for name in env.agents})
        return not env.agents

    def reset() -> bool:
        env.reset(seed=next(seeds))
        return False

    return step, reset


@contextmanager
def peer_among(count: int) -> Iterator[tuple[Step, Step]]:
    """Yield a step and a reset of the same hall in ir-sim."""
    os.environ.setdefault("MPLBACKEND", "Agg")  # as there is no display
    import irsim

    draws = np.random.default_rng(0)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "world.yaml"
        path.write_text(WORLD.format(count=count, step=STEP))
        env = irsim.make(str(path), display=False, log_level="ERROR")
        steps = 0

        def step() -> bool:
            nonlocal steps
            steps += 1
            env.step(draws.uniform(-1.0, 1.0, 2) * (1.2, 1.0))
            env.get_lidar_scan()
            return bool(env.done()) or steps % LONGEST == 0

        def reset() -> bool:
            env.reset()
            return False

        yield step, reset
        env.end()


if __name__ == "__main__":
    main()
