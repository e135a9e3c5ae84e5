"""Worst-case search: its results, cases, minimised trials, messages and errors."""

import csv
import math
from dataclasses import replace
from itertools import pairwise

import pytest
from typer.testing import CliRunner

import sim
from sim.cli import app
from sim.searches import Objective, Space, WorstCaseSearch, run_search
from sim.searches.evaluations import upper_bound
from sim.searches.minimising import Minimiser
from sim.searches.report import write_report
from sim.searches.results import Case

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


SHORT = """
name: cell
floorplan: ariac2023
duration: 3.0
people: [{name: operator}]
gantry:
  controller: oblivious
  jobs: [{pick: bin2, place: agv1, part: pump}, {pick: bin6, place: agv4, part: battery}]
"""

SHORT_STUDY = """
name: worst
trials: [cell.trial.yaml]
random:
  start_time: {uniform: [0.0, 2.0]}
  people.operator.personality: {choice: [indifferent, antagonistic]}
seed: 4
"""

SEARCHED = {"sampler": "tpe", "evaluations": 12, "batch": 4, "cases": 2}
"""Options of the search that several tests use."""


def written(folder, trial, study):
    """Return a folder with a trial and a study."""
    (folder / "cell.trial.yaml").write_text(trial)
    (folder / "worst.study.yaml").write_text(study)
    return folder


@pytest.fixture
def cell(tmp_path):
    return written(tmp_path, CELL, STUDY)


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    return sim.Study.load(
        written(tmp_path_factory.mktemp("study"), CELL, STUDY) / "worst.study.yaml"
    )


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """A study of trials of three seconds."""
    folder = written(tmp_path_factory.mktemp("short"), SHORT, SHORT_STUDY)
    return sim.Study.load(folder / "worst.study.yaml")


@pytest.fixture(scope="module")
def searched(study):
    """Results of the search on one process, in the folder `out` beside the study."""
    return results_of(study, study.folder / "out", **SEARCHED)


USUAL = {"minimise": "least_margin_moving", "sampler": "random", "cases": 0, "batch": 4}


def results_of(study, out, *, jobs=1, evaluations=8, **options):
    return sim.search(study, out, jobs=jobs, evaluations=evaluations, **(USUAL | options))


def controlled(study, name):
    """Return the study with another controller."""
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
    for number in range(20):
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


def assert_same(results, others):
    """Check that the table, the cases and the evaluations of two searches are the same."""
    assert results.evaluations == others.evaluations
    assert [case.evaluation for case in results.cases] == [case.evaluation for case in others.cases]
    files = [f"cases/{case.path.name}" for case in results.cases]
    assert files
    for file in ("results.csv", *files):
        assert (results.folder / file).read_bytes() == (others.folder / file).read_bytes()


def test_a_search_that_was_stopped_and_resumed_on_two_processes_is_the_same(searched, study):
    done, out = [], study.folder / "part"

    def stop(now):
        done.append(now.done)
        if now.done == 8:
            raise KeyboardInterrupt

    part = results_of(study, out, progress=stop, **SEARCHED)
    assert part.interrupted
    assert done == [4, 8]
    assert part.evaluations == searched.evaluations[:8]
    rest = results_of(study, out, jobs=2, **SEARCHED)
    assert not rest.interrupted
    assert_same(rest, searched)


@pytest.mark.slow
@pytest.mark.parametrize(("backend", "jobs"), [("loky", 2), ("dask", 1), ("dask", 2)])
def test_a_search_is_the_same_on_any_number_of_processes(searched, study, backend, jobs):
    out = study.folder / f"{backend}-{jobs}"
    assert_same(results_of(study, out, jobs=jobs, backend=backend, **SEARCHED), searched)


def test_a_search_can_be_extended_but_not_changed(short, tmp_path):
    keys = {**SEARCHED, "cases": 0}
    results_of(short, tmp_path / "out", **{**keys, "evaluations": 6})
    longer = results_of(short, tmp_path / "out", **{**keys, "evaluations": 10})
    assert longer.evaluations == results_of(short, tmp_path / "whole", **keys).evaluations[:10]
    with pytest.raises(OSError, match=r"another study .changed since: the search"):
        results_of(short, tmp_path / "out", **{**keys, "batch": 3})


