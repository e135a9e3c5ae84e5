"""From the name of a controller, as a trial gives it, to the controller."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from floorplan import suggestion

from ..drive import Steps
from ..gantry import GantryRobot
from ..trials.own_code import OwnCodeError, find_own
from .avoiding import avoiding
from .external import external
from .oblivious import oblivious
from .parked import parked
from .pausing import pausing

Controller = Callable[[GantryRobot], Steps]
"""What runs the gantry: called once with it, gives a generator of things to wait for."""

CONTROLLERS: dict[str, Controller] = {
    "parked": parked,
    "oblivious": oblivious,
    "pausing": pausing,
    "avoiding": avoiding,
    "external": external,
}
"""The controllers that come with Floorwalker."""


class ControllerError(ValueError):
    """A gantry controller that can't be found, or that failed while it ran."""


def find_controller(name: str | Controller, folder: Path) -> Controller:
    """Return the built-in controller of that name, or the one at `package.module:name`.

    Modules are looked up in `folder`, where the trial stands, and as `import` does. A controller
    itself is returned as it is. `ControllerError` says what is missing.
    """
    if not isinstance(name, str):
        if callable(name):
            return name
        raise ControllerError(
            f"{name!r} is no gantry controller; give a name, or a function of one argument"
        )
    if name in CONTROLLERS:
        return CONTROLLERS[name]
    if ":" not in name:
        raise ControllerError(
            f"no gantry controller is called {name!r}; {suggestion(name, CONTROLLERS)};"
            " your own is package.module:name"
        )
    try:
        controller = find_own(name, folder)
    except OwnCodeError as why:
        raise ControllerError(f"the gantry controller {why}") from why
    if not callable(controller):
        raise ControllerError(f"{name} is no controller")
    return controller  # type: ignore[no-any-return]
