"""Environments: checkers of gymnasium and PettingZoo, the same bytes as a trial, bad input."""

import json
import math
import warnings
from dataclasses import asdict, replace
from functools import partial

import gymnasium
import numpy as np
import pytest
import shapely
from gymnasium.utils.env_checker import check_env
from pettingzoo.test import parallel_api_test, parallel_seed_test

import sim
from sim.gym import FloorEnv, Interface, ParallelFloorEnv
from sim.gym.environment import FOLDER
from sim.gym.ticks import with_controllers
from sim.machines.policy import ActionBounds, driven, flat
from sim.studies.design import Choice
from sim.studies.variables import variable

AMR = FOLDER / "amr.trial.yaml"
PAIR = FOLDER / "two_amrs.study.yaml"


def towards_goal(observation):
    """Turn to the goal, and drive."""
    return np.tanh(np.array([0.3 * observation[7], 0.5 * observation[8]]))


def episode(env, policy, seed):
    """Return the observations of an episode."""
    observation, _ = env.reset(seed=seed)
    seen = [observation]
    done = False
    while not done:
        observation, _, terminated, truncated, _ = env.step(policy(observation))
        seen.append(observation)
        done = terminated or truncated
    return seen


def same_run(one, other):
    return one.events == other.events and all(
        one.motions[name].pieces == other.motions[name].pieces for name in one.motions
    )


