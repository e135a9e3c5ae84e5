"""Worst-case search: what it finds, keeps, minimises and says; and what it rejects."""

import csv
import math
import random
from dataclasses import replace

import pytest
from typer.testing import CliRunner

import sim
from sim.cli import app
from sim.searches import Objective, Space, WorstCaseSearch, run_search
from sim.searches.evaluations import upper_bound
from sim.searches.minimising import Minimiser

CELL = """
name: cell
floorplan: ariac2023
duration: 40.0
rules: {machine: none, person: none}
people:
  - {name: operator, personality: indifferent}
  - {name: visitor, personality: helpful, start: {time: 30.25}}
gantry:
  controller: oblivious
  at: [-7.0, 0.0, 0.0]
  jobs:
    - {pick: bin2, place: agv1, part: purple pump}
    - {pick: bin6, place: agv4, part: blue battery}
    - {pick: bin3, place: agv2, part: green sensor}
agvs: {agv3: [{time: 39.0, to: assembly_front}]}
expect: {penalties: 0, jobs_done: ">= 3", people.operator.visits: {never: [station2]}}
"""

STUDY = """
name: worst
trials: [cell.trial.yaml]
random:
  start_time: {uniform: [0.0, 20.0]}
  people.operator.max_speed: {normal: [1.0, 0.2], within: [0.6, 1.4]}
  people.operator.personality: {choice: [indifferent, antagonistic]}
  gantry_at: {uniform: [[-14.0, -4.0, 0.0], [-2.5, 4.0, 0.0]]}
  job_order: shuffled
seed: 4
"""


@pytest.fixture
def cell(tmp_path):
    """A folder with a trial and a study."""
    (tmp_path / "cell.trial.yaml").write_text(CELL)
    (tmp_path / "worst.study.yaml").write_text(STUDY)
    return tmp_path


@pytest.fixture
def study(cell):
    return sim.Study.load(cell / "worst.study.yaml")


def found(study, out, *, jobs=1, evaluations=24, **given):
    given = {"minimise": "least_margin_moving", "sampler": "random", "cases": 0, **given}
    return sim.search(study, out, jobs=jobs, evaluations=evaluations, **given)


def controlled(study, name):
    """The study with another controller."""
    trials = [replace(one, gantry=replace(one.gantry, controller=name)) for one in study.trials]
    return replace(study, trials=tuple(trials))


def lines(folder):
    with (folder / "results.csv").open(newline="") as file:
        return [*csv.DictReader(file)]


# The space.


def test_every_random_point_is_within_its_dimensions_and_makes_a_trial(study):
    space = Space(study)
    names = [one.name for one in space.dimensions]
    assert names[:3] == ["start_time", "people.operator.max_speed", "people.operator.personality"]
    assert names[3:6] == ["gantry_at[0]", "gantry_at[1]", "gantry_at[2]"]
    assert names[6:] == ["job_order[0]", "job_order[1]", "job_order[2]"]
    for number in range(60):
        point = space.random_point(number)
        assert space.fault(point) == ""
        row = space.row(number, point)
        assert row.trial.people[0].max_speed == row.parameters["people.operator.max_speed"]
        assert sorted(row.parameters["job_order"]) == [0, 1, 2]
    assert space.random_point(3) == space.random_point(3) != space.random_point(4)


def test_a_normal_dimension_draws_its_distribution(study):
    space = Space(study)
    normal = space.dimensions[1]
    values = [normal.draw(k / 1000) for k in range(1, 1000)]
    assert values == sorted(values)
    assert abs(values[499] - 1.0) < 1e-6
    inside = sum(0.8 <= value <= 1.2 for value in values) / 999
    assert abs(inside - 0.6827 / 0.9545) < 0.01


def test_trials_and_values_of_the_grid_are_dimensions(study):
    other = replace(study.trials[0], name="other")
    space = Space(replace(study, trials=(*study.trials, other)))
    assert space.dimensions[0].values == ("cell", "other")
    point = {**space.random_point(0), "trial": "other"}
    assert space.row(0, point).trial.name == "other"


