"""A controller under supervision: errors in it are reported with its name and line."""

from __future__ import annotations

import inspect
import traceback
from collections.abc import Callable, Generator
from functools import partial
from pathlib import Path
from typing import Any

from simpy.events import Event
from simpy.exceptions import Interrupt

from ....core.own_source import in_words
from ..drive import Steps
from ..robot import GantryRobot
from .finding import Controller, ControllerError

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
