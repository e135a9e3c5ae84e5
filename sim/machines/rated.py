"""Controllers with a rate: functions, and classes, that are called at each tick for a command."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

from floorplan.files.problems import Fault

from ..core.custom_code import CodeFolder, CustomCode, Kind, argument_fault
from ..core.scenario import controller_name
from .commanding import Steps
from .controllers import Source, loaded, source_of
from .policy_driven import PolicyDriven
from .policy_files import SUFFIX
from .supervision import ControllerError, supervised

NEEDS_RATE = "give rate, at which a function or a class with a method __call__ is called (Hz)"

MOST_RATE = 100.0
"""Hz. Highest rate of a controller."""

NEAR = 0.3
"""Metres. A target of a gantry that is so near to its next step is that step."""

Code = str | Callable[[Any], Any]
"""A controller by its name, or a function or class."""


def rate_faults(rate: float | None) -> Iterator[Fault]:
    """Yield the fault of a rate that is too high."""
    if rate is not None and rate > MOST_RATE:
        yield f"must be at most {MOST_RATE:g} Hz, not {rate:g}", ("rate",)


def program(
    controller: Code, rate: float | None, kind: Kind, folder: CodeFolder
) -> Callable[[Any], Steps]:
    """Return the supervised controller of a machine by its name.

    With a `rate` (Hz), the controller is called at each tick for a command. The error of the kind
    is raised if there is no such controller.
    """
    code = loaded(controller, kind, find_program(controller, rate, kind, folder))
    steps = code if rate is None else partial(_called, code, rate)
    return partial(supervised, controller_name(controller), steps, code=code)


def find_program(
    controller: Code, rate: float | None, kind: Kind, folder: CodeFolder
) -> Source | None:
    """Return the source of a custom controller, or None for a built-in one or a callable.

    `ControllerError` if there is no such controller, or if its rate does not fit.
    """
    if rate is None:
        source = source_of(controller, kind, folder)
        if isinstance(source, CustomCode) and _is_plain(source):
            raise ControllerError(f"the {kind.noun} {controller!r} is no generator; {NEEDS_RATE}")
        return source
    if isinstance(controller, str):
        if controller.endswith(SUFFIX):
            raise ControllerError(f"the policy {controller!r} has a rate of its own; omit it")
        if controller in kind.builtin:
            raise ControllerError(f"the {kind.noun} {controller!r} has no rate; omit it")
    words = (
        "function that returns a command, nor a class with a method __call__: with a rate, a"
        " controller is one of these; omit rate for a generator"
    )
    return source_of(
        controller, replace(kind, words=words, accepts=_returns_commands, builtin={}), folder
    )


def _returns_commands(code: Any) -> bool:
    if inspect.isclass(code):
        return any("__call__" in vars(base) for base in code.__mro__)
    return inspect.isfunction(code) and not inspect.isgeneratorfunction(code)


def _is_plain(source: CustomCode) -> bool:
    """Return whether a function certainly yields nothing, or a class is called like one."""
    definition = source.definitions()[source.attribute]
    if definition.decorator_list or not isinstance(definition, ast.FunctionDef | ast.ClassDef):
        return False
    if isinstance(definition, ast.ClassDef):
        methods = {node.name for node in definition.body if isinstance(node, ast.FunctionDef)}
        return "__call__" in methods and "__iter__" not in methods and not definition.bases
    return not any(isinstance(node, ast.Yield | ast.YieldFrom) for node in ast.walk(definition))


def _called(code: Callable[..., Any], rate: float, machine: PolicyDriven) -> Steps:
    """Call a function, or a new object of a class, at each tick for a command."""
    function, make = code, code
    if inspect.isclass(code):
        function = make(machine) if argument_fault(make, {}) else make()

    def chosen() -> Steps:
        machine.begin_mission()
        return function(machine)
        yield

    yield from machine.act_at_ticks(rate, chosen, NEAR)
