"""Minimum margins of runs against dense sampling, and the slack of every expectation."""

import math
import random

import numpy as np
import pytest

import navigation
import sim
from sim.safety.margins import (
    Encountered,
    Margin,
    RecordedRequirement,
    least_margins,
    moving_spans,
)
from sim.trials import slack
from sim.trials.timeline import NumberCondition

DENSE = 0.01
"""Interval of the samples of a margin (s)."""

TOLERANCE = 0.03
"""Excess (m) of a sampled margin over the minimum, which may lie between samples."""

LAWS = {
    "linear": "{gantry_law: {iso_ts_15066: {t1: 0.3, t2: 0.4, intrusion: 0.5}},"
    " machine: none, person: none}",
    "integral": "{gantry_law: {iso_ts_15066_integral: {t1: 0.3, t2: 0.4, intrusion: 0.5}},"
    " machine: none, person: none}",
    "fixed": "{gantry_law: {fixed: 2.0}, machine: none, person: none}",
    "paper": "paper",
}


def trial(seed, law, controller="oblivious"):
    """Return a trial with two people and all kinds of machines, drawn from a seed."""
    rng = random.Random(seed)
    times = sorted(round(rng.uniform(0, 50), 2) for _ in range(2))
    personalities = [rng.choice(("helpful", "indifferent", "antagonistic")) for _ in range(2)]
    jobs = rng.sample(["bin2", "bin6", "bin3", "bin5"], 2)
    return f"""
name: margins
floorplan: ariac2023
duration: 70
seed: {seed}
rules: {law}
people:
  - {{name: one, personality: {personalities[0]}}}
  - {{name: other, personality: {personalities[1]}, start: {{time: {times[0]}}}}}
gantry:
  controller: {controller}
  at: [{rng.uniform(-8, -3):.2f}, {rng.uniform(-2, 2):.2f}, 0.0]
  jobs: [{", ".join(f"{{pick: {one}, place: agv1, part: pump}}" for one in jobs)}]
agvs: {{agv1: [{{time: {times[1]}, to: assembly_front}}]}}
"""


def sampled(run, person, machine, spans):
    """Return the minimum margin at dense times of some spans, except near jumps."""
    least = math.inf
    jumps = [*run.motions[person].jumps]
    for begin, end in spans:
        times = np.linspace(begin, end, max(int((end - begin) / DENSE), 2))
        times = times[[all(abs(t - jump) > 2e-3 for jump in jumps) for t in times]]
        if len(times):
            least = min(least, float(run.margin(person, machine, times).min()))
    return least


def spans_of(run, person, machine, *, moving):
    begin = run.summary["people"][person]["started"]
    if begin is None:
        return []
    is_vehicle = run.scene.machine(machine).category == "vehicle"
    if moving or is_vehicle:
        return moving_spans(run.motions[machine], begin, run.duration)
    return [(begin, run.duration)]


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("seed", range(6))
def test_the_minimum_margin_equals_dense_sampling(law, seed):
    run = sim.run(sim.Trial.parse(trial(seed, LAWS[law])))
    pairs = [(p.name, m.name) for p in run.scene.people for m in run.scene.machines]
    for key, moving in (("least_margin", False), ("least_margin_moving", True)):
        recorded = run.summary[key]
        least = min(
            sampled(run, person, machine, spans_of(run, person, machine, moving=moving))
            for person, machine in pairs
        )
        if recorded is None:
            assert least == math.inf
            continue
        assert recorded["value"] <= least + 1e-6
        assert recorded["value"] >= least - TOLERANCE
        spans = spans_of(run, recorded["person"], recorded["machine"], moving=moving)
        assert any(begin - 1e-6 <= recorded["time"] <= end + 1e-6 for begin, end in spans)


@pytest.mark.parametrize("seed", range(12))
def test_the_least_margin_is_negative_where_there_was_a_violation(seed):
    run = sim.run(sim.Trial.parse(trial(seed, LAWS["linear"])))
    violated = any(e["kind"] == "violation" for e in run.events)
    assert (run.summary["least_margin"]["value"] < 0) == violated
    moving = run.summary["least_margin_moving"]
    assert moving is None or moving["value"] >= run.summary["least_margin"]["value"]


def test_a_run_without_machines_or_people_has_no_margin():
    nobody = sim.run(sim.Trial.parse("{floorplan: ariac2023, duration: 5}"))
    assert nobody.summary["least_margin"] is None
    with pytest.raises(sim.TrialError, match="least_margin"):
        sim.Trial.parse("{floorplan: ariac2023, duration: 5, expect: {least_margin: '>= 0'}}")


def test_a_machine_that_never_moves_has_no_margin_while_it_moves():
    run = sim.run(sim.Trial.parse("{floorplan: ariac2023, duration: 20, people: [{name: p}]}"))
    assert run.summary["least_margin"]["machine"] == "gantry"
    assert run.summary["least_margin_moving"] is None


