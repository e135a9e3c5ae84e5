"""Simulated time: a SimPy environment with exact times and alarms."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from enum import IntEnum
from functools import partial
from heapq import heappop, heappush
from typing import Any, NoReturn, SupportsIndex

import simpy
from simpy.core import EmptySchedule, StopSimulation
from simpy.events import NORMAL, URGENT, Event

from floorplan import UserError


class Turn(IntEnum):
    """Order of events at the same time, lowest first.

    As with SimPy's priorities, events of the same turn occur in the order in which they were
    scheduled, so that runs are reproducible.

    Attributes
    ----------
    VIOLATION
        Start or end of a violation. The law sees the speeds before any motion changes.
    OUTSIDE
        Commands of programs that advance the simulation: as soon as it gets there.
    MOTION_ENDS
        End of a motion.
    NOTICE
        Observation of machines by people, after positions and protective stops have changed.
    THOUGHT
        Reasoning of people, with all percepts of this time.
    INSISTENCE
        Enforcement of rules, after programs could obey them.
    COMMAND
        Scheduled commands. The order in which they were issued has no effect on other events.
    """

    VIOLATION = 0
    OUTSIDE = 1
    MOTION_ENDS = 2
    NOTICE = 3
    THOUGHT = 4
    INSISTENCE = 5
    COMMAND = 6


_PRIORITY: list[Any] = [URGENT, (URGENT + NORMAL) / 2, *range(NORMAL, len(Turn) - 1)]
"""The turns as SimPy's priorities. SimPy gives URGENT to new processes, and NORMAL to outcomes."""

MOMENT = 1e-3
"""Seconds. Few events of a factory floor occur within one."""


class StandstillError(UserError):
    """Simulated time does not progress: events occur again and again at nearly the same time."""


class InProgress:
    """Part of a run in progress. It cannot be copied or pickled."""

    def __reduce_ex__(self, protocol: SupportsIndex) -> NoReturn:
        """Raise a `TypeError`, because waiting processes and open files cannot be copied."""
        raise TypeError(
            f"a {type(self).__name__} cannot be copied or pickled, because it is part of a run in"
            " progress; copy the trial and run it again"
        )


