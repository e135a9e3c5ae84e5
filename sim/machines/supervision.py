"""Supervision of controllers: their errors name the controller, the time and the line."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Generator
from functools import partial
from typing import Any

from simpy.events import Event
from simpy.exceptions import Interrupt

from floorplan import UserError

from ..core.custom_code import FLOORWALKER, code_of, file_of, in_words, own_line
from .commanded import CommandedMachine
from .commanding import Steps

MOST_AT_ONCE = 1000
"""Number of events that a controller may yield at one time. More are an endless loop."""


class ControllerError(UserError):
    """Error of a controller that cannot be found or that failed."""


def supervised(
    name: str, controller: Callable[[Any], Steps], machine: CommandedMachine, code: Any = None
) -> Steps:
    """Return the steps of `controller`, whose name in the trial is `name`.

    `ControllerError` if it raises an error, is no generator, or yields something other than an
    event. `code` is the custom code that it calls, by default the controller itself.
    """
    steps: Any = None
    try:
        steps = controller(machine)
        if not isinstance(steps, Generator):
            steps = _iterated(steps)
        yield from _checked(steps, machine)
    except Exception as why:
        raise ControllerError(
            f"the {machine.shape.kind} controller {name!r} failed at t = {machine.now:g} s"
            f"{_place(why, controller if code is None else code, steps)}: {_fault(why)}"
        ) from why


def _fault(why: Exception) -> str:
    """Return the text of an error with its type, or the remedy for an interrupt."""
    if isinstance(why, Interrupt):
        return f"it was interrupted by {why.cause!r} where no `except simpy.Interrupt` catches it"
    return in_words(why)


def _iterated(steps: Any) -> Steps:
    if isinstance(steps, tuple) or not hasattr(steps, "__iter__"):
        raise TypeError(
            f"what it returned, {steps!r}, is not a generator; if that is a twist, give a rate"
        )
    yield from steps


def _checked(steps: Steps, machine: CommandedMachine) -> Steps:
    """Yield the same steps. `TypeError` if one is not an event."""
    proceed: Callable[[], Event] = partial(next, steps)
    now, yields = machine.now, 0
    while True:
        now, yields = machine.now, yields + 1 if machine.now == now else 0
        if yields > MOST_AT_ONCE:
            raise RuntimeError("it never lets time pass")
        try:
            event = proceed()
        except StopIteration:
            return
        if not isinstance(event, Event):
            raise TypeError(
                f"it yielded {event!r}, not something that the {machine.shape.kind}'s methods"
                " return"
            )
        try:
            answer = yield event
            proceed = partial(steps.send, answer)
        except Exception as why:
            proceed = partial(steps.throw, why)


def _place(why: Exception, code: Any, steps: Any) -> str:
    """Return file and line of an error in custom code, in brackets, or an empty text."""
    source = file_of(code)
    if source is None or code_of(code).__module__.partition(".")[0] in FLOORWALKER:
        return ""
    if place := own_line(why, str(source)):
        return place
    frame = getattr(steps, "gi_frame", None)  # a wrong event is reported outside the generator
    if frame is not None and frame.f_code.co_filename == str(source):
        return f" ({source.name}, line {frame.f_lineno})"
    function = code_of(code)  # and so is a wrong result of a function
    if inspect.isclass(function):
        function = code_of(function.__call__)
    return f" ({source.name}, line {inspect.getsourcelines(function)[1]})"
