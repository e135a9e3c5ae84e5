"""The scenes of the human challenge from end to end: goals of the person, and penalties."""

import itertools
import math

import numpy as np
import pytest
from run_events import events, first

import sim

LAW = sim.PAPER.gantry_law
GANTRY = (-2.5, 0.5)


@pytest.fixture(scope="module")
def scene():
    """Return a function that runs the scene of a personality, once for each."""
    runs = {}

    def run(personality):
        if personality not in runs:
            runs[personality] = sim.run(sim.Trial.load(f"scene_{personality}"))
        return runs[personality]

    return run


def goals(run):
    return [(event["t"], event["station"]) for event in events(run, "goal")]


@pytest.mark.parametrize("personality", ["indifferent", "antagonistic", "helpful"])
def test_every_scene_meets_its_expectations(scene, personality):
    assert scene(personality).unmet == []


def test_the_indifferent_person_walks_into_the_gantry_after_station1(scene):
    run = scene("indifferent")
    assert run.summary["people"]["operator"]["visits"][:4] == [
        "station4",
        "station2",
        "station1",
        "station4",
    ]
    violation = first(run, "violation")
    assert [name for t, name in goals(run) if t < violation["t"]][-1] == "station3"
    assert violation["with"] == "gantry"
    assert violation["penalty"] is True
    assert violation["distance"] < violation["required"]
    assert violation["required"] - violation["distance"] < 1e-6
    assert run.summary["penalties"] == len(events(run, "violation"))


@pytest.mark.parametrize("personality", ["indifferent", "antagonistic"])
def test_a_violation_disables_teleports_and_restarts(scene, personality):
    run = scene(personality)
    t = first(run, "violation")["t"]
    assert first(run, "gantry_disabled", after=t)["t"] == t
    assert first(run, "gantry_enabled", after=t)["t"] == pytest.approx(t + 8.0, abs=1e-9)
    teleport = first(run, "teleport", after=t)
    assert (teleport["t"], teleport["to"], teleport["reason"]) == (t, [-15.0, -10.0], "gantry")
    assert run.motions["operator"].position(t + 4.0) == pytest.approx((-15.0, -10.0))
    assert run.motions["operator"].rotation(t + 4.0) == pytest.approx(math.pi)
    restart = first(run, "goal", after=t + 1e-6)
    assert restart["t"] == pytest.approx(t + 8.0, abs=1e-9)
    assert restart["station"] == "station4"


def test_the_antagonistic_person_turns_to_the_gantry_before_station1(scene):
    run = scene("antagonistic")
    noticed, violation = first(run, "gantry_detected"), first(run, "violation")
    assert run.summary["people"]["operator"]["visits"][:2] == ["station4", "station2"]
    assert [name for t, name in goals(run) if t < noticed["t"]][-1] == "station1"
    assert noticed["distance"] == pytest.approx(2 * LAW.distance(1.0, 0.0), abs=1e-6)
    headed = first(run, "goal", after=noticed["t"])
    assert headed["t"] == noticed["t"]
    assert math.dist(headed["at"], GANTRY) < 1.0
    arrivals = [e for e in events(run, "arrived") if e["t"] < violation["t"]]
    assert [e["station"] for e in arrivals] == ["station4", "station2"]


def test_the_antagonistic_person_turns_to_the_gantry_in_every_round(scene):
    """The teleport into the safe zone does not count as the nearest point of the approach."""
    run = scene("antagonistic")
    noticed, violations = events(run, "gantry_detected"), events(run, "violation")
    assert len(noticed) - len(violations) in (0, 1)
    for notice, violation in zip(noticed, violations, strict=False):
        assert 0 < violation["t"] - notice["t"] < 6.0
    assert "station1" not in run.summary["people"]["operator"]["visits"]


def test_the_helpful_person_never_comes_too_close_and_does_not_dither(scene):
    run = scene("helpful")
    assert run.duration == 275.0
    assert events(run, "violation", "teleport", "gantry_disabled") == []
    assert run.summary["penalties"] == 0
    turns = [event["t"] for event in events(run, "gantry_detected")]
    assert len(turns) >= 4
    assert min(b - a for a, b in itertools.pairwise(turns)) > 5.0
    visits = run.summary["people"]["operator"]["visits"]
    assert set(visits) == {"station4", "station2"}
    for t in turns:
        before = [name for u, name in goals(run) if u <= t][-1]
        turned = first(run, "goal", after=t + 1e-6)
        assert turned["station"] != before
        standing = run.motions["operator"].velocity(np.array([t + 0.5, turned["t"] - 1e-6]))
        assert np.abs(standing).max() == 0.0