def test_a_study_in_which_nothing_varies_is_rejected(study):
    with pytest.raises(ValueError, match=r"nothing varies in the study 'worst'"):
        Space(replace(study, random={}))


# The search.


def test_a_search_is_the_same_on_any_number_of_processes(study, cell):
    one = found(study, cell / "one", sampler="tpe", cases=2)
    other = found(study, cell / "other", sampler="tpe", cases=2, jobs=2)
    assert (cell / "one/results.csv").read_bytes() == (cell / "other/results.csv").read_bytes()
    saved = [sorted((cell / name / "cases").glob("*.trial.yaml")) for name in ("one", "other")]
    assert [path.read_text() for path in saved[0]] == [path.read_text() for path in saved[1]]
    assert [case.evaluation for case in one.cases] == [case.evaluation for case in other.cases]
    assert saved[0]


def test_a_search_is_resumed_as_if_it_had_not_been_stopped(study, cell):
    whole = found(study, cell / "whole", sampler="tpe", evaluations=30)
    done = []

    def stop(now):
        done.append(now.done)
        if now.done == 24:
            raise KeyboardInterrupt

    part = found(study, cell / "part", sampler="tpe", evaluations=30, progress=stop)
    assert part.interrupted
    assert len(part) == 24
    rest = found(study, cell / "part", sampler="tpe", evaluations=30)
    assert not rest.interrupted
    assert rest.evaluations == whole.evaluations
    assert (cell / "part/results.csv").read_bytes() == (cell / "whole/results.csv").read_bytes()


def test_a_search_can_be_extended_but_not_changed(study, cell):
    found(study, cell / "out", sampler="tpe", evaluations=20)
    longer = found(study, cell / "out", sampler="tpe", evaluations=28)
    whole = found(study, cell / "new", sampler="tpe", evaluations=28)
    assert longer.evaluations == whole.evaluations
    with pytest.raises(OSError, match=r"another study .changed since: the search"):
        found(study, cell / "out", sampler="tpe", batch=4)


