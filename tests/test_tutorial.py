"""Results that the tutorial states, compared with those of its files."""

import shlex
from dataclasses import replace
from pathlib import Path

import pytest
from test_documents import blocks

import sim

TUTORIAL = Path(__file__).resolve().parents[1] / "docs" / "tutorial.md"


@pytest.fixture
def trial(tmp_path):
    for kind in ("yaml", "asl", "python"):
        for name, text in blocks(TUTORIAL, kind):
            if name:
                (tmp_path / name).write_text(text, encoding="utf-8")
    return sim.Trial.load(tmp_path / "room.trial.yaml")


def test_six_violations_and_eight_jobs_with_the_oblivious_controller(trial):
    summary = sim.run(trial).summary
    assert (summary["penalties"], summary["jobs_done"]) == (6, 8)
    assert summary["violations"] == {"gantry": 6, "person": 0}


def test_four_violations_are_left_if_ada_is_polite(trial):
    assert sim.run(trial.with_personality("polite.asl")).summary["penalties"] == 4


def test_no_violation_and_six_jobs_with_the_courteous_controller(trial):
    gantry = replace(trial.gantry, controller="courteous:courteous")
    summary = sim.run(replace(trial, gantry=gantry)).summary
    assert (summary["penalties"], summary["jobs_done"]) == (0, 6)


NOT_HERE = ("render", "replay", "study")
"""Commands that open a browser, or that take long and have separate tests."""


@pytest.mark.slow
@pytest.mark.parametrize("page", ["tutorial.md", "plots.md"])
def test_the_commands_of_the_tutorial_run(page, trial, tmp_path, floorwalker):
    shown = (TUTORIAL.parent / page).read_text(encoding="utf-8")
    lines = [line for line in shown.splitlines() if line.startswith("floorwalker ")]
    assert len(lines) > 5
    if page == "tutorial.md":  # its first command follows the installation
        lines.insert(0, "floorwalker run")
    for line in lines:
        words = shlex.split(line.replace("another-run", "run").replace("run.mp4", "again.gif"))
        if words[1] not in NOT_HERE:
            assert floorwalker(*words[1:], cwd=tmp_path).returncode == 0, line
