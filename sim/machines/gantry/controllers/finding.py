"""Controllers by the names that a trial gives."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Callable
from pathlib import Path

from floorplan import UserError, suggestion

from ....core.own_code import import_own
from ....core.own_source import (
    REFUSED,
    Definition,
    Kind,
    OwnCodeError,
    Source,
    find_source,
    is_plain,
    methods,
)
from ..drive import Steps
from ..robot import GantryRobot
from .avoiding import avoiding
from .external import external
from .oblivious import oblivious
from .parked import parked
from .pausing import pausing

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


def _may_be_controller(definition: Definition) -> bool:
    if isinstance(definition, ast.ClassDef):
        return not is_plain(definition) or "__iter__" in methods(definition)
    return isinstance(definition, ast.FunctionDef) and (
        bool(definition.decorator_list) or _yields(definition)
    )


def _yields(function: ast.FunctionDef) -> bool:
    """Return True if `yield` stands in the function itself, and not only in one inside it."""
    left: list[ast.AST] = [*function.body]
    while left:
        node = left.pop()
        if isinstance(node, ast.Yield | ast.YieldFrom):
            return True
        if not isinstance(node, _SCOPES):
            left += ast.iter_child_nodes(node)
    return False


def _is_controller(found: object) -> bool:
    if inspect.isclass(found):
        return hasattr(found, "__iter__")
    return inspect.isfunction(found) and inspect.isgeneratorfunction(inspect.unwrap(found))


_SCOPES = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef, ast.Lambda)

CONTROLLER = Kind(
    words="generator function, nor a class with a method __iter__, as a controller is",
    written=_may_be_controller,
    made=_is_controller,
)
"""The kind of function or class that a trial names as its controller."""


class ControllerError(UserError):
    """A gantry controller that can't be found, or that failed while it ran."""


def find_controller(name: str | Controller, folder: Path, *, own_code: bool = True) -> Controller:
    """Return the built-in controller of that name, or the one at `package.module:name`.

    That one stands in `folder` and is imported; without `own_code` it is refused. A controller
    itself is returned as it is. `ControllerError` says what is missing.
    """
    source = controller_source(name, folder, own_code=own_code)
    if source is None:
        return CONTROLLERS[name] if isinstance(name, str) else name
    try:
        found: Controller = import_own(source)
    except OwnCodeError as why:
        raise ControllerError(f"the gantry controller {why}") from why
    return found


def controller_source(
    name: str | Controller, folder: Path, *, own_code: bool = True
) -> Source | None:
    """Return the source of the controller at `package.module:name`, which is not imported.

    None for a built-in one, and for a controller itself. `ControllerError` is as of
    `find_controller`, as far as the source shows what is missing.
    """
    if not isinstance(name, str):
        if callable(name):
            return None
        raise ControllerError(
            f"{name!r} is no gantry controller; give a name, or a function of one argument"
        )
    if name in CONTROLLERS:
        return None
    if ":" not in name:
        raise ControllerError(
            f"no gantry controller is called {name!r}; {suggestion(name, CONTROLLERS)};"
            " your own is package.module:name"
        )
    if not own_code:
        raise ControllerError(f"the gantry controller {name!r}: {REFUSED}")
    try:
        return find_source(name, folder, CONTROLLER)
    except OwnCodeError as why:
        raise ControllerError(f"the gantry controller {why}") from why
