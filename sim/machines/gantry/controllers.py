"""Gantry controllers: built-in baselines, lookup by name, and error reports.

A controller is a callable of one argument, the `GantryRobot`, that returns a generator of
things to wait for. Copy one of these files to write your own, and name it in a trial as
`package.module:name`.
"""

from __future__ import annotations

import ast
import inspect
import traceback
from collections.abc import Callable, Generator
from functools import partial
from pathlib import Path
from typing import Any

from simpy.events import Event
from simpy.exceptions import Interrupt

from floorplan import UserError
from floorplan.files.problems import suggestion

from ...core.custom_code import (
    REFUSED,
    CodeLocation,
    Definition,
    Kind,
    OwnCodeError,
    find_source,
    import_own,
    in_words,
    is_plain,
    methods,
)
from .avoidance import Caution, avoiding
from .drive import Steps
from .robot import GantryRobot


def parked(gantry: GantryRobot) -> Steps:
    """Do nothing at all."""
    return
    yield


def oblivious(gantry: GantryRobot) -> Steps:
    """Do one task after the other, on the straight path to it."""
    while (task := (yield gantry.next_task())) is not None:
        yield gantry.do(task)


def external(gantry: GantryRobot) -> Steps:
    """Do nothing of its own: whoever has the simulation commands the gantry."""
    return
    yield


def pausing(gantry: GantryRobot) -> Steps:
    """Do one task after the other, on the straight path to it, at the speed that people allow."""
    caution = Caution(gantry)
    while (task := (yield gantry.next_task())) is not None:
        while task.next_step is not None:
            yield from caution.go((yield gantry.locate(task)))
            yield gantry.handle(task)


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
) -> CodeLocation | None:
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


MOST_AT_ONCE = 1000
"""Number of times a controller may yield at one instant; more count as endless."""


def supervised(name: str, controller: Controller, gantry: GantryRobot) -> Steps:
    """Return the steps of `controller`, which a trial names `name`.

    `ControllerError` names the fault: it raised something, yielded something that can't be
    waited for, or is no generator at all.
    """
    steps: Any = None
    try:
        steps = controller(gantry)
        if not isinstance(steps, Generator):
            steps = _iterated(steps)
        yield from _checked(steps, gantry)
    except Exception as why:
        raise ControllerError(
            f"the gantry controller {name!r} failed at t = {gantry.now:g} s"
            f"{_place(why, controller, steps)}: {_fault(why)}"
        ) from why


def _fault(why: Exception) -> str:
    """Return the error's text with its type; of an interrupt, the remedy."""
    if isinstance(why, Interrupt):
        return f"it was interrupted by {why.cause!r} where no `except simpy.Interrupt` catches it"
    return in_words(why)


def _iterated(steps: Any) -> Steps:
    if not hasattr(steps, "__iter__"):
        raise TypeError(f"what it returned, {steps!r}, is no generator")
    yield from steps


def _checked(steps: Steps, gantry: GantryRobot) -> Steps:
    """Yield the same steps, if each is something that can be waited for."""
    go_on: Callable[[], Event] = partial(next, steps)
    now, yields = gantry.now, 0
    while True:
        now, yields = gantry.now, yields + 1 if gantry.now == now else 0
        if yields > MOST_AT_ONCE:
            raise RuntimeError("it goes on for ever without letting time pass")
        try:
            event = go_on()
        except StopIteration:
            return
        if not isinstance(event, Event):
            raise TypeError(f"it yielded {event!r}, not something that the gantry's methods return")
        try:
            answer = yield event
            go_on = partial(steps.send, answer)
        except Exception as why:
            go_on = partial(steps.throw, why)


def _place(why: Exception, controller: Controller, steps: Any) -> str:
    """Return file and line of the controller at which it failed, in brackets, where known."""
    try:
        source = inspect.getsourcefile(controller)
    except TypeError:
        return ""
    frame = getattr(steps, "gi_frame", None)
    lines = [frame.f_lineno] if frame is not None and frame.f_code.co_filename == source else []
    lines += [f.lineno for f in traceback.extract_tb(why.__traceback__) if f.filename == source]
    return f" ({Path(source).name}, line {lines[-1]})" if source and lines else ""


__all__ = [
    "CONTROLLERS",
    "Caution",
    "Controller",
    "ControllerError",
    "avoiding",
    "controller_source",
    "find_controller",
    "oblivious",
    "parked",
    "pausing",
    "supervised",
]
