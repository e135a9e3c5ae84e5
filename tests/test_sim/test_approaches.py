"""Approaches of machines during violations: their counts, and durations against dense sampling."""

import numpy as np
import pytest

import sim

RULES = "{gantry_law: {fixed: 4.0}, agv_law: {fixed: 2.5}, machine: none, person: none}"

TRIAL = """
name: approach
floorplan: ariac2023
duration: 60
seed: {seed}
rules: {rules}
people: [{{name: operator, personality: {personality}}}]
gantry:
  controller: oblivious
  at: [-5.0, 2.5, 0.0]
  jobs: {jobs}
agvs: {{agv1: [{{time: 20, to: assembly_front}}]}}
"""

TO_AND_FRO = "[{wait: 20}, {move: [-5.0, -3.0, 0]}, {wait: 5}, {move: [-5.0, 3.5, 0]}, {wait: 60}]"
PARTS = "[{pick: bin2, place: agv1, part: p}, {pick: bin6, place: agv4, part: b}]"


def run_of(jobs, seed=0, personality="indifferent", rules=RULES):
    text = TRIAL.format(jobs=jobs, seed=seed, personality=personality, rules=rules)
    return sim.run(sim.Trial.parse(text))


def sampled(run, step=1e-3):
    """Return the sampled time (s) in which machines move towards people during violations."""
    seconds = 0.0
    for (person, machine), spans in run.violations.items():
        dx, dy = run.scene.rules.measured_at(run.scene.machine(machine))
        for begin, end in spans:
            t = np.arange(begin + step / 2, end, step)
            moving = run.motions[machine]
            apart = run.motions[person].position(t) - moving.position(t) - [dx, dy]
            closing = (moving.velocity(t) * apart).sum(axis=1) > 0.0
            # An approach that lasts since the begin of a violation is its cause.
            after = np.cumsum(~closing) > 0
            seconds += step * float((closing & after).sum())
    return seconds


@pytest.mark.parametrize("personality", ["indifferent", "antagonistic", "helpful"])
@pytest.mark.parametrize("jobs", [TO_AND_FRO, PARTS])
@pytest.mark.parametrize("seed", range(3))
def test_the_duration_of_approaches_equals_dense_sampling(jobs, seed, personality):
    run = run_of(jobs, seed, personality)
    approaches = run.summary["approaches"]
    assert approaches["duration"] == pytest.approx(sampled(run), abs=0.02)
    assert (approaches["count"] == 0) == (approaches["duration"] == 0)


def test_a_machine_that_sets_out_towards_a_person_already_too_near_is_counted():
    runs = [run_of(TO_AND_FRO, seed, name) for seed in range(4) for name in ("helpful", "curious")]
    counted = [run for run in runs if run.summary["approaches"]["count"]]
    assert counted
    for run in counted:
        approaches = run.summary["approaches"]
        spans = run.violations[approaches["person"], approaches["machine"]]
        assert any(begin < approaches["time"] <= end for begin, end in spans)
        assert approaches["margin"] < 0.0
        least = run.margin(approaches["person"], approaches["machine"], approaches["time"])
        assert approaches["margin"] == pytest.approx(float(least), abs=1e-5)


def test_a_violation_that_the_machine_begins_is_no_approach():
    # The machine drives up to a standing person, and stops within the required distance.
    text = TRIAL.format(
        jobs="[{wait: 30}, {move: [-5.0, 2.5, 0]}, {wait: 60}]",
        seed=0,
        personality="indifferent",
        rules=RULES,
    )
    trial = sim.Trial.parse(text.replace("at: [-5.0, 2.5, 0.0]", "at: [-14.0, -3.0, 0.0]"))
    run = sim.run(trial)
    caused = [e for e in run.events if e["kind"] == "violation" and e["cause"] == "gantry"]
    approach = run.summary["approaches"]
    assert caused
    assert approach["duration"] == pytest.approx(sampled(run), abs=0.02)


def test_approaches_can_be_expected_and_have_a_time():
    run = run_of(TO_AND_FRO, 0, "helpful")
    count = run.summary["approaches"]["count"]
    text = TRIAL.format(jobs=TO_AND_FRO, seed=0, personality="helpful", rules=RULES)
    text += f"expect: {{approaches: {count + 1}, approaches.duration: '< 60'}}"
    verdicts = sim.run(sim.Trial.parse(text)).verdicts
    assert [one.met for one in verdicts] == [False, True]
    assert [one.slack < 0 for one in verdicts] == [True, False]
