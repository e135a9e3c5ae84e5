"""Sampled steerings, with ORCA and social force as examples: closed forms and whole trials."""

from __future__ import annotations

import importlib.util
import itertools
import math
import shutil
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import shapely

import navigation
import sim
from sim.people.crowd.sampled_scene import SampledScene, WallSides

EXAMPLES = Path(__file__).parents[2] / "examples" / "steering"


def example(name: str):
    """Import an example, because no package contains it."""
    spec = importlib.util.spec_from_file_location(
        f"steering_example_{name}", EXAMPLES / f"{name}.py"
    )
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


_orca, _social_force = example("orca"), example("social_force")
HalfPlane, Orca = _orca.HalfPlane, _orca.Orca
least_change, nearest_permitted = _orca.least_change, _orca.nearest_permitted
SocialForce, SocialForceParameters = _social_force.SocialForce, _social_force.SocialForceParameters

HALL = """
floorplan: {boundary: [[0, 0], [12, 0], [12, 6], [0, 6]]}
duration: 40
rules: observe
"""

CALM = SocialForceParameters(fluctuation=0.0)

MODELS = {"orca": Orca, "social_force": lambda: SocialForce(CALM)}

NAMES = {"orca": "orca:Orca", "social_force": "social_force:SocialForce"}


def scene(at, velocity, desired, *, steered=None, walls=()) -> SampledScene:
    """Return people of 0.3 m and 1 m/s, and points of walls near the first."""
    count = len(at)
    return SampledScene(
        step=0.05,
        seed=0,
        at=np.array(at, dtype=float),
        velocity=np.array(velocity, dtype=float),
        desired=np.array(desired, dtype=float),
        radius=np.full(count, 0.3),
        max_speed=np.ones(count),
        steered=np.array([True] * count if steered is None else steered),
        wall_of=np.zeros(len(walls), dtype=int),
        wall_at=np.array(walls, dtype=float).reshape(-1, 2),
    )


def text(steering: str, *people: str) -> str:
    return f"{HALL}steering: {NAMES.get(steering, steering)}\npeople:\n" + "\n".join(
        f"  - {one}" for one in people
    )


def trial(tmp_path, steering: str, *walkers: tuple[str, str, str]) -> sim.Trial:
    """Return a trial in the hall with these names, starts and goals."""
    people = []
    shutil.copytree(EXAMPLES, tmp_path, dirs_exist_ok=True)
    for name, at, goal in walkers:
        (tmp_path / f"{name}.asl").write_text(f"+human_start <- move({goal}, 0).")
        people.append(f"{{name: {name}, at: [{at}], personality: {name}.asl}}")
    return sim.Trial.parse(text(steering, *people), folder=tmp_path)


@pytest.mark.parametrize("model", MODELS)
def test_person_alone_keeps_the_desired_velocity(model):
    alone = scene([(0, 0)], [(0.6, 0.8)], [(0.6, 0.8)])
    assert MODELS[model]().velocities(alone)[0] == pytest.approx((0.6, 0.8), abs=1e-12)


def test_social_force_relaxes_exponentially():
    model, v = SocialForce(CALM), np.zeros((1, 2))
    for k in range(1, 41):
        v = model.velocities(scene([(0, 0)], v, [(1, 0)]))
        assert v[0] == pytest.approx((1 - (1 - 0.05 / 0.5) ** k, 0.0), abs=1e-12)


def test_social_force_of_a_person_who_stands_has_its_closed_form():
    # The ellipse is a circle, so b is the distance. A person behind counts half.
    for x, weight in ((0.9, 1.0), (-0.9, 0.5)):
        people = scene([(0, 0), (x, 0)], [(1, 0), (0, 0)], [(1, 0), (0, 0)], steered=[True, False])
        push = weight * 2.1 / 0.3 * math.exp(-0.9 / 0.3)
        expected = min(1.0 - math.copysign(0.05 * push, x), 1.0)
        assert SocialForce(CALM).velocities(people)[0] == pytest.approx((expected, 0.0))


