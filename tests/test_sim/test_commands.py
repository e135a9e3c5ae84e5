"""A run with commands from outside repeats from the file that recorded them."""

import random

import pytest
from shapely.geometry import box

import sim
from floorplan import Obstacle

TRIAL = """
floorplan: ariac2023
duration: 45
people: [{name: p, personality: indifferent, count: 4, at: anywhere}]
gantry: {controller: avoiding, repeat: true, jobs: [{pick: bin2, place: agv1, part: pump}]}
agvs:
  agv1: [{time: 10, to: assembly_front}]
  agv2: {yield: true, moves: [{time: 3, to: assembly_back}, {time: 25, to: kitting}]}
"""


def interfere(simulation, chance):
    """Advance by irregular steps to the end, with random commands in between, as from a viewer."""
    placed = []
    while not simulation.over:
        simulation.advance(simulation.clock.now + chance.uniform(0.05, 2.0))
        at = int(simulation.clock.now * 1000 + 1) / 1000
        machine = chance.choice(["gantry", "agv1", "agv2"])
        match chance.choice(["send", "block", "clear", "hold", "release"]):
            case "send":
                place = (chance.uniform(-15, -1), chance.uniform(-10, 10))
                to = chance.choice(["station1", "station3", place])
                command = sim.Command(at, send=f"p{chance.randint(1, 4)}", to=to)
            case "block":
                x, y = chance.uniform(-14, -3), chance.uniform(-9, 9)
                name = f"box{len(simulation.commands)}"
                command = sim.Command(
                    at,
                    block=Obstacle(name=name, footprint=box(x, y, x + 1, y + 1), bottom=0, top=1),
                )
                placed.append(name)
            case "clear" if placed:
                command = sim.Command(at, clear=placed.pop())
            case "hold":
                command = sim.Command(at, hold=machine)
            case _:
                command = sim.Command(at, release=machine)
        simulation.command(command)


def test_a_run_with_commands_repeats_byte_for_byte(tmp_path):
    trial = sim.Trial.parse(TRIAL)
    first, second = (sim.Recording(tmp_path / name) for name in ("first", "second"))
    simulation = sim.Simulation(trial, first)
    interfere(simulation, random.Random(3))
    first.finish(simulation.finish())
    assert len(simulation.commands) > 20
    again = sim.Trial.parse(f"{TRIAL}commands: {first.folder / 'commands.yaml'}\n")
    second.finish(sim.run(again, second))
    for file in first.folder.iterdir():
        if file.name != "summary.json":
            assert file.read_bytes() == (second.folder / file.name).read_bytes(), file.name


@pytest.mark.parametrize(
    ("commands", "problem"),
    [
        ("[{time: 1}]", "commands[0]: give a time and one of send, block, clear, hold, release"),
        ("[{time: 1, send: operator}]", "commands[0].to: a person is sent to a place"),
        ("[{time: 1, hold: gantry, for: 3}]", "commands[0].for: unknown key"),
        ("[{time: 1, send: operator, to: statoin2}]", "did you mean 'station2'?"),
        ("[{time: 5, hold: gantry}, {time: 1, release: gantry}]", "before the previous command"),
        ("[{time: 1, block: bin2, x: [0, 1], y: [0, 1]}]", "'bin2' already"),
        ("[{time: 1, clear: crate}]", "nothing that is called 'crate' was put down"),
        ("none.yaml", "no such file: 'none.yaml'"),
    ],
)
def test_invalid_commands_are_rejected_with_their_place(commands, problem):
    text = f"floorplan: ariac2023\npeople: [{{name: operator}}]\ncommands: {commands}\n"
    with pytest.raises(sim.TrialError) as refused:
        sim.Trial.parse(text, file="mine.yaml")
    assert "mine.yaml: line 3" in str(refused.value)
    assert problem in str(refused.value)


def test_a_late_command_or_one_of_another_machine_is_rejected():
    simulation = sim.Simulation(sim.Trial.parse(TRIAL))
    simulation.advance(10.0)
    with pytest.raises(ValueError, match="comes too late"):
        simulation.command(sim.Command(5.0, hold="gantry"))
    with pytest.raises(sim.TrialError, match="no person is called 'q'"):
        simulation.command(sim.Command(12.0, send="q", to="station1"))
    assert simulation.commands == []
