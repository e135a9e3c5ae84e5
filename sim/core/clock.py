"""Simulated time: SimPy's event loop with movable alarms, and its pace in real time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from enum import IntEnum
from heapq import heappush
from operator import attrgetter
from typing import TYPE_CHECKING, Any, NoReturn, SupportsIndex

import simpy
from simpy.core import StopSimulation
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
"""Seconds. Nothing on a factory floor happens more than a few times within one."""


class StandstillError(UserError):
    """Simulated time does not go on: things happen again and again at an instant, or nearly so."""


class InProgress:
    """Part of a run in progress. It cannot be copied or pickled: `TypeError` says so."""

    def __reduce_ex__(self, protocol: SupportsIndex) -> NoReturn:
        """Refuse to be copied: waiting processes, open files and callbacks cannot be."""
        raise TypeError(
            f"a {type(self).__name__} cannot be copied or pickled, because it is part of a run in"
            " progress; copy the trial and run it again"
        )


class Clock(InProgress, simpy.Environment):
    """SimPy environment that can also wait for an instant, not only for a delay.

    SimPy adds a delay to the present time, which rounds; an instant at which two motions meet
    has to arrive as it was computed.

    `most` events may happen within a `MOMENT`; `StandstillError` where there are more, with
    what `busy` says that happens.
    """

    def __init__(
        self,
        initial_time: float = 0.0,
        *,
        most: int = 1000,
        busy: Callable[[], str] = lambda: "the same again and again",
    ) -> None:
        super().__init__(initial_time)
        self.most = most
        self.stopped = False
        self.inside = False
        """Whether the simulation is under way, not the program that advances it."""
        self._busy = busy
        self.begin_moment()

    if not TYPE_CHECKING:
        now = property(attrgetter("_now"), doc="Time (seconds).")  # as SimPy's; asked all the time

    @contextmanager
    def under_way(self) -> Iterator[None]:
        """Be inside the simulation in this context."""
        before, self.inside = self.inside, True
        try:
            yield
        finally:
            self.inside = before

    def begin_moment(self) -> None:
        """Count events anew, because something has come from outside the simulation."""
        self._moment_ends = self._now + MOMENT
        self._happened = 0

    def stop(self) -> None:
        """Stop for good, between two events. A signal handler or another thread may say so."""
        self.stopped = True

    def step(self) -> None:
        """Let the next event happen."""
        if self.stopped:
            raise StopSimulation(None)
        super().step()
        if self._now >= self._moment_ends:
            self.begin_moment()
        self._happened += 1
        if self._happened > self.most:
            raise StandstillError(
                f"time stands still at t = {self.now:.9g} s: more than {self.most:,} things have"
                f" happened within a millisecond: {self._busy()}"
            )

    def advance(self, until: float, enough: Callable[[], bool] | None = None) -> None:
        """Let happen what comes before the outside at `until` (s), or until it is `enough()`."""
        with suppress(StopSimulation):  # the trial has come to its end, or was stopped
            while enough is None or not enough():
                if not self._queue or self._queue[0][0] >= until:
                    arrival = self.at(until, Turn.OUTSIDE)
                    while not arrival.processed:
                        self.step()
                    break
                self.step()

    def at(self, t: float, turn: Turn = Turn.MOTION_ENDS) -> Event:
        """Return an event that happens at `t` (seconds, not before now)."""
        return self.put(Instant(self, []), t, turn)

    def put(self, event: Event, t: float, turn: Turn) -> Event:
        """Let an event happen at `t` (seconds, not before now); return it."""
        now = self._now
        # As SimPy's `schedule` does, but with the instant itself: now + (t - now) need not be t.
        entry = (now if now > t else t, _PRIORITY[turn], next(self._eid), event)
        heappush(self._queue, entry)
        return event

    def ask(self, t: float, answer: Callable[[], Any], turn: Turn) -> Event:
        """Return an event that happens at `t` (seconds), with what `answer` returns then.

        It is what a process would be that waits for the instant, in a third of the events.
        """

        def answered() -> None:
            event._value = answer()

        event = self.call_at(t, answered, turn)
        return event

    def happened(self, value: Any) -> Event:
        """Return an event that has happened: who waits for it gets `value` and goes on at once."""
        event = Event(self)
        event._ok, event._value = True, value
        event.callbacks = None  # type: ignore[assignment]
        return event

    def call_at(self, t: float, action: Callable[[], None], turn: Turn = Turn.MOTION_ENDS) -> Event:
        """Call `action` at `t` (seconds); return the event of that instant."""
        event = self.at(t, turn)
        then(event, lambda _: action())
        return event

    def end(self) -> Event:
        """Return an event that stops the clock when it happens."""
        event = Event(self)
        then(event, StopSimulation.callback)
        return event


class Instant(Event):
    """An event that is sure to happen, and has no value; its `callbacks` are called then."""

    _ok = True
    _value = None

    def __init__(self, env: Clock, callbacks: list[Callable[[Event], None]]) -> None:
        self.env = env
        self.callbacks = callbacks


def then(event: Event, action: Callable[[Event], None]) -> None:
    """Call `action` when `event`, which has not happened yet, does."""
    assert event.callbacks is not None
    event.callbacks.append(action)


def occur(event: Event, value: Any) -> None:
    """Let an event that is not scheduled happen at once, with a value."""
    callbacks, event.callbacks = event.callbacks, None  # type: ignore[assignment]
    event._ok, event._value = True, value
    for callback in callbacks:
        callback(event)


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
        self._turn = turn
        self._calls: list[Callable[[Event], None]] | None = None
        self._pending: Event | None = None
        self._time: float | None = None

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
        self._pending = None
        if t is not None:
            # Most alarms are never set, and those that are, again and again.
            calls = self._calls = self._calls or [self._ring]
            self._pending = self._clock.put(Instant(self._clock, calls), t, self._turn)

    def _ring(self, event: Event) -> None:
        # SimPy can't take an event back: one that was set before is let pass.
        if event is self._pending:
            self._pending = None
            self._time = None
            self._action()
