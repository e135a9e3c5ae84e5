"""Controllers of vehicles: built-in ones, custom ones, and functions called at a fixed rate."""

from __future__ import annotations

import ast
import inspect
import itertools
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from ...core.custom_code import CodeFolder, CustomCode, Kind, argument_fault
from ...core.scenario import controller_name
from ..caution import Caution
from ..commanding import Steps
from ..controllers import (
    Source,
    external,
    gone_to,
    is_controller,
    loaded,
    oblivious,
    parked,
    pausing,
    source_of,
)
from ..policy_files import SUFFIX
from ..supervision import ControllerError, supervised
from .amr import Amr

ASIDE = 0.5
"""Metres. Distance from the bodies of people at which `avoiding` passes them, if possible."""

AGAIN = 1.0
"""Seconds after which `avoiding` plans around people again."""


def avoiding(vehicle: Amr) -> Steps:
    """Do one task after the other as `pausing`, on routes around people where they are."""
    caution = Caution(vehicle)
    while (task := (yield vehicle.next_task())) is not None:
        while task.next_step is not None:
            people = yield from caution.look()
            if vehicle.avoid({person.name: person.at for person in people}, ASIDE):
                vehicle.stop()
            pose = yield vehicle.locate(task)
            if (yield from gone_to(vehicle, caution, pose, AGAIN)):
                yield vehicle.handle(task)


VEHICLE_CONTROLLERS: dict[str, Callable[[Any], Steps]] = {
    "parked": parked,
    "oblivious": oblivious,
    "pausing": pausing,
    "avoiding": avoiding,
    "external": external,
}
"""The built-in controllers of vehicles."""


NEEDS_RATE = "give rate, at which a function or a class with a method __call__ is called (Hz)"

VEHICLE_CONTROLLER = Kind(
    noun="vehicle controller",
    words="generator function, nor a class with a method __iter__, as a controller is;"
    f" {NEEDS_RATE}",
    accepts=is_controller,
    error=ControllerError,
    builtin=VEHICLE_CONTROLLERS,
)
"""Functions and classes that a vehicle can name as its controller."""


def _returns_twists(code: Any) -> bool:
    if inspect.isclass(code):
        return any("__call__" in vars(base) for base in code.__mro__)
    return inspect.isfunction(code) and not inspect.isgeneratorfunction(code)


FUNCTION = Kind(
    noun="vehicle controller",
    words="function that returns a twist, nor a class with a method __call__: with a rate, a"
    " controller is one of these; omit rate for a generator",
    accepts=_returns_twists,
    error=ControllerError,
)
"""Functions and classes that a vehicle can name as its controller with a rate."""


def program(
    controller: str | Callable[[Any], Any], rate: float | None, folder: CodeFolder
) -> Callable[[Amr], Steps]:
    """Return the supervised controller of a vehicle by its name.

    With a `rate` (Hz), the controller is called at each tick for a twist. `ControllerError` if
    there is no such controller.
    """
    code = loaded(controller, VEHICLE_CONTROLLER, find_program(controller, rate, folder))
    steps = code if rate is None else partial(_steered, code, rate)
    return partial(supervised, controller_name(controller), steps, code=code)


def find_program(
    controller: str | Callable[[Any], Any], rate: float | None, folder: CodeFolder
) -> Source | None:
    """Return the source of a custom controller, or None for a built-in one or a callable.

    `ControllerError` if there is no such controller, or if its rate does not fit.
    """
    if rate is not None and isinstance(controller, str):
        if controller.endswith(SUFFIX):
            raise ControllerError(f"the policy {controller!r} has a rate of its own; omit it")
        if controller in VEHICLE_CONTROLLERS:
            raise ControllerError(f"the vehicle controller {controller!r} has no rate; omit it")
    source = source_of(controller, VEHICLE_CONTROLLER if rate is None else FUNCTION, folder)
    if rate is None and isinstance(source, CustomCode) and _is_plain(source):
        raise ControllerError(
            f"the vehicle controller {controller!r} is no generator; {NEEDS_RATE}"
        )
    return source


def _is_plain(source: CustomCode) -> bool:
    """Return whether a function certainly yields nothing, or a class is called like one."""
    definition = source.definitions()[source.attribute]
    if definition.decorator_list or not isinstance(definition, ast.FunctionDef | ast.ClassDef):
        return False
    if isinstance(definition, ast.ClassDef):
        methods = {node.name for node in definition.body if isinstance(node, ast.FunctionDef)}
        return "__call__" in methods and "__iter__" not in methods and not definition.bases
    return not any(isinstance(node, ast.Yield | ast.YieldFrom) for node in ast.walk(definition))


def _steered(code: Callable[..., Any], rate: float, vehicle: Amr) -> Steps:
    """Call a function, or a new object of a class, at each tick for a twist."""
    function, make = code, code
    if inspect.isclass(code):
        function = make(vehicle) if argument_fault(make, {}) else make()
    for k in itertools.count(1):
        vehicle.begin_mission()
        twist: Sequence[float] | None = function(vehicle)
        until = k / rate
        if twist is not None:
            vehicle.steer(twist, until)
        yield vehicle.until(until)
