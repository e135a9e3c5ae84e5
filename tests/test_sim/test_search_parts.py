"""Parts of searches: ranks, distinct cases, dimensions, and minimising."""

import math
from dataclasses import replace

import pytest

import sim
from sim.searches import Objective, Space
from sim.searches.evaluations import (
    Evaluation,
    distinct,
    evaluation_of,
    failed,
    record,
    upper_bound,
)
from sim.searches.minimising import Minimiser
from sim.searches.objective import Situation
from sim.searches.results import least
from sim.searches.space import Dimension

OBJECTIVE = Objective("least_margin")


def tried(number, value=None, *, result="run", point=None, **situation):
    return Evaluation(number, point or {}, True, {}, result, value, Situation(**situation))


def test_errors_are_worst_and_runs_without_a_value_come_last():
    one, none, error, worse = (
        tried(0, 0.5),
        tried(1),
        tried(2, result="error", error="TypeError: x"),
        tried(3, -2.0),
    )
    ranked = sorted([one, none, error, worse], key=lambda e: e.rank)
    assert [e.number for e in ranked] == [2, 3, 0, 1]
    assert [e.rank for e in ranked] == [-math.inf, -2.0, 0.5, math.inf]
    assert [e.is_break(OBJECTIVE) for e in (one, none, error, worse)] == [False, False, True, True]
    assert least([one, none, worse]) is worse and least([none]) is None
    assert least([worse, error]) is error
    assert [e.number for e in distinct([one, none, error, worse], [], 1)] == [2]


def at(number, x, y=0.0, value=-1.0, person="ann", machine="cart"):
    return tried(number, value, person=person, machine=machine, time=1.0, x=x, y=y)


@pytest.mark.parametrize(("apart", "count"), [(0.5, 1), (1.5, 1), (1.99, 1), (2.01, 2), (5.0, 2)])
def test_situations_within_two_metres_are_one(apart, count):
    way = apart * math.cos(0.7), apart * math.sin(0.7)
    assert len(distinct([at(0, 0.0), at(1, *way)], [], 9)) == count
    assert len(distinct([at(0, 0.0), at(1, *way, person="bob")], [], 9)) == 2
    assert len(distinct([at(0, 0.0), at(1, *way, machine="fork")], [], 9)) == 2


def test_the_worst_of_similar_situations_are_chosen_up_to_a_number():
    all_of_it = [at(0, 0.0, value=-1.0), at(1, 1.0, value=-3.0), at(2, 9.0, value=-2.0)]
    assert [e.number for e in distinct(all_of_it, [], 9)] == [1, 2]
    assert [e.number for e in distinct(all_of_it, [], 1)] == [1]
    assert distinct(all_of_it, [], 0) == []
    same = [at(5, 0.0), at(4, 0.1)]
    assert [e.number for e in distinct(same, [], 9)] == [4]


def test_failures_are_one_if_their_messages_differ_in_numbers_only():
    errors = ["TypeError: at 1.5 s", "TypeError: at 20 s", "ValueError: at 1.5 s"]
    evaluations = [tried(k, result="error", error=text) for k, text in enumerate(errors)]
    assert [e.number for e in distinct(evaluations, [], 9)] == [0, 2]
    assert len(distinct([evaluations[0], at(7, 0.0)], [], 9)) == 2


@pytest.mark.parametrize(
    ("shares", "count"), [((0.5, 0.5), 2), ((0.2, 0.2), 1), ((0.0, 0.36), 2), ((0.0, 0.34), 1)]
)
def test_without_a_place_points_are_one_within_a_quarter_of_their_ranges(shares, count):
    dimensions = [Dimension("a", "a", 10.0, 20.0), Dimension("b", "b", -2.0, 2.0)]
    points = [{"a": 10.0, "b": -2.0}, {"a": 10.0 + 10 * shares[0], "b": -2.0 + 4 * shares[1]}]
    evaluations = [tried(k, -1.0, point=point) for k, point in enumerate(points)]
    assert len(distinct(evaluations, dimensions, 9)) == count


def test_without_a_place_different_words_are_different_points():
    dimensions = [Dimension("who", "who", values=("x", "y")), Dimension("b", "b", 0.0, 1.0)]
    points = [{"who": "x", "b": 0.0}, {"who": "y", "b": 0.0}, {"who": "x", "b": 0.1}]
    evaluations = [tried(k, -1.0, point=point) for k, point in enumerate(points)]
    assert [e.number for e in distinct(evaluations, dimensions, 9)] == [0, 1]


