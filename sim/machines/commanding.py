"""Drives of commanded machines, and their moves, which can be replaced, stopped and resumed."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Sequence
from typing import Any

from simpy.events import Event

from floorplan import UserError
from navigation import Motion, Moving, first_time
from navigation.kernels.braking import Stops
from navigation.motion import State

from ..core.body import ROUNDING, Body
from ..core.clock import Alarm, Clock, Turn, then
from ..core.entries import Pose
from .arguments import number

Steps = Generator[Event, Any, Any]
"""Steps of a controller: a generator of events, as in SimPy."""

RETRY = 2.0
"""Seconds after which a blocked vehicle plans again, if nothing has changed on the floor."""


class Drive(ABC):
    """Drive of a commanded machine, which passes "disabled" and "enabled" to a function.

    It counts the time for which the machine was stopped, without braking, and the working time.
    """

    stops: Stops
    """Stops of the machine at all times of a motion."""

    top_speed: float
    """Top speed, m/s."""

    stopping_distance: float
    """Longest distance of a stop, m."""

    def __init__(
        self, clock: Clock, body: Body, *, disabled_or_enabled: Callable[[str], None]
    ) -> None:
        self.body = body
        self.standing_time = 0.0
        self.working_time = 0.0
        self._clock = clock
        self._notify = disabled_or_enabled
        self._enabled: Event | None = None
        self._stopped_since = 0.0
        self._on_hold = False
        self._limit = math.inf
        self._too_fast = False
        """Whether it is stopped because its motion is faster than the limit."""
        self._commands = 0
        self._move: Move | None = None
        """Current move."""
        self.target: Pose | None = None
        """Target of the last move."""
        self.last_move: tuple[Pose, float] | None = None
        """Target and speed share of the last command, if that was a move."""
        self._replaced = clock.event()
        self._braking = clock.event()
        self._arrival = Alarm(clock, self._arrived, Turn.MOTION_ENDS)
        self._previewed_at, self._previewed_on = -1.0, body.motion
        self._previews: dict[tuple[tuple[float, ...], float], Motion] = {}
        """Motions from the present state, because a controller often asks for one before a move."""

    @abstractmethod
    def destination(self, target: Sequence[float]) -> Pose:
        """Return the pose at the end of a move to x, y, and a rotation if there is one."""

    def preview(self, target: Sequence[float], speed_share: float) -> Motion:
        """Return the motion from the present state to `target`.

        `ValueError` if the target cannot be reached, or the share of the top speeds is not in
        0 … 1.
        """
        now, motion = self._clock.now, self.body.motion
        if self._previewed_at != now or self._previewed_on is not motion:
            self._previewed_at, self._previewed_on = now, motion
            self._previews.clear()
        key = (tuple(map(float, target)), self._allowed(speed_share))
        preview = self._previews.get(key)
        if preview is None:
            preview = self._previews[key] = self._planned(*key)
        return preview

    @abstractmethod
    def _planned(self, target: tuple[float, ...], speed_share: float) -> Motion:
        """Return a motion for `preview`, at a share within the speed limit."""

    def resumed(self, target: Pose, speed_share: float) -> Motion:
        """Return the motion with which a move continues after a stop."""
        return self.preview(target, speed_share)

    def pauses(self, move: Move) -> bool:
        """Return whether a move that has come to rest early is resumed later."""
        return False

    @abstractmethod
    def stopping(self, state: State, t: float) -> Motion:
        """Return the fastest stop from `state` at `t` (seconds)."""

    @property
    def disabled(self) -> bool:
        """Whether the machine is stopped, by a protective stop or otherwise."""
        return self._enabled is not None

    @property
    def replaced(self) -> Event:
        """Event that occurs when another command replaces the current one."""
        return self._replaced

    def begin(self) -> int:
        """Begin a command, which replaces the current one. Return its number."""
        self._commands += 1
        if self._move is not None:
            self._move.end()
        if self._replaced.callbacks:
            # Renewed before the old event occurs, because a callback may wait for the next one.
            replaced, self._replaced = self._replaced, self._clock.event()
            replaced.succeed()
        return self._commands

    def is_under_way(self, command: int) -> bool:
        """Return whether the command with this number is the current one."""
        return command == self._commands

    def move(
        self,
        target: Pose,
        speed_share: float = 1.0,
        *,
        resume: bool = True,
        command: int | None = None,
    ) -> Event:
        """Start to move to `target`, as a part of `command` or as a new one. Return its end.

        See `CommandedMachine.move_to`.
        """
        motion = self.preview(target, speed_share)
        if command is None:
            self.begin()
        self.last_move = (target, speed_share) if command is None else None
        self.target = target

        def resumed() -> Motion:
            return self.resumed(target, speed_share)

        move = self._move = Move(self, resumed if resume else None, resumed)
        if not self.disabled:
            move.follow(motion)
        if command is None:
            self._begin_soon(move)
        else:
            move.proceed()
        return move

    def follow(self, motion: Motion, again: Callable[[], Motion] | None = None) -> Event:
        """Start to follow `motion`, which begins here and now. See `CommandedMachine.follow`.

        `again` returns the motion with which to continue when the speed limit changes. Without it,
        the machine is stopped while the motion is too fast.
        """
        if self.disabled:
            raise UserError(f"the {self.body.kind} is disabled")

        def slower() -> Motion | None:
            if again is not None:
                return again()
            if self._is_too_fast(self.body.motion):
                self._stop_too_fast()
            return None

        self.begin()
        self.last_move = self.target = None
        move = self._move = Move(self, None, slower)
        if again is None and self._is_too_fast(motion):
            self._stop_too_fast()
        else:
            move.follow(motion)
        self._begin_soon(move)
        return move

    def limit_speed(self, speed: float | None) -> None:
        """Limit the top speed (m/s), or end the limit. The current move is replanned.

        If a followed motion is too fast, the machine is stopped until the limit ends.
        """
        self._limit = math.inf if speed is None else speed
        if self._too_fast:
            self._too_fast = False
            self._release()
        elif not self.disabled and self._move is not None:
            self._move.adapt()

    def _stop_too_fast(self) -> None:
        self._too_fast = True
        self._stop()

    def _allowed(self, speed_share: float) -> float:
        """Return a share of the top speeds, reduced to the speed limit."""
        return min(speed_share, self._limit / self.top_speed)

    def _is_too_fast(self, motion: Motion) -> bool:
        """Return whether a motion exceeds the speed limit from now on."""
        if self._limit == math.inf:
            return False
        too_fast = Moving(self._limit * (1 + ROUNDING) + ROUNDING)
        now = self._clock.now
        return first_time(too_fast, motion, motion, now, max(now, motion.end)) is not None

    def stop(self) -> Steps:
        """Brake, discard the current command, and wait for the standstill."""
        self.begin()
        if not self.disabled:
            self._brake()
        return self._until(self.body.motion.end)

    def wait(self, seconds: float) -> Steps:
        """Wait. Time in which the machine is stopped does not count."""
        return self._enabled_for(number("wait(seconds)", seconds, 0.0), None)

    def work(self, seconds: float, command: int, *, stays: bool = False) -> Steps:
        """Work as a part of `command`. The value is False if the command was replaced.

        A machine that `stays` where it is works also while it is stopped.
        """
        return self._enabled_for(seconds, command, stays=stays)

    def hold(self, stands: bool) -> None:
        """Brake and stay stationary until `hold(False)`: a protective stop."""
        self._on_hold = stands
        if stands:
            self._stop()
        else:
            self._release()

    def close(self) -> None:
        """Count the time of an unfinished stop at the end of the trial."""
        if self._enabled is not None:
            self._count_standing()

    @property
    def _may_move(self) -> bool:
        """Whether there is no reason for a stop any more."""
        return not self._on_hold and not self._too_fast

    def _stop(self) -> None:
        if self._enabled is None:
            self._enabled = self._clock.event()
            self._stopped_since = self._clock.now
            self._brake()
            self._notify("disabled")

    def _release(self) -> None:
        """End the stop if there is no reason for it any more."""
        if self._enabled is not None and self._may_move:
            self._count_standing()
            enabled, self._enabled = self._enabled, None
            enabled.succeed()
            self._notify("enabled")

    def _count_standing(self) -> None:
        """Count the time at rest, without the braking before, which may still last."""
        rests_from = max(self._stopped_since, self.body.motion.end)
        self.standing_time += max(0.0, self._clock.now - rests_from)

    def _brake(self) -> None:
        self._follow_stop()
        if self._move is not None:
            self._move.broken_off()
        self._interrupt_waits()

    def _follow_stop(self) -> None:
        self.body.follow(self.stopping(self.body.state, self._clock.now))

    def _interrupt_waits(self) -> None:
        """Interrupt `wait` and `work`, so that their time does not count while it is stopped."""
        if self._braking.callbacks:
            braking, self._braking = self._braking, self._clock.event()
            braking.succeed()

    def _begin_soon(self, move: Move) -> None:
        """Begin a move later at this time, when its controller has given all commands."""
        self._clock.call_at(self._clock.now, move.proceed, Turn.VIOLATION)

    def when_released(self, move: Move) -> None:
        """Continue a move at the end of the stop."""
        assert self._enabled is not None
        then(self._enabled, move.proceed)

    def is_move(self, move: Move) -> bool:
        """Return whether this is the current move."""
        return move is self._move

    def extend(self, move: Event | None, longer: Callable[[], Motion]) -> None:
        """Continue with a longer motion if `move` is the current one."""
        if self._move is not None and move is self._move:
            self._move.extend(longer())

    def await_arrival(self, t: float | None) -> None:
        """Set the time at which the current move arrives (s), if any."""
        self._arrival.set(t)

    def _arrived(self) -> None:
        if self._move is not None:
            self._move.arrive()

    def ended(self) -> None:
        """Handle the end of the current move."""
        self._move = None
        self.await_arrival(None)

    def _until(self, t: float) -> Steps:
        yield self._clock.at(t)

    def _enabled_for(self, seconds: float, command: int | None, *, stays: bool = False) -> Steps:
        """Wait until the machine was free to move for `seconds`, or `command` is replaced.

        All seconds count if the machine `stays`.
        """
        while seconds > 0 and command in (None, self._commands):
            enabled = self._enabled
            change = self._braking if enabled is None else enabled
            if command is not None:
                change = change | self._replaced
            if enabled is not None and not stays:
                yield change
                continue
            begun = self._clock.now
            done = self._clock.at(begun + seconds)
            yield done | change
            elapsed = self._clock.now - begun
            if command is not None and enabled is None:
                self.working_time += elapsed
            seconds = 0.0 if done.processed else seconds - elapsed
        return command in (None, self._commands)


class Move(Event):
    """A move of a drive. As an event, it is the end of the move, at its target or elsewhere.

    When the machine is stopped, the move is broken off. It continues afterwards with the motion
    that `resumed` returns, and waits if that is None. Without `resumed`, it ends. It also ends when
    another command replaces it. When the speed limit changes, it continues with the motion that
    `adapted` returns, if any.
    """

    def __init__(
        self,
        drive: Drive,
        resumed: Callable[[], Motion | None] | None,
        adapted: Callable[[], Motion | None],
    ) -> None:
        super().__init__(drive.body.clock)
        self._drive = drive
        self._resumed = resumed
        self._adapted = adapted
        self._motion: Motion | None = None
        self._begun = False

    @property
    def moves(self) -> bool:
        """Whether the machine follows a motion of this move, and neither brakes nor waits."""
        return self._motion is not None

    def follow(self, motion: Motion) -> None:
        """Follow a motion that begins here and now."""
        self._motion = motion
        self._drive.body.follow(motion)

    def proceed(self, _: Event | None = None) -> None:
        """Begin or continue, at the end of the stop if the machine is stopped."""
        drive = self._drive
        if not drive.is_move(self):
            return
        if drive.disabled:
            drive.when_released(self)
            return
        if self._motion is None:
            if self._resumed is None:
                self.end()
                return
            motion = self._resumed()
            if motion is None:
                return
            self.follow(motion)
        self._await_arrival()

    def adapt(self) -> None:
        """Continue with the motion that the speed limit allows."""
        if self._motion is not None and self._motion.end > self._drive.body.clock.now:
            motion = self._adapted()
            if motion is not None:
                self.extend(motion)

    def extend(self, motion: Motion) -> None:
        """Continue with another motion that begins here and now."""
        self.follow(motion)
        if self._begun:
            self._await_arrival()

    def pause(self) -> None:
        """Wait for the next `proceed`."""
        self._motion, self._begun = None, False
        self._drive.await_arrival(None)

    def broken_off(self) -> None:
        """Continue at the end of the stop, or end. A move that has not begun waits to begin."""
        begun = self._begun
        self.pause()
        if begun:
            if self._resumed is None:
                self.end()
            else:
                self.proceed()

    def end(self) -> None:
        """End the move, at its target or elsewhere."""
        self._begun = False
        self._drive.ended()
        if self.callbacks:
            self.succeed()
        elif not self.processed:  # without an entry in the queue, because nothing waits for it
            self._drive.body.clock.occur(self, None)

    def arrive(self) -> None:
        """End at the target, or wait if the move has come to rest early."""
        if self._motion is None:
            return
        if self._resumed is not None and self._drive.pauses(self):
            self.pause()
        else:
            self.end()

    def _await_arrival(self) -> None:
        if self._motion is None:  # the machine was stopped as it set out
            if self._drive.disabled:
                self._drive.when_released(self)
        else:
            self._begun = True
            self._drive.await_arrival(self._motion.end)
