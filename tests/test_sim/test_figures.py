"""A figure of a run is declared once; summary, expectations, studies and words follow."""

import numpy as np
import pytest

import sim
from sim.core.events import GoalChanged
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
        events=(GoalChanged, {}),
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


def test_the_nearest_to_an_agv_is_that_of_one_that_moves():
    trial = sim.Trial.parse(
        """\
floorplan: ariac2023
duration: 90
rules: {based_on: observe, agv_offset: 0.2}
people: [{name: crew, count: 3, at: anywhere}, {name: late, start: {event: job_done}}]
agvs:
  agv1: [{time: 10, to: assembly_front}, {time: 60, to: kitting}]
  agv2: [{time: 20, to: assembly_back}]
expect: {nearest_agv: "> 0", people.crew2.nearest_agv.required: "> 0"}
"""
    )
    run = sim.run(trial)
    assert run.unmet == []
    t = np.linspace(0.0, 90.0, 90_001)
    sampled = {}
    for person in ("crew1", "crew2", "crew3"):
        for agv in ("agv1", "agv2", "agv3"):
            drives = np.hypot(*run.motions[agv].velocity(t).T) > 0.0
            if drives.any():
                sampled[person, agv] = run.distance(person, agv, t[drives]).min()
        found = run.summary["people"][person]["nearest_agv"]
        least = min((apart, agv) for (who, agv), apart in sampled.items() if who == person)
        assert (found["distance"], found["agv"]) == (pytest.approx(least[0], abs=5e-3), least[1])
        apart = run.distance(person, found["agv"], found["time"])
        assert found["distance"] == pytest.approx(float(apart), abs=1e-6)
        required = run.required(person, found["agv"], [found["time"]])
        assert found["required"] == pytest.approx(required[0], abs=0.05)
    nearest = run.summary["nearest_agv"]
    assert nearest["distance"] == pytest.approx(min(sampled.values()), abs=5e-3)
    assert run.summary["people"][nearest["person"]]["nearest_agv"]["agv"] == nearest["agv"]
    assert run.summary["people"]["late"]["nearest_agv"] is None
    shown = dict(figures_in_words(run.summary))["nearest to an AGV"]
    assert f"({nearest['person']} and {nearest['agv']}) at {nearest['time']:.1f} s" in shown


def test_without_moves_of_agvs_there_is_no_nearest_one():
    run = sim.run(sim.Trial.parse("{floorplan: ariac2023, duration: 1, people: [{name: eve}]}"))
    assert "nearest_agv" not in run.summary
    later = (
        "{floorplan: ariac2023, duration: 1, people: [{name: eve}],"
        " agvs: {agv1: [{time: 5, to: assembly_front}]}}"
    )
    assert sim.run(sim.Trial.parse(later)).summary["nearest_agv"] is None
