"""Commands from outside: methods of machines and people, and their arguments as in files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

import bdi
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
    if kind not in CLASSES:
        return ""
    return method_fault(CLASSES[kind], f"a machine of the kind {kind}", method, arguments)


def method_fault(cls: type, noun: str, method: str, arguments: Mapping[str, Any]) -> str:
    """Return the fault of a call of a command of a class, or an empty text."""
    names = [name for name in dir(cls) if hasattr(getattr(cls, name), "is_command")]
    if method in names:
        return argument_fault(partial(getattr(cls, method), None), arguments)
    return f"{noun} has no command {method!r}; {suggestion(method, names)}"


def written_arguments(arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Return arguments as plain values: motions as pieces, tasks as numbers, actions as text."""
    return {name: _written(value) for name, value in arguments.items()}


def given_arguments(commanded: object, written: Mapping[str, Any]) -> dict[str, Any]:
    """Return the arguments of a method of a machine or person from their plain values."""
    arguments = dict(written)
    if "motion" in arguments:
        arguments["motion"] = Motion(tuple(map(_piece, arguments["motion"])))
    if "action" in arguments:
        arguments["action"] = bdi.parse_literal(arguments["action"])
    if "task" in arguments and isinstance(commanded, TaskedMachine):
        arguments["task"] = commanded.tasks.numbered(arguments["task"])
    return arguments


def _piece(written: Sequence[Any]) -> Piece:
    begin, end, x, y, rotation = written
    return Piece(begin, end, tuple(x), tuple(y), tuple(rotation))


def _written(value: Any) -> Any:
    if isinstance(value, Motion):
        return [_written(tuple(piece)) for piece in value.pieces]
    if isinstance(value, Task):
        return value.number
    if isinstance(value, bdi.Literal):
        return str(value)
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, list | tuple):
        return [_written(item) for item in value]
    return value
