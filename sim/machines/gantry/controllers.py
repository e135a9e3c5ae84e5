"""Gantry controllers: built-in baselines, lookup by name, and error reports.

A controller is a callable of one argument, the `GantryRobot`, that returns a generator of
things to wait for. Copy one of these files to write your own, and name it in a trial as
`package.module:name`.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Generator
from functools import partial
from pathlib import Path
from typing import Any

from simpy.events import Event
from simpy.exceptions import Interrupt

from floorplan import UserError

from ...core.custom_code import CodeFolder, CustomCode, Kind, in_words, line_in
from ..caution import Caution
from ..commanded import CommandedMachine
from ..commanding import Steps
from .avoidance import avoiding
from .robot import GantryRobot


def parked(gantry: CommandedMachine) -> Steps:
    """Do nothing."""
    return
    yield


def oblivious(gantry: CommandedMachine) -> Steps:
    """Do tasks in order on straight paths, and ignore people."""
    while (task := (yield gantry.next_task())) is not None:
        yield gantry.do(task)


def external(gantry: CommandedMachine) -> Steps:
    """Do nothing, because external code commands the gantry."""
    return
    yield


def pausing(gantry: CommandedMachine) -> Steps:
    """Do tasks in order on straight paths, as fast as people allow."""
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


class ControllerError(UserError):
    """Error of a gantry controller that cannot be found or that failed."""


def _is_controller(found: object) -> bool:
    if inspect.isclass(found):
        return hasattr(found, "__iter__")
    return inspect.isfunction(found) and inspect.isgeneratorfunction(inspect.unwrap(found))


CONTROLLER = Kind(
    noun="gantry controller",
    words="generator function, nor a class with a method __iter__, as a controller is",
    accepts=_is_controller,
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


def controller_source(name: str | Controller, folder: CodeFolder) -> CustomCode | None:
    """Return the source of the controller at `package.module:name`, which is not imported.

    None for a built-in one, and for a controller itself. `ControllerError` if it is not there.
    """
    if isinstance(name, str):
        if name in CONTROLLERS:
            return None
        return folder.find(name, CONTROLLER)
    if callable(name):
        return None
    raise ControllerError(
        f"{name!r} is not a gantry controller; give a name, or a function of one argument"
    )


MOST_AT_ONCE = 1000
"""Number of times a controller may yield at one instant; more count as endless."""


def supervised(name: str, controller: Callable[[Any], Steps], gantry: CommandedMachine) -> Steps:
    """Return the steps of `controller`, which a trial names `name`.

    `ControllerError` names the fault: it raised something, yielded something that can't be
    waited for, or is not a generator at all.
    """
    steps: Any = None
    try:
        steps = controller(gantry)
        if not isinstance(steps, Generator):
            steps = _iterated(steps)
        yield from _checked(steps, gantry)
    except Exception as why:
        raise ControllerError(
            f"the {gantry.shape.kind} controller {name!r} failed at t = {gantry.now:g} s"
            f"{_place(why, controller, steps)}: {_fault(why)}"
        ) from why


def _fault(why: Exception) -> str:
    """Return the error's text with its type; of an interrupt, the remedy."""
    if isinstance(why, Interrupt):
        return f"it was interrupted by {why.cause!r} where no `except simpy.Interrupt` catches it"
    return in_words(why)


def _iterated(steps: Any) -> Steps:
    if not hasattr(steps, "__iter__"):
        raise TypeError(f"what it returned, {steps!r}, is not a generator")
    yield from steps


def _checked(steps: Steps, gantry: CommandedMachine) -> Steps:
    """Yield the same steps, if each is something that can be waited for."""
    go_on: Callable[[], Event] = partial(next, steps)
    now, yields = gantry.now, 0
    while True:
        now, yields = gantry.now, yields + 1 if gantry.now == now else 0
        if yields > MOST_AT_ONCE:
            raise RuntimeError("it never lets time pass")
        try:
            event = go_on()
        except StopIteration:
            return
        if not isinstance(event, Event):
            raise TypeError(
                f"it yielded {event!r}, not something that the {gantry.shape.kind}'s methods return"
            )
        try:
            answer = yield event
            go_on = partial(steps.send, answer)
        except Exception as why:
            go_on = partial(steps.throw, why)


def _place(why: Exception, controller: Callable[[Any], Steps], steps: Any) -> str:
    """Return file and line of the controller at which it failed, in brackets, where known."""
    try:
        source = inspect.getsourcefile(controller)
    except TypeError:
        return ""
    if place := line_in(why, {source}):
        return place
    frame = getattr(steps, "gi_frame", None)  # what it yielded is judged outside of it
    if source is None or frame is None or frame.f_code.co_filename != source:
        return ""
    return f" ({Path(source).name}, line {frame.f_lineno})"


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
