"""Controllers of vehicles: built-in ones, and custom ones as `package.module:name`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...core.custom_code import Kind
from ..caution import Caution
from ..commanding import Steps
from ..controllers import external, gone_to, is_controller, oblivious, parked, pausing
from ..rated import NEEDS_RATE
from ..supervision import ControllerError
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


VEHICLE_CONTROLLER = Kind(
    noun="vehicle controller",
    words="generator function, nor a class with a method __iter__, as a controller is;"
    f" {NEEDS_RATE}",
    accepts=is_controller,
    error=ControllerError,
    builtin=VEHICLE_CONTROLLERS,
)
"""Functions and classes that a vehicle can name as its controller."""
