"""Reaction to an occupied field: after the response time, until the restart delay is over."""

from __future__ import annotations

import math
from collections.abc import Callable
from enum import Enum

from ...core.clock import Alarm, Clock, Turn
from ...core.fields import MachineFields


class ReactionState(Enum):
    """ReactionState of a reaction."""

    IDLE = "idle"
    RESPONDING = "responding"
    """The response time runs. The reaction begins after it in any case, as a sensor keeps its
    signal."""
    ACTIVE = "active"


class Reaction:
    """Reaction to a trigger, such as an intrusion: a stop, or a lower speed.

    It calls `begin(cause, person)` after the response time. It calls `end` when there has been no
    trigger for the restart delay, and the machine has come to rest if it must.
    """

    def __init__(
        self,
        clock: Clock,
        fields: MachineFields,
        begin: Callable[[str, str], None],
        end: Callable[[], None],
    ) -> None:
        self.state = ReactionState.IDLE
        self._clock = clock
        self._fields = fields
        self._begin, self._end = begin, end
        self._triggered = False
        self._cause = self._person = ""
        """The first trigger."""
        self._free_since = self._rests_from = -math.inf
        self._began = 0.0
        self._past: list[tuple[float, float]] = []
        self._response = Alarm(clock, self.trip, Turn.MOTION_ENDS)
        self._release = Alarm(clock, self._over, Turn.MOTION_ENDS)

    @property
    def active(self) -> bool:
        """Whether it has begun and not ended."""
        return self.state is ReactionState.ACTIVE

    @property
    def intervals(self) -> list[tuple[float, float]]:
        """Begins and ends until now in seconds."""
        return [*self._past, (self._began, self._clock.now)] if self.active else self._past

    def become(self, cause: str, person: str) -> None:
        """Update the trigger. There is none without a cause."""
        now = self._clock.now
        if cause and not self._triggered:
            self._release.set(None)
            if self.state is ReactionState.IDLE:
                self.state = ReactionState.RESPONDING
                self._cause, self._person = cause, person
                self._response.set(now + self._fields.response_time)
        elif self._triggered and not cause:
            self._free_since = now
        self._triggered = bool(cause)
        self._await_release()

    def rests_from(self, t: float) -> None:
        """Set the time from which the machine is at rest (s)."""
        self._rests_from = t
        self._await_release()

    def trip(self) -> None:
        """Begin at once if the response time runs."""
        self._response.set(None)
        if self.state is ReactionState.RESPONDING:
            self.state, self._began = ReactionState.ACTIVE, self._clock.now
            self._begin(self._cause, self._person)
            self._await_release()

    def _await_release(self) -> None:
        if self.active and not self._triggered:
            free = self._free_since + self._fields.restart_delay
            self._release.set(max(free, self._rests_from, self._clock.now))

    def _over(self) -> None:
        self._past.append((self._began, self._clock.now))
        self.state = ReactionState.IDLE
        self._end()
