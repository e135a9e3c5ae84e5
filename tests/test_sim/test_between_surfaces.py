"""Rules between surfaces: every use of the law, against sampled footprints."""

import json
from functools import cache

import numpy as np
import pytest
import shapely
import yaml
from run_events import events, record

import sim

WEDGE = [[-0.4, -0.4], [1.3, -0.2], [1.3, 0.5], [-0.4, 0.4]]

TRIAL = """
name: surfaces
floorplan: ariac2023
duration: 90
seed: {seed}
rules: {{between: surfaces, machine: {machine}, person: none, {laws}}}
people:
  - {{name: ann, radius: 0.25}}
  - {{name: bob, personality: antagonistic}}
  - {{name: cas, personality: curious}}
gantry:
  controller: {controller}
  jobs: [{{move: [-2.5, 0.5, 1.5]}}, {{move: [-12, 3, 0]}}, {{move: [-12, 3, 3]}}]
  repeat: true
agvs:
  agv1: {{moves: [{{time: 5, to: assembly_front}}, {{time: 40, to: kitting}}], yield: {yields}}}
  agv3: [{{time: 8, to: warehouse}}]
machines:
  cart:
    kind: amr
    at: [-14, -10, 0]
    footprint: {footprint}
    controller: {controller}
    missions: [{{go: [-5.0, -9.5]}}, {{turn: 2.0}}, {{turn: -2.0}}, {{go: [-14, -9]}}]
    repeat: true
"""

LAWS = {
    "fixed": "gantry_law: {fixed: 0.6}, agv_law: {fixed: 0.5}",
    "linear": "gantry_law: {iso_ts_15066: {t1: 0.3, t2: 0.4, intrusion: 0.2}},"
    " agv_law: {iso_ts_15066: {t1: 0.1, t2: 0.4, intrusion: 0.2}}",
    "integral": "gantry_law: {iso_ts_15066_integral: {t1: 0.3, t2: 0.4, intrusion: 0.2}},"
    " agv_law: {fixed: 0.5}",
}

STEP = 0.01
"""Interval of samples (s)."""


@cache
def run_of(seed, law="fixed", controller="oblivious", machine="none"):
    yields = "false" if controller == "oblivious" else "true"
    text = TRIAL.format(
        seed=seed,
        laws=LAWS[law],
        controller=controller,
        yields=yields,
        machine=machine,
        footprint=json.dumps(WEDGE),
    )
    return sim.run(sim.Trial.parse(text))


def sampled(run, person, machine, t):
    """Return distances between surfaces (m), speeds of the axis and the farthest corner (m/s)."""
    motion, shape = run.motions[machine], run.scene.machine(machine)
    radius = next(one.radius for one in run.scene.people if one.name == person)
    at, rotation = run.motions[person].position(t), motion.rotation(t)
    corners = shapely.get_coordinates(shape.footprint((0.0, 0.0), 0.0))
    turn = np.exp(1j * rotation)[:, None] * (corners @ [1.0, 1.0j])
    placed = np.stack([turn.real, turn.imag], axis=2) + motion.position(t)[:, None]
    distances = shapely.distance(shapely.polygons(placed), shapely.points(at))
    to_arm = np.hypot(*(at - motion.position(t)).T) - shape.reach
    distances = np.minimum(distances, to_arm) if shape.reach else distances
    farthest = max(float(np.hypot(*corners.T).max()), shape.reach)
    turning = np.abs([motion.state(one).velocity[2] for one in t]) * farthest
    speeds = np.hypot(*motion.velocity(t).T)
    return np.maximum(distances - radius, 0.0), speeds, turning


def inside(spans, t):
    return any(begin <= t <= end for begin, end in spans)


def at_an_end(spans, t, away=2e-3):
    return any(abs(t - end) < away for span in spans for end in span)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_violations_equal_those_of_sampled_footprints(seed, law):
    run = run_of(seed, law)
    t = np.arange(0.005, run.duration, 0.1)
    for (person, machine), spans in run.violations.items():
        distance, speed, turning = sampled(run, person, machine, t)
        assert run.distance(person, machine, t) == pytest.approx(distance, abs=3e-5)
        short = distance < run.required(person, machine, t) - 0.011
        long = distance > run.required(person, machine, t) + 0.011
        moves = np.full(len(t), run.scene.machine(machine).category == "robot")
        moves |= np.maximum(speed, turning) > 0.02
        for k, instant in enumerate(t):
            if short[k] and moves[k] and not at_an_end(spans, instant):
                assert inside(spans, instant), (person, machine, instant)
            if long[k]:
                assert not inside(spans, instant) or at_an_end(spans, instant)
    assert sum(map(len, run.violations.values()))


@pytest.mark.parametrize("seed", range(2))
def test_violations_begin_and_end_where_the_surfaces_are_that_far_apart(seed):
    run, checked = run_of(seed), 0
    for (person, machine), spans in run.violations.items():
        required = 0.6 if run.scene.machine(machine).category == "robot" else 0.5
        for begin, end in spans:
            distance, speed, turning = sampled(run, person, machine, np.array([begin, end]))
            is_robot = run.scene.machine(machine).category == "robot"
            for one, v, w, t in zip(distance, speed, turning, (begin, end), strict=True):
                if 0.0 < t < run.duration and (is_robot or max(v, w) > 0.02):
                    assert one == pytest.approx(required, abs=3e-5)
                    checked += 1
    assert checked > 3


