"""The gantry: its jobs, its controllers, and its motion while it is disabled."""

import itertools
import json
import math
from dataclasses import replace

import numpy as np
import pytest
from run_events import events

import navigation
import sim

ALONE = """
floorplan: ariac2023
duration: 120
gantry:
  controller: {controller}
  at: [-7.0, 0.0, 0.0]
  repeat: {repeat}
  jobs:
    - {{move: [-2.5, 0.5, 1.0]}}
    - {{wait: 3.0}}
    - {{pick: bin2, place: agv1, part: purple pump}}
    - {{submit: ORDER1}}
"""


def alone(controller="oblivious", repeat="false", folder=".", **changes):
    return sim.Trial.parse(ALONE.format(controller=controller, repeat=repeat), folder=folder)


def test_jobs_take_the_time_of_their_moves_and_handling():
    run = sim.run(alone())
    done = events(run, "job_done", "order_submitted")
    assert [event.get("job", event["kind"]) for event in done] == [
        "move",
        "wait",
        "pick_place",
        "order_submitted",
    ]
    assert (done[2]["part"], done[2]["from"], done[2]["to"]) == ("purple pump", "bin2", "agv1")
    move = navigation.gantry_move((-7, 0, 0), (-2.5, 0.5, 1.0))
    bin2 = navigation.gantry_move((-2.5, 0.5, 1.0), (-1.9, 2.625, 1.0))
    agv1 = navigation.gantry_move((-1.9, 2.625, 1.0), (-2.27, 4.8, 1.0))
    expected = [move.end, move.end + 3.0, move.end + 3.0 + bin2.end + 2.0 + agv1.end + 2.0]
    assert [event["t"] for event in done[:3]] == pytest.approx(expected, abs=1e-6)
    assert run.summary["jobs_done"] == 3
    assert run.motions["gantry"].position(100.0) == pytest.approx((-2.27, 4.8))


def test_repeated_jobs_continue_to_the_end():
    run = sim.run(alone(repeat="true"))
    assert run.summary["jobs_done"] > 6


def test_jobs_without_duration_are_not_repeated_endlessly():
    trial = sim.Trial.parse(
        "floorplan: ariac2023\nduration: 60\ngantry: {controller: oblivious, repeat: true,"
        " at: [-7.0, 0.0, 0.0], jobs: [{move: [-5.0, 0.0, 0.0]}]}"
    )
    assert sim.run(trial).summary["jobs_done"] == 2


def test_a_parked_gantry_stays():
    run = sim.run(alone("parked"))
    assert run.summary["jobs_done"] == 0
    assert np.ptp(run.motions["gantry"].position(np.linspace(0, 120, 99)), axis=0).max() == 0


def test_a_disabled_gantry_stops_waits_and_continues():
    """An indifferent person walks up to a gantry that moves back and forth between two places."""
    trial = sim.Trial.parse(
        """
floorplan: ariac2023
duration: 200
people: [{name: operator, personality: indifferent}]
gantry:
  controller: oblivious
  at: [-5.0, 3.0, 0.0]
  repeat: true
  jobs: [{move: [-9.0, 3.0, 0.0]}, {move: [-5.0, -3.0, 1.0]}]
"""
    )
    run = sim.run(trial)
    disabled, enabled = events(run, "gantry_disabled"), events(run, "gantry_enabled")
    assert len(disabled) >= 2
    gantry = run.motions["gantry"]
    for off, on in zip(disabled, enabled, strict=False):
        assert on["t"] == pytest.approx(off["t"] + 8.0, abs=1e-9)
        at = gantry.state(off["t"])
        # From 1 m/s the gantry stops within v / a + 2 a / j seconds.
        stopped = off["t"] + at.speed / 0.5 + 2 * 0.5 / 2.0 + 1e-6
        assert np.abs(gantry.velocity(np.linspace(stopped, on["t"] - 1e-6, 50))).max() == 0.0
        assert gantry.state(on["t"] + 0.5).speed > 0
    assert run.summary["gantry_disabled_time"] == pytest.approx(
        sum(min(off["t"] + 8.0, 200.0) - off["t"] for off in disabled)
    )
    assert run.summary["jobs_done"] >= 3
    ts = np.linspace(0, 200, 200_001)
    assert np.abs(gantry.velocity(ts)).max() <= 1.0 + 1e-6
    steps = np.hypot(*np.diff(gantry.position(ts), axis=0).T)
    assert steps.max() <= math.sqrt(2) * 1e-3 * (1 + 1e-6)


