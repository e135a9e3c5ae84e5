"""Controllers of all machines: built-in ones, and custom ones by name.

A controller is a callable of one argument, the machine, that returns a generator of events.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from typing import Any

from navigation import PlanningError

from ..core.custom_code import CodeFolder, CustomCode, Kind
from ..core.entries import Pose
from .caution import Caution
from .commanded import CommandedMachine
from .commanding import RETRY, Steps
from .policy_files import SUFFIX, PolicyFile
from .tasked import TaskedMachine

STAY = ("parked", "external")
"""Built-in controllers that do not move a machine without a command."""

Source = CustomCode | PolicyFile
"""Source of a custom controller, which is not imported before its method `load`."""


def parked(machine: CommandedMachine) -> Steps:
    """Do nothing."""
    return
    yield


def oblivious(machine: TaskedMachine) -> Steps:
    """Do tasks in order on straight paths, and ignore people."""
    while (task := (yield machine.next_task())) is not None:
        yield machine.do(task)


def pausing(machine: TaskedMachine) -> Steps:
    """Do one task after the other, at the speed that people allow."""
    caution = Caution(machine)
    while (task := (yield machine.next_task())) is not None:
        while task.next_step is not None:
            pose = yield machine.locate(task)
            if (yield from gone_to(machine, caution, pose, math.inf)):
                yield machine.handle(task)


def gone_to(machine: CommandedMachine, caution: Caution, pose: Pose, seconds: float) -> Steps:
    """Go to a pose as `Caution.go`, and stop if there is no path any more."""
    try:
        return (yield from caution.go(pose, seconds=seconds))
    except PlanningError:
        yield machine.stop()
        yield machine.look(RETRY)
        return False


def external(machine: CommandedMachine) -> Steps:
    """Do nothing, because external code commands the machine."""
    return
    yield


def is_controller(code: object) -> bool:
    """Return whether an object is a generator function, or a class with a method `__iter__`."""
    if inspect.isclass(code):
        return hasattr(code, "__iter__")
    return inspect.isfunction(code) and inspect.isgeneratorfunction(inspect.unwrap(code))


def source_of(
    controller: str | Callable[[Any], Any], kind: Kind, folder: CodeFolder
) -> Source | None:
    """Return the source of a custom controller, or None for a built-in one or a callable.

    The error of the `kind` is raised if there is no such controller.
    """
    if isinstance(controller, str):
        if controller in kind.builtin:
            return None
        if controller.endswith(SUFFIX):
            return PolicyFile.find(controller, folder)
        return folder.find(controller, kind)
    if callable(controller):
        return None
    raise kind.error(
        f"{controller!r} is not a {kind.noun}; give a name, or a function of one argument"
    )


def loaded(
    controller: str | Callable[[Any], Any], kind: Kind, source: Source | None
) -> Callable[[Any], Any]:
    """Return a controller by its name and source, or the callable itself."""
    if source is not None:
        code: Callable[[Any], Any] = source.load()
        return code
    builtin: Callable[[Any], Any]
    builtin = kind.builtin[controller] if isinstance(controller, str) else controller
    return builtin