@pytest.mark.slow
def test_tpe_finds_less_than_random_trials(study, cell):
    both = [
        results_of(study, cell / name, sampler=name, evaluations=64) for name in ("random", "tpe")
    ]
    chosen = [one.value for one in both[1].evaluations if not one.is_random]
    drawn = [one.value for one in both[0].evaluations if one.value is not None]
    assert sorted(chosen)[len(chosen) // 2] < sorted(drawn)[len(drawn) // 2]


def test_the_first_batches_and_a_share_of_the_others_are_random(study):
    wanted = WorstCaseSearch(
        study=study, objective=Objective("penalties"), batch=8, random_share=0.25
    )
    assert [k for k in range(32) if wanted.is_random(k)] == [*range(16), 16, 17, 24, 25]


def test_the_table_has_the_values_and_results_of_evaluations(searched):
    table = lines(searched.folder)
    assert [int(line["row"]) for line in table] == [*range(12)]
    for line, one in zip(table, searched.evaluations, strict=True):
        assert line["sampled"] == ("random" if one.is_random else "sampler")
        assert line["result"] == "run"
        assert float(line["value"]) == one.value == float(line["least_margin_moving.value"])
        assert float(line["start_time"]) == one.values["start_time"]
    for one in searched.evaluations[3::6]:
        trial = searched.space.row(one.number, one.point).trial
        assert sim.run(trial).summary["least_margin_moving"]["value"] == one.value


def test_the_slack_of_an_expectation_is_an_objective(short, tmp_path):
    expecting = (replace(short.trials[0], expect={"jobs_done": ">= 3"}),)
    keys = {"slack": "jobs_done", "minimise": "", "evaluations": 4}
    results = results_of(replace(short, trials=expecting), tmp_path / "out", **keys)
    for line, one in zip(lines(tmp_path / "out"), results.evaluations, strict=True):
        assert float(line["value"]) == one.value == int(line["jobs_done"]) - 3


def test_the_report_shows_cases_objective_and_coverage(searched):
    page = (searched.folder / "report.html").read_text()
    assert searched.worth in page
    assert "Coverage" in page
    assert page.count("<svg") == 2
    for case in searched.cases:
        assert f"cases/{case.path.name}" in page
        assert case.replay.exists()


# Cases.


def test_cases_are_distinct_minimised_and_fail_alone(searched):
    # Cases that are minimised to the same trial are one.
    assert len(searched.cases) in (1, 2)
    for case in searched.cases:
        trial = sim.Trial.load(case.path)
        run = sim.run(trial)
        assert [one.met for one in run.verdicts] == [False]
        assert run.summary["least_margin_moving"]["value"] == case.minimised.value < 0
        assert len(trial.people) == 1
        assert len(trial.gantry.jobs) <= 2
        assert not trial.agvs
        assert trial.duration <= case.evaluation.situation.time + 2
        assert case.minimised.runs <= 200
        assert trial.people[0].start.time == round(trial.people[0].start.time, 2)
    for one, other in pairwise(case.evaluation.situation for case in searched.cases):
        alike = (one.person, one.machine) == (other.person, other.machine)
        assert not alike or math.dist((one.x, one.y), (other.x, other.y)) > 2.0


def test_a_case_names_its_evaluation_and_its_replay(searched):
    case = searched.cases[0]
    comments = [line for line in case.path.read_text().splitlines() if line.startswith("#")]
    assert comments == [
        f"# Minimised from evaluation {case.evaluation.number} of the search 'worst':",
        f"# least_margin_moving −{-case.minimised.value:.3f},"
        f" before minimising −{-case.evaluation.value:.3f}",
        "# Replay: worst-1.html. Film: floorwalker render worst-1.trial.yaml --out worst-1.mp4",
    ]


def test_a_minimised_case_fails_in_pytest(searched, pytester):
    path = pytester.path / searched.cases[0].path.name
    text = searched.cases[0].path.read_text()
    path.write_text("\n".join(line for line in text.splitlines() if "folder:" not in line))
    outcome = pytester.runpytest_inprocess("-p", "no:xdist", "-o", "addopts=")
    outcome.assert_outcomes(failed=1)
    outcome.stdout.fnmatch_lines(["*expected: least_margin_moving >= 0", "*slack: *-*m"])


def test_expected_work_is_not_minimised_away(cell):
    text = CELL.replace("duration: 40.0", "duration: 20.0")
    trial = sim.Trial.parse(text, folder=cell)
    small = Minimiser(trial, Objective(slack="jobs_done")).minimised()
    assert small.trial.duration == 20.0
    assert len(small.trial.gantry.jobs) == 3
    assert small.trial.expect == {"jobs_done": ">= 3"}


def test_a_trial_that_breaks_nothing_is_not_minimised(cell):
    trial = sim.Trial.parse(CELL.replace("oblivious", "parked"), folder=cell)
    assert Minimiser(trial, Objective("least_margin_moving")).minimised() is None


HALL = """
floorplan:
  boundary: [[0, 0], [18, 0], [18, 11], [0, 11]]
  stations: {a: [2, 5], b: [16, 5]}
  safe_zone: {at: [9, 5]}
duration: 60
seed: 3
rules: {based_on: observe, between: surfaces, agv_law: {fixed: 4}}
people:
  - {name: ann, at: [14, 8], personality: curious, start: {time: 7.5}, beliefs: [pause(3)]}
  - {name: bob, at: [4, 9], manners: {patience: 4}}
machines:
  v: {kind: amr, at: [3, 2, 0], size: [1.6, 0.8], max_turn_speed: 0.8, max_jerk: 2.5,
      controller: oblivious, missions: [{go: [15, 2.5]}, {go: [14, 8]}, {go: [3, 2]}],
      repeat: true}
  w: {kind: amr, at: [16, 9.5, 0], missions: [{wait: 5}]}
fields: {w: {sets: [{name: all, protective: [[2, 2], [-2, 2], [-2, -2], [2, -2]]}]}}
work: {}
expect: {contacts: 0}
"""


def test_every_key_that_a_break_does_not_need_is_omitted():
    trial = sim.Trial.parse(HALL)
    small = Minimiser(trial, Objective("least_margin_moving")).minimised()
    (person,) = small.trial.people
    assert replace(person, at=None) == sim.PersonEntry(person.name)
    assert small.trial.machines.keys() == {"v"}
    keys = small.trial.machines["v"].keys
    assert keys.keys() == {"at", "controller", "missions"}
    assert len(keys["missions"]) == 1
    assert not small.trial.fields and small.trial.seed == 0
    text = small.trial.to_yaml()
    again = sim.run(sim.Trial.parse(text))
    assert again.summary["least_margin_moving"]["value"] == small.value < 0


def test_a_trial_with_too_many_contacts_ends_soon_after_the_first():
    # A person on the path of the vehicle is run over again and again.
    eve = "people:\n  - {name: eve, at: [5, 2.2], personality: external, max_speed: 0.1}"
    there_and_back = "{go: [7, 2.2]}, {go: [3, 2.2]}"
    text = HALL.replace("people:", eve).replace("duration: 60", "duration: 13")
    text = text.replace("{go: [15, 2.5]}, {go: [14, 8]}, {go: [3, 2]}", there_and_back)
    trial = sim.Trial.parse(text)
    run = sim.run(trial)
    assert run.summary["contacts"] > 1
    small = Minimiser(trial, Objective(slack="contacts")).minimised().trial
    assert sim.run(small).summary["contacts"] >= 1
    shorter = replace(small, duration=small.duration - 2.0)
    assert sim.run(shorter).summary["contacts"] == 0


def test_a_case_that_is_not_saved_is_not_listed_as_a_test(searched, tmp_path):
    unsaved = tuple(Case(case.evaluation) for case in searched.cases)
    write_report(replace(searched, cases=unsaved), tmp_path / "report.html")
    for folder, is_saved in ((searched.folder, True), (tmp_path, False)):
        page = (folder / "report.html").read_text()
        assert ("in pytest" in page) == is_saved
        assert ("not saved" in page) != is_saved


def test_an_expectation_over_time_is_an_objective(short, tmp_path):
    timeline = [{"eventually": "human_started"}, {"never": "goal", "after": 1}]
    changed = replace(short, trials=(replace(short.trials[0], expect={"timeline": timeline}),))
    wanted = {"minimise": "", "slack": "timeline.1", "evaluations": 4, "cases": 1}
    results = results_of(changed, tmp_path / "out", **wanted)
    assert results.broken
    assert sim.Trial.load(results.cases[0].path).expect == {"timeline": [timeline[1]]}


# Bounds on the rate of failures.


@pytest.mark.parametrize("count", [1, 7, 60])
def test_the_bound_of_a_rate_of_none_is_that_of_the_rule_of_three(count):
    assert upper_bound(0, count) == pytest.approx(1 - 0.05 ** (1 / count), rel=1e-9)
    assert upper_bound(count, count) == 1.0


def test_the_bound_holds_as_often_as_stated():
    count = 40
    bounds = [upper_bound(k, count) for k in range(count + 1)]
    for rate in (0.01, 0.1, 0.5, 0.93):
        missed = sum(
            math.comb(count, k) * rate**k * (1 - rate) ** (count - k)
            for k, bound in enumerate(bounds)
            if bound < rate
        )
        assert missed <= 0.05, rate


def test_a_search_in_which_nothing_breaks_states_an_upper_bound(short, tmp_path):
    results = results_of(short, tmp_path / "out", below=-100.0, sampler="tpe", evaluations=20)
    assert not results.broken
    assert results.rate == (0, 11, upper_bound(0, 11))
    assert results.worth == (
        "Of 11 random trials none broke: with 95 % confidence at most 24 % of the trials of this"
        " study break. The other 9 were chosen by the sampler and carry no rate."
    )


# Bad input.


def test_points_that_make_no_trial_are_listed_and_the_search_continues(tmp_path):
    trial = SHORT.replace("{name: operator}", "{name: operator, at: [-5.0, 3.75]}")
    at = "people.operator.at: {uniform: [[-15.0, -10.0], [-5.0, 3.75]]}"
    written(tmp_path, trial, SHORT_STUDY.replace("seed:", f"  {at}\nseed:"))
    results = results_of(
        sim.Study.load(tmp_path / "worst.study.yaml"), tmp_path / "out", evaluations=12
    )
    none = results.no_trial
    assert 0 < len(none) < len(results) == 12
    assert any(f"{len(none)} of 12 points make no trial" in notice for notice in results.notices)
    assert "Points that make no trial" in (tmp_path / "out/report.html").read_text()
    assert {line["result"] for line in lines(tmp_path / "out")} == {"run", "no trial"}


def test_an_objective_that_never_changes_is_reported(short, tmp_path):
    results = results_of(short, tmp_path / "out", minimise="agv_teleports")
    assert results.notices == ("agv_teleports is 0 in all 8 runs: nothing guides the search",)


def test_an_objective_that_no_run_has_ends_the_search_after_the_first_batch(tmp_path):
    written(tmp_path, SHORT.replace("oblivious", "parked"), SHORT_STUDY)
    parked = sim.Study.load(tmp_path / "worst.study.yaml")
    with pytest.raises(ValueError, match="no run of the first batch has a number for least_margin"):
        results_of(parked, tmp_path / "out")
    assert len(lines(tmp_path / "out")) == 4


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"minimise": "leest_margin"}, "no figure 'leest_margin'; .*least_margin"),
        ({"minimise": "leest"}, r"no figure 'leest'; there are: [a-z_, ]+\Z"),
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
def test_a_wrong_argument_gives_one_message(study, cell, arguments, message):
    with pytest.raises(ValueError, match=message):
        results_of(study, cell / "out", **arguments)


