"""Faults of commands: names of nothing, and what can't be done at that time."""

from __future__ import annotations

import math
from collections.abc import Iterator

from floorplan import LARGEST, Fault, UserError, height_fault, polygon_fault, suggestion, time_fault

from ..core.commands import COMMANDS, Command
from ..core.scenario import Scenario, spot
from .names import checked_name, machines, people, stations
from .place_checks import names_taken


def command_faults(trial: Scenario) -> Iterator[Fault]:
    """Yield what can't be about the commands of a trial."""
    placed: set[str] = set()
    before = 0.0
    for k, command in enumerate(trial.commands):
        if fault := time_fault(command.time):
            yield fault, (k, "time")
        elif command.time < before:
            yield f"comes before the command in front of it, at {before:g} s", (k, "time")
        before = max(before, command.time)
        if sum(getattr(command, name) is not None for name in COMMANDS) != 1:
            yield f"must be one of {', '.join(COMMANDS)}", (k,)
        for message, key in _faults(command, trial, placed):
            yield message, (k, key)
        if command.block is not None:
            placed.add(command.block.name)
        placed.discard(command.clear or "")


def _faults(command: Command, trial: Scenario, placed: set[str]) -> Iterator[tuple[str, str]]:
    """Yield what can't be about one command, and of which key, while those are `placed`."""
    known = {"send": people(trial), "hold": machines(trial), "release": machines(trial)}
    for key, names in known.items():
        if (name := getattr(command, key)) is not None:
            try:
                checked_name(name, "person" if key == "send" else "machine", names)
            except UserError as why:
                yield str(why), key
    if (command.send is None) != (command.to is None):
        yield "a person is sent to a place: [x, y], or the name of a station or a door", "to"
    elif any(one.name == command.send and one.recorded is not None for one in trial.people):
        yield f"{command.send} walks as measured, and can't be sent anywhere", "send"
    elif command.to is not None:
        yield from ((message, "to") for message in _place_faults(command, trial))
    if (one := command.block) is not None:
        if one.name in names_taken(trial) | placed or any(
            one.name == timed.obstacle.name for timed in trial.obstacles
        ):
            yield f"something else is called {one.name!r} already", "block"
        if fault := polygon_fault(one.footprint):
            yield fault, "block"
        if one.footprint.interiors:
            yield "must have no holes", "block"
        if fault := height_fault(one):
            yield fault, "z"
    if command.clear is not None and command.clear not in placed:
        hint = suggestion(command.clear, placed) if placed else "there is nothing then"
        yield f"nothing that is called {command.clear!r} was put down by then; {hint}", "clear"


def _place_faults(command: Command, trial: Scenario) -> Iterator[str]:
    assert command.to is not None
    at = spot(trial.floorplan, command.to)
    if at is None:
        doors = [door.name for door in trial.floorplan.doors]
        hint = suggestion(str(command.to), [*stations(trial), *doors])
        yield f"no station or door is called {command.to!r}; {hint}"
    elif not all(map(math.isfinite, at)) or max(map(abs, at)) > LARGEST:
        yield f"must be a place, not {command.to!r}"
