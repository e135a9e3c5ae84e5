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
"""Reasons for which a controller can request interrupts."""

REASONS = get_args(Interruption)


class Interrupts:
    """Interrupts of one controller, masked while it handles one.

    After an interrupt there is no other one until the controller gives a command outside the
    `except` or `finally` block that handles it. Reasons that occur meanwhile interrupt it then,
    each once. If a command ends at the time of an interrupt, its result is delivered first.
    """

    # The masking is that of POSIX signals (`sigaction` with all of them in `sa_mask`): signals are
    # blocked while a handler runs, and each stays pending once. Without masking, a person who
    # comes near while the controller backs off would break off the handler at its `yield`. A
    # signal handler unmasks by its return. A generator gives no sign when it leaves its `except`
    # block, but `sys.exc_info` has the exception as long as that block runs. So the first command
    # without this exception is outside of it.

    def __init__(self) -> None:
        self.close_distance: float | None = None
        """Distance (m) of a person that interrupts, if the controller has requested it."""
        self._reasons: set[str] = set()
        self._pending: list[str] = []
        self._handled: Interrupt | None = None
        self._process: Process | None = None

    def request(self, reason: str, distance: float) -> None:
        """Interrupt for this reason from now on. See `CommandedMachine.interrupt_on`."""
        if reason not in REASONS:
            hint = suggestion(str(reason), REASONS)
            raise UserError(f"nothing called {reason!r} interrupts a controller; {hint}")
        if reason == "person_close":
            if not number("interrupt_on(distance)", distance) > 0:
                raise UserError(f"interrupt_on(distance) must be more than 0, not {distance}")
            self.close_distance = distance
        self._reasons.add(reason)

    def start(self, clock: Clock, controller: Steps) -> None:
        """Run `controller` with interrupts from now on."""
        self._process = clock.process(self._delivered_to(controller))

    def happened(self, reason: str) -> None:
        """Interrupt the controller as soon as possible if it has requested this reason."""
        process = self._process
        if process is None or not process.is_alive or reason not in self._reasons:
            return
        if reason not in self._pending:
            self._pending.append(reason)
            if self._handled is None:
                process.interrupt()

    def command_given(self) -> None:
        """Unmask interrupts, unless the caller is still in the `except` block of the last one."""
        # Within this block, the present exception is the interrupt or was raised while handling it.
        exception = sys.exc_info()[1]
        while exception is not None and exception is not self._handled:
            exception = exception.__context__
        if exception is None:
            self._handled = None

    def _delivered_to(self, controller: Steps) -> Steps:
        """Yield the steps of `controller`, and throw interrupts into it where allowed."""
        proceed: Callable[[], Event] = partial(next, controller)
        while True:
            try:
                event = proceed()
            except StopIteration:
                return
            proceed = yield from self._waited_for(event, controller)

    def _waited_for(self, event: Event, controller: Steps) -> Steps:
        """Wait for `event` or an interrupt. Return a function that resumes the controller."""
        while True:
            if self._pending and self._handled is None and not event.triggered:
                self._handled = Interrupt(self._pending.pop(0))
                return partial(controller.throw, self._handled)
            try:
                answer: Any = yield event
            except Interrupt:
                continue  # thrown now, or still masked
            except Exception as why:
                return partial(controller.throw, why)
            return partial(controller.send, answer)
