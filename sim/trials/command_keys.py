"""The keys of commands: in a trial file, or in a file of their own."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import BeforeValidator, Discriminator, Field, Tag

from floorplan import (
    NotNegative,
    Obstacle,
    ObstacleSchema,
    Pair,
    Range,
    Strictly,
    UserError,
    footprint,
    read_yaml,
)

from ..core.commands import COMMANDS, Command
from ..core.keys import Keys
from ..core.scenario import Scenario, TrialError
from .command_checks import command_faults

_Made = TypeVar("_Made", bound=Scenario)


class _Keys(Keys):
    stands_for = Command
    time: NotNegative


class _Send(_Keys):
    send: str
    to: Pair | str


class _Block(ObstacleSchema):
    time: NotNegative
    block: Annotated[str, Field(min_length=1)]
    z: Range = (0.0, 1.0)

    def value(self) -> Command:
        return Command(self.time, block=Obstacle(self.block, footprint(self), *self.z))


class _Clear(_Keys):
    clear: str


class _Hold(_Keys):
    hold: str


class _Release(_Keys):
    release: str


def _one_command(value: Any) -> Any:
    if isinstance(value, dict) and len(value.keys() & {*COMMANDS}) != 1:
        raise UserError(f"give a time and one of {', '.join(COMMANDS)}")
    return value


def _form(value: Any) -> str:
    """Return which command it is, by a word that is none of its keys."""
    named = (name for name in COMMANDS if isinstance(value, dict) and name in value)
    return f"to {next(named, COMMANDS[0])}"


_Command = Annotated[
    Annotated[
        Annotated[_Send, Tag("to send")]
        | Annotated[_Block, Tag("to block")]
        | Annotated[_Clear, Tag("to clear")]
        | Annotated[_Hold, Tag("to hold")]
        | Annotated[_Release, Tag("to release")],
        Discriminator(_form),
    ],
    BeforeValidator(_one_command),
]

CommandEntries = Annotated[
    Annotated[str, Tag("file")] | Annotated[list[_Command], Tag("list")],
    Discriminator(lambda value: "file" if isinstance(value, str) else "list"),
]
"""Commands in order of time, or the file that has them."""


class _CommandFile(Strictly):
    commands: list[_Command]


class _OneCommand(Strictly):
    command: _Command


def commanded(trial: _Made, path: Path) -> _Made:
    """Return the trial with the commands in the file at `path`.

    `TrialError` names the file, and the lines in it that can't be or can't be in this trial.
    """
    document = read_yaml(path, TrialError)
    commands = commands_of(document.checked(_CommandFile, TrialError).commands)
    made = replace(trial, commands=commands)
    problems = [document.problem(said, "commands", *at) for said, at in command_faults(made)]
    if problems:
        raise TrialError(document.file, problems)
    return made


def commands_of(entries: list[Any]) -> tuple[Command, ...]:
    """Return the commands that the keys stand for."""
    return tuple(entry.value() for entry in entries)


def read_command(keys: Any) -> Command:
    """Return the command with these keys; pydantic's `ValidationError` says what is wrong."""
    command: Command = _OneCommand.model_validate({"command": keys}).command.value()
    return command