@pytest.mark.parametrize("name", ["floorwalker/Amr-v0", "floorwalker/Gantry-v0"])
def test_registered_environments_pass_the_checker(name):
    env = gymnasium.make(name, render_mode="rgb_array")
    env.reset(seed=0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*render modes")
        check_env(env.unwrapped, skip_render_check=False)
    env.reset(seed=0)
    assert env.render().shape[2] == 3


@pytest.mark.parametrize("actions", ["continuous", "discrete"])
def test_flat_observations_and_both_forms_of_actions_pass_the_checker(actions):
    env = FloorEnv(AMR, observation="flat", actions=actions, rays=8)
    check_env(env, skip_render_check=True)
    assert env.observation_space.shape == (Interface(rays=8).size,)


def test_several_machines_pass_the_checkers_of_pettingzoo():
    parallel_api_test(ParallelFloorEnv(PAIR), num_cycles=50)
    parallel_seed_test(partial(ParallelFloorEnv, PAIR), num_cycles=10)


def test_a_seed_determines_an_episode_regardless_of_earlier_ones():
    env, other = FloorEnv(observation="flat"), FloorEnv(observation="flat")
    episode(other, towards_goal, 1)
    first, second = (episode(one, towards_goal, 5) for one in (env, other))
    assert np.array_equal(np.array(first), np.array(second))
    assert not np.array_equal(first[0], env.reset(seed=6)[0])


def test_vectors_of_both_kinds_see_the_same():
    seen = []
    for mode in ("sync", "async"):
        envs = gymnasium.make_vec(
            "floorwalker/Amr-v0", 2, vectorization_mode=mode, observation="flat"
        )
        first, _ = envs.reset(seed=3)
        actions = np.full((2, 2), 0.5, np.float32)
        rows = [first, *(envs.step(actions)[0] for _ in range(4))]
        envs.close()
        seen.append(np.array(rows))
    assert np.array_equal(*seen)


def test_a_policy_gives_the_same_run_in_the_environment_and_in_a_trial():
    env = FloorEnv(AMR, observation="flat")
    episode(env, towards_goal, 5)
    run, trial = env.run(), env.episodes.ticks.simulation.trial

    def choose(machine):
        return ActionBounds(machine).command(towards_goal(flat(env.interface.observe(machine))))

    controller = partial(driven, choose, env.interface)
    simulation = sim.Simulation(with_controllers(trial, {"bot": controller}))
    simulation.advance(run.duration)
    assert same_run(run, simulation.finish())


def linear_policy(path, interface, outputs=2, metadata=True, discrete=False):
    """Write a policy that turns to the goal as an ONNX file, or one of nine discrete actions."""
    onnx = pytest.importorskip("onnx")
    weights = np.zeros((interface.size, outputs), np.float32)
    weights[7, 0], weights[8, 1] = 0.3, 0.5
    nodes = [onnx.helper.make_node("MatMul", ["obs", "weights"], ["action"])]
    result = onnx.helper.make_tensor_value_info("action", 1, [1, outputs])
    if discrete:
        nodes.append(onnx.helper.make_node("ArgMax", ["action"], ["choice"], axis=1, keepdims=0))
        result = onnx.helper.make_tensor_value_info("choice", 7, [1])
    graph = onnx.helper.make_graph(
        nodes,
        "policy",
        [onnx.helper.make_tensor_value_info("obs", 1, [1, interface.size])],
        [result],
        [onnx.numpy_helper.from_array(weights, "weights")],
    )
    model = onnx.helper.make_model(graph, opset_imports=[onnx.helper.make_opsetid("", 17)])
    model.ir_version = 9
    if metadata:
        model.metadata_props.add(key="floorwalker", value=json.dumps(asdict(interface)))
    onnx.save(model, path)


def trial_with(controller, folder):
    text = AMR.read_text().replace("missions:", f"controller: {controller}\n    missions:")
    return replace(sim.Trial.parse(text, folder=folder), seed=7)


def test_an_onnx_file_is_a_controller_with_the_run_of_its_environment(tmp_path):
    interface = Interface(2.0, people=2, rays=8)
    linear_policy(tmp_path / "policy.onnx", interface)
    run = sim.run(trial_with("policy.onnx", tmp_path))
    assert math.dist(run.motions["bot"].position(60.0)[:2], (-5, -4)) > 1.0
    session = pytest.importorskip("onnxruntime").InferenceSession(str(tmp_path / "policy.onnx"))

    def policy(observation):
        return np.clip(session.run(None, {"obs": observation[np.newaxis]})[0][0], -1, 1)

    trial = trial_with("parked", tmp_path)
    env = FloorEnv(trial, observation="flat", **asdict(interface))
    env.episodes.study = replace(env.episodes.study, trials=(trial,))
    env.episodes.reset(0)
    env.episodes.ticks = type(env.episodes.ticks)(trial, ["bot"], interface)
    env.episodes.ticks.advance({})
    while not env.episodes.ticks.over:
        env.episodes.ticks.advance(
            {"bot": env._spaces.chosen(policy(flat(env.episodes.observe("bot"))))}
        )
    assert same_run(run, env.run())


def test_an_onnx_file_may_choose_discrete_actions(tmp_path):
    interface = Interface(people=0, rays=8)
    linear_policy(tmp_path / "policy.onnx", interface, outputs=9, discrete=True)
    run = sim.run(trial_with("policy.onnx", tmp_path))
    # The fifth of the nine actions is no motion, and the first is both components backwards.
    xs = [run.motions["bot"].position(t)[0] for t in np.linspace(0.0, 60.0, 20)]
    assert max(xs) - min(xs) > 0.1
    linear_policy(tmp_path / "policy.onnx", interface, outputs=12, discrete=True)
    sim.run(trial_with("policy.onnx", tmp_path))


@pytest.mark.parametrize(
    ("kind", "word"),
    [
        ("missing", "no file"),
        ("broken", "ONNX"),
        ("unlabelled", "metadata"),
        ("three outputs", "3 numbers, not 2"),
    ],
)
def test_a_wrong_policy_file_is_named_with_its_fault(tmp_path, kind, word):
    path, interface = tmp_path / "policy.onnx", Interface(rays=8)
    if kind == "broken":
        path.write_bytes(b"no policy")
    elif kind != "missing":
        outputs = 3 if kind == "three outputs" else 2
        linear_policy(path, interface, outputs, metadata=kind != "unlabelled")
    with pytest.raises(ValueError, match=word) as fault:
        sim.run(trial_with("policy.onnx", tmp_path))
    assert "policy.onnx" in str(fault.value)


def test_a_scan_measures_the_floor_machines_and_people():
    env = FloorEnv(PAIR, machine="left", rays=0, people=0)
    for seed in range(5):
        env.reset(seed=seed)
        simulation = env.episodes.ticks.simulation
        me, other = (simulation.machines[name] for name in ("left", "right"))
        plan = simulation.trial.floorplan
        x, y, rotation = other.position
        solid = [
            shapely.box(*plan.boundary.bounds).exterior,
            *(one.footprint for one in plan.obstacles),
            other.shape.footprint((x, y), rotation),
            *(shapely.Point(p.body.at).buffer(p.radius, 512) for p in simulation.people),
        ]
        x, y, rotation = me.position
        ranges = me.scan(72, 8.0)
        for k, measured in enumerate(ranges):
            angle = rotation - math.pi + k * math.tau / 72
            ray = shapely.LineString([(x, y), (x + 8 * math.cos(angle), y + 8 * math.sin(angle))])
            hits = [ray.intersection(one) for one in solid if ray.intersects(one)]
            nearest = min((hit.distance(shapely.Point(x, y)) for hit in hits), default=8.0)
            assert measured == pytest.approx(nearest, abs=1e-3)


def test_people_are_observed_at_their_positions_and_the_nearest_first():
    env = FloorEnv(AMR, people=3)
    observation, _ = env.reset(seed=2)
    x, y, c, s = observation["self"][:4]
    there = [person.body.at for person in env.episodes.ticks.simulation.people]
    expected = sorted(there, key=lambda at: math.dist(at, (x, y)))[:3]
    for row, at in zip(observation["people"], expected, strict=True):
        assert (x + row[0] * c - row[1] * s, y + row[0] * s + row[1] * c) == pytest.approx(
            at, abs=1e-4
        )


def test_the_margin_is_negative_during_violations_alone():
    env = FloorEnv(AMR, rays=0)
    env.reset(seed=11)
    costs, times = [], []
    done = False
    while not done:
        _, _, *ends, info = env.step(np.array([0.8, 0.1], np.float32))
        costs.append(info["cost"])
        times.append(info["time"])
        done = any(ends)
    run = env.run()
    spans = [span for (_, name), spans in run.violations.items() if name == "bot" for span in spans]
    for time, cost in zip(times, costs, strict=True):
        inside = any(span[0] + 1e-6 < time < span[1] - 1e-6 for span in spans)
        outside = all(time < span[0] - 1e-6 or time > span[1] + 1e-6 for span in spans)
        assert (cost > 0.0) or not inside
        assert (cost == 0.0) or not outside


def test_a_gantry_that_is_sent_to_its_goals_completes_the_episode():
    env = FloorEnv(FOLDER / "gantry.trial.yaml", observation="dict", people=0, rays=0)
    observation, _ = env.reset(seed=0)
    axes = env.episodes.ticks.machines["gantry"].gantry
    low, high = np.array([axes.x.low, axes.y.low]), np.array([axes.x.high, axes.y.high])
    for _ in range(600):
        x, y, c, s = observation["self"][:4]
        dx, dy, _ = observation["goal"]
        goal = np.array((x + dx * c - dy * s, y + dx * s + dy * c))
        action = np.array([*(2 * (goal - low) / (high - low) - 1), 1.0], np.float32)
        observation, _, done, over, _ = env.step(np.clip(action, -1, 1))
        if done or over:
            break
    assert done
    assert not over


@pytest.mark.parametrize(
    ("action", "word"),
    [
        (np.array([np.nan, 0.0]), r"action\[0\]"),
        (np.array([0.0, 1.5]), r"action\[1\]"),
        (np.zeros(3), "shape"),
        ("left", "2 numbers"),
    ],
)
def test_a_bad_action_is_named(action, word):
    env = FloorEnv(AMR)
    env.reset(seed=0)
    with pytest.raises(ValueError, match=word):
        env.step(action)


@pytest.mark.parametrize(
    ("keys", "word"),
    [
        ({"machine": "bat"}, "bot"),
        ({"speed": 3}, "known are"),
        ({"rate": math.inf}, "rate"),
        ({"actions": "both"}, "actions"),
        ({"render_mode": "human"}, "render_mode"),
        ({"trial": "people_aisle"}, "no vehicle"),
        ({"trial": "nowhere"}, "nowhere"),
    ],
)
def test_a_bad_argument_is_named(keys, word):
    with pytest.raises(ValueError, match=word):
        FloorEnv(**{"trial": AMR, **keys})


def test_a_reset_without_a_possible_start_states_the_reason():
    env = FloorEnv(AMR)
    inside = Choice(((-2.0, -1.0, 0.0),))
    env.episodes.study = replace(env.episodes.study, random={variable("machines.bot.at"): inside})
    with pytest.raises(ValueError, match="rack1"):
        env.reset(seed=0)


def test_a_branch_continues_with_the_same_bytes():
    text = AMR.read_text().replace("missions:", "controller: external\n    missions:")
    simulation = sim.Simulation(sim.Trial.parse(text))
    for k in range(5):
        simulation.advance(k * 0.4)
        simulation.machines["bot"].twist((0.1 * k, 0.1), 1.0)
    branch = simulation.branch()
    runs = []
    for one in (simulation, branch):
        one.machines["bot"].twist((0.5, -0.2), 2.0)
        one.advance(6.0)
        runs.append(one.finish())
    assert same_run(*runs)
