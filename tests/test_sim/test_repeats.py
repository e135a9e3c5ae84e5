"""Repeats of a study: identical ones, sequential stopping, and the number needed."""

import numpy as np
import pytest
from typer.testing import CliRunner

import sim
from sim.cli import app
from sim.studies.repeats import repetitions_needed

TRIAL = """
name: cell
floorplan: ariac2023
duration: 15.0
people: [{name: operator, personality: indifferent}]
gantry: {controller: parked, at: [-5.0, 2.5, 0.0]}
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "cell.trial.yaml").write_text(TRIAL)
    return tmp_path


def study(folder, text):
    path = folder / "some.study.yaml"
    path.write_text("trials: [cell.trial.yaml]\n" + text)
    return sim.Study.load(path)


def run(folder, text, out="out", **options):
    return sim.run_study(study(folder, text), folder / out, jobs=1, **options)


GRID = "grid: {personality: [indifferent, antagonistic]}\n"


def test_identical_repeats_are_counted_once_and_reported(folder):
    results = run(folder, GRID + "repeat: 4\n")
    compared = results.comparison
    assert len(results) == 8
    assert [(len(group.rows), group.repeats) for group in compared.groups] == [(1, 4), (1, 4)]
    assert compared.identical.startswith("The 4 repeats of 2 of 2 combinations are identical")
    assert compared.identical in (folder / "out/report.html").read_text()
    assert all(effect is None for one in results.contrasts for effect in one.effects.values())


def test_repeats_that_draw_something_are_all_counted(folder):
    drawn = "random: {people.operator.personality: {choice: [indifferent, helpful]}}\n"
    results = run(folder, drawn + "repeat: 4\n")
    assert [len(group.rows) for group in results.comparison.groups] == [4]
    assert results.comparison.identical == ""
    spread = "random: {max_speed: {uniform: [0.8, 1.2]}}\n"
    results = run(folder, GRID + spread + "repeat: 3\n", "other")
    assert [len(group.rows) for group in results.comparison.groups] == [3, 3]


def test_the_command_and_the_check_report_identical_repeats(folder, monkeypatch):
    monkeypatch.chdir(folder)
    study(folder, GRID + "repeat: 3\n")
    outcome = CliRunner().invoke(app, ["check", "some.study.yaml"])
    assert "nothing is drawn in `random`, so the 3 repeats" in outcome.output
    outcome = CliRunner().invoke(app, ["study", "some.study.yaml", "--jobs", "1"])
    assert "The 3 repeats of 2 of 2 combinations are identical" in outcome.output


UNTIL = GRID + "random: {max_speed: {uniform: [0.8, 1.2]}}\nrepeat: 12\nuntil: "


def test_a_study_ends_once_its_intervals_are_narrow(folder):
    figure = "people.operator.distance_walked"
    keys = f"{{width: 2.5, of: {figure}, at_least: 4}}"
    results = run(folder, UNTIL + keys)
    repetitions = len(results) // 2
    assert 4 <= repetitions < 12
    assert results.width(figure) <= 2.5
    # One repetition less is not enough, unless it is below the minimum.
    columns = {name: values[: len(results) - 2] for name, values in results.columns.items()}
    before = type(results)(results.study, results.folder, columns)
    assert repetitions == 4 or before.width(figure) > 2.5
    again = run(folder, UNTIL + keys)
    assert again.columns == results.columns
    whole = run(folder, UNTIL.removesuffix("until: "), "whole")
    assert {name: values[: len(results)] for name, values in whole.columns.items()} == (
        results.columns
    )


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("{width: 1.0, of: penaltys}", "until.of: a run has no such figure; .*penalties"),
        ("{width: 0, of: penalties}", "until.width"),
        ("{width: 1.0}", "until.of"),
        ("{width: 1.0, of: penalties, at_least: 1}", "until.at_least"),
        ("{width: 1.0, of: interrupted}", "until.of: a run has no such figure"),
    ],
)
def test_a_wrong_condition_is_rejected_with_its_place(folder, keys, message):
    with pytest.raises(sim.StudyError, match=f"line 5, {message}"):
        study(folder, UNTIL + keys)


def test_the_repetitions_needed_give_the_width():
    rng = np.random.default_rng(3)
    needed = repetitions_needed(rng.normal(scale=2.0, size=400).tolist(), 0.5)
    assert needed == pytest.approx((2 * 1.96 * 2.0 / 0.5) ** 2, rel=0.15)
    means = rng.normal(scale=2.0, size=(2000, needed)).mean(axis=1)
    assert np.mean(np.abs(means) <= 0.25) == pytest.approx(0.95, abs=0.03)


def test_the_number_of_repetitions_needs_two_values_and_a_width():
    with pytest.raises(ValueError, match="two values or more, not 1"):
        repetitions_needed([1.0], 0.5)
    with pytest.raises(ValueError, match="width must be more than 0, not 0"):
        repetitions_needed([1.0, 2.0], 0)