def test_an_evaluation_is_the_same_from_its_line():
    left = {
        "result": "run",
        "error": None,
        "value": -0.5,
        "worst.person": "ann",
        "worst.machine": None,
        "worst.time": 3.0,
        "worst.x": 1.0,
        "worst.y": 2.0,
        "figures": {"penalties": 3},
    }
    one = evaluation_of(4, {"a": 1.0}, {"a": 1.0, "at": (1, 2)}, left, is_random=False)
    assert (one.situation.person, one.situation.machine, one.situation.error) == ("ann", "", "")
    line = record(one, left)
    assert line["row"] == 4 and line["sampled"] == "sampler" and line["at"] == "1 2"
    assert line["penalties"] == 3 and line["value"] == -0.5 and line["error"] is None
    again = evaluation_of(4, {"a": 1.0}, {"a": 1.0, "at": (1, 2)}, line, is_random=False)
    assert again == one
    broken = failed(RuntimeError("so\n  it is"))
    assert (broken["result"], broken["error"]) == ("error", "RuntimeError: so it is")
    assert failed(OSError("gone"))["result"] == "no trial"


def test_the_bound_of_a_rate_is_that_of_the_binomial():
    for broken, count in ((0, 5), (1, 9), (3, 11), (7, 8)):
        rate = upper_bound(broken, count)
        at_most = sum(
            math.comb(count, k) * rate**k * (1 - rate) ** (count - k) for k in range(broken + 1)
        )
        assert at_most == pytest.approx(0.05, abs=1e-9)


# Dimensions.


def test_numbers_are_rounded_and_stay_within_their_dimension():
    narrow = Dimension("a", "a", 0.12345678, 0.12345699)
    for share in (0.0, 0.3, 1.0):
        assert narrow.low <= narrow.draw(share) <= narrow.high
    assert narrow.fault(narrow.draw(0.0)) == "" == narrow.fault(narrow.draw(1.0))
    wide = Dimension("a", "a", -1.0, 3.0)
    assert wide.rounded(0.12345678) == 0.123457
    assert [wide.rounded(x) for x in (-1.5, 3.5)] == [-1.0, 3.0]
    assert [wide.draw(k / 4) for k in range(5)] == [-1.0, 0.0, 1.0, 2.0, 3.0]
    assert [wide.share(x) for x in (-1.0, 1.0, 3.0)] == [0.0, 0.5, 1.0]
    assert Dimension("a", "a", 2.0, 2.0).share(2.0) == 0.0


def test_words_are_drawn_equally_often_and_have_equal_shares():
    words = Dimension("a", "a", values=("x", "y", "z"))
    assert [words.draw(share) for share in (0.0, 0.32, 0.34, 0.66, 0.67, 0.99, 1.0)] == [*"xxyyzzz"]
    assert [words.share(word) for word in "xyz"] == [0.0, 0.5, 1.0]
    assert words.fault("y") == "" and "one of x, y, z" in words.fault("w")
    assert Dimension("a", "a", values=("x",)).share("x") == 0.0


STUDY = """
name: worst
trials: [cell.trial.yaml]
grid: {duration: [2.0], people.operator.personality: [indifferent, antagonistic]}
random: {start_time: {uniform: [0.0, 1.0]}}
seed: 4
"""

CELL = """
name: cell
floorplan: ariac2023
duration: 2.0
people: [{name: operator}]
gantry: {controller: oblivious, jobs: [{wait: 1}]}
"""


@pytest.fixture
def study(tmp_path):
    (tmp_path / "cell.trial.yaml").write_text(CELL)
    (tmp_path / "worst.study.yaml").write_text(STUDY)
    return sim.Study.load(tmp_path / "worst.study.yaml")


def test_a_grid_of_one_value_is_no_dimension_but_counts(study):
    space = Space(study)
    assert [one.name for one in space.dimensions] == ["people.operator.personality", "start_time"]
    row = space.row(7, {"people.operator.personality": "antagonistic", "start_time": 0.5})
    assert row.trial.duration == 2.0 and row.trial.people[0].start.time == 0.5
    assert row.parameters["trial"] == "cell" and row.trial.seed == row.parameters["seed"]
    assert row.trial.seed != space.row(8, space.random_point(8)).trial.seed


