"""A figure of a run is declared once; summary, expectations, studies and words follow."""

import pytest

import sim
from sim.core.events import Goal
from sim.record.figures import FIGURES, SummaryFigure
from sim.record.summary import figures_in_words
from sim.record.words import plain

TRIAL = """
floorplan: ariac2023
duration: 30
people: [{name: nina, personality: helpful}]
expect: {goals_set: "> 90", people.nina.waits: 0}
"""


@pytest.fixture
def own_figures(monkeypatch):
    """One of the whole run, one of each person."""
    goals = SummaryFigure(
        path="goals_set",
        of=lambda run: sum(len(motion.pieces) > 1 for motion in run.motions.values()),
        label="goals set",
        words=plain,
        events=(Goal, {}),
        measure="chief",
    )
    waits = SummaryFigure(path="people.NAME.waits", of=lambda run, person: 0, label="waits")
    for figure in (goals, waits):
        monkeypatch.setitem(FIGURES, figure.path, figure)


def test_a_figure_is_added_by_its_declaration_alone(own_figures, tmp_path):
    trial = sim.Trial.parse(TRIAL)
    run = sim.run(trial)
    assert run.summary["goals_set"] >= 1
    assert run.summary["people"]["nina"]["waits"] == 0
    unmet = [verdict for verdict in run.verdicts if not verdict.met]
    assert [verdict.place for verdict in unmet] == [("goals_set",)]
    assert unmet[0].time == [e["t"] for e in run.events if e["kind"] == "goal"][-1]
    assert dict(figures_in_words(run.summary))["goals set"] == str(run.summary["goals_set"])
    study = sim.Study(name="own", trials=(trial,), repeat=2)
    results = sim.run_study(study, tmp_path / "study", jobs=1)
    assert results.columns["goals_set"] == [run.summary["goals_set"]] * 2
    assert results.columns["people.nina.waits"] == [0, 0]
    assert "Goals set" in [measure.title for measure in results.comparison.spreads]


def test_many_people_have_a_line_each():
    person = {"visits": ["press"], "distance_walked": 3.0, "time_standing": 0.0, "replans": 0}
    people = {f"p{k}": {"personality": "helpful", **person} for k in range(25)}
    lines = dict(figures_in_words({"people": people}))
    assert lines["p0"] == "helpful; visits press 1×; walked 3.0 m"
    assert len(lines) == 21 and lines["others"].startswith("5 people")
    few = dict(figures_in_words({"people": {"p0": people["p0"]}}))
    assert few["p0: walked"] == "3.0 m" and few["p0: replans"] == "0"
