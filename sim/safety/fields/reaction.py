"""Reaction to an occupied field: after the response time, until the restart delay is over."""

from __future__ import annotations

import math
from collections.abc import Callable

from ...core.clock import Alarm, Clock, Turn
from ...core.fields import MachineFields


class Reaction:
    """Calls `begin(cause, person)` the response time after something is wrong, and `end` later.

    It ends once nothing has been wrong for the restart delay and the machine stands where it must.
    What was wrong for less than the response time counts as well: a sensor keeps its signal.
    """

    def __init__(
        self,
        clock: Clock,
        fields: MachineFields,
        begin: Callable[[str, str], None],
        end: Callable[[], None],
    ) -> None:
        self.lasts = False
        self._clock = clock
        self._fields = fields
        self._begin, self._end = begin, end
        self._wrong = False
        self._pending: tuple[str, str] | None = None
        """Cause and person of what was wrong first, until it begins."""
        self._free_since = self._stands_from = -math.inf
        self._tripping = Alarm(clock, self.trip, Turn.MOTION_ENDS)
        self._ending = Alarm(clock, self._over, Turn.MOTION_ENDS)

    def become(self, cause: str, person: str) -> None:
        """Take note of what is wrong now, which is nothing without a cause."""
        now = self._clock.now
        if cause and not self._wrong:
            self._ending.set(None)
            if not self.lasts and self._pending is None:
                self._pending = cause, person
                self._tripping.set(now + self._fields.response_time)
        elif self._wrong and not cause:
            self._free_since = now
        self._wrong = bool(cause)
        self._await_end()

    def stands_from(self, t: float) -> None:
        """Take note that the machine stands from `t` (seconds) on."""
        self._stands_from = t
        self._await_end()

    def trip(self) -> None:
        """Begin, if something is or was wrong."""
        self._tripping.set(None)
        if self._pending is not None:
            (cause, person), self._pending = self._pending, None
            self.lasts = True
            self._begin(cause, person)
            self._await_end()

    def _await_end(self) -> None:
        if self.lasts and not self._wrong:
            free = self._free_since + self._fields.restart_delay
            self._ending.set(max(free, self._stands_from, self._clock.now))

    def _over(self) -> None:
        self.lasts = False
        self._end()