@pytest.mark.slow
def test_tpe_finds_less_than_random_trials(study, cell):
    both = [found(study, cell / name, sampler=name, evaluations=64) for name in ("random", "tpe")]
    chosen = [one.value for one in both[1].evaluations if not one.is_random]
    drawn = [one.value for one in both[0].evaluations if one.value is not None]
    assert sorted(chosen)[len(chosen) // 2] < sorted(drawn)[len(drawn) // 2]


def test_random_evaluations_are_those_of_the_first_batches_and_a_share_of_the_others(study):
    wanted = WorstCaseSearch(
        study=study, objective=Objective("penalties"), batch=8, random_share=0.25
    )
    assert [k for k in range(32) if wanted.is_random(k)] == [*range(16), 16, 17, 24, 25]


def test_the_table_has_what_was_tried_and_what_came_of_it(study, cell):
    results = found(study, cell / "out", slack="jobs_done", minimise="", evaluations=9)
    table = lines(cell / "out")
    assert [int(line["row"]) for line in table] == [*range(9)]
    for line, one in zip(table, results.evaluations, strict=True):
        assert float(line["value"]) == one.value == int(line["jobs_done"]) - 3
        assert line["result"] == "run"
        assert float(line["start_time"]) == one.values["start_time"]
        trial = results.space.row(one.number, one.point).trial
        assert sim.run(trial).summary["jobs_done"] == int(line["jobs_done"])


def test_the_report_shows_cases_objective_and_coverage(study, cell):
    results = found(study, cell / "out", cases=2)
    page = (cell / "out/report.html").read_text()
    assert results.worth in page
    assert "Coverage" in page
    assert page.count("<svg") == 2
    for case in results.cases:
        assert f"cases/{case.path.name}" in page
        assert case.replay.exists()


# Cases.


def test_cases_are_distinct_minimised_and_fail_by_themselves(study, cell):
    results = found(study, cell / "out", evaluations=40, cases=3)
    assert results.cases
    for case in results.cases:
        trial = sim.Trial.load(case.path)
        run = sim.run(trial)
        assert [one.met for one in run.verdicts] == [False]
        assert run.summary["least_margin_moving"]["value"] == case.minimised.value < 0
        assert len(trial.people) == 1
        assert len(trial.gantry.jobs) <= 2
        assert not trial.agvs
        assert trial.duration <= case.evaluation.situation.time + 2
        assert case.minimised.runs <= 100
        assert trial.people[0].start.time == round(trial.people[0].start.time, 2)
    situations = [case.evaluation.situation for case in results.cases]
    for k, one in enumerate(situations):
        for other in situations[:k]:
            alike = (one.person, one.machine) == (other.person, other.machine)
            assert not alike or math.dist((one.x, one.y), (other.x, other.y)) > 2.0


def test_a_minimised_case_fails_in_pytest(study, cell, pytester):
    results = found(study, cell / "out", cases=1)
    path = pytester.path / results.cases[0].path.name
    text = results.cases[0].path.read_text()
    path.write_text("\n".join(line for line in text.splitlines() if "folder:" not in line))
    outcome = pytester.runpytest_inprocess("-p", "no:xdist", "-o", "addopts=")
    outcome.assert_outcomes(failed=1)
    outcome.stdout.fnmatch_lines(["*expected: least_margin_moving >= 0", "*slack: *-*m"])


def test_work_that_is_to_be_done_is_not_minimised_away(cell):
    text = CELL.replace("duration: 40.0", "duration: 20.0")
    trial = sim.Trial.parse(text, folder=cell)
    small = Minimiser(trial, Objective(slack="jobs_done")).minimised()
    assert small.trial.duration == 20.0
    assert len(small.trial.gantry.jobs) == 3
    assert small.trial.expect == {"jobs_done": ">= 3"}


def test_a_trial_that_breaks_nothing_is_not_minimised(cell):
    trial = sim.Trial.parse(CELL.replace("oblivious", "parked"), folder=cell)
    assert Minimiser(trial, Objective("least_margin_moving")).minimised() is None


def test_an_expectation_over_time_is_an_objective(study, cell):
    trial = study.trials[0]
    timeline = [{"eventually": "job_done"}, {"never": "job_done", "after": 1}]
    changed = replace(study, trials=(replace(trial, expect={"timeline": timeline}),))
    results = found(changed, cell / "out", minimise="", slack="timeline.1", cases=1)
    assert results.broken
    assert sim.Trial.load(results.cases[0].path).expect == {"timeline": [timeline[1]]}


# What a search is worth.


@pytest.mark.parametrize("count", [1, 7, 60])
def test_the_bound_of_a_rate_of_none_is_that_of_the_rule_of_three(count):
    assert upper_bound(0, count) == pytest.approx(1 - 0.05 ** (1 / count), rel=1e-9)
    assert upper_bound(count, count) == 1.0


def test_the_bound_holds_as_often_as_it_says():
    rng = random.Random(0)
    count, rate, missed = 40, 0.1, 0
    for _ in range(4000):
        missed += upper_bound(sum(rng.random() < rate for _ in range(count)), count) < rate
    assert missed / 4000 <= 0.06


def test_a_search_in_which_nothing_breaks_says_what_that_is_worth(study, cell):
    results = found(study, cell / "out", below=-100.0, sampler="tpe", evaluations=40)
    assert not results.broken
    assert results.rate == (0, 22, upper_bound(0, 22))
    assert results.worth == (
        "Of 22 random trials none broke: with 95 % confidence at most 13 % of the trials of this"
        " study break. The other 18 were chosen by the sampler and carry no rate."
    )


# Bad input.


def test_points_that_make_no_trial_are_listed_and_the_search_continues(study, cell):
    name = "people.operator.at"
    trial = replace(
        study.trials[0],
        people=tuple(replace(one, at=(-5.0, 3.75)) for one in study.trials[0].people[:1]),
    )
    text = STUDY.replace(
        "gantry_at: {uniform: [[-14.0, -4.0, 0.0], [-2.5, 4.0, 0.0]]}",
        f"{name}: {{uniform: [[-15.0, -10.0], [-5.0, 3.75]]}}",
    )
    (cell / "cell.trial.yaml").write_text(trial.to_yaml(cell))
    (cell / "blocked.study.yaml").write_text(text)
    results = found(sim.Study.load(cell / "blocked.study.yaml"), cell / "out")
    none = results.no_trial
    assert 0 < len(none) < len(results) == 24
    assert any(f"{len(none)} of 24 points make no trial" in notice for notice in results.notices)
    assert "Points that make no trial" in (cell / "out/report.html").read_text()
    assert {line["result"] for line in lines(cell / "out")} == {"run", "no trial"}


def test_an_objective_that_never_changes_is_reported(study, cell):
    results = found(study, cell / "out", minimise="agv_teleports")
    assert results.notices == ("agv_teleports is 0 in all 24 runs: nothing guides the search",)


def test_an_objective_that_no_run_has_ends_the_search_after_the_first_batch(study, cell):
    (cell / "cell.trial.yaml").write_text(CELL.replace("oblivious", "parked"))
    parked = sim.Study.load(cell / "worst.study.yaml")
    parked = replace(parked, trials=tuple(replace(one, agvs={}) for one in parked.trials))
    with pytest.raises(ValueError, match="no run of the first batch has a number for least_margin"):
        found(parked, cell / "out")
    assert len(lines(cell / "out")) == 8


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"minimise": "leest_margin"}, "no figure 'leest_margin'; .*least_margin"),
        ({"minimise": "people.operator.visits"}, "people.operator.visits is a list of visits"),
        ({"minimise": "people.operator.personality"}, "no figure 'people.operator.personality'"),
        ({"minimise": "", "slack": "penalty"}, "expects nothing of 'penalty'; .*penalties"),
        ({"minimise": ""}, "a search needs one objective"),
        ({"slack": "penalties"}, "a search needs one objective"),
        ({"below": "0"}, "below must be a number, not '0'"),
        ({"evaluations": 0}, "evaluations must be a whole number of at least 1, not 0"),
        ({"batch": 2.5}, "batch must be a whole number of at least 1, not 2.5"),
        ({"random_share": 1.5}, "random_share must be from 0 to 1, not 1.5"),
        ({"sampler": "cmaes"}, "no sampler is called 'cmaes'; .*tpe.*random"),
        ({"sampler": "mine:Sampler"}, "mine:Sampler"),
    ],
)
def test_a_wrong_argument_gives_one_message(study, cell, given, message):
    with pytest.raises(ValueError, match=message):
        found(study, cell / "out", **given)


