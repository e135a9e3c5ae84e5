"""Machines commanded between two advances. The trial with the commands repeats the run."""

import json
import random
from contextlib import suppress
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import pytest
from small_floors import WORKCELL, on_floor

import navigation
import sim
from sim.bridge.exchange import Exchange
from sim.bridge.workcell import Workcell

TRIAL = on_floor(
    WORKCELL,
    """\
duration: 60
seed: 3
rules: observe
people: [{name: ann, at: [2, 9]}, {name: bob, at: [18, 4]}]
gantry: {controller: external, jobs: [{move: [5, 5, 0]}, {wait: 1.0}]}
machines:
  a: {kind: amr, at: [4, 4, 0], size: [1.0, 0.7], controller: external}
  b: {kind: amr, at: [16, 8, 3.1416], controller: external, missions: [{go: press}]}
""",
)


def in_bytes(folder):
    return [(folder / name).read_bytes() for name in ("events.jsonl", "motions.jsonl")]


def recorded(trial, folder, drive=lambda simulation: None):
    recording = sim.Recording(folder)
    simulation = sim.Simulation(trial, recording)
    drive(simulation)
    simulation.advance(trial.duration)
    run = simulation.finish()
    recording.finish(run)
    return run


def at_random(simulation, seed=7):
    """Give all kinds of commands in irregular steps."""
    chance = random.Random(seed)
    a, b, gantry = (simulation.machines[name] for name in ("a", "b", "gantry"))
    a.move_to(15.0, 4.0)
    b.do(b.open_tasks[0])
    gantry.do(gantry.open_tasks[0])
    t = 0.0
    while t < 55.0:
        t += chance.choice([0.1, 0.25, chance.random(), 3.0 * chance.random()])
        simulation.advance(t)
        x, y, turn, speed = (chance.uniform(*ends) for ends in ((2, 18), (2, 5), (-3, 3), (0, 0.8)))
        machine = chance.choice([a, b])
        wishes = [
            partial(machine.move_to, x, y, speed_share=0.7),
            partial(machine.twist, (speed, turn / 10), 2.0),
            partial(machine.turn_to, turn),
            machine.stop,
            machine.resume,
            partial(machine.stand_for, "test", True),
            partial(machine.stand_for, "test", False),
            lambda: gantry.move_to(chance.uniform(2, 18), chance.uniform(2, 10), resume=False),
            gantry.stop,
            lambda: gantry.pick("press"),
            lambda: gantry.follow(
                navigation.gantry_move(gantry.position, (9.0, 9.0, 0.5), gantry.now)
                if gantry.state.speed == 0
                else gantry.stopping(gantry.state, gantry.now)
            ),
            lambda: simulation.machines["cart"].drive(chance.choice(["west", "east", 3.0])),
            lambda: simulation.command(
                sim.Command(None, send="ann", to=(chance.uniform(2, 6), 9.0))
            ),
            lambda: simulation.command(sim.Command(hold="cart")),
            lambda: simulation.command(sim.Command(simulation.clock.now + 1.3, release="cart")),
        ]
        for _ in range(chance.choice([1, 1, 2])):
            # A command that cannot be executed now leaves no trace.
            with suppress(ValueError, navigation.PlanningError):
                chance.choice(wishes)()


def test_a_run_commanded_from_outside_repeats_to_the_byte(tmp_path):
    trial = sim.Trial.parse(TRIAL)
    run = recorded(trial, tmp_path / "first", at_random)
    calls = {command.call for command in run.trial.commands}
    assert calls >= {
        "move_to",
        "twist",
        "turn_to",
        "stop",
        "resume",
        "do",
        "follow",
        "pick",
        "drive",
    }
    assert len(run.trial.commands) > 40
    run.trial.save(tmp_path / "again.trial.yaml")
    again = sim.Trial.load(tmp_path / "again.trial.yaml")
    assert again.commands == run.trial.commands
    same = recorded(again, tmp_path / "second")
    assert in_bytes(tmp_path / "second") == in_bytes(tmp_path / "first")
    assert same.trial.commands == run.trial.commands
    listed = sim.Trial.parse(TRIAL + f"commands: {tmp_path / 'first' / 'commands.yaml'}\n")
    recorded(listed, tmp_path / "third")
    assert in_bytes(tmp_path / "third") == in_bytes(tmp_path / "first")


