"""Train a vehicle among people with PPO of stable-baselines3, and export its policy as ONNX.

Needs `pip install 'floorwalker[gym,onnx]' onnx stable-baselines3`. One training takes about ten
minutes of one core.

    python train.py --seed 1 --steps 200000 --folder policies
"""

import argparse
import csv
import dataclasses
import json
from collections import deque
from pathlib import Path

import gymnasium
import numpy as np
import onnx
import torch
from gymnasium import spaces
from onnx import TensorProto, helper, numpy_helper
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor

import sim.gym  # registers the environments

FIRST_TEST_SEED = 1_000_000
"""Episodes of tests have seeds from here on, which no training draws."""

LONGEST = 10.0
"""Metres. Observations are divided by this length, and limited to -1 to 1."""

WAYS_TO_DRIVE = ("policy", "straight", "random")


class Scaled(BaseFeaturesExtractor):
    """Divides positions, distances and velocities by `LONGEST`."""

    def __init__(self, space: spaces.Box) -> None:
        super().__init__(space, features_dim=space.shape[0])

    def forward(self, observation: torch.Tensor) -> torch.Tensor:
        return torch.clamp(observation / LONGEST, -1.0, 1.0)


class Curve(BaseCallback):
    """Share of the last 200 episodes that reached their goal, every 10,000 steps."""

    def __init__(self) -> None:
        super().__init__()
        self.ends: deque[bool] = deque(maxlen=200)
        self.rows: list[tuple[int, float]] = []

    def _on_step(self) -> bool:
        for done, info in zip(self.locals["dones"], self.locals["infos"], strict=True):
            if done:
                self.ends.append(reached(info))
        if self.ends and self.num_timesteps >= 10_000 * (len(self.rows) + 1):
            self.rows.append((self.num_timesteps, float(np.mean(self.ends))))
            print(f"{self.num_timesteps} steps: {self.rows[-1][1]:.2f}", flush=True)
        return True


def reached(info: dict) -> bool:
    """Return whether the last step of an episode reached the goal."""
    return any(event["kind"] == "job_done" for event in info["events"])


def train(seed: int, steps: int) -> tuple[PPO, list[tuple[int, float]]]:
    """Return a trained model, and the share of episodes that reached their goal meanwhile."""
    torch.set_num_threads(1)
    envs = make_vec_env(
        "floorwalker/Amr-v0", n_envs=4, seed=seed, env_kwargs={"observation": "flat"}
    )
    model = PPO(
        "MlpPolicy",
        envs,
        seed=seed,
        n_steps=512,
        batch_size=64,
        gamma=0.99,
        policy_kwargs={"features_extractor_class": Scaled, "net_arch": [64, 64]},
        device="cpu",
    )
    curve = Curve()
    model.learn(steps, callback=curve)
    return model, curve.rows


def export(model: PPO, path: Path, interface: sim.gym.Interface) -> None:
    """Write the network that chooses actions to an ONNX file, with its interface."""
    layers = [
        *(one for one in model.policy.mlp_extractor.policy_net if hasattr(one, "weight")),
        model.policy.action_net,
    ]
    constants = [
        numpy_helper.from_array(np.array(value, np.float32), name)
        for name, value in (("longest", LONGEST), ("low", -1.0), ("high", 1.0))
    ]
    nodes = [
        helper.make_node("Div", ["observation", "longest"], ["divided"]),
        helper.make_node("Clip", ["divided", "low", "high"], ["x0"]),
    ]
    for k, layer in enumerate(layers):
        for name in ("weight", "bias"):
            array = getattr(layer, name).detach().numpy()
            constants.append(numpy_helper.from_array(array, f"{name}{k}"))
        last = k == len(layers) - 1
        output = "action" if last else f"sum{k}"
        inputs = [f"x{k}", f"weight{k}", f"bias{k}"]
        nodes.append(helper.make_node("Gemm", inputs, [output], transB=1))
        if not last:
            nodes.append(helper.make_node("Tanh", [output], [f"x{k + 1}"]))
    size, actions = layers[0].in_features, layers[-1].out_features
    graph = helper.make_graph(
        nodes,
        "policy",
        [helper.make_tensor_value_info("observation", TensorProto.FLOAT, [1, size])],
        [helper.make_tensor_value_info("action", TensorProto.FLOAT, [1, actions])],
        constants,
    )
    written = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    keys = json.dumps(dataclasses.asdict(interface))
    written.metadata_props.add(key="floorwalker", value=keys)
    onnx.save(written, path)


def shares(drive: str, episodes: int, model: PPO | None = None) -> tuple[float, float]:
    """Return the shares of test episodes that reach the goal, and that end with a contact."""
    env = gymnasium.make("floorwalker/Amr-v0", observation="flat")
    goals = contacts = 0
    for k in range(episodes):
        observation, _ = env.reset(seed=FIRST_TEST_SEED + k)
        env.action_space.seed(k)
        done = truncated = False
        while not (done or truncated):
            if drive == "policy":
                action, _ = model.predict(observation, deterministic=True)
            elif drive == "straight":
                action = straight(observation)
            else:
                action = env.action_space.sample()
            observation, _, done, truncated, info = env.step(action)
        goals += reached(info)
        contacts += done and not reached(info)
    return goals / episodes, contacts / episodes


def straight(observation: np.ndarray) -> np.ndarray:
    """Return the action that drives straight to the goal."""
    x, y = observation[7:9]
    angle = float(np.arctan2(y, x))
    return np.array([np.cos(angle) if abs(angle) < 0.5 else 0.0, np.clip(2 * angle, -1, 1)])


def main() -> None:
    """Train one seed, and write its policy, its learning curve and its test."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--steps", type=int, default=200_000)
    arguments.add_argument("--episodes", type=int, default=200, help="episodes of the test")
    arguments.add_argument("--folder", type=Path, default=Path("policies"))
    options = arguments.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    model, curve = train(options.seed, options.steps)
    model.save(options.folder / f"policy-{options.seed}.zip")
    with (options.folder / f"curve-{options.seed}.csv").open("w", newline="") as file:
        csv.writer(file).writerows([("steps", "goals"), *curve])
    interface = gymnasium.make("floorwalker/Amr-v0").unwrapped.interface
    export(model, options.folder / f"policy-{options.seed}.onnx", interface)
    for drive in WAYS_TO_DRIVE:
        goals, contacts = shares(drive, options.episodes, model)
        print(f"{drive}: {goals:.2f} of the goals, {contacts:.2f} end with a contact", flush=True)


if __name__ == "__main__":
    main()
