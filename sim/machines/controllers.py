"""Controllers that machines share: built-in ones, and reports of the errors of all.

A controller is a callable of one argument, the machine, that returns a generator of things to wait
for.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Generator
from functools import partial
from typing import Any

from simpy.events import Event
from simpy.exceptions import Interrupt

from floorplan import UserError
from navigation import PlanningError

from ..core.custom_code import FLOORWALKER, code_of, file_of, in_words, own_line
from ..core.entries import Pose
from .caution import Caution
from .commanded import CommandedMachine
from .commanding import RETRY, Steps

STAY = ("parked", "external")
"""Built-in controllers that do not move a machine without a command."""


class ControllerError(UserError):
    """Error of a controller that cannot be found or that failed."""


def parked(machine: CommandedMachine) -> Steps:
    """Do nothing."""
    return
    yield


def oblivious(machine: CommandedMachine) -> Steps:
    """Do tasks in order on straight paths, and ignore people."""
    while (task := (yield machine.next_task())) is not None:
        yield machine.do(task)


def pausing(machine: CommandedMachine) -> Steps:
    """Do one task after the other, at the speed that people allow."""
    caution = Caution(machine)
    while (task := (yield machine.next_task())) is not None:
        while task.next_step is not None:
            pose = yield machine.locate(task)
            if (yield from gone_to(machine, caution, pose, math.inf)):
                yield machine.handle(task)


def gone_to(machine: CommandedMachine, caution: Caution, pose: Pose, seconds: float) -> Steps:
    """Go to a pose as `Caution.go`; stop where something has closed the way to it."""
    try:
        return (yield from caution.go(pose, seconds=seconds))
    except PlanningError:
        yield machine.stop()
        yield machine.look(RETRY)
        return False


def external(machine: CommandedMachine) -> Steps:
    """Do nothing, because external code commands the machine."""
    return
    yield


def is_controller(found: object) -> bool:
    """Return whether an object is a generator function, or a class with a method `__iter__`."""
    if inspect.isclass(found):
        return hasattr(found, "__iter__")
    return inspect.isfunction(found) and inspect.isgeneratorfunction(inspect.unwrap(found))


MOST_AT_ONCE = 1000
"""Number of times a controller may yield at one instant; more count as endless."""


def supervised(
    name: str, controller: Callable[[Any], Steps], machine: CommandedMachine, code: Any = None
) -> Steps:
    """Return the steps of `controller`, which a trial names `name`.

    `ControllerError` names the fault: it raised something, yielded something that can't be
    waited for, or is not a generator at all. `code` is what it calls, if that is something else.
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
    """Return the error's text with its type; of an interrupt, the remedy."""
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
    """Yield the same steps, if each is something that can be waited for."""
    go_on: Callable[[], Event] = partial(next, steps)
    now, yields = machine.now, 0
    while True:
        now, yields = machine.now, yields + 1 if machine.now == now else 0
        if yields > MOST_AT_ONCE:
            raise RuntimeError("it never lets time pass")
        try:
            event = go_on()
        except StopIteration:
            return
        if not isinstance(event, Event):
            raise TypeError(
                f"it yielded {event!r}, not something that the {machine.shape.kind}'s methods"
                " return"
            )
        try:
            answer = yield event
            go_on = partial(steps.send, answer)
        except Exception as why:
            go_on = partial(steps.throw, why)


def _place(why: Exception, code: Any, steps: Any) -> str:
    """Return file and line of the code at which it failed, in brackets, where known."""
    source = file_of(code)
    if source is None or code_of(code).__module__.partition(".")[0] in FLOORWALKER:
        return ""
    if place := own_line(why, str(source)):
        return place
    frame = getattr(steps, "gi_frame", None)  # what it yielded is judged outside of it
    if frame is not None and frame.f_code.co_filename == str(source):
        return f" ({source.name}, line {frame.f_lineno})"
    found = code_of(code)  # and so is what a function returned
    function = code_of(found.__call__) if inspect.isclass(found) else found
    return f" ({source.name}, line {inspect.getsourcelines(function)[1]})"