def test_a_command_from_outside_is_an_event_with_its_arguments():
    simulation = sim.Simulation(sim.Trial.parse(TRIAL))
    simulation.advance(1.0 / 3.0)
    simulation.machines["a"].twist((0.5, 0.1), seconds=2.0)
    (command,) = simulation.commands
    assert (command.time, command.machine, command.call) == (1.0 / 3.0, "a", "twist")
    assert command.arguments == {"twist": [0.5, 0.1], "seconds": 2.0}
    event = next(event for event in simulation.events if event["kind"] == "commanded")
    assert event["arguments"] == [["twist", [0.5, 0.1]], ["seconds", 2.0]]
    assert json.loads(json.dumps(event)) == event


def test_a_command_now_is_not_too_late():
    simulation = sim.Simulation(sim.Trial.parse(TRIAL))
    simulation.advance(2.0 / 3.0)
    simulation.command(sim.Command(None, hold="a"))
    simulation.command(sim.Command(simulation.clock.now, hold="b"))
    simulation.command(sim.Command(round(simulation.clock.now, 9), hold="gantry"))
    simulation.advance(1.0)
    assert all(simulation.machines[name].is_held for name in ("a", "b", "gantry"))
    with pytest.raises(ValueError, match="too late"):
        simulation.command(sim.Command(0.5, release="a"))


def test_commands_of_controllers_are_not_recorded():
    def back(vehicle):
        yield vehicle.move_to(6.0, 4.0)
        yield vehicle.turn_to(1.0)

    keys = {"at": (4.0, 4.0, 0.0), "controller": back}
    trial = sim.Trial(
        sim.Trial.parse(TRIAL).floorplan, machines={"a": sim.MachineEntry("amr", keys)}
    )
    assert sim.run(trial).trial.commands == ()


def test_a_rejected_command_is_not_recorded():
    simulation = sim.Simulation(sim.Trial.parse(TRIAL))
    simulation.advance(1.0)
    for refused in (
        lambda: simulation.machines["a"].move_to(10.0, 6.5),
        lambda: simulation.machines["a"].twist((99.0, 0.0), 1.0),
        lambda: simulation.machines["gantry"].move_to(99.0, 0.0),
    ):
        with pytest.raises((ValueError, navigation.PlanningError)):
            refused()
    assert simulation.commands == []


@pytest.mark.parametrize(
    ("command", "place", "word"),
    [
        ("{time: 1, machine: a}", "commands[0]", "one of send"),
        ("{time: 1, call: stop}", "commands[0].machine", "a call has a machine"),
        ("{time: 1, machine: z, call: stop}", "commands[0].machine", "'z'"),
        ("{time: 1, machine: a, call: stopp}", "commands[0].call", "stop"),
        ("{time: 1, machine: cart, call: twist}", "commands[0].call", "agv"),
        ("{time: 1, machine: a, call: move_to, arguments: {x: 1}}", "commands[0].call", "'y'"),
        ("{machine: a, call: stop}", "commands[0].time", "time"),
    ],
)
def test_an_impossible_command_to_a_machine_is_rejected(command, place, word):
    with pytest.raises(sim.TrialError) as refused:
        sim.Trial.parse(f"{TRIAL}commands: [{command}]\n")
    assert place in str(refused.value)
    assert word in str(refused.value)


