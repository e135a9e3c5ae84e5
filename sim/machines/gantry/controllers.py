"""Controllers of gantries by name: built-in baselines, and custom ones as `package.module:name`."""

from __future__ import annotations

from collections.abc import Callable

from ...core.custom_code import CodeFolder, Kind
from ..commanding import Steps
from ..controllers import (
    Source,
    external,
    is_controller,
    oblivious,
    parked,
    pausing,
    source_of,
)
from ..rated import NEEDS_RATE
from ..supervision import ControllerError
from .avoidance import avoiding
from .robot import GantryRobot

Controller = Callable[[GantryRobot], Steps]
"""Function of the gantry that returns a generator of events."""

CONTROLLERS: dict[str, Controller] = {
    "parked": parked,
    "oblivious": oblivious,
    "pausing": pausing,
    "avoiding": avoiding,
    "external": external,
}
"""The built-in controllers."""


CONTROLLER = Kind(
    noun="gantry controller",
    words="generator function, nor a class with a method __iter__, as a controller is;"
    f" {NEEDS_RATE}",
    accepts=is_controller,
    error=ControllerError,
    builtin=CONTROLLERS,
)
"""Functions and classes that a trial can name as the controller of a gantry."""


def controller_source(name: str | Controller, folder: CodeFolder) -> Source | None:
    """Return the source of a custom controller, or None for a built-in one or a callable.

    `ControllerError` if there is no such controller.
    """
    return source_of(name, CONTROLLER, folder)