def test_social_force_is_the_gradient_of_the_elliptical_potential():
    other, step = np.array([1.3, 0.4]), np.array([-2.0, 0.0])

    def potential(at):
        apart = at - other
        both = np.hypot(*apart) + np.hypot(*(apart - step))
        return 2.1 * math.exp(-math.sqrt(both**2 - 4.0) / 2 / 0.3)

    small = 1e-6
    slope = [
        (potential(small * axis) - potential(-small * axis)) / (2 * small) for axis in np.eye(2)
    ]
    people = scene([(0, 0), other], [(0.5, 0), (-1, 0)], [(0.5, 0), (-1, 0)])
    people = replace(people, max_speed=np.full(2, 9.0))
    parameters = replace(CALM, faster=9.0)
    change = SocialForce(parameters).velocities(people)[0] - (0.5, 0.0)
    assert change / 0.05 == pytest.approx(-np.array(slope), rel=1e-5)


def test_social_force_of_a_wall_has_its_closed_form():
    people = scene([(0, 0)], [(0, 0)], [(1, 0)], walls=[(0.0, -0.8)])
    push = 10.0 / 0.2 * math.exp(-0.8 / 0.2)
    assert SocialForce(CALM).velocities(people)[0] == pytest.approx((0.1, 0.05 * push))


@pytest.mark.parametrize("model", MODELS)
def test_two_people_head_on_are_point_symmetric(model):
    steering = MODELS[model]()
    at, v = np.array([[-2.0, 0.01], [2.0, -0.01]]), np.array([[1.0, 0.0], [-1.0, 0.0]])
    desired, apart = v.copy(), []
    for _ in range(120):
        v = steering.velocities(scene(at, v, desired))
        at = at + 0.05 * v
        assert at[0] == pytest.approx(-at[1], abs=1e-9)
        apart.append(math.dist(*at))
    assert at[0][0] > 1.0
    if model == "orca":
        assert min(apart) >= 0.6 - 1e-9


def in_obstacle(apart, relative, radius, horizon) -> bool:
    """Return whether a point comes within the radius during the horizon, by a closed form of its
    path.
    """
    (px, py), (vx, vy) = apart, relative
    square = vx * vx + vy * vy
    t = min(max((px * vx + py * vy) / square, 0.0), horizon) if square else 0.0
    return math.hypot(px - t * vx, py - t * vy) < radius


def test_half_plane_of_orca_is_tangent_to_the_sampled_velocity_obstacle():
    chance = np.random.default_rng(3)
    angles = np.linspace(0.0, 2 * math.pi, 721)
    for _ in range(60):
        apart = chance.uniform(-3, 3, 2)
        if np.hypot(*apart) < 0.65:
            continue
        relative = chance.uniform(-2, 2, 2)
        change, normal = least_change(tuple(apart), tuple(relative), 0.6, 2.0, 0.05)
        size = math.hypot(*change)
        inside = in_obstacle(apart, relative, 0.6, 2.0)
        # The end of the change is on the boundary, and the normal points out of the obstacle.
        end = relative + change
        assert in_obstacle(apart, end - 1e-6 * np.array(normal), 0.6, 2.0)
        assert not in_obstacle(apart, end + 1e-6 * np.array(normal), 0.6, 2.0)
        assert inside == (np.dot(change, normal) > 0.0)
        # No smaller sampled change reaches the boundary.
        for share in (0.5, 0.9, 0.999):
            for x, y in zip(np.cos(angles), np.sin(angles), strict=True):
                moved = relative + share * size * np.array([x, y])
                assert in_obstacle(apart, moved, 0.6, 2.0) == inside


def test_people_who_overlap_part_within_one_step():
    people = scene([(0, 0), (0.55, 0)], [(0, 0), (0, 0)], [(0, 0), (0, 0)])
    v = Orca().velocities(people)
    assert math.dist(people.at[0] + 0.05 * v[0], people.at[1] + 0.05 * v[1]) >= 0.6 - 1e-9


def test_linear_programs_against_sampled_velocities():
    chance = np.random.default_rng(5)
    grid = [p for p in itertools.product(np.linspace(-1, 1, 41), repeat=2) if math.hypot(*p) <= 1]
    crowded = 0
    for _ in range(80):
        angles = chance.uniform(0, 2 * math.pi, 7)
        planes = [
            HalfPlane((s * math.cos(a), s * math.sin(a)), (math.cos(a), math.sin(a)))
            for a, s in zip(angles, chance.uniform(-0.7, 0.3, 7), strict=True)
        ]
        walls = [replaced for replaced in planes[:2] if replaced.violation((0.0, 0.0)) <= 0.0]
        people, desired = planes[2:], tuple(chance.uniform(-0.7, 0.7, 2))
        permitted = nearest_permitted(walls, people, desired, 1.0)
        assert math.hypot(*permitted) <= 1 + 1e-9
        assert all(wall.violation(permitted) <= 1e-9 for wall in walls)
        allowed = [v for v in grid if all(wall.violation(v) <= 0 for wall in walls)]
        worst = max(plane.violation(permitted) for plane in people)
        least = min(max(plane.violation(v) for plane in people) for v in allowed)
        if worst > 1e-9:
            crowded += 1
            assert worst <= least + 1e-9 and least > 0.0
        else:
            free = [v for v in allowed if all(plane.violation(v) <= 0 for plane in people)]
            nearest = min((math.dist(v, desired) for v in free), default=math.inf)
            assert math.dist(permitted, desired) <= nearest + 1e-9
    assert 10 < crowded < 70