def test_a_command_that_fails_in_the_run_is_named():
    commands = "commands: [{time: 1, machine: a, call: move_to, arguments: {x: 10.0, y: 6.5}}]\n"
    with pytest.raises(ValueError, match="move_to of a at t = 1 s cannot be carried out"):
        sim.run(sim.Trial.parse(TRIAL + commands))


def test_machines_commanded_over_a_bridge_repeat_to_the_byte(tmp_path):
    trial = sim.Trial.load("ariac2023")
    trial = replace(trial, duration=30.0, gantry=sim.GantryEntry("external"))
    recording = sim.Recording(tmp_path / "first")
    exchange = Exchange()
    workcell = Workcell(trial, exchange, recording)
    follow = exchange.topics["/gantry_controller/joint_trajectory"].heard
    move_agv = exchange.services["/ariac/move_agv1"].answer
    point = {"time_from_start": {"sec": 0, "nanosec": 0}, "velocities": []}
    names = [
        "gantry_rotation_joint",
        "gantry_x_axis_joint",
        "gantry_y_axis_joint",
    ]
    for k in range(1, 60):
        workcell.cell.pace.step(0.37 * k - workcell.now)
        if k % 7 == 1:
            at = {"positions": [0.1 * k, -4.0 + 0.05 * k, 1.0]}
            with suppress(ValueError):  # it is disabled
                follow({"joint_names": names, "points": [point | at]}, "")
        if k % 11 == 3:
            move_agv(SimpleNamespace(name="client"), {"location": k % 3})
    workcell.cell.pace.step(30.0 - workcell.now)
    run = workcell.simulation.finish()
    recording.finish(run)
    assert {command.call for command in run.trial.commands} == {"move_to", "drive"}
    recorded(run.trial, tmp_path / "second")
    assert in_bytes(tmp_path / "second") == in_bytes(tmp_path / "first")


@pytest.mark.parametrize(
    ("misuse", "words"),
    [
        (lambda s: s.machines["a"].twist((0.5, 0.1)), ("a.twist", "'seconds'")),
        (lambda s: s.machines["a"].move_to("press"), ("a.move_to", "'y'")),
        (lambda s: s.machines["a"].twist((0.5, 0.1), 1.0, speed=2), ("a.twist", "'speed'")),
        (lambda s: s.machines["gantry"].wait(), ("gantry.wait", "'seconds'")),
        (lambda s: s.machines["a"].next_task(1), ("a.next_task", "takes ()")),
        (lambda s: s.machines["a"].locate(), ("a.locate", "'task'")),
        (lambda s: s.machines["a"].complete("go"), ("a.complete", "takes ()")),
        (lambda s: s.machines["gantry"].locate(place=1), ("gantry.locate", "'task'")),
        (lambda s: s.machines["a"].record("x"), ("record", "'x'")),
        (lambda s: s.machines["gantry"].record("x"), ("record", "'x'")),
        (lambda s: s.machines["gantri"], ("'gantri'", "'gantry'")),
        (lambda s: s.advance("3"), ("advance", "'3'")),
        (lambda s: s.advance(1.0), ("1", "t = 2 s")),
    ],
)
def test_misuse_from_outside_causes_one_sentence_with_the_argument(misuse, words):
    simulation = sim.Simulation(sim.Trial.parse(TRIAL))
    simulation.advance(2.0)
    simulation.advance(2.0)
    with pytest.raises(ValueError) as refused:
        misuse(simulation)
    assert all(word in str(refused.value) for word in words)
    assert simulation.commands == []


def test_misuse_in_a_controller_names_the_line_and_the_argument():
    def hasty(vehicle):
        yield vehicle.twist((0.5, 0.1))

    keys = {"at": (4.0, 4.0, 0.0), "controller": hasty}
    machines = {"a": sim.MachineEntry("amr", keys)}
    trial = sim.Trial(sim.Trial.parse(TRIAL).floorplan, machines=machines)
    with pytest.raises(ValueError, match=r"py, line \d+.*a\.twist.*'seconds'"):
        sim.run(trial)