def sampler(ask, tell=lambda points, values: None):
    """A class of samplers with these methods."""

    class Custom:
        def __init__(self, dimensions, seed):
            self.dimensions = dimensions

        def ask(self, count):
            return ask(self, count)

        def tell(self, points, values):
            tell(points, values)

    return Custom


def low(self, count):
    return [{d.name: d.values[0] if d.values else d.low for d in self.dimensions}] * count


def test_a_custom_sampler_is_asked_and_told(study, cell):
    told = []
    custom = sampler(low, lambda points, values: told.append((len(points), values)))
    results = found(study, cell / "out", sampler=custom)
    assert [count for count, _ in told] == [8, 8, 8]
    assert told[2][1][:2] == [one.value for one in results.evaluations[16:18]]
    assert {one.values["start_time"] for one in results.evaluations if not one.is_random} == {0.0}


def test_a_custom_sampler_is_named_in_a_file(study, cell):
    (cell / "mine.py").write_text(
        "class Lowest:\n"
        "    def __init__(self, dimensions, seed):\n"
        "        self.dimensions = dimensions\n"
        "    def ask(self, count):\n"
        "        return [{d.name: d.values[0] if d.values else d.low for d in self.dimensions}]"
        " * count\n"
        "    def tell(self, points, values):\n"
        "        pass\n"
    )
    results = found(study, cell / "out", sampler="mine:Lowest")
    assert results.sampler == "mine:Lowest"
    assert {one.values["start_time"] for one in results.evaluations if not one.is_random} == {0.0}


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda self, count: None, "Custom must return a list, not None"),
        (lambda self, count: low(self, count - 1), "Custom must return 6 points, not 5"),
        (lambda self, count: [{"x": 1}] * count, "a point must have values for start_time"),
        (
            lambda self, count: [{**low(self, 1)[0], "start_time": 99.0}] * count,
            "start_time must be a number from 0 to 20, not 99.0",
        ),
        (
            lambda self, count: [{**low(self, 1)[0], "start_time": math.nan}] * count,
            "start_time must be a number from 0 to 20, not nan",
        ),
        (
            lambda self, count: [{**low(self, 1)[0], "people.operator.personality": 7}] * count,
            "people.operator.personality must be one of indifferent, antagonistic, not 7",
        ),
        (lambda self, count: 1 / 0, "Custom failed: ZeroDivisionError: division by zero"),
    ],
)
def test_a_sampler_that_returns_nonsense_is_rejected(study, cell, ask, message):
    with pytest.raises(ValueError, match=message):
        found(study, cell / "out", sampler=sampler(ask))