def sampler(ask, tell=lambda points, values: None):
    """Return a class of samplers with these methods."""

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


def test_a_custom_sampler_proposes_points_and_receives_values(short, tmp_path):
    received = []
    custom = sampler(low, lambda points, values: received.append((len(points), values)))
    results = results_of(short, tmp_path / "out", sampler=custom, evaluations=12)
    assert [count for count, _ in received] == [4, 4, 4]
    assert received[2][1] == [one.value for one in results.evaluations[8:]]
    assert {one.values["start_time"] for one in results.evaluations if not one.is_random} == {0.0}


def test_a_custom_sampler_is_named_in_a_file(short, tmp_path):
    (tmp_path / "mine.py").write_text(
        "class Lowest:\n"
        "    def __init__(self, dimensions, seed):\n"
        "        self.dimensions = dimensions\n"
        "    def ask(self, count):\n"
        "        return [{d.name: d.values[0] if d.values else d.low for d in self.dimensions}]"
        " * count\n"
        "    def tell(self, points, values):\n"
        "        pass\n"
    )
    own = replace(short, folder=tmp_path)
    results = results_of(own, tmp_path / "out", sampler="mine:Lowest", evaluations=12)
    assert results.sampler == "mine:Lowest"
    assert {one.values["start_time"] for one in results.evaluations if not one.is_random} == {0.0}


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda self, count: None, "Custom must return a list, not None"),
        (lambda self, count: low(self, count - 1), "Custom must return 3 points, not 2"),
        (lambda self, count: [{"x": 1}] * count, "a point must have values for start_time"),
        (
            lambda self, count: [{**low(self, 1)[0], "start_time": 99.0}] * count,
            "start_time must be a number from 0 to 2, not 99.0",
        ),
        (
            lambda self, count: [{**low(self, 1)[0], "start_time": math.nan}] * count,
            "start_time must be a number from 0 to 2, not nan",
        ),
        (
            lambda self, count: [{**low(self, 1)[0], "people.operator.personality": 7}] * count,
            "people.operator.personality must be one of indifferent, antagonistic, not 7",
        ),
        (lambda self, count: 1 / 0, "Custom failed: ZeroDivisionError: division by zero"),
    ],
)
def test_a_sampler_that_returns_nonsense_is_rejected(short, tmp_path, ask, message):
    with pytest.raises(ValueError, match=message):
        results_of(short, tmp_path / "out", sampler=sampler(ask), evaluations=12)