class Clock(InProgress, simpy.Environment):
    """SimPy environment with a queue of its own, which is ordered by exact times.

    SimPy adds delays to the current time, which rounds. The time at which two motions meet must
    occur as it was computed.

    Parameters
    ----------
    initial_time : float, optional
        Time at the begin, s.
    most : int, optional
        Maximum number of events within a `MOMENT`. More raise a `StandstillError`.
    busy : callable, optional
        Returns what happens all the time, for the message of that error.
    """

    now = 0.0
    """Time, s."""

    def __init__(
        self,
        initial_time: float = 0.0,
        *,
        most: int = 1000,
        busy: Callable[[], str] = lambda: "the same again and again",
    ) -> None:
        super().__init__(initial_time)
        self.now = initial_time
        self.most = most
        self.stopped = False
        self.inside = False
        """Whether the simulation acts, and not the program that advances it."""
        self._scheduled: list[tuple[float, float, int, Callable[[], None]]] = []
        self._numbers = itertools.count()
        self._triggers_only = False
        self._busy = busy
        self.begin_moment()

    @contextmanager
    def under_way(self) -> Iterator[None]:
        """Mark what happens in this context as part of the simulation."""
        before, self.inside = self.inside, True
        try:
            yield
        finally:
            self.inside = before

    def begin_moment(self) -> None:
        """Restart the count of events, because a program outside the simulation has acted."""
        self._moment_ends = self.now + MOMENT
        self._happened = 0

    def stop(self) -> None:
        """Stop for good, between two events. Signal handlers and other threads may call this."""
        self.stopped = True

    # The queue

    def schedule(self, event: Event, priority: int = NORMAL, delay: float = 0) -> None:
        """Schedule a SimPy event. See `simpy.Environment.schedule`."""
        if not self._triggers_only:
            self._put(self.now + delay, priority, partial(self._process, event))

    def peek(self) -> float:
        """Return the time of the next event (s), or infinity."""
        return self._scheduled[0][0] if self._scheduled else math.inf

    def step(self) -> None:
        """Process the next event."""
        if self.stopped:
            raise StopSimulation(None)
        if not self._scheduled:
            raise EmptySchedule
        self.now, _, _, action = heappop(self._scheduled)
        action()
        if self.now >= self._moment_ends:
            self.begin_moment()
        self._happened += 1
        if self._happened > self.most:
            raise StandstillError(
                f"time stands still at t = {self.now:.9g} s: more than {self.most:,} things have"
                f" happened within a millisecond: {self._busy()}"
            )

    def advance(self, until: float, enough: Callable[[], bool] | None = None) -> None:
        """Process events before the turn `OUTSIDE` at `until` (s), or until `enough()` is true."""
        with suppress(StopSimulation):  # at the end of the trial, or after `stop`
            while enough is None or not enough():
                if not self._scheduled or self._scheduled[0][0] >= until:
                    arrival = self.at(until, Turn.OUTSIDE)
                    while not arrival.processed:
                        self.step()
                    break
                self.step()

    def call_at(self, t: float, action: Callable[[], None], turn: Turn = Turn.MOTION_ENDS) -> None:
        """Call `action` at `t` (s), but not before now."""
        self._put(max(t, self.now), _PRIORITY[turn], action)

    def _put(self, t: float, priority: float, action: Callable[[], None]) -> None:
        heappush(self._scheduled, (t, priority, next(self._numbers), action))

    # Events for processes

    def at(self, t: float, turn: Turn = Turn.MOTION_ENDS) -> Event:
        """Return an event that occurs at `t` (s), but not before now."""
        event = self._trigger(Event(self))
        self.call_at(t, partial(self._process, event), turn)
        return event

    def ask(self, t: float, answer: Callable[[], Any], turn: Turn) -> Event:
        """Return an event that occurs at `t` (s). Its value is the result of `answer` then."""
        event = self._trigger(Event(self))
        self.call_at(t, lambda: self._process(self._trigger(event, answer())), turn)
        return event

    def happened(self, value: Any) -> Event:
        """Return an event that has occurred. A process that waits for it continues at once."""
        return self.occur(Event(self), value)

    def occur(self, event: Event, value: Any) -> Event:
        """Process an event that is not scheduled now, and return it."""
        self._process(self._trigger(event, value))
        return event

    def end(self) -> Event:
        """Return an event that stops the clock when it occurs."""
        event = Event(self)
        then(event, StopSimulation.callback)
        return event

    def _trigger(self, event: Event, value: Any = None) -> Event:
        """Give an event its value, but do not schedule it. Return the event."""
        self._triggers_only = True
        event.trigger(Event(self).succeed(value))
        self._triggers_only = False
        return event

    def _process(self, event: Event) -> None:
        """Call the callbacks of an event. Raise its error if no process handles that."""
        callbacks, event.callbacks = event.callbacks, None  # type: ignore[assignment]
        for k, callback in enumerate(callbacks, 1):
            try:
                callback(event)
            except StopSimulation:
                event.callbacks = callbacks[k:]
                self.schedule(event, URGENT - 1)
                raise
        if not (event.ok or event.defused):
            why: Any = event.value
            raise type(why)(*why.args) from why


def then(event: Event, action: Callable[[Event], None]) -> None:
    """Call `action` when an event occurs that has not occurred yet."""
    event.callbacks.append(action)


class Alarm(InProgress):
    """Timer that calls `action` once at a time that can be changed or cancelled.

    Parameters
    ----------
    clock : Clock
        Clock of the simulation.
    action : callable
        Function without arguments.
    turn : Turn
        Order among events at the same time.
    """

    def __init__(self, clock: Clock, action: Callable[[], None], turn: Turn) -> None:
        self._clock = clock
        self._action = action
        self._priority = _PRIORITY[turn]
        self._time: float | None = None
        self._settings = 0

    @property
    def time(self) -> float | None:
        """Time of the call in seconds, or None if it is not set."""
        return self._time

    def set(self, t: float | None) -> None:
        """Set, change or cancel the time of the call.

        Parameters
        ----------
        t : float or None
            Time in seconds, or None to cancel the call.
        """
        if t == self._time:
            return
        self._time = t
        self._settings += 1
        if t is not None:
            clock = self._clock
            action = partial(self._ring, self._settings)
            clock._put(t if t > clock.now else clock.now, self._priority, action)

    def _ring(self, setting: int) -> None:
        # A call that was changed or cancelled stays in the queue.
        if setting == self._settings:
            self._time = None
            self._action()
