"""Counterfactuals: the same trial without machines or without people, with the same draws."""

from dataclasses import replace

import pytest

import sim

TRIAL = """
name: cost
floorplan: ariac2023
duration: 60
seed: 3
people:
  - {name: one, personality: antagonistic, max_speed: [0.8, 1.2]}
  - {name: other, personality: helpful, start: {part_placed: {agv: agv1}}}
gantry:
  controller: oblivious
  jobs: [{pick: bin2, place: agv1, part: pump}, {pick: bin6, place: agv4, part: battery}]
agvs: {agv1: [{time: 30, to: assembly_front}]}
"""


def run(counterfactual, text=TRIAL):
    return sim.run(sim.Trial.parse(f"{text}counterfactual: {counterfactual}\n"))


def test_the_difference_to_a_run_without_machines_is_that_of_a_floor_without_them():
    found = run("without machines")
    trial = found.trial
    plan = replace(trial.floorplan, gantry=None, lanes=())
    starts = [found.summary["people"][name]["started"] for name in ("one", "other")]
    people = tuple(
        replace(person, start=sim.Start(time=60.0 if start is None else start))
        for person, start in zip(trial.people, starts, strict=True)
    )
    bare = sim.Trial(
        floorplan=plan, name="cost", duration=60.0, seed=3, people=people, rules=trial.rules
    )
    alone = sim.run(bare).summary["people"]
    cost = found.summary["counterfactual"]
    for name in ("one", "other"):
        figures = found.summary["people"][name]
        mine = cost["people"][name]
        assert mine["visits"] == len(figures["visits"]) - len(alone[name]["visits"])
        for key in ("distance_walked", "time_standing"):
            assert mine[key] == pytest.approx(figures[key] - alone[name][key], abs=1e-8)
    assert cost["visits"] == sum(one["visits"] for one in cost["people"].values()) < 0


def test_the_run_itself_stays_the_same():
    with_it, without = run("without machines"), sim.run(sim.Trial.parse(TRIAL))
    assert with_it.events == without.events
    left = {key: value for key, value in with_it.summary.items() if key in without.summary}
    costs = ("cpu_seconds", "realtime_factor")
    assert {k: v for k, v in left.items() if k not in costs} == {
        k: v for k, v in without.summary.items() if k not in costs
    }


def test_machines_that_nobody_meets_cost_nothing():
    text = "{floorplan: ariac2023, duration: 30, people: [{name: p}],"
    quiet = f"{text} rules: {{machine: none, person: none}}, gantry: {{at: [-14.0, -4.0, 0.0]}},"
    found = sim.run(sim.Trial.parse(f"{quiet} counterfactual: without machines}}"))
    assert found.summary["counterfactual"]["visits"] == 0
    assert found.summary["counterfactual"]["distance_walked"] == 0.0


def test_people_cost_a_gantry_jobs():
    found = run("without people").summary["counterfactual"]
    assert found["jobs_done"] <= 0
    assert set(found) == {
        "jobs_done",
        "gantry_idle_time",
        "gantry_disabled_time",
        "protective_stop_time",
    }


def test_a_trial_can_expect_a_cost_and_is_written_with_it():
    text = TRIAL + "counterfactual: without machines\nexpect: {counterfactual.visits: '>= 0'}\n"
    trial = sim.Trial.parse(text)
    assert sim.Trial.parse(trial.to_yaml()).counterfactual == "without machines"
    (verdict,) = sim.run(trial).verdicts
    assert not verdict.met
    with pytest.raises(sim.TrialError, match=r"counterfactual.visits: a run has no such figure"):
        sim.Trial.parse(TRIAL + "expect: {counterfactual.visits: 0}\n")


def test_another_word_is_rejected():
    with pytest.raises(sim.TrialError, match=r"counterfactual: .*without machines"):
        run("without robots")


def test_a_study_has_the_cost_as_a_column(tmp_path):
    text = TRIAL.replace("duration: 60", "duration: 30") + "counterfactual: without machines\n"
    (tmp_path / "cost.trial.yaml").write_text(text)
    (tmp_path / "some.study.yaml").write_text("trials: [cost.trial.yaml]\nrepeat: 2\n")
    study = sim.Study.load(tmp_path / "some.study.yaml")
    results = sim.run_study(study, tmp_path / "out", jobs=1)
    run = sim.run(study.row(0).trial)
    assert results.columns["counterfactual.visits"][0] == run.summary["counterfactual"]["visits"]