def test_a_sampler_that_is_no_class_with_its_methods_is_rejected(short, tmp_path):
    with pytest.raises(ValueError, match="has no method ask"):
        results_of(short, tmp_path / "out", sampler=lambda dimensions, seed: object())


def test_a_search_with_a_changed_custom_sampler_is_not_resumed(short, tmp_path):
    results_of(short, tmp_path / "out", sampler=sampler(low), evaluations=10)

    def high(self, count):
        return [{d.name: d.values[0] if d.values else d.high for d in self.dimensions}] * count

    with pytest.raises(ValueError, match=r"can't be resumed: .* asks for start_time 2"):
        results_of(short, tmp_path / "out", sampler=sampler(high), evaluations=12)


def test_an_error_of_a_controller_is_minimised(tmp_path):
    (tmp_path / "broken.py").write_text(
        "def broken(gantry):\n"
        "    task = yield gantry.next_task()\n"
        "    yield gantry.wait(2.0)\n"
        "    if gantry.position[0] > -9.0:\n"
        "        raise RuntimeError('east')\n"
    )
    trial = SHORT.replace("oblivious", "broken:broken\n  at: [-7.0, 0.0, 0.0]")
    at = "gantry_at: {uniform: [[-14.0, -4.0, 0.0], [-2.5, 4.0, 0.0]]}"
    written(tmp_path, trial, SHORT_STUDY.replace("seed:", f"  {at}\nseed:"))
    results = results_of(sim.Study.load(tmp_path / "worst.study.yaml"), tmp_path / "out", cases=3)
    errors = [one for one in results.evaluations if one.result == "error"]
    assert 0 < len(errors) < 8
    assert "RuntimeError: east" in errors[0].situation.error
    (case,) = results.cases
    assert case.evaluation.result == "error"
    trial = sim.Trial.load(case.path)
    assert (len(trial.people), len(trial.gantry.jobs)) == (1, 0)
    with pytest.raises(ValueError, match="RuntimeError: east"):
        sim.run(trial)
    assert case.replay.exists()


