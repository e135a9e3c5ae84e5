"""Visual noticing: field of view, occlusion, reaction time, and draws."""

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from small_floors import GANTRY, on_floor

import sim

GO = '+human_start <- move({x}, {y}, 0).\n+gantry_detected(_) <- .print("seen").\n'

HALL = on_floor(
    """\
boundary: [[0, 0], [20, 0], [20, 12], [0, 12]]
obstacles: {screen: {x: [9.9, 10.1], y: [2, 8], z: [0, HIGH]}}
safe_zone: {at: [2, 5]}
"""
    + GANTRY.replace("[10, 8, 0]", "[12, 5, 0]"),
    """\
rules:
  gantry_law: {fixed: 0.6}
  notice: {law: {fixed: 8.0}, factor: 1, cap: null}
  machine: none
  person: none
duration: 30
""",
)


def seen(tmp_path, person, *, high=3.0, goal=(8.0, 5.0), seed=0, more=""):
    """Return the run, and the times (s) at which the gantry is noticed."""
    (tmp_path / "go.asl").write_text(GO.replace("{x}", str(goal[0])).replace("{y}", str(goal[1])))
    text = HALL.replace("HIGH", str(high)) + more
    text += f"seed: {seed}\npeople: [{{name: eve, personality: go.asl, {person}}}]\n"
    trial = sim.Trial.parse(text, folder=tmp_path)
    assert sim.Trial.parse(trial.to_yaml(tmp_path), folder=tmp_path) == trial
    run = sim.run(trial)
    return run, [event["t"] for event in run.events if event["kind"] == "gantry_detected"]


def test_an_obstacle_hides_the_gantry_until_it_comes_into_view(tmp_path):
    """The oracle is a straight line in the plane from the eyes to any corner of the torso."""
    _, near = seen(tmp_path, "at: [2, 1]", goal=(9, 11))
    run, noticed = seen(tmp_path, "at: [2, 1], noticing: {occlusion: true}", goal=(9, 11))
    screen, torso = shapely.box(9.9, 2, 10.1, 8), shapely.box(11.5, 4.5, 12.5, 5.5)
    corners = [(12.0, 5.0), *torso.exterior.coords[:-1]]

    def free(t):
        eye = run.motions["eve"].position(t)
        return any(not screen.intersects(shapely.LineString([eye, at])) for at in corners)

    distance = {
        t: math.dist(run.motions["eve"].position(t), (12.0, 5.0)) for t in np.arange(0, 20, 0.01)
    }
    closing = [t for t in distance if distance[t] <= 8.0 and t + 0.01 in distance]
    first = next(t for t in closing if free(t))
    assert len(noticed) == 1 and near[0] < noticed[0]
    assert first - 1e-6 <= noticed[0] <= first + 0.1 + 0.011


def test_people_see_over_low_and_under_high_obstacles(tmp_path):
    eyes = "at: [2, 5], noticing: {occlusion: true}"
    _, near = seen(tmp_path, "at: [2, 5]")
    _, low = seen(tmp_path, eyes, high=1.2)
    _, high = seen(tmp_path, eyes)
    assert low == near and high == []
    pallet = "obstacles: {crate: {x: [7, 8], y: [1, 9], z: [0, 2.5], there: [[0, 29.9]]}}\n"
    _, hidden = seen(tmp_path, eyes, high=0.5, goal=(6.4, 5.0), more=pallet)
    assert hidden == pytest.approx([29.9], abs=0.1)  # as soon as the obstacle is removed


def test_people_do_not_see_behind_themselves(tmp_path):
    low = {"high": 0.5, "goal": (8.0, 9.0)}
    _, all_round = seen(tmp_path, "at: [8, 11]", **low)
    _, narrow = seen(tmp_path, "at: [8, 11], noticing: {field_of_view: 40}", **low)
    _, wide = seen(tmp_path, "at: [8, 11], noticing: {field_of_view: 180}", **low)
    assert len(all_round) == len(wide) == 1 and all_round <= wide
    assert narrow == []  # the person looks along the aisle, and the gantry is beside them


def test_people_notice_after_their_reaction_time(tmp_path):
    _, at_once = seen(tmp_path, "at: [2, 5]", high=0.5)
    _, later = seen(tmp_path, "at: [2, 5], noticing: {reaction_time: 0.75}", high=0.5)
    assert later == pytest.approx([at_once[0] + 0.75])


def test_figures_are_drawn_from_the_seed_for_each_person(tmp_path):
    text = HALL.replace("HIGH", "1") + (
        "people: [{name: p, count: 40, at: anywhere, max_speed: {normal: [1.34, 0.26]},"
        " noticing: {field_of_view: [90, 180], reaction_time: {lognormal: [0.75, 0.3]}}}]\n"
    )
    trial = replace(sim.Trial.parse(text, folder=tmp_path), duration=0.1)

    def figures(trial):
        people = sim.Simulation(trial).people
        return [(person.walker.human.max_speed, person.reaction_time) for person in people]

    first, again = figures(trial), figures(trial)
    other = figures(replace(trial, seed=1))
    fewer = figures(replace(trial, people=trial.people[5:]))
    assert first == again and first[5:] == fewer
    assert not {one for one, _ in first} & {one for one, _ in other}
    speeds, reactions = np.array(first).T
    assert 1.2 < speeds.mean() < 1.48 and 0.15 < speeds.std() < 0.4
    assert 0.6 < np.median(reactions) < 0.9