def test_lasting_violations_count_again_when_the_gantry_is_enabled(tmp_path):
    """The referee moves a person home if the program does not leave."""
    (tmp_path / "stay.asl").write_text("!stay. +!stay <- .wait(1000); !stay.\n")
    trial = sim.Trial.parse(
        """
floorplan: ariac2023
duration: 60
people: [{name: a, personality: stay.asl, at: [-5.0, 3.75], home: [-5.0, 3.75]}]
gantry:
  controller: oblivious
  at: [-9.0, 3.75, 0.0]
  jobs: [{wait: 5.0}, {move: [-5.0, 3.0, 0.0]}]
""",
        folder=tmp_path,
    )
    run = sim.run(trial)
    violations, teleports = events(run, "violation"), events(run, "teleport")
    assert len(violations) >= 3
    for earlier, later in itertools.pairwise(violations):
        assert later["t"] >= earlier["t"] + 8.0
    # The home is station1, so the referee moves the person there, which is also too close.
    assert [event["t"] for event in teleports] == [event["t"] for event in violations]
    assert teleports[0]["to"] == [-5.0, 3.75]
    assert run.summary["penalties"] == len(violations)


@pytest.fixture
def controller(tmp_path):
    """Return a function that writes a controller into a new module."""
    names = (f"controller_{tmp_path.name}_{k}" for k in itertools.count())

    def make(text):
        name = next(names)
        (tmp_path / f"{name}.py").write_text(text)
        return name, tmp_path

    return make


def test_a_custom_controller_moves_the_gantry(controller):
    name, folder = controller(
        """
class Shuttle:
    def __init__(self, gantry):
        self.gantry = gantry

    def __iter__(self):
        return self.steps()

    def steps(self):
        yield self.gantry.move_to(-5.0, 0.0)


def back_and_forth(gantry):
    for _ in range(3):
        yield gantry.move_to(-5.0, 0.0)
        yield gantry.wait(1.0)
        yield gantry.move_to(-7.0, 0.0, rotation=0.5)
"""
    )
    run = sim.run(alone(f"{name}:back_and_forth", folder=folder))
    there = navigation.gantry_move((-7, 0, 0), (-5, 0, 0)).end
    xs = run.motions["gantry"].position([there, there + 0.5])[:, 0]
    assert xs == pytest.approx([-5.0, -5.0], abs=1e-6)
    run = sim.run(alone(f"{name}:Shuttle", folder=folder))
    assert run.motions["gantry"].position(60.0) == pytest.approx((-5.0, 0.0))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "def go(gantry):\n    yield gantry.move_to(-5, 0)\n    1 / 0\n",
            r"line 3\): ZeroDivisionError",
        ),
        (
            "def go(gantry):\n    yield gantry.move_to(5, 0)\n",
            "x = 5 is outside the gantry's range",
        ),
        ("def go(gantry):\n    yield 'lunch'\n", "yielded 'lunch'"),
        ("def go(gantry):\n    yield gantry.wait(-1)\n", "at least 0, not -1"),
        (
            "def go(gantry):\n    yield gantry.pick('moon')\n",
            "AGV is called 'moon'",
        ),
        ("def go():\n    yield\n", "takes 0 positional arguments"),
        (
            "def go(gantry):\n    while True:\n        yield gantry.wait(0)\n",
            "it never lets time pass",
        ),
    ],
)
def test_a_controller_that_fails_is_named_with_its_line(controller, text, message):
    name, folder = controller(text)
    with pytest.raises(sim.ControllerError, match=message) as caught:
        sim.run(alone(f"{name}:go", folder=folder))
    assert f"{name}:go" in str(caught.value)


def test_the_command_retains_the_recording_of_a_failed_run(controller, floorwalker):
    name, folder = controller("def go(gantry):\n    yield gantry.wait(30)\n    1 / 0\n")
    (folder / "t.yaml").write_text(ALONE.format(controller=f"{name}:go", repeat="false"))
    done = floorwalker("run", "t.yaml", "--out", "out", cwd=folder)
    assert done.returncode == 1
    assert "line 3): ZeroDivisionError: division by zero" in done.stderr
    assert "Traceback" not in done.stderr
    events = (folder / "out" / "events.jsonl").read_text()
    recorded_events = [json.loads(line) for line in events.splitlines()]
    assert recorded_events[0]["kind"] == "trial_started"
    assert recorded_events[-1]["t"] == 30.0
    summary = json.loads((folder / "out" / "summary.json").read_text())
    assert summary["interrupted"] is True


@pytest.mark.parametrize("repeat", [False, True])
def test_a_trial_can_end_with_the_orders_of_its_jobs(repeat):
    text = (
        "floorplan: ariac2023\nduration: 60\nuntil_submitted: true\ngantry:\n"
        f"  controller: oblivious\n  repeat: {str(repeat).lower()}\n"
        "  jobs: [{wait: 1}, {submit: a}, {wait: 2.5}, {submit: b}]\n"
    )
    trial = sim.Trial.parse(text)
    assert sim.Trial.parse(trial.to_yaml()) == trial
    run = sim.run(trial)
    assert run.duration == pytest.approx(3.5)
    assert not run.summary["interrupted"]
    assert [e["order"] for e in run.events if e["kind"] == "order_submitted"] == ["a", "b"]
    assert sim.run(replace(trial, until_submitted=False)).duration == 60.0