# The command.


def test_the_command_searches_and_exits_with_1_if_a_trial_breaks(tmp_path, monkeypatch):
    monkeypatch.chdir(written(tmp_path, SHORT, SHORT_STUDY))
    keys = "{minimise: least_margin_moving, below: 100, sampler: random, evaluations: 8, cases: 1}"
    (tmp_path / "worst.study.yaml").write_text(SHORT_STUDY + f"search: {keys}")
    outcome = CliRunner().invoke(app, ["search", "worst.study.yaml", "--jobs", "1"])
    assert outcome.exit_code == 1
    assert "of 8 evaluations broke least_margin_moving" in outcome.output
    assert "searches/worst/cases/worst-1.trial.yaml: 1 person" in outcome.output
    assert "random trials" in outcome.output
    met = ["--minimise", "jobs_done", "--evaluations", "2", "--out", "other", "--jobs", "1"]
    outcome = CliRunner().invoke(app, ["search", "worst.study.yaml", *met])
    assert outcome.exit_code == 0
    assert "nothing broke jobs_done" in outcome.output


def test_columns_that_do_not_fit_are_left_to_the_report(tmp_path, monkeypatch):
    monkeypatch.chdir(written(tmp_path, SHORT, SHORT_STUDY))
    monkeypatch.setattr("sim.commands.search.WIDTH", 40)
    keys = ["--minimise", "penalties", "--sampler", "random", "--evaluations", "4", "--jobs", "1"]
    lines = CliRunner().invoke(app, ["search", "worst.study.yaml", *keys]).output.splitlines()
    (header,) = (line for line in lines if "Value" in line)
    assert header.replace("┃", "|").split("|")[1:-1] == [" No. ", " Value ", " start_time "]
    assert "Only in the report: people.operator.personality" in lines


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


def test_run_search_runs_a_prepared_search(short, tmp_path):
    wanted = WorstCaseSearch(
        study=short, objective=Objective("penalties"), sampler="random", evaluations=4
    )
    assert len(run_search(wanted, tmp_path / "out", jobs=1)) == 4
