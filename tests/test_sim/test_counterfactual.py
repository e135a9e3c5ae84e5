"""Counterfactuals: the same trial without machines or people, with the same random draws."""

from dataclasses import replace

import pytest

import sim
from sim.orders.workload import Workload
from sim.trials.counterfactual import counterfactual_of, difference

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


def test_a_run_without_machines_equals_a_floor_without_machines():
    actual = run("without machines")
    trial = actual.trial
    plan = replace(trial.floorplan, gantry=None, lanes=())
    starts = [actual.summary["people"][name]["started"] for name in ("one", "other")]
    people = tuple(
        replace(person, start=sim.Start(time=60.0 if start is None else start))
        for person, start in zip(trial.people, starts, strict=True)
    )
    bare = sim.Trial(
        floorplan=plan, name="cost", duration=60.0, seed=3, people=people, rules=trial.rules
    )
    alone = sim.run(bare).summary["people"]
    cost = actual.summary["counterfactual"]
    for name in ("one", "other"):
        figures = actual.summary["people"][name]
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


def test_machines_without_encounters_make_no_difference():
    text = "{floorplan: ariac2023, duration: 30, people: [{name: p}],"
    quiet = f"{text} rules: {{machine: none, person: none}}, gantry: {{at: [-14.0, -4.0, 0.0]}},"
    unaffected = sim.run(sim.Trial.parse(f"{quiet} counterfactual: without machines}}"))
    assert unaffected.summary["counterfactual"]["visits"] == 0
    assert unaffected.summary["counterfactual"]["distance_walked"] == 0.0


def test_people_cost_a_gantry_jobs():
    cost = run("without people").summary["counterfactual"]
    assert cost["jobs_done"] <= 0
    assert set(cost) == {
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


EVERYTHING = """
name: all
floorplan: ariac2023
duration: 50
seed: 3
people:
  - {name: one, personality: worker, work: line, start: {time: 4}}
  - {name: early, personality: external, start: {part_placed: {agv: agv1}}}
  - {name: never, personality: external, start: {event: penalty}}
work: {line: [{name: job, at: station1, duration: 5}]}
gantry:
  controller: oblivious
  jobs: [{pick: bin2, place: agv1, part: pump}]
agvs: {agv1: [{time: 30, to: assembly_front}]}
machines: {fork: {kind: amr, at: [-14, 2, 0]}}
blackouts: [{machine: gantry, start: {time: 1}, seconds: 2}]
commands:
  - {time: 5, hold: gantry}
  - {time: 6, release: gantry}
  - {time: 7, send: one, to: station2}
  - {time: 8, block: box, x: [-15, -14], y: [8, 9], z: [0, 1]}
expect: {penalties: 0}
"""


def bare(which, **started):
    trial = sim.Trial.parse(f"{EVERYTHING}counterfactual: {which}\n")
    return trial, counterfactual_of(trial, {"one": 4.0, "early": 12.5, "never": None} | started)


def test_people_without_machines_start_at_the_same_times():
    trial, alone = bare("without machines")
    assert (alone.agvs, alone.machines, alone.fields, alone.blackouts) == ({}, {}, {}, ())
    assert alone.gantry == type(alone.gantry)() and alone.workload is None
    assert alone.floorplan.gantry is None and not alone.floorplan.lanes
    assert [one.start.time for one in alone.people] == [4.0, 12.5, 50.0]
    assert [(one.time, one.send) for one in alone.commands] == [(7, "one"), (8, None)]
    assert (alone.work, alone.seed, alone.duration) == (trial.work, 3, 50)
    assert alone.expect == {} and alone.counterfactual is None
    sim.run(alone)


def test_a_trial_without_people_has_all_machines_and_no_work_of_people():
    trial, alone = bare("without people")
    assert alone.people == () and alone.work == {}
    for key in ("agvs", "machines", "gantry", "commands", "blackouts", "floorplan", "seed"):
        assert getattr(alone, key) == getattr(trial, key)
    assert alone.expect == {} and alone.counterfactual is None


def test_orders_of_a_workload_are_work_of_machines():
    trial = sim.Trial.parse("{floorplan: ariac2023, people: [{name: ann}]}")
    for which, stays in (("without machines", False), ("without people", True)):
        one = replace(trial, counterfactual=which, workload=Workload(()), until_submitted=True)
        alone = counterfactual_of(one, {"ann": 0.0})
        assert (alone.workload is not None) is stays and not alone.until_submitted


def test_the_difference_is_the_run_minus_its_counterfactual():
    trial, _ = bare("without people")
    keys = ("jobs_done", "gantry_idle_time", "gantry_disabled_time", "protective_stop_time")
    mine, other = (
        dict(zip(keys, values, strict=True)) for values in ((3, 9.0, 2.0, 5.0), (7, 1.5, 0.0, 1.0))
    )
    assert difference(trial, mine, other) == {
        "jobs_done": -4,
        "gantry_idle_time": 7.5,
        "gantry_disabled_time": 2.0,
        "protective_stop_time": 4.0,
    }
    trial, _ = bare("without machines")

    def people(visits, walked, standing):
        return {"visits": visits, "distance_walked": walked, "time_standing": standing}

    mine = {"people": {"a": people(["x"], 10.0, 3.0), "b": people([], 1.0, 9.0)}}
    other = {"people": {"a": people(["x", "y", "z"], 30.0, 1.0), "b": people(["x"], 4.0, 2.0)}}
    assert difference(trial, mine, other) == {
        "visits": -3,
        "distance_walked": -23.0,
        "time_standing": 9.0,
        "people": {"a": people(-2, -20.0, 2.0), "b": people(-1, -3.0, 7.0)},
    }
