"""Runs in which simulated time stops end with a message, and keep their events."""

import inspect

import pytest

import floorplan
import sim


def halving(gantry):
    """Wait for shorter and shorter times, so that one second is never reached."""
    seconds = 0.5
    while True:
        yield gantry.wait(seconds)
        seconds /= 2


def test_a_standstill_ends_a_command_and_keeps_its_events(floorwalker, tmp_path):
    (tmp_path / "own.py").write_text(inspect.getsource(halving))
    (tmp_path / "t.trial.yaml").write_text(
        "floorplan: ariac2023\nduration: 60.0\ngantry: {controller: 'own:halving'}\n"
    )
    ended = floorwalker("run", "t.trial.yaml", "--out", "run", cwd=tmp_path)
    assert ended.returncode == 1
    assert "t = " in ended.stderr
    assert "gantry's controller" in ended.stderr
    run = sim.load_run(tmp_path / "run")
    assert run.summary["interrupted"]
    assert len(run.events) < 5000


def test_a_controller_that_stops_time_is_named():
    trial = sim.Trial.parse("floorplan: ariac2023\nduration: 60.0\ngantry: {controller: parked}")
    simulation = sim.Simulation(trial)
    simulation.clock.process(halving(simulation.gantry))
    with pytest.raises(floorplan.UserError, match=r"t = 1 s.*gantry's controller"):
        simulation.advance(60.0)
    assert simulation.finish().duration == pytest.approx(1.0)
