"""`floorwalker new` and `floorwalker list`: new files run unchanged."""

import pytest
import yaml

import sim


def test_a_new_trial_runs_and_meets_its_expectations(floorwalker, tmp_path):
    assert floorwalker("new", "trial", cwd=tmp_path).returncode == 0
    checked = floorwalker("check", "new.trial.yaml", cwd=tmp_path)
    assert checked.returncode == 0
    done = floorwalker("run", "new.trial.yaml", "--out", "run", cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr


def test_a_new_controller_runs_and_moves_the_gantry(floorwalker, tmp_path):
    floorwalker("new", "controller", "mine.py", cwd=tmp_path)
    assert "mine:work" in (tmp_path / "mine.py").read_text()
    text = 'floorplan: ariac2023\nduration: 60\ngantry: {controller: "mine:work"}\n'
    run = sim.run(sim.Trial.parse(text, folder=tmp_path))
    assert run.motions["gantry"].state(60.0).at != run.motions["gantry"].state(0.0).at
    assert floorwalker(
        *("run", "ariac2023", "--controller", "mine:work", "--duration", "5", "--out", "run"),
        cwd=tmp_path,
    ).returncode == 0  # fmt: skip


def test_a_new_personality_runs_and_walks_the_stations(floorwalker, tmp_path):
    floorwalker("new", "personality", "polite.asl", cwd=tmp_path)
    checked = floorwalker("check", "polite.asl", cwd=tmp_path)
    assert (checked.returncode, checked.stderr) == (0, "")
    text = "floorplan: ariac2023\nduration: 120\npeople: [{name: eve, personality: polite.asl}]\n"
    assert sim.run(sim.Trial.parse(text, folder=tmp_path)).summary["people"]["eve"]["visits"]


@pytest.mark.parametrize("kind", ["trial", "controller", "personality"])
def test_a_file_that_exists_is_not_overwritten(kind, floorwalker, tmp_path):
    (tmp_path / "mine").write_text("mine")
    done = floorwalker("new", kind, "mine", cwd=tmp_path)
    assert done.returncode == 1 and "exists already" in done.stderr
    assert (tmp_path / "mine").read_text() == "mine"


def test_unknown_kinds_are_rejected(floorwalker, tmp_path):
    done = floorwalker("new", "planner", cwd=tmp_path)
    assert done.returncode == 2 and "personality" in done.stderr


def test_the_figures_that_are_listed_can_be_expected(floorwalker):
    done = floorwalker("list", "figures")
    names = [line.split()[0] for line in done.stdout.splitlines()[1:]]
    assert {"penalties", "minimum_separation.distance", "people.NAME.visits"} <= {*names}
    plain = [name for name in names if name in ("penalties", "contacts", "jobs_done", "overlaps")]
    text = yaml.safe_dump(
        {
            "floorplan": "ariac2023",
            "people": [{"name": "a"}, {"name": "b"}],
            "expect": dict.fromkeys(plain, ">= 0"),
        }
    )
    assert len(sim.Trial.parse(text).expect) == 4


def test_one_section_is_listed_alone(floorwalker):
    done = floorwalker("list", "controllers")
    assert "avoiding" in done.stdout and "ariac2023" not in done.stdout
    assert "figures" not in floorwalker("list").stdout.splitlines()
    assert floorwalker("list", "everything").returncode == 2
