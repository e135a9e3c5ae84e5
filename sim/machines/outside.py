"""Commands to machines from outside: their methods, and their arguments as files have them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from floorplan.files.problems import suggestion
from navigation import Motion, Piece

from ..core.body import Machine
from ..core.custom_code import argument_fault
from .agv.agv import Agv
from .amr.amr import Amr
from .gantry.robot import GantryRobot
from .tasked import TaskedMachine
from .tasks import Task

CLASSES: Mapping[str, type[Machine]] = {"gantry": GantryRobot, "agv": Agv, "amr": Amr}
"""Classes of the machines of built-in kinds."""


def call_fault(kind: str, method: str, arguments: Mapping[str, Any]) -> str:
    """Return the fault of a command to a machine of a built-in kind, or an empty text."""
    machine = CLASSES.get(kind)
    names = [name for name in dir(machine) if hasattr(getattr(machine, name), "is_command")]
    if machine is None:
        return ""
    if method in names:
        return argument_fault(partial(getattr(machine, method), None), arguments)
    return f"a machine of the kind {kind} has no command {method!r}; {suggestion(method, names)}"


def written_arguments(arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Return arguments as plain values: motions as lists of pieces, tasks as numbers."""
    return {name: _written(value) for name, value in arguments.items()}


def given_arguments(machine: Machine, written: Mapping[str, Any]) -> dict[str, Any]:
    """Return the arguments of a method of a machine from their plain values."""
    arguments = dict(written)
    if "motion" in arguments:
        arguments["motion"] = Motion(tuple(map(_piece, arguments["motion"])))
    if "task" in arguments and isinstance(machine, TaskedMachine):
        arguments["task"] = machine.tasks.numbered(arguments["task"])
    return arguments


def _piece(written: Sequence[Any]) -> Piece:
    begin, end, x, y, rotation = written
    return Piece(begin, end, tuple(x), tuple(y), tuple(rotation))


def _written(value: Any) -> Any:
    if isinstance(value, Motion):
        return [_written(tuple(piece)) for piece in value.pieces]
    if isinstance(value, Task):
        return value.number
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, list | tuple):
        return [_written(item) for item in value]
    return value