def test_nearest_points_of_walls():
    room = shapely.box(0, 0, 10, 10) - shapely.box(4, 4, 6, 6)
    at = np.array([(3.5, 5.0), (3.5, 3.5), (0.5, 0.25)])
    who, points = WallSides(room).near(at, 1.0)
    nearest = sorted((k, *place) for k, place in zip(who.tolist(), points.tolist(), strict=True))
    assert nearest == [(0, 4.0, 5.0), (1, 4.0, 4.0), (2, 0.0, 0.25), (2, 0.5, 0.0)]


@pytest.mark.parametrize("steering", MODELS)
def test_person_alone_walks_straight_to_the_goal(tmp_path, steering):
    run = sim.run(trial(tmp_path, steering, ("a", "1, 3", "11, 3")))
    (arrived,) = [event for event in run.events if event["kind"] == "arrived"]
    motion = run.motions["a"]
    t = np.linspace(0.0, arrived["t"], 200)
    beside = 1e-6 if steering == "orca" else 0.1  # fluctuations
    assert np.abs(motion.position(t)[:, 1] - 3.0).max() < beside
    # 9.4 m at 1 m/s. The social force adds 0.45 s for the acceleration in steps of 0.05 s,
    # and up to 2 % because the maximum speed cuts off the faster half of the fluctuations.
    soonest, share = (9.4, 1.0) if steering == "orca" else (9.85, 1.02)
    assert soonest - 0.06 < arrived["t"] < soonest * share + 0.06


@pytest.mark.parametrize("steering", MODELS)
def test_a_trial_of_crossing_people_is_repeatable(tmp_path, steering):
    crossing = trial(
        tmp_path,
        steering,
        ("a", "1, 3", "11, 3.1"),
        ("b", "11, 3", "1, 2.9"),
        ("c", "6, 0.6", "6, 5.2"),
        ("d", "6.5, 5.4", "6, 0.7"),
    )
    run, again = sim.run(crossing), sim.run(crossing)
    arrived = [event["person"] for event in run.events if event["kind"] == "arrived"]
    assert sorted(arrived) == ["a", "b", "c", "d"]
    assert run.events == again.events
    for name, motion in run.motions.items():
        assert [*motion.pieces] == [*again.motions[name].pieces]
        assert {piece.x[2:] for piece in motion.pieces} == {(0.0, 0.0)}
    apart = min(
        navigation.minimum_separation(run.motions[a], run.motions[b], 0.0, run.duration)[1]
        for a, b in itertools.combinations(run.motions, 2)
    )
    assert (apart < 0.6) == (run.summary["overlaps"] > 0)
    if steering == "orca":
        assert apart > 0.55


@pytest.mark.parametrize("steering", MODELS)
def test_a_sampled_steering_is_written_again(tmp_path, steering):
    steered = trial(tmp_path, steering, ("a", "1, 3", "11, 3"))
    assert f"steering: {NAMES[steering]}" in steered.to_yaml(folder=tmp_path)


def test_a_steering_without_a_module_is_rejected():
    with pytest.raises(sim.TrialError, match="line 5, steering"):
        sim.Trial.parse(text("orka", "{name: a, at: [1, 1]}"))


@pytest.mark.parametrize(
    ("result", "word"),
    [("scene.velocity * float('nan')", "finite"), ("[0.0]", "shape"), ("1 / 0", "division")],
)
def test_wrong_velocities_end_the_run_with_the_name_of_the_steering(tmp_path, result, word):
    code = f"class Broken:\n    def velocities(self, scene):\n        return {result}\n"
    (tmp_path / "mine.py").write_text(code)
    broken = trial(tmp_path, "mine:Broken", ("a", "1, 3", "11, 3"))
    with pytest.raises(ValueError, match=rf"mine:Broken.*{word}"):
        sim.run(broken)
