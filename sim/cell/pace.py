"""Pace of a run: simulated time by real time, in steps, or paused."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from floorplan import UserError

from ..simulation import Simulation

BEHIND = 1.0
"""Seconds of real time that a run may be late before it gives up catching up."""


def checked_speed(speed: float) -> float:
    """Return a speed. `ValueError` unless it is finite and above 0."""
    if not 0 < speed < math.inf:
        raise UserError(f"speed must be more than 0, not {speed:g}")
    return speed


class _Tick:
    def __init__(self, period: float, action: Callable[[], None]) -> None:
        self.period = period
        self.action = action
        self.count = 0

    def begin(self, now: float) -> None:
        """Count from a time (s)."""
        self.count = math.floor(now / self.period + 1e-9)

    @property
    def next(self) -> float:
        return (self.count + 1) * self.period


class Pace:
    """Advances a simulation in real time, or step by step.

    Parameters
    ----------
    simulation : Simulation
        The simulation.
    speed : float, optional
        Simulated seconds per second of real time.
    step : bool, optional
        Whether time advances only by `step` and `advance`.
    now : callable, optional
        Function that returns real time in seconds.

    Attributes
    ----------
    enough : callable
        Function that is called after each event, and ends `advance` early if it returns True.
    after : list of callable
        Functions that are called after each advance, before those of the ticks.
    changed : callable
        Function that is called after each change of speed or pause, and after `end`.
    failure : Exception or None
        Exception that a custom program raised in the run, which ends it. See `check`.
    """

    def __init__(
        self,
        simulation: Simulation,
        *,
        speed: float = 1.0,
        step: bool = False,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        self.enough: Callable[[], bool] = lambda: False
        self.after: list[Callable[[], None]] = []
        self.changed: Callable[[], None] = lambda: None
        self.paused = False
        self.held = ""
        """Reason for which a transport holds the run, if any."""
        self.failure: Exception | None = None
        self._simulation = simulation
        self._clock = simulation.clock
        self._speed = 0.0 if step else checked_speed(speed)
        self._real_time = now
        self._at = simulation.clock.now
        self._since: float | None = None
        self._ended = False
        self._ticks: list[_Tick] = []

    @property
    def speed(self) -> float:
        """Simulated seconds per second of real time, or 0 if time advances in steps."""
        return self._speed

    @property
    def now(self) -> float:
        """Simulated time in seconds."""
        return self._clock.now

    @property
    def over(self) -> bool:
        """Whether the run has ended, was stopped, or has failed."""
        simulation = self._simulation
        return self._ended or self.failure is not None or simulation.over or simulation.stopped

    def end(self) -> None:
        """End the run before its time."""
        self._ended = True
        self.changed()

    def check(self) -> None:
        """Raise the exception with which the run has failed, if it has."""
        if self.failure is not None:
            raise self.failure

    def change(self, *, speed: float | None = None, paused: bool | None = None) -> None:
        """Change the speed, pause, or continue. None leaves a value as it is.

        Parameters
        ----------
        speed : float, optional
            Simulated seconds per second of real time.
        paused : bool, optional
            Whether the run is paused.

        Raises
        ------
        ValueError
            If the speed is invalid, or time advances in steps.
        """
        if speed is not None and not self._speed:
            raise UserError("the pace depends on the clients, so it has no speed")
        speed = self._speed if speed is None else checked_speed(speed)
        self._restart(self.target())
        self._speed = speed
        self.paused = self.paused if paused is None else paused
        self.changed()

    def keep_time(self, speed: float, now: Callable[[], float]) -> None:
        """Follow real time from now on, at a speed and by a clock `now` (s)."""
        self._speed, self._real_time = checked_speed(speed), now
        self._at, self._since = self.now, None

    def hold(self, reason: str) -> bool:
        """Hold the run for a reason. Return whether it was not held."""
        before, self.held = self.held, reason
        if not before:
            self._restart(self.now)
        return not before

    def release(self) -> bool:
        """Continue from now on. Return whether the run was held."""
        before, self.held = self.held, ""
        if before:
            self._restart(self.now)
        return bool(before)

    def every(self, period: float, action: Callable[[], None]) -> None:
        """Call a function whenever simulated time reaches a multiple of a period (s)."""
        if not 0 < period < math.inf:
            raise UserError(f"every(period) must be more than 0 and finite, not {period:g}")
        tick = _Tick(period, action)
        tick.begin(self.now)
        self._ticks.append(tick)

    def continue_with(self, simulation: Simulation) -> None:
        """Advance another simulation from its present time on, with the same speed and ticks.

        Parameters
        ----------
        simulation : Simulation
            The simulation.
        """
        self._simulation, self._clock = simulation, simulation.clock
        self._ended, self.failure = False, None
        for tick in self._ticks:
            tick.begin(self.now)
        self._restart(self.now)

    @property
    def next_tick(self) -> float:
        """Time of the next tick in seconds."""
        return min((tick.next for tick in self._ticks), default=math.inf)

    def target(self) -> float:
        """Return the simulated time (s) that real time requires now."""
        if self._since is None:
            self._since = self._real_time()
        if self.held or self.paused or not self._speed:
            return self._at
        return self._at + (self._real_time() - self._since) * self._speed

    def catch_up(self, longest: float = math.inf) -> None:
        """Advance to the time that real time requires, by at most `longest` seconds."""
        target = min(self.target(), self.now + longest)
        while self.now < target and not self.over:
            self.advance(target)

    def delay(self) -> float:
        """Return the real time until the next tick or event in seconds, negative if it is late."""
        if not self._speed:
            return 0.0
        due = min(self.next_tick, self._clock.peek())
        return (due - self.target()) / self._speed

    def give_up(self) -> bool:
        """Continue from the present if the run is late by `BEHIND`. Return whether it is."""
        is_late = self.delay() < -BEHIND
        if is_late:
            self._restart(self.now)
        return is_late

    def step(self, seconds: float) -> None:
        """Advance by a duration, even if the run is paused.

        Parameters
        ----------
        seconds : float
            Duration in seconds.

        Raises
        ------
        ValueError
            If the duration is negative or not finite.
        """
        if not 0 <= seconds < math.inf:
            raise UserError(f"step(seconds) must be 0 or more and finite, not {seconds:g}")
        until = self.now + seconds
        while self.now < until and not self.over:
            self.advance(until)
        self._restart(self.now)

    def advance(self, until: float) -> bool:
        """Advance to a time (s), but not beyond the next tick. Return whether `enough` ended it."""
        self._clock.begin_moment()
        enough = False

        def is_enough() -> bool:
            nonlocal enough
            enough = self.enough()
            return enough or self._simulation.over

        try:
            self._simulation.advance(min(until, self.next_tick), enough=is_enough)
        except Exception as why:  # of a custom program, not of the caller
            self.failure = self.failure or why
            return False
        for action in self.after:
            action()
        now = self.now
        for tick in self._ticks:
            if now >= tick.next:
                tick.count += 1
                tick.action()
        return enough

    def _restart(self, at: float) -> None:
        """Relate the simulated time `at` to the present."""
        self._at, self._since = at, self._real_time()
