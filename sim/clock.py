"""Simulated time: SimPy's loop, with alarms at exact instants that can be moved."""

from __future__ import annotations

from collections.abc import Callable
from heapq import heappush

import simpy
from simpy.events import NORMAL, Event, EventPriority


class Clock(simpy.Environment):
    """A SimPy environment that also knows how to wait for an instant, not only for a delay.

    SimPy adds a delay to the present time, which rounds; an instant at which two motions meet
    has to arrive as it was worked out.
    """

    def at(self, t: float, priority: int = NORMAL) -> Event:
        """An event that happens at `t` (seconds, not before now)."""
        event = Event(self)
        event._ok = True
        event._value = None
        entry = (max(t, self.now), EventPriority(priority), next(self._eid), event)
        heappush(self._queue, entry)
        return event


class Alarm:
    """Calls `action` at an instant that may be changed or taken back until then."""

    def __init__(self, clock: Clock, action: Callable[[], None], priority: int = NORMAL) -> None:
        self._clock = clock
        self._action = action
        self._priority = priority
        self._pending: Event | None = None
        self._time: float | None = None

    @property
    def time(self) -> float | None:
        """When it is set to ring, if it is."""
        return self._time

    def set(self, t: float | None) -> None:
        """Ring at `t` (seconds) and at no other time; None takes it back."""
        if t == self._time:
            return
        self._time = t
        self._pending = None
        if t is not None:
            self._pending = self._clock.at(t, self._priority)
            assert self._pending.callbacks is not None
            self._pending.callbacks.append(self._ring)

    def _ring(self, event: Event) -> None:
        if event is self._pending:
            self._pending = None
            self._time = None
            self._action()
