"""Controllers passed in Python: functions and classes of any origin."""

import functools
import sys
from dataclasses import replace

import pytest

import sim

TRIAL = sim.Trial.parse("floorplan: ariac2023\nduration: 20\npeople: [{name: ada}]\n")


def driven_by(controller, **changes):
    return replace(TRIAL, gantry=sim.GantryEntry(controller=controller), **changes)


def to(x):
    def go(gantry):
        yield gantry.move_to(x, 0.0)

    return go


class Thinker:
    def __init__(self, gantry):
        self.gantry = gantry

    def __iter__(self):
        yield self.gantry.move_to(-3.0, 0.0)


class Remembering:
    def run(self, gantry):
        yield gantry.move_to(-3.0, 0.0)


@pytest.mark.parametrize(
    ("controller", "name"),
    [
        (to(-3.0), "to.<locals>.go"),
        (Thinker, "Thinker"),
        (Remembering().run, "Remembering.run"),
        (functools.partial(lambda x, gantry: to(x)(gantry), -3.0), "partial"),
    ],
)
def test_a_callable_of_the_gantry_is_a_controller(controller, name, tmp_path):
    trial = driven_by(controller, folder=tmp_path)
    assert trial.gantry.controller_name == name
    assert sim.run(trial).motions["gantry"].position(20.0) == pytest.approx((-3.0, 0.0))
    with pytest.raises(ValueError, match=r"its gantry controller .* is in no module"):
        trial.to_yaml()


def test_a_function_with_a_rate_sends_the_gantry_to_targets_and_its_jobs():
    calls = []

    def choose(gantry):
        calls.append(gantry.now)
        goal = gantry.goal_pose
        return (-3.0, 0.0, 0.5) if goal is None else goal[:2]

    places = (-8.0, 2.0, 0.0), (-4.0, -2.0, 0.0)
    jobs = tuple(sim.Job("move", target=place) for place in places)
    gantry = sim.GantryEntry(controller=choose, rate=2.0, jobs=jobs)
    run = sim.run(replace(TRIAL, duration=60.0, gantry=gantry))
    assert run.summary["jobs_done"] == 2
    assert run.motions["gantry"].position(60.0) == pytest.approx((-3.0, 0.0))
    assert calls == [k / 2 for k in range(len(calls))]


def test_a_target_of_a_function_with_a_rate_is_checked():
    gantry = sim.GantryEntry(controller=lambda gantry: 3.0, rate=2.0)
    with pytest.raises(sim.ControllerError, match=r"target must be \(x, y\)"):
        sim.run(replace(TRIAL, gantry=gantry))


def test_a_failing_controller_is_named_by_its_qualified_name():
    def late(gantry):
        yield gantry.wait(1.0)
        raise LookupError

    with pytest.raises(sim.ControllerError, match=r"<locals>.late' failed at t = 1 s \(.*line"):
        sim.run(driven_by(late))
    with pytest.raises(sim.ControllerError, match="3 is not a gantry controller; give a name"):
        sim.run(driven_by(3))


@pytest.fixture
def module(tmp_path, monkeypatch):
    """A module in `folder`, from which a notebook there has imported the function `go`."""
    text = "def go(gantry):\n    yield gantry.move_to(-3.0, 0.0)\n"
    (tmp_path / "policies_of_mine").mkdir()
    (tmp_path / "policies_of_mine" / "bold.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    from policies_of_mine import bold

    yield bold
    for name in [name for name in sys.modules if name.startswith("policies_of_mine")]:
        del sys.modules[name]


def test_a_controller_in_a_module_beside_the_trial_is_written_by_its_name(module, tmp_path):
    trial = driven_by(module.go, folder=tmp_path)
    trial.save(tmp_path / "t.yaml")
    again = sim.Trial.load(tmp_path / "t.yaml")
    assert again.gantry.controller == "policies_of_mine.bold:go"
    assert sim.run(again).events == sim.run(trial).events
    with pytest.raises(ValueError, match="in no module"):
        replace(trial, folder=tmp_path / "elsewhere").to_yaml()


@pytest.mark.slow
def test_a_study_with_a_python_controller_runs_on_several_processes_or_states_the_remedy(
    module, tmp_path
):
    study = sim.Study("bold", (driven_by(module.go, folder=tmp_path),), repeat=2)
    results = sim.run_study(study, tmp_path / "study", jobs=2)
    assert (len(results), results.failed) == (2, {})
    loose = sim.Study("loose", (driven_by(to(-3.0)),))
    with pytest.raises(ValueError, match="put it into a file there"):
        sim.run_study(loose, tmp_path / "loose", jobs=2)