def test_a_point_must_have_every_dimension_and_no_other(study):
    space = Space(study)
    point = {"people.operator.personality": "antagonistic", "start_time": 0.5}
    assert space.fault(point) == ""
    for wrong in ({}, {**point, "x": 1}, {"start_time": 0.5}, [1, 2]):
        assert "must have values for" in space.fault(wrong)
    assert space.fault({**point, "start_time": 1.5}).startswith("start_time must be a number")


# Minimising.


def test_cases_that_are_minimised_to_one_trial_are_one_case(study, tmp_path):
    results = sim.search(
        study,
        tmp_path / "out",
        minimise="penalties",
        below=9.0,
        evaluations=8,
        batch=4,
        cases=4,
        sampler="random",
        jobs=1,
    )
    trials = [replace(case.minimised.trial, name="") for case in results.cases]
    assert all(one not in trials[:k] for k, one in enumerate(trials))
    assert len({*(path.name for path in (tmp_path / "out/cases").glob("*.yaml"))}) == len(trials)
    assert len(trials) < len(distinct(results.broken, results.space.dimensions, 4))
    for case in results.cases:
        assert sim.run(sim.Trial.load(case.path)).summary["penalties"] == case.minimised.value < 9.0


WAITING = """
name: waiting
floorplan: ariac2023
duration: 40
rules: {{gantry_law: {{fixed: 3.0}}, machine: none, person: none}}
people: [{{name: ann, personality: external, at: [-5.0, 3.75], start: {{time: {start}}}}}]
gantry:
  controller: oblivious
  at: [-10.0, -3.0, 0.0]
  jobs:
  - {{move: [-12.0, -3.0, 0.0]}}
  - {{move: [-10.0, -3.0, 0.0]}}
  - {{move: [-12.0, -3.0, 0.0]}}
  - {{move: [-5.0, 3.0, 0.0]}}
"""


def minimised(text, **objective):
    return Minimiser(sim.Trial.parse(text), Objective(**objective)).minimised()


def test_a_wait_takes_the_place_of_jobs_that_only_take_time():
    whole = sim.run(sim.Trial.parse(WAITING.format(start=0)))
    done = [event["t"] for event in whole.events if event["kind"] == "job_done"]
    # Ann comes when the last move is well under way. With fewer jobs it ends before.
    text = WAITING.format(start=round(done[3] - 1.5, 2))
    small = minimised(text, minimise="least_margin_moving")
    kinds = [job.kind for job in small.trial.gantry.jobs]
    assert kinds[-1] == "move" and kinds.count("move") == 1 and len(kinds) <= 2
    assert small.value < 0.0
    assert sim.run(small.trial).summary["least_margin_moving"]["value"] == small.value


def test_a_minimised_trial_has_only_necessary_entries():
    text = """
name: much
floorplan: ariac2023
duration: 40
seed: 7
rules: {gantry_law: {fixed: 3.0}, machine: none, person: none}
people:
- {name: ann, personality: external, at: [-5.0, 3.75], max_speed: 1.23}
- {name: bob, personality: external, at: [-19.0, 8.0]}
gantry:
  controller: oblivious
  at: [-10.0, -3.0, 0.0]
  jobs: [{move: [-12.0, -3.0, 0.0]}, {move: [-5.0, 3.0, 0.0]}, {wait: 5}]
agvs: {agv1: [{time: 3, to: assembly_front}], agv2: [{time: 3, to: assembly_front}]}
blackouts: [{machine: gantry, start: {time: 1}, seconds: 2}]
commands: [{time: 2, hold: gantry}, {time: 3, release: gantry}]
"""
    small = minimised(text, minimise="least_margin_moving")
    trial = small.trial
    assert [person.name for person in trial.people] == ["ann"]
    assert [job.kind for job in trial.gantry.jobs] == ["move"]
    assert trial.agvs == {} and trial.blackouts == () and trial.commands == ()
    assert trial.seed == 0 and trial.people[0].max_speed != 1.23
    assert trial.duration < 40 and small.runs <= 100
    assert trial.expect == {"least_margin_moving": ">= 0"}
    assert sim.run(trial).summary["least_margin_moving"]["value"] == small.value < 0