def test_a_recorded_requirement_encloses_its_curve_and_takes_the_right_side_of_a_jump():
    curve = ((0.0, 1.0), (2.0, 3.0), (2.0, 0.5), (5.0, 0.5), (6.0, 4.0))
    law = RecordedRequirement(curve)
    assert law.required(None, 2.0, 2.0).value == 0.5
    rng = random.Random(1)
    for _ in range(300):
        begin, end = sorted((rng.uniform(0, 6), rng.uniform(0, 6)))
        bound = law.required(None, begin, end)
        middle = (begin + end) / 2
        for t in np.linspace(begin, np.nextafter(end, begin), 60):
            exact = law.required(None, t, t).value
            assert abs(exact - bound.value - bound.slope * (t - middle)) <= bound.slack + 1e-9


@pytest.mark.parametrize(
    ("condition", "value", "amount"),
    [
        (3, 3, 0.0),
        (3, 5, -2.0),
        (">= 1.0", 1.25, 0.25),
        (">= 1.0", 0.25, -0.75),
        ("> 3", 4, 0.0),
        ("> 3", 3, -1.0),
        ("< 3", 1, 1.0),
        ("!= 2", 2, -1.0),
        ("!= 2", 5, 3.0),
        ("8.0 ± 0.5", 8.25, 0.25),
        ("8.0 ± 0.5", 9.0, -0.5),
        ("> 1, < 4", 3.5, pytest.approx(0.5)),
    ],
)
def test_the_slack_of_a_number_is_its_distance_to_the_bound(condition, value, amount):
    assert NumberCondition.parse(condition).slack(value) == amount


def test_the_slack_of_a_number_is_negative_exactly_where_it_does_not_pass():
    rng = random.Random(5)
    values = [0, 1, 3, 0.0, 1.0, 1e-9, 0.1 + 0.2, 0.3, math.nextafter(1.0, 2), -1.0]
    signs = ["<", "<=", ">", ">=", "==", "!="]
    for _ in range(3000):
        condition = NumberCondition.parse(f"{rng.choice(signs)} {rng.choice(values)!r}")
        value = rng.choice([*values, rng.uniform(-2, 2)])
        assert (condition.slack(value) < 0) == (not condition.passes(value))


def test_the_slack_of_visits_counts_the_differences():
    came = ["a", "b", "a"]
    assert slack.of_visits(came, ["a", "c"], "begin_with") == -1
    assert slack.of_visits(came, ["a", "b"], "begin_with") == 0
    assert slack.of_visits(came, ["a", "b"], "exactly") == -1
    assert slack.of_visits(came, ["a", "a"], "in_order") == 0
    assert slack.of_visits(came, ["a", "c", "b"], "in_order") == -2
    assert slack.of_visits(came, ["a"], "never") == -2
    assert slack.of_visits(came, ["d"], "never") == 0


EXPECT = """
expect:
  penalties: 0
  jobs_done: ">= 2"
  minimum_separation: ">= {metres}"
  least_margin: ">= 0"
  duration: "> 70"
  people.one.distance_walked: "> 30, < 60"
  people.one.visits: {{begin_with: [station4, station2]}}
  people.other.visits: {{never: [station1]}}
  interrupted: false
  timeline:
    - {{never: {{near: [one, gantry], metres: {metres}}}}}
    - {{always: {{apart: [other, gantry], metres: {metres}}}, before: 40}}
    - {{always: {{near: [one, gantry], metres: 9}}}}
    - {{eventually: {{near: [one, other], metres: 3}}}}
    - {{eventually: violation}}
    - {{eventually: violation, times: "<= 1"}}
    - {{never: {{moving: agv1}}}}
    - {{always: {{moving: gantry}}, after: 5, within: 4}}
    - {{whenever: goal, then: arrived, within: 14}}
    - {{never: arrived, after: violation}}
"""


@pytest.mark.parametrize("seed", range(20))
def test_slack_is_negative_exactly_where_an_expectation_is_not_met(seed):
    text = trial(seed, LAWS["linear"]) + EXPECT.format(metres=2 + seed % 4)
    run = sim.run(sim.Trial.parse(text))
    assert {one.met for one in run.verdicts} == {True, False}
    for verdict in run.verdicts:
        assert (verdict.slack < 0) == (not verdict.met), verdict


def test_slack_of_distances_is_in_metres_and_that_of_responses_in_seconds():
    text = trial(3, LAWS["linear"]) + EXPECT.format(metres=3)
    run = sim.run(sim.Trial.parse(text))
    of = {".".join(map(str, one.place)): one for one in run.verdicts}
    _, metres = navigation.minimum_separation(
        run.motions["one"], run.motions["gantry"], 0.0, run.duration
    )
    assert of["timeline.0"].slack == pytest.approx(metres - 3, abs=1e-9)
    assert of["timeline.0"].unit == "m"
    assert of["timeline.8"].unit == "s"
    assert of["least_margin"].slack == run.summary["least_margin"]["value"]
    separation = run.summary["minimum_separation"]["distance"]
    assert of["minimum_separation"].slack == pytest.approx(separation - 3, abs=1e-12)