def test_a_sampler_that_is_no_class_with_its_methods_is_rejected(study, cell):
    with pytest.raises(ValueError, match="has no method ask"):
        found(study, cell / "out", sampler=lambda dimensions, seed: object())


def test_a_sampler_that_asks_otherwise_is_not_resumed(study, cell):
    found(study, cell / "out", sampler=sampler(low), evaluations=20)

    def high(self, count):
        return [{d.name: d.values[0] if d.values else d.high for d in self.dimensions}] * count

    with pytest.raises(ValueError, match=r"can't be resumed: .* asks for start_time 20"):
        found(study, cell / "out", sampler=sampler(high), evaluations=24)


def test_a_controller_that_raises_is_found_and_minimised(study, cell):
    (cell / "broken.py").write_text(
        "def broken(gantry):\n"
        "    task = yield gantry.next_task()\n"
        "    yield gantry.wait(7.0)\n"
        "    if gantry.position[0] > -9.0:\n"
        "        raise RuntimeError('east')\n"
    )
    (cell / "cell.trial.yaml").write_text(CELL.replace("oblivious", "broken:broken"))
    results = found(sim.Study.load(cell / "worst.study.yaml"), cell / "out", cases=3)
    errors = [one for one in results.evaluations if one.result == "error"]
    assert 0 < len(errors) < 24
    assert "RuntimeError: east" in errors[0].situation.error
    case = results.cases[0]
    assert case.evaluation.result == "error"
    trial = sim.Trial.load(case.path)
    assert trial.duration <= 10.0
    with pytest.raises(ValueError, match="RuntimeError: east"):
        sim.run(trial)
    assert case.replay.exists()


# The command.


def test_the_command_searches_and_exits_with_1_if_a_trial_breaks(cell, monkeypatch):
    monkeypatch.chdir(cell)
    (cell / "worst.study.yaml").write_text(
        STUDY
        + "search: {minimise: least_margin_moving, sampler: random, evaluations: 16, cases: 1}"
    )
    outcome = CliRunner().invoke(app, ["search", "worst.study.yaml", "--jobs", "1"])
    assert outcome.exit_code == 1
    assert "of 16 evaluations broke least_margin_moving" in outcome.output
    assert "searches/worst/cases/worst-1.trial.yaml: 1 person" in outcome.output
    assert "random trials" in outcome.output
    met = ["--minimise", "jobs_done", "--evaluations", "8", "--out", "other", "--jobs", "1"]
    outcome = CliRunner().invoke(app, ["search", "worst.study.yaml", *met])
    assert outcome.exit_code == 0
    assert "nothing broke jobs_done" in outcome.output


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("search: {minimize: penalties}", "search.minimize"),
        ("search: {evaluations: 0}", "search.evaluations"),
        ("search: {random_share: 2}", "search.random_share"),
        ("search: 3", "search"),
    ],
)
def test_wrong_keys_of_a_search_are_rejected_with_their_place(cell, keys, message):
    (cell / "worst.study.yaml").write_text(STUDY + keys)
    with pytest.raises(sim.StudyError, match=rf"line 11, {message}"):
        sim.Study.load(cell / "worst.study.yaml")


def test_run_search_runs_what_is_given(study, cell):
    wanted = WorstCaseSearch(
        study=study, objective=Objective("penalties"), sampler="random", evaluations=8
    )
    assert len(run_search(wanted, cell / "out", jobs=1)) == 8