@pytest.mark.slow
def test_minimum_distances_and_margins_equal_dense_sampling():
    run = run_of(0, "linear")
    margins = {}
    for person, machine in run.violations:
        if run.scene.machine(machine).category != "robot":
            continue
        begin = run.summary["people"][person]["started"]
        t = np.arange(begin, run.duration, STEP)
        distance, _, _ = sampled(run, person, machine, t)
        recorded = run.summary["people"][person]["minimum_separation"]["distance"]
        assert distance.min() - 0.03 <= recorded <= distance.min() + 3e-5
        margins[person] = float((distance - run.required(person, machine, t)).min())
    assert run.summary["least_margin"]["value"] <= min(margins.values()) + 3e-5
    least = run.summary["least_margin"]
    pair = least["person"], least["machine"]
    at = np.array([least["time"]])
    assert float(run.margin(*pair, at)[0]) == pytest.approx(least["value"], abs=1e-5)
    assert run.summary["distances_between"] == "surfaces"


@pytest.mark.parametrize("seed", range(3))
def test_the_duration_of_approaches_equals_dense_sampling(seed):
    run = run_of(seed)
    step, seconds = 2e-3, 0.0
    for (person, machine), spans in run.violations.items():
        shapes = run.scene.shapes(person, machine)
        motion = run.motions[machine]
        for begin, end in spans:
            t = np.arange(begin + step / 2, end, step)
            places = run.motions[person].position(t)
            now, later = (
                np.column_stack([motion.position(one), motion.rotation(one)])
                for one in (t, t + 1e-5)
            )
            nearer = shapes.distances(places, now) - shapes.distances(places, later) > 1e-10
            # An approach that lasts since the begin of a violation is its cause, even if it is slow
            # at first.
            after = np.cumsum(~nearer & (t > begin + 0.01)) > 0
            seconds += step * float((nearer & after).sum())
    assert run.summary["approaches"]["duration"] == pytest.approx(seconds, abs=0.05)


@pytest.mark.parametrize("law", ["fixed", "linear"])
@pytest.mark.parametrize("seed", range(2))
def test_careful_machines_never_come_too_close_by_their_own_motion(seed, law):
    run = run_of(seed, law, "pausing")
    careful = ("gantry", "agv1", "cart")
    for event in events(run, "violation"):
        if event["with"] in careful:
            assert event["cause"] == "person", event
    assert run.summary["machines"]["gantry"]["jobs_done"]
    assert run.motions["cart"].position(run.duration) != pytest.approx(np.array([-14.0, -10.0]))


def test_a_protective_stop_lasts_until_the_surfaces_are_apart():
    run = run_of(0, machine="stop")
    assert events(run, "protective_stop")
    for event in events(run, "violation"):
        pair = event["person"], event["with"]
        assert event["distance"] == pytest.approx(run.distance(*pair, event["t"]), abs=1e-6)


TURN = """
floorplan: {{boundary: [[0, 0], [10, 0], [10, 10], [0, 10]]}}
duration: 12
rules: {{between: {between}, agv_law: {{fixed: 0.2}}, machine: none, person: none}}
people: [{{name: ann, at: [5.0, 6.7], max_speed: 0.05}}]
machines:
  bar: {{kind: amr, at: [5, 5, 0], size: [3.0, 0.6], missions: [{{turn: 3.0}}]}}
"""


def test_a_vehicle_that_turns_on_the_spot_violates_the_law_with_its_corners():
    run = sim.run(sim.Trial.parse(TURN.format(between="surfaces")))
    (violation,) = events(run, "violation")
    assert violation["cause"] == "amr"
    assert violation["distance"] == pytest.approx(0.2, abs=1e-6)
    ((begin, end),) = run.violations["ann", "bar"]
    distance, _, _ = sampled(run, "ann", "bar", np.array([begin, end]))
    assert distance == pytest.approx([0.2, 0.2], abs=1e-6)
    # Between centres there is no violation, because the centre of the vehicle does not move.
    run = sim.run(sim.Trial.parse(TURN.format(between="centres")))
    assert not run.violations["ann", "bar"]


def test_recordings_and_trials_keep_where_distances_are_measured(tmp_path):
    folder = tmp_path / "run"
    trial = run_of(1).trial
    run = record(trial, folder)
    again = sim.load_run(folder)
    assert again.scene.rules.between == "surfaces"
    t = np.linspace(0.0, run.duration, 50)
    assert again.distance("ann", "cart", t) == pytest.approx(run.distance("ann", "cart", t))
    (folder / "summary.json").unlink()
    worked_out = sim.load_run(folder).violations
    for pair, spans in run.violations.items():
        lasting = [span for span in spans if span[1] - span[0] > 1e-6]
        loaded = [span for span in worked_out[pair] if span[1] - span[0] > 1e-6]
        assert np.array(loaded) == pytest.approx(np.array(lasting), abs=1e-6)
    run.trial.save(tmp_path / "again.yaml")
    written = yaml.safe_load((tmp_path / "again.yaml").read_text())
    assert written["rules"]["between"] == "surfaces"
    assert sim.Trial.load(tmp_path / "again.yaml").rules == run.trial.rules


@pytest.mark.parametrize(
    ("rules", "message"),
    [
        ("{between: skin}", "between"),
        ("{between: surfaces, agv_offset: 0.3}", "agv_offset: distances between surfaces are not"),
    ],
)
def test_bad_rules_are_named(rules, message):
    with pytest.raises(sim.TrialError, match=message):
        sim.Trial.parse(f"floorplan: ariac2023\nduration: 5\nrules: {rules}\n")


def test_the_offset_of_a_rule_set_does_not_count_between_surfaces():
    text = "floorplan: ariac2023\nduration: 5\nrules: {based_on: ariac2023, between: surfaces}\n"
    assert sim.Trial.parse(text).rules.agv_offset == 0.0