@pytest.mark.parametrize("personality", ["indifferent", "antagonistic", "helpful"])
def test_verdicts_equal_those_of_sampled_motions(scene, personality):
    """The recorded motions, sampled at 1 kHz, agree with the referee."""
    run = scene(personality)
    samples = run.sample(rate=1000.0)
    person, gantry = samples["operator"], samples["gantry"]
    apart = np.hypot(*(person[:, :2] - gantry[:, :2]).T)
    required = 2.5 * np.hypot(*person[:, 3:].T) + 1.0
    too_close = apart < required - 1e-9
    near_event = np.zeros(len(too_close), dtype=bool)
    for event in events(run, "violation"):
        near_event |= np.abs(samples["t"] - event["t"]) <= 1.5e-3
    assert not (too_close & ~near_event).any()
    nearest = run.summary["minimum_separation"]
    assert nearest["distance"] == pytest.approx(apart.min(), abs=2e-3)


@pytest.mark.parametrize("personality", ["indifferent", "antagonistic", "helpful"])
def test_people_never_touch_anything(scene, personality):
    import shapely

    import floorplan

    run = scene(personality)
    plan = floorplan.load("ariac2023")
    parked = [lane.footprint(0.0) for lane in plan.lanes]
    solid = shapely.union_all(
        [o.footprint for o in plan.obstacles if o.overlaps(0.0, plan.human.height)] + parked
    )
    points = shapely.points(run.sample(rate=100.0)["operator"][:, :2])
    assert shapely.distance(points, solid).min() >= plan.human.radius - 1e-9
    assert shapely.distance(points, plan.boundary.exterior).min() >= plan.human.radius - 1e-9


NEAR_AGV = """
floorplan: ariac2023
duration: 60
people:
  - {{name: operator, personality: {folder}/stay.asl, at: [-2.4, 4.08]}}
gantry: {{at: [-14.0, -6.0, 0.0]}}
agvs: {agvs}
"""


def near_agv(folder, agvs):
    (folder / "stay.asl").write_text("!stay. +!stay <- .wait(1000); !stay.\n")
    return sim.run(sim.Trial.parse(NEAR_AGV.format(folder=folder, agvs=agvs)))


def test_a_stationary_agv_causes_no_teleport(tmp_path):
    run = near_agv(tmp_path, "{}")
    assert math.dist((-2.4, 4.08), (-2.27, 4.8)) < LAW.distance(0.0, 0.0)
    assert events(run, "violation", "teleport") == []
    assert run.summary["agv_teleports"] == 0


def test_an_agv_that_drives_past_teleports_without_penalty(tmp_path):
    run = near_agv(tmp_path, "{agv1: [{time: 20.0, to: warehouse}]}")
    (violation,) = events(run, "violation")
    assert violation["with"] == "agv1"
    assert violation["penalty"] is False
    # It counts from the time at which the AGV is faster than 0.01 m/s (2 m/s²).
    assert violation["t"] == pytest.approx(20.005, abs=1e-6)
    (teleport,) = events(run, "teleport")
    assert (teleport["t"], teleport["reason"]) == (violation["t"], "agv")
    assert run.summary["agv_teleports"] == 1
    assert run.summary["penalties"] == 0
    assert run.summary["gantry_disabled_time"] == 0.0


def test_an_agv_that_passes_a_walking_person():
    run = sim.run(
        sim.Trial.parse(
            """
floorplan: ariac2023
duration: 60
people: [{name: operator, personality: indifferent}]
gantry: {at: [0.4, 7.0, 0.0]}
agvs: {agv4: [{time: 2.0, to: assembly_back}]}
"""
        )
    )
    violation = first(run, "violation")
    assert violation["with"] == "agv4"
    t = violation["t"]
    person, agv = (run.motions[name].state(t - 1e-6) for name in ("operator", "agv4"))
    assert math.dist(person.at, agv.at) == pytest.approx(
        LAW.distance(person.speed, agv.speed), abs=1e-4
    )
    assert first(run, "goal", after=t + 1e-6)["t"] == pytest.approx(t + 8.0, abs=1e-9)
