"""Metrics of social navigation of runs, and of runs read back from disk."""

import json
from dataclasses import replace

import numpy as np
import pytest
from run_events import record

import sim
from navigation import standing

TRIAL = """
floorplan: ariac2023
duration: 120
people:
  - {name: ada, personality: antagonistic}
  - {name: ben, personality: helpful, start: {time: 20.0}}
gantry: {controller: oblivious, repeat: true, at: [-7, 0, 0],
         jobs: [{pick: bin2, place: agv1}, {pick: bin6, place: agv4}]}
agvs: {agv2: [{time: 30.0, to: as1}]}
"""


@pytest.fixture(scope="module")
def figures(run):
    return sim.metrics(run)


def test_social_metrics_are_finite_numbers(figures):
    assert json.loads(json.dumps(figures, allow_nan=False)) == figures


def test_social_metrics_include_all_people(run, figures):
    assert list(figures["people"]) == ["ada", "ben"]
    assert list(figures["machines"]) == ["gantry", "agv1", "agv2", "agv3", "agv4"]
    assert set(figures["people"]["ada"]["distance_to"]) == set(run.motions) - {"ada"}


def test_social_metrics_agree_with_the_summary(run, figures):
    for name, person in run.summary["people"].items():
        metrics = figures["people"][name]
        assert metrics["path_length"] == pytest.approx(person["distance_walked"], abs=1e-6)
        assert metrics["time"] == pytest.approx(run.duration - person["started"], abs=1e-9)
        nearest = person["minimum_separation"]["distance"]
        assert metrics["distance_to"]["gantry"]["minimum"] == pytest.approx(nearest, abs=1e-6)


def test_social_metrics_agree_with_the_trajectory(run, figures):
    samples = run.sample(rate=500.0)
    t = samples["t"]
    apart = {
        name: np.hypot(*(samples[name][:, :2] - samples["gantry"][:, :2]).T)
        for name in ("ada", "ben")
    }
    apart["ben"][t < 20.0] = np.inf
    nearest = np.minimum(apart["ada"], apart["ben"])
    distances = figures["machines"]["gantry"]["distance_to_people"]
    assert distances["average"] == pytest.approx(nearest.mean(), abs=1e-2)
    assert distances["minimum"] == pytest.approx(nearest.min(), abs=1e-2)
    social = ((nearest >= 1.2) & (nearest < 3.6)).mean()
    assert distances["social_space_intrusions"] == pytest.approx(100 * social, abs=0.1)
    speed = np.hypot(*samples["gantry"][:, 3:].T)
    assert figures["machines"]["gantry"]["maximum_speed"] == pytest.approx(speed.max(), abs=1e-3)


def test_a_goal_counts_as_reached_only_if_the_person_got_there(run, figures):
    for name in ("ada", "ben"):
        metrics = figures["people"][name]
        kinds = [e["kind"] for e in run.events if e.get("person") == name]
        assert metrics["goals"] == kinds.count("goal")
        assert metrics["goals_reached"] == kinds.count("arrived") > 0
        assert 1.0 < metrics["time_to_goal"] < 60.0


def test_a_person_who_never_starts_has_social_metrics():
    trial = sim.Trial.parse(
        "floorplan: ariac2023\nduration: 5\npeople: [{name: a, start: {event: penalty}}]\n"
    )
    figures = sim.metrics(sim.run(trial))
    assert figures["people"]["a"]["time"] == 0.0
    assert figures["people"]["a"]["time_to_goal"] is None
    assert figures["people"]["a"]["distance_to"]["gantry"]["minimum"] is None
    assert figures["machines"]["gantry"]["distance_to_people"]["time"] == 0.0
    json.dumps(figures, allow_nan=False)


def test_a_floor_without_people():
    figures = sim.metrics(sim.run(sim.Trial.parse("floorplan: warehouse\nduration: 5\n")))
    assert figures["people"] == {}
    assert set(figures["machines"]) == {"tug1", "tug2"}


def test_radii_are_subtracted(run, figures):
    smaller = sim.metrics(run, radii={"gantry": 1.5, "ada": 1.0})
    before = figures["people"]["ada"]["distance_to"]["gantry"]
    after = smaller["people"]["ada"]["distance_to"]["gantry"]
    for key in ("average", "minimum", "maximum"):
        assert after[key] == pytest.approx(before[key] - 2.5, abs=1e-6)
    assert after["social_space_intrusions"] > before["social_space_intrusions"]


@pytest.mark.parametrize(
    ("radii", "message"),
    [
        ({"gantri": 1.0}, "did you mean 'gantry'?"),
        ({"gantry": -1.0}, "from 0 to 1e"),
        ({"gantry": 1e300}, "not 1e.300"),
    ],
)
def test_invalid_radii_are_rejected(run, radii, message):
    with pytest.raises(ValueError, match=message.replace("?", r"\?")):
        sim.metrics(run, radii=radii)


