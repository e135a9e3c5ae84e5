"""From the name of a controller, as a trial gives it, to the controller."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable
from pathlib import Path

from ..drive import Steps
from ..gantry import GantryRobot
from ..rules import suggestion
from .avoiding import avoiding
from .external import external
from .oblivious import oblivious
from .parked import parked
from .pausing import pausing

Controller = Callable[[GantryRobot], Steps]

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


def find_controller(name: str, folder: Path) -> Controller:
    """The built-in controller of that name, or the one at `package.module:name`.

    Modules are looked up as `import` does, and in `folder`, where the trial stands.
    `ControllerError` says what is missing.
    """
    if name in CONTROLLERS:
        return CONTROLLERS[name]
    module_name, colon, attribute = name.partition(":")
    if not colon:
        raise ControllerError(
            f"no gantry controller is called {name!r}; {suggestion(name, CONTROLLERS)};"
            " your own is package.module:name"
        )
    place = str(folder.resolve())
    sys.path.insert(0, place)
    try:
        module = importlib.import_module(module_name)
    except ImportError as why:
        raise ControllerError(f"the gantry controller {name!r} can't be imported: {why}") from why
    finally:
        sys.path.remove(place)
    controller = getattr(module, attribute, None)
    if not callable(controller):
        raise ControllerError(f"{module_name} has no controller {attribute!r}")
    return controller  # type: ignore[no-any-return]
