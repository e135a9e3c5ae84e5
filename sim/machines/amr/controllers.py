"""Controllers of vehicles: built-in ones, custom ones, and functions called at a fixed rate."""

from __future__ import annotations

import inspect
import itertools
import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from navigation import PlanningError
from navigation.vehicles import Twist

from ...core.custom_code import CodeFolder, CustomCode, Kind
from ...core.entries import Pose
from ..caution import Caution
from ..commanding import Steps
from ..controllers import (
    ControllerError,
    external,
    is_controller,
    oblivious,
    parked,
    supervised,
)
from .amr import Amr
from .drive import RETRY

ASIDE = 0.5
"""Metres. `avoiding` passes people at this distance from their bodies, if it can."""

AGAIN = 1.0
"""Seconds after which `avoiding` plans around people again."""


def pausing(vehicle: Amr) -> Steps:
    """Do one task after the other, at the speed that people allow."""
    caution = Caution(vehicle)
    while (task := (yield vehicle.next_task())) is not None:
        while task.next_step is not None:
            pose = yield vehicle.locate(task)
            if (yield from _gone(vehicle, caution, pose, math.inf)):
                yield vehicle.handle(task)


def avoiding(vehicle: Amr) -> Steps:
    """Do one task after the other as `pausing`, on routes around people where they are."""
    caution = Caution(vehicle)
    while (task := (yield vehicle.next_task())) is not None:
        while task.next_step is not None:
            people = yield from caution.look()
            if vehicle.drive.avoid({person.name: person.at for person in people}, ASIDE):
                vehicle.stop()
            pose = yield vehicle.locate(task)
            if (yield from _gone(vehicle, caution, pose, AGAIN)):
                yield vehicle.handle(task)


def _gone(vehicle: Amr, caution: Caution, pose: Pose, seconds: float) -> Steps:
    """Go to a pose as `Caution.go`; stop where something has closed the way to it."""
    try:
        return (yield from caution.go(pose, seconds=seconds))
    except PlanningError:
        yield vehicle.stop()
        yield vehicle.look(RETRY)
        return False


VEHICLE_CONTROLLERS: dict[str, Callable[[Any], Steps]] = {
    "parked": parked,
    "oblivious": oblivious,
    "pausing": pausing,
    "avoiding": avoiding,
    "external": external,
}
"""The controllers of vehicles that come with Floorwalker."""


VEHICLE_CONTROLLER = Kind(
    noun="vehicle controller",
    words="generator function, nor a class with a method __iter__, as a controller is",
    accepts=is_controller,
    error=ControllerError,
    builtin=VEHICLE_CONTROLLERS,
)
"""The kind of function or class that a vehicle names as its controller."""

FUNCTION = Kind(
    noun="function of twists",
    words="function: with a rate, a controller is a function that returns a twist",
    accepts=lambda found: inspect.isfunction(found) and not inspect.isgeneratorfunction(found),
    error=ControllerError,
)
"""The kind of function that a vehicle names as its controller with a rate."""


def program(
    given: str | Callable[[Any], Any], rate: float | None, folder: CodeFolder
) -> Callable[[Amr], Steps]:
    """Return the controller of a vehicle by its name, supervised.

    With a `rate` (Hz), it is a function that returns a twist each time. `ControllerError` if there
    is no such controller.
    """
    name = given if isinstance(given, str) else getattr(given, "__qualname__", repr(given))
    source = find_program(given, rate, folder)
    found: Any = VEHICLE_CONTROLLERS[given] if isinstance(given, str) and not source else given
    if source is not None:
        found = source.load()
    controller = found if rate is None else partial(_steered, found, rate)
    return partial(supervised, name, controller)


def find_program(
    given: str | Callable[[Any], Any], rate: float | None, folder: CodeFolder
) -> CustomCode | None:
    """Return the source of a custom controller, which is not imported; None for other ones."""
    if not isinstance(given, str) or (rate is None and given in VEHICLE_CONTROLLERS):
        return None
    return folder.find(given, VEHICLE_CONTROLLER if rate is None else FUNCTION)


def _steered(function: Callable[[Amr], Sequence[float] | None], rate: float, me: Amr) -> Steps:
    """Call a function `rate` times a second, and drive with the twist that it returns."""
    for k in itertools.count(1):
        twist = function(me)
        until = k / rate
        if twist is not None and (me.only_waits or not me.disabled):
            stands = me.body.motion.end <= me.now
            if not stands or any(Twist.of(twist)):
                me.twist(twist, until - me.now)
        yield me.until(until)