def test_a_recorded_requirement_that_jumps_is_that_before_the_jump_until_then():
    law = RecordedRequirement([(0.0, 1.0), (2.0, 1.0), (2.0, 3.0), (4.0, 3.0), (6.0, 4.0)])
    assert law.required(None, 0.0, 2.0) == navigation.Enclosure(value=1.0, slope=0.0, slack=0.0)
    assert law.required(None, 2.0, 4.0) == navigation.Enclosure(value=3.0, slope=0.0, slack=0.0)
    assert law.required(None, 4.0, 6.0) == navigation.Enclosure(value=3.5, slope=0.5, slack=0.0)
    assert law.required(None, 2.0, 2.0).value == 3.0
    for before, after in ((-5.0, 1.0), (9.0, 4.0)):
        assert law.required(None, before, before).value == after


def test_a_machine_that_turns_on_the_spot_moves_if_turning_counts():
    drive = navigation.vehicle_path((0, 0, 0), [(2, 0, 0), (2, 0, 1.5), (2, 3, 1.5)][:2])
    (driving,) = moving_spans(drive)
    (all_of_it,) = moving_spans(drive, turning=True)
    turn = navigation.vehicle_turn((0, 0, 0), 1.5, 3.0)
    assert moving_spans(turn) == []
    assert moving_spans(turn, turning=True) == [(3.0, pytest.approx(turn.end))]
    assert driving[0] == all_of_it[0] == 0.0
    assert driving[1] == pytest.approx(navigation.vehicle_segment((0, 0, 0), (2, 0)).end)
    assert all_of_it[1] == pytest.approx(drive.end)
    assert moving_spans(drive, 1.0, 2.0) == [(1.0, 2.0)]
    assert moving_spans(drive, drive.end, 99.0) == []


def beside(walk, machine, spans, moving, name="cart"):
    law = navigation.FixedDistance(1.0)
    return Encountered("ann", name, law, walk, machine, None, spans, moving)


def test_least_margins_are_of_the_spans_that_count():
    walk = navigation.standing((0.0, 0.0))
    far = navigation.vehicle_segment((6.0, 0.0, math.pi), (3.0, 0.0))
    near = navigation.standing((2.0, 0.0))
    spans = [(0.0, 20.0)]
    overall, moving = least_margins(
        [
            beside(walk, far, spans, moving_spans(far, 0.0, 20.0)),
            beside(walk, near, spans, [], "near"),
        ]
    )
    assert (overall.value, overall.machine) == (pytest.approx(1.0), "near")
    assert (moving.value, moving.machine) == (pytest.approx(2.0), "cart")
    assert least_margins([beside(walk, far, [], [])]) == (None, None)
    # The overall minimum is at rest. During motion, another machine is nearer.
    back = navigation.vehicle_segment((3.0, 0.0, 0.0), (9.0, 0.0), 5.0)
    other = navigation.vehicle_segment((9.0, 1.0, math.pi), (3.5, 1.0))
    pair = [
        beside(walk, back, [(0.0, 20.0)], [(6.5, 12.0)]),
        beside(walk, other, [(0.0, 20.0)], [(0.0, 20.0)], "other"),
    ]
    overall, moving = least_margins(pair)
    assert overall.machine == "cart" and overall.value == pytest.approx(2.0)
    exact = float(back.position(6.5)[0]) - 1.0
    assert moving.value == pytest.approx(min(exact, math.hypot(3.5, 1.0) - 1.0))


def test_a_margin_that_is_just_negative_stays_negative_in_the_summary():
    assert Margin(-1e-15, 1.0, "ann", "cart").figures["value"] == -1e-9
    assert Margin(-0.5, 1.0, "ann", "cart").figures["value"] == -0.5
    assert Margin(0.0, 1.0, "ann", "cart").figures == {
        "value": 0.0,
        "time": 1.0,
        "person": "ann",
        "machine": "cart",
    }


@pytest.mark.parametrize(
    ("condition", "value", "amount"),
    [
        ("!= 2", 2.0, -math.ulp(2.0)),
        ("!= 2.5", 2.5, -math.ulp(2.5)),
        ("!= 2", 2, -1.0),
        ("> 3.5", 4, 0.5),
        ("< 3.5", 3, 0.5),
        ("> 3", 3.0, -math.ulp(3.0)),
        ("< 3", 3.0, -math.ulp(3.0)),
        ("== 3", 3, 0.0),
        ("== 3", 1.5, -1.5),
        (">= 3", 3, 0.0),
        ("<= 3", 2, 1.0),
    ],
)
def test_slack_of_whole_and_other_numbers(condition, value, amount):
    assert NumberCondition.parse(condition).slack(value) == pytest.approx(amount, rel=1e-9, abs=0.0)


def test_a_slack_has_the_sign_of_its_verdict():
    assert slack.signed(0.5, met=True) == 0.5 and slack.signed(-0.5, met=False) == -0.5
    assert slack.signed(-0.5, met=True) == 0.0 and slack.signed(0.5, met=False) == -1e-9
    assert slack.of_flag(True) == 1.0 and slack.of_flag(False) == -1.0
    assert slack.of_visits(["a"], ["a", "b"], "exactly") == -1
    assert slack.of_visits(["a"], ["a", "b"], "begin_with") == -1
    assert slack.of_visits(["b", "a"], ["a", "b"], "exactly") == -2
