"""The gate through which commands from outside come into a simulation."""

from __future__ import annotations

from collections.abc import Callable

from ..core.clock import Clock
from .exchange import RefusedError

MOST_COMMANDS = 300
"""How many commands are taken at one instant of simulated time."""


class Gate:
    """Lets commands in at the time that it is, and not too many of them at once.

    `catch_up()` brings simulated time up to now; `is_open()` tells whether the run still goes on.
    """

    def __init__(self, clock: Clock) -> None:
        self.catch_up: Callable[[], None] = lambda: None
        self.is_open: Callable[[], bool] = lambda: True
        self._clock = clock
        self._since = clock.now
        self._count = 0

    def enter(self, what: str) -> None:
        """Somebody wants `what`; `RefusedError` where the run is over, or it gets too much."""
        if self.is_open():
            self.catch_up()
        if not self.is_open():
            raise RefusedError(f"{what}: the run is over")
        now = self._clock.now
        self._count = self._count + 1 if now == self._since else 1
        self._since = now
        if self._count > MOST_COMMANDS:
            raise RefusedError(
                f"{what}: more than {MOST_COMMANDS} commands at t = {now:g} s; not done"
            )
