"""Runs ended by a full disk or a signal: their files stay whole."""

import signal

import pytest
from processes import started
from waiting import HANG, until

import sim

BRIDGE = ["bridge", "--port", "0", "--speed", "0"]


@pytest.mark.parametrize(
    ("room", "command"),
    [(2000, ["run"]), (12_000, ["run"]), (100_000, ["run"]), (12_000, BRIDGE)],
)
def test_a_recording_on_a_full_disk_stays_whole(tmp_path, floorwalker, room_for, room, command):
    with room_for(room):
        done = floorwalker(*command, "--duration", "60", "--out", "out", cwd=tmp_path)
    assert done.returncode == 1
    *notices, message = done.stderr.splitlines()
    assert message.startswith("floorwalker: cannot continue writing to out: ")
    assert all(notice.startswith(("serving", "the trial begins")) for notice in notices)
    assert len(notices) == (0 if command == ["run"] else 2)
    out = tmp_path / "out"
    assert not (out / "replay.html").exists()
    assert not list(out.glob(".unfinished-*"))
    for lines in out.glob("*.jsonl"):
        assert lines.read_bytes()[-1:] in (b"", b"\n"), lines.name
    if (out / "scene.json").exists():
        assert 0 <= sim.load_run(out).duration <= 60


@pytest.mark.parametrize("command", [["run"], BRIDGE])
def test_a_terminated_run_is_recorded_completely(tmp_path, command):
    arguments = [*command, "--duration", "2000000", "--out", "out"]
    process = started(*arguments, cwd=tmp_path)
    events = tmp_path / "out" / "events.jsonl"
    until(lambda: events.exists() and events.stat().st_size > 100, process)
    process.send_signal(signal.SIGTERM)
    _, message = process.communicate(timeout=HANG)
    assert process.returncode == 130
    assert "The recording up to then is kept" in message and "Traceback" not in message
    assert sim.load_run(tmp_path / "out").summary["interrupted"]


STOPS_ITSELF = """
import signal
from pathlib import Path
def stops(gantry):
    yield gantry.wait(1.0)
    signal.raise_signal(signal.SIGINT)
    Path("gone-on").touch()
    while True:
        yield gantry.wait(1.0)
"""


def test_ctrl_c_lets_writing_finish(tmp_path, floorwalker):
    (tmp_path / "own.py").write_text(STOPS_ITSELF)
    (tmp_path / "own.trial.yaml").write_text(
        "floorplan: ariac2023\nduration: 1.0e+6\ngantry: {controller: 'own:stops'}\n"
    )
    done = floorwalker("run", "own.trial.yaml", "--out", "out", cwd=tmp_path)
    assert done.returncode == 130
    assert (tmp_path / "gone-on").exists()
    run = sim.load_run(tmp_path / "out")
    assert run.duration == 1.0
    assert run.events[-1] == {"t": 1.0, "kind": "trial_ended", "interrupted": True}


def test_a_simulation_can_be_stopped_from_within():
    class Impatient(sim.Listener):
        def event(self, event):
            if event["t"] > 10.0:
                simulation.stop()

    simulation = sim.Simulation(sim.Trial.load("scene_antagonistic"), Impatient())
    simulation.advance(100.0)
    stood = simulation.clock.now
    assert 10.0 < stood < 100.0
    simulation.advance(100.0)
    assert simulation.clock.now == stood and simulation.stopped and not simulation.over
    assert simulation.finish().summary["interrupted"]
