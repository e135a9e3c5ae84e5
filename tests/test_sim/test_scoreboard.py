"""The built-in study that compares gantry controllers."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

import sim
from sim.cli import app
from sim.studies.scoreboard import (
    SCENES,
    paired_tests,
    scoreboard,
    scores,
    sign_flips,
    write_scoreboard,
)


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scoreboard")
    (folder / "mine.py").write_text(
        "def fast(gantry):\n"
        "    while (task := (yield gantry.next_task())) is not None:\n"
        "        yield gantry.do(task)\n"
    )
    study = scoreboard(["mine:fast", "oblivious", "parked"], repeat=2, folder=folder)
    return sim.run_study(shorter(study), folder / "out", jobs=1)


def shorter(study, duration=75.0):
    """Return the study with shorter trials. In 75 s, jobs are done and an AGV moves."""
    trials = tuple(replace(trial, duration=duration) for trial in study.trials)
    return replace(study, trials=trials)


def test_all_controllers_get_the_same_draws(results):
    columns = results.columns
    drawn = ("personality", "max_speed", "gantry_at", "job_order")
    rows = [
        *zip(columns["trial"], columns["repetition"], *(columns[d] for d in drawn), strict=True)
    ]
    each = {}
    for row, controller in zip(rows, columns["controller"], strict=True):
        each.setdefault(controller, []).append(row)
    assert sorted(each["mine:fast"]) == sorted(each["parked"]) == sorted(each["oblivious"])
    assert {row[0] for row in rows} == {*SCENES}
    assert len(results) == 3 * 3 * 2


def test_scores_are_means_and_the_worst_row_has_the_least_margin(results):
    columns = results.columns
    by_controller = {score.controller: score for score in scores(results)}
    for name, score in by_controller.items():
        mine = [k for k, one in enumerate(columns["controller"]) if one == name]
        jobs = next(one for m, one in score.spreads.items() if m.column == "jobs_done")
        assert jobs.mean == pytest.approx(np.mean([columns["jobs_done"][k] for k in mine]))
        margins = {k: columns["least_margin_moving.value"][k] for k in mine}
        finite = {k: value for k, value in margins.items() if value is not None}
        if finite:
            assert finite[score.worst_row] == min(finite.values()) == score.least_margin
    assert by_controller["parked"].spreads[next(iter(by_controller["parked"].spreads))] is not None
    assert by_controller["mine:fast"].least_margin < 0


def test_only_controllers_that_behave_differently_have_a_difference(results):
    tests = paired_tests(results)
    jobs = {(t.one, t.other): t for t in tests if t.measure.column == "jobs_done"}
    assert jobs["mine:fast", "parked"].difference >= jobs["mine:fast", "parked"].low > 0
    assert jobs["mine:fast", "parked"].count == 6
    assert 2 / 2**6 <= jobs["mine:fast", "parked"].p < 0.5


def test_the_page_links_the_worst_trials(results):
    page = write_scoreboard(results)
    text = page.read_text()
    for score in scores(results):
        if score.worst_row is not None:
            path = f"trials/{score.worst_row:06d}.yaml"
            assert path in text
            assert (page.parent / path).exists()


def test_random_signs_give_the_exact_share():
    off = np.array([1.0, 2.0, 0.5, 1.5])
    flips = [abs(np.dot(s, off)) >= off.sum() for s in itertools.product((-1, 1), repeat=4)]
    assert sign_flips(off) == pytest.approx(np.mean(flips), abs=0.01)
    rng = np.random.default_rng(1)
    small = [sign_flips(rng.normal(size=12)) < 0.05 for _ in range(200)]
    assert 0.01 <= np.mean(small) <= 0.1


@pytest.mark.parametrize(
    ("controllers", "message"),
    [(["avoiding", "avoiding"], "given once"), (["avoidign"], "avoiding"), (["a:b"], "a:b")],
)
def test_wrong_controllers_are_rejected(tmp_path, controllers, message):
    with pytest.raises(ValueError, match=message):
        scoreboard(controllers, folder=tmp_path)


def test_the_command_prints_the_scores(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    options = ["--controller", "oblivious", "--repeat", "1", "--jobs", "1"]
    outcome = CliRunner().invoke(app, ["study", "scoreboard", *options])
    assert outcome.exit_code == 0
    assert "oblivious" in outcome.output
    assert "scoreboard.html" in outcome.output
    outcome = CliRunner().invoke(app, ["study", "some.study.yaml", "--controller", "parked"])
    assert outcome.exit_code == 2
    assert "is for scoreboard only" in outcome.output


def test_the_same_controller_under_two_names_gets_the_same_runs(tmp_path):
    code = "import sim\n\n\ndef careful(gantry):\n    caution = sim.Caution(gantry)\n"
    code += "    while (task := (yield gantry.next_task())) is not None:\n"
    code += "        while task.next_step is not None:\n"
    code += "            yield from caution.go((yield gantry.locate(task)))\n"
    code += "            yield gantry.handle(task)\n"
    (tmp_path / "mine.py").write_text(code)
    study = shorter(scoreboard(["pausing", "mine:careful"], repeat=1, folder=tmp_path), 40.0)
    results = sim.run_study(study, tmp_path / "out", jobs=1)
    one, other = (
        [
            {k: v[row] for k, v in results.columns.items() if k not in ("row", "controller")}
            for row in rows
        ]
        for rows in (range(0, 6, 2), range(1, 6, 2))
    )
    assert one == other
    assert paired_tests(results) == []
