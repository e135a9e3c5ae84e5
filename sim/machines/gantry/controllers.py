"""Gantry controllers: built-in baselines, and lookup by name.

A controller is a callable of one argument, the `GantryRobot`, that returns a generator of
things to wait for. Copy one of these files to write your own, and name it in a trial as
`package.module:name`.
"""

from __future__ import annotations

from collections.abc import Callable

from ...core.custom_code import CodeFolder, CustomCode, Kind
from ..commanding import Steps
from ..controllers import ControllerError, external, is_controller, oblivious, parked, pausing
from ..policy_files import SUFFIX, PolicyFile
from .avoidance import avoiding
from .robot import GantryRobot

Controller = Callable[[GantryRobot], Steps]
"""Program of the gantry: called once with it, gives a generator of events to wait for."""

CONTROLLERS: dict[str, Controller] = {
    "parked": parked,
    "oblivious": oblivious,
    "pausing": pausing,
    "avoiding": avoiding,
    "external": external,
}
"""The controllers that come with Floorwalker."""


CONTROLLER = Kind(
    noun="gantry controller",
    words="generator function, nor a class with a method __iter__, as a controller is",
    accepts=is_controller,
    error=ControllerError,
    builtin=CONTROLLERS,
)
"""The kind of function or class that a trial names as its controller."""


def find_controller(name: str | Controller, folder: CodeFolder) -> Controller:
    """Return the built-in controller of that name, or the one at `package.module:name`.

    That one stands in `folder` and is imported. A controller itself is returned as it is.
    `ControllerError` says what is missing.
    """
    source = controller_source(name, folder)
    if source is not None:
        found: Controller = source.load()
        return found
    return CONTROLLERS[name] if isinstance(name, str) else name


def controller_source(name: str | Controller, folder: CodeFolder) -> CustomCode | PolicyFile | None:
    """Return the source of the controller at `package.module:name`, which is not imported.

    None for a built-in one, and for a controller itself. `ControllerError` if it is not there.
    """
    if isinstance(name, str):
        if name in CONTROLLERS:
            return None
        if name.endswith(SUFFIX):
            return PolicyFile.find(name, folder)
        return folder.find(name, CONTROLLER)
    if callable(name):
        return None
    raise ControllerError(
        f"{name!r} is not a gantry controller; give a name, or a function of one argument"
    )
