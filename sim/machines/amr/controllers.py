"""Controllers of vehicles: built-in ones, custom ones, and functions called at a fixed rate."""

from __future__ import annotations

import ast
import inspect
import itertools
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from navigation.vehicles import Twist

from ...core.custom_code import CodeFolder, CustomCode, Definition, Kind, argument_fault
from ...core.scenario import controller_name
from ..caution import Caution
from ..commanding import Steps
from ..controllers import (
    ControllerError,
    external,
    gone_to,
    is_controller,
    oblivious,
    parked,
    pausing,
    supervised,
)
from ..policy_files import SUFFIX, PolicyFile
from .amr import Amr

ASIDE = 0.5
"""Metres. `avoiding` passes people at this distance from their bodies, if it can."""

AGAIN = 1.0
"""Seconds after which `avoiding` plans around people again."""


def avoiding(vehicle: Amr) -> Steps:
    """Do one task after the other as `pausing`, on routes around people where they are."""
    caution = Caution(vehicle)
    while (task := (yield vehicle.next_task())) is not None:
        while task.next_step is not None:
            people = yield from caution.look()
            if vehicle.drive.avoid({person.name: person.at for person in people}, ASIDE):
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
"""The controllers of vehicles that come with Floorwalker."""


NEEDS_RATE = "give rate, at which a function or a class with a method __call__ is called (Hz)"

VEHICLE_CONTROLLER = Kind(
    noun="vehicle controller",
    words="generator function, nor a class with a method __iter__, as a controller is;"
    f" {NEEDS_RATE}",
    accepts=is_controller,
    error=ControllerError,
    builtin=VEHICLE_CONTROLLERS,
)
"""The kind of function or class that a vehicle names as its controller."""


def _returns_twists(found: Any) -> bool:
    if inspect.isclass(found):
        return any("__call__" in vars(base) for base in found.__mro__)
    return inspect.isfunction(found) and not inspect.isgeneratorfunction(found)


FUNCTION = Kind(
    noun="vehicle controller",
    words="function that returns a twist, nor a class with a method __call__: with a rate, a"
    " controller is one of these; omit rate for a generator",
    accepts=_returns_twists,
    error=ControllerError,
)
"""The kind of function or class that a vehicle names as its controller with a rate."""


def program(
    given: str | Callable[[Any], Any], rate: float | None, folder: CodeFolder
) -> Callable[[Amr], Steps]:
    """Return the controller of a vehicle by its name, supervised.

    With a `rate` (Hz), it is called each time for a twist. `ControllerError` if there is no such
    controller.
    """
    source = find_program(given, rate, folder)
    found: Any = VEHICLE_CONTROLLERS[given] if isinstance(given, str) and not source else given
    if source is not None:
        found = source.load()
    controller = found if rate is None else partial(_steered, found, rate)
    return partial(supervised, controller_name(given), controller, code=found)


def find_program(
    given: str | Callable[[Any], Any], rate: float | None, folder: CodeFolder
) -> CustomCode | PolicyFile | None:
    """Return the source of a custom controller, which is not imported; None for other ones."""
    if not isinstance(given, str):
        return None
    if given.endswith(SUFFIX):
        if rate is None:
            return PolicyFile.find(given, folder)
        raise ControllerError(f"the policy {given!r} has a rate of its own; omit it")
    if given in VEHICLE_CONTROLLERS:
        if rate is None:
            return None
        raise ControllerError(f"the vehicle controller {given!r} has no rate; omit it")
    source = folder.find(given, VEHICLE_CONTROLLER if rate is None else FUNCTION)
    if rate is None and _is_plain_function(source.definitions()[source.attribute]):
        raise ControllerError(f"the vehicle controller {given!r} is no generator; {NEEDS_RATE}")
    return source


def _is_plain_function(definition: Definition) -> bool:
    """Return whether a function certainly yields nothing, or a class is called like one."""
    if definition.decorator_list or not isinstance(definition, ast.FunctionDef | ast.ClassDef):
        return False
    if isinstance(definition, ast.ClassDef):
        methods = {node.name for node in definition.body if isinstance(node, ast.FunctionDef)}
        return "__call__" in methods and "__iter__" not in methods and not definition.bases
    return not any(isinstance(node, ast.Yield | ast.YieldFrom) for node in ast.walk(definition))


def _steered(given: Callable[..., Any], rate: float, me: Amr) -> Steps:
    """Call a function, or a new object of a class, `rate` times a second for a twist to drive."""
    function, make = given, given
    if inspect.isclass(given):
        function = make(me) if argument_fault(make, {}) else make()
    for k in itertools.count(1):
        me.begin_mission()
        twist: Sequence[float] | None = function(me)
        until = k / rate
        if twist is not None and (me.only_waits or not me.disabled):
            stands = me.body.motion.end <= me.now
            if not stands or any(Twist.of(twist)):
                me.twist(twist, until - me.now)
        yield me.until(until)