def test_the_command_prints_the_same_metrics_of_a_recording(run, figures, tmp_path, floorwalker):
    trial = tmp_path / "two.trial.yaml"
    trial.write_text(TRIAL)
    record(sim.Trial.load(trial), tmp_path / "run")
    command = ("metrics", tmp_path / "run")
    done = floorwalker(*command, "--json")
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout) == figures
    table = floorwalker(*command).stdout
    assert "ada – gantry" in table
    assert "gantry – nearest" in table
    done = floorwalker(*command, "--json", "--radius", "gantry=1.5")
    assert json.loads(done.stdout) == sim.metrics(run, radii={"gantry": 1.5})
    for wrong in ("gantry", "gantry=wide", "gantry=nan", "=1"):
        done = floorwalker(*command, "--radius", wrong)
        assert done.returncode == 2
        assert "expected BODY=METRES" in done.stderr


def test_tables_have_room_for_many_people(tmp_path, floorwalker):
    trial = tmp_path / "crew.trial.yaml"
    trial.write_text(
        "{floorplan: ariac2023, duration: 1, people: [{name: crew, count: 9, at: anywhere}]}"
    )
    table = floorwalker("metrics", trial).stdout
    assert "…" not in table and max(map(len, table.splitlines())) <= 80
    assert "crew2 – crew7" in table and "crew7 – crew2" not in table
    assert "crew7 – agv1" in table


def test_social_work_is_the_integral_of_the_forces(run, figures):
    """Compare with a sum over samples of the formula in HuNavSim's evaluator."""
    t = np.arange(0.0, run.duration, 0.002)
    bodies = {name: (m.position(t), m.velocity(t)) for name, m in run.motions.items()}

    def force(me, other):
        (p, v), (q, w) = bodies[me], bodies[other]
        apart = q - p
        unit = apart / np.linalg.norm(apart, axis=1)[:, None]
        towards = 2.0 * (v - w) + unit
        size = np.linalg.norm(towards, axis=1)
        turn = np.angle(unit @ [1, 1j] / (towards @ [1, 1j]))
        along, width = towards @ [1, 1j] / size, 0.35 * size
        far = -np.linalg.norm(apart, axis=1) / width
        slow, side = np.exp(far - (3 * width * turn) ** 2), np.exp(far - (2 * width * turn) ** 2)
        there = (t >= 20.0) | ("ben" not in (me, other))
        return -2.1 * (slow + np.sign(turn) * side * 1j) * along * there

    people = list(figures["people"])
    for name in ("gantry", "ada"):
        others = [other for other in people if other != name]
        sums = abs(sum(force(name, o) for o in others)) + sum(abs(force(o, name)) for o in others)
        work = figures["machines" if name == "gantry" else "people"][name]["social_work"]
        assert work == pytest.approx(float(sums.sum()) * 0.002, rel=5e-3) and work > 0


def test_social_work_of_two_standing_people_is_isotropic(run):
    started = tuple({"t": 0.0, "kind": "human_started", "person": name} for name in ("ada", "ben"))
    for angle in np.linspace(0.0, 6.0, 25):
        ben = standing((0.7 * np.cos(angle), 0.7 * np.sin(angle)))
        motions = {"ada": standing((0.0, 0.0)), "ben": ben}
        stood = replace(run, duration=10.0, motions=motions, events=started)
        work = sim.metrics(stood)["people"]["ada"]["social_work"]
        # Neither has a side to turn to, so the forces only slow them down.
        assert work == pytest.approx(2 * 2.1 * np.exp(-0.7 / 0.35) * 10.0)


def test_others_keep_a_distance_from_the_centre_of_a_group():
    trial = replace(sim.Trial.load("people_group"), duration=20.0)
    run = sim.run(trial)
    figures = sim.metrics(run)
    t = np.arange(0.0, 20.0, 0.005)
    middle = np.mean([run.motions[f"crew{k}"].position(t) for k in (1, 2, 3)], axis=0)
    away = np.hypot(*(run.motions["ada"].position(t) - middle).T)
    distances = figures["people"]["ada"]["distance_to_groups"]["crew1"]
    assert distances["minimum"] == pytest.approx(away.min(), abs=1e-2)
    assert distances["average"] == pytest.approx(away.mean(), abs=1e-2)
    near = 100 * ((away >= 1.2) & (away < 3.6)).mean()
    assert distances["social_space_intrusions"] == pytest.approx(near, abs=0.2)
    assert all("distance_to_groups" not in figures["people"][f"crew{k}"] for k in (1, 2, 3))
    wanted = {"metrics.people.ada.distance_to_groups.crew1.minimum": f"< {away.min() + 0.01}"}
    assert replace(run, trial=replace(trial, expect=wanted)).unmet == []
