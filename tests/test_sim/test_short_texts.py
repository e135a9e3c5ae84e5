"""Public values have short texts in Python, and tables in notebooks."""

import re

import pytest

import sim


@pytest.fixture(scope="module")
def values(tmp_path_factory):
    trial = sim.Trial.load("workcell")
    run = sim.run(sim.Trial.load("ariac2023"))
    study = sim.Study.parse("{trials: [ariac2023], grid: {personality: [helpful, curious]}}")
    results = sim.run_study(study, tmp_path_factory.mktemp("study"), jobs=1)
    shapes = [*run.scene.machines, *run.scene.people, run.scene]
    entries = [*trial.people, trial.gantry, *trial.gantry.jobs, trial.rules]
    return [trial, run, study, results, results.comparison, *shapes, *entries]


def test_texts_of_values_are_short(values):
    for value in values:
        assert len(repr(value)) < 450, repr(value)


def test_a_text_names_values_other_than_defaults():
    entry = sim.PersonEntry("eve", at=(1.0, 2.0), beliefs=("x" * 100,))
    text = repr(entry)
    assert text.startswith("PersonEntry(name='eve', at=(1.0, 2.0), beliefs=('xxx")
    assert "…" in text and "personality" not in text
    assert repr(sim.Start(time=3.0)) == "Start(time=3.0)"


def test_trials_and_results_are_tables_in_notebooks(values):
    trial, _, study, results = values[:4]
    page = trial._repr_html_()
    for words in ("workcell", "180 s", "ada", "avoiding"):
        assert words in page
    page = results._repr_html_()
    rows = re.findall(r"<tr>.*?</tr>", page)
    assert len(rows) == 1 + len(study) and "helpful" in page and "runs" in rows[0]


def test_tables_in_notebooks_show_markup_as_text():
    trial = sim.Trial(sim.Trial.load("ariac2023").floorplan, name="<b>x")
    assert "&lt;b&gt;x" in trial._repr_html_() and "<b>" not in trial._repr_html_()
