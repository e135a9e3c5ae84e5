"""Interrupts of controllers, as in SimPy, and masked while one is handled."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from typing import Any, Literal, get_args

from simpy.events import Event, Process
from simpy.exceptions import Interrupt

from floorplan import UserError
from floorplan.files.problems import suggestion

from ..core.clock import Clock
from .arguments import number
from .commanding import Steps

Interruption = Literal["person_close", "disabled", "enabled", "part_dropped", "contact"]
"""Reasons for which a controller can ask to be interrupted."""

REASONS = get_args(Interruption)


class Interrupts:
    """The interrupts of one controller, masked while it handles one, as an operating system's are.

    From one interrupt on there is no other until the controller has given a command outside the
    `except` (or `finally`) in which it handles that one; then what happened meanwhile interrupts
    it, each reason once. A command that ends at the instant of an interrupt is answered first, so
    that its outcome is not lost.
    """

    # The masking is that of POSIX signals (`sigaction` with all of them in `sa_mask`): while a
    # handler runs they are blocked, and one that arrives stays pending, once however often it came.
    # Without that, a person who comes near while the controller backs off would break off the
    # handler at its `yield`. A signal handler unmasks by its return; a generator does not say when
    # it leaves its `except`. But Python has the exception at hand for as long as that runs, so that
    # the first command given without it is given outside.

    def __init__(self) -> None:
        self.close_distance: float | None = None
        """Metres within which a person's coming interrupts, if the controller asked for it."""
        self._wanted: set[str] = set()
        self._pending: list[str] = []
        self._handled: Interrupt | None = None
        self._process: Process | None = None

    def ask_for(self, reason: str, distance: float) -> None:
        """Interrupt for this reason from now on; see `GantryRobot.interrupt_on`."""
        if reason not in REASONS:
            hint = suggestion(str(reason), REASONS)
            raise UserError(f"nothing called {reason!r} interrupts a controller; {hint}")
        if reason == "person_close":
            if not number("interrupt_on(distance)", distance) > 0:
                raise UserError(f"interrupt_on(distance) must be more than 0, not {distance}")
            self.close_distance = distance
        self._wanted.add(reason)

    def start(self, clock: Clock, controller: Steps) -> None:
        """Run `controller` from now on, and interrupt it."""
        self._process = clock.process(self._delivered_to(controller))

    def happened(self, reason: str) -> None:
        """Interrupt the controller, now or as soon as it may be, if it asked for this reason."""
        process = self._process
        if process is None or not process.is_alive or reason not in self._wanted:
            return
        if reason not in self._pending:
            self._pending.append(reason)
            if self._handled is None:
                process.interrupt()

    def command_given(self) -> None:
        """Unmask interrupts, unless the caller is still in the `except` that handles the last."""
        # Inside `except`, Python has the exception, or one that was raised on top of it, at hand.
        exception = sys.exc_info()[1]
        while exception is not None and exception is not self._handled:
            exception = exception.__context__
        if exception is None:
            self._handled = None

    def _delivered_to(self, controller: Steps) -> Steps:
        """Yield the steps of `controller`, and throw interrupts into it where they may be."""
        go_on: Callable[[], Event] = partial(next, controller)
        while True:
            try:
                event = go_on()
            except StopIteration:
                return
            go_on = yield from self._waited_for(event, controller)

    def _waited_for(self, event: Event, controller: Steps) -> Steps:
        """Wait for `event`, or for an interrupt; the value resumes the controller."""
        while True:
            if self._pending and self._handled is None and not event.triggered:
                self._handled = Interrupt(self._pending.pop(0))
                return partial(controller.throw, self._handled)
            try:
                answer: Any = yield event
            except Interrupt:
                continue  # a reason is pending; where it may not be thrown yet, wait on
            except Exception as why:
                return partial(controller.throw, why)
            return partial(controller.send, answer)
