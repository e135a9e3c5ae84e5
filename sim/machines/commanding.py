"""Commanding of machines: moves that can be replaced or stopped, and interrupts of controllers."""

from __future__ import annotations

import math
import sys
from abc import ABC, abstractmethod
from collections.abc import Callable, Generator
from functools import partial
from typing import Any, Literal, get_args

from simpy.events import Event, Process
from simpy.exceptions import Interrupt

from floorplan import UserError
from floorplan.files.problems import suggestion
from navigation import Motion, Moving, first_time
from navigation.kernels.braking import Stops
from navigation.motion import State

from ..core.body import ROUNDING, Body
from ..core.clock import Clock, Turn, then
from ..core.entries import Pose

Steps = Generator[Event, Any, Any]
"""Steps of a controller: a generator of events to wait for, in SimPy's manner."""


class Drive(ABC):
    """Drive of a commanded machine, which passes "disabled" and "enabled" to a function.

    It counts how long it was made to stand, how much of that it braked, and how long it worked.
    """

    stops: Stops
    """How the machine stops at any instant of a motion."""

    top_speed: float
    """Its top speed, m/s."""

    def __init__(
        self, clock: Clock, body: Body, *, disabled_or_enabled: Callable[[str], None]
    ) -> None:
        self.body = body
        self.standing_time = 0.0
        self.braking_time = 0.0
        self.working_time = 0.0
        self._clock = clock
        self._notify = disabled_or_enabled
        self._enabled: Event | None = None
        self._stands_since = 0.0
        self._held = False
        self._limit = math.inf
        self._too_fast = False
        """Whether it stands because it can't follow a motion at the limit of its speed."""
        self._commands = 0
        self._last: Move | None = None
        """The move that began last."""
        self.target: Pose | None = None
        """Target of the last move."""
        self.last_move: tuple[Pose, float] | None = None
        """Target and share of the top speeds of the last command, if that was a move."""
        self._moves: dict[Move, None] = {}
        self._replaced = clock.event()
        self._braking = clock.event()

    @abstractmethod
    def preview(self, target: Pose, speed_share: float) -> Motion:
        """Return the motion from here and now to `target`, at that share of the top speeds.

        `ValueError` if the machine can't get there, or the share is not in 0 … 1.
        """

    def resumed(self, target: Pose, speed_share: float) -> Motion:
        """Return the motion with which a move goes on after the machine was made to stand."""
        return self.preview(target, speed_share)

    @abstractmethod
    def stopping(self, state: State, t: float) -> Motion:
        """Return the fastest stop from `state` at `t` (seconds)."""

    @property
    def disabled(self) -> bool:
        """True while it is made to stand."""
        return self._enabled is not None

    @property
    def enabled(self) -> Event | None:
        """The event that it is made to stand no longer; None while it isn't."""
        return self._enabled

    def begin(self) -> int:
        """Begin a command, which takes the place of the one under way; return its number."""
        self._commands += 1
        if self._replaced.callbacks:
            # A new event first: who is woken by the old one may wait for the next replacement at
            # once.
            replaced, self._replaced = self._replaced, self._clock.event()
            replaced.succeed()
        return self._commands

    def is_under_way(self, command: int) -> bool:
        """Return True while no other command has taken the place of the one of this number."""
        return command == self._commands

    def move(
        self,
        target: Pose,
        speed_share: float = 1.0,
        *,
        resume: bool = True,
        command: int | None = None,
    ) -> Event:
        """Set out for `target`, as a part of `command` or as one of its own; return its end.

        See `GantryRobot.move_to`.
        """
        motion = self.preview(target, speed_share)
        number = self.begin() if command is None else command
        self.last_move = (target, speed_share) if command is None else None
        self.target = target
        if not self.disabled:
            self.body.follow(motion)

        def set_out() -> None:
            self.body.follow(self.resumed(target, speed_share))

        move = self._last = Move(self, number, set_out if resume else None, set_out)
        if command is None:
            self._begin_soon(move)
        else:
            move.begin()
        return move

    def follow(self, motion: Motion, again: Callable[[], Motion] | None = None) -> Event:
        """Go along `motion`, which begins here and now; see `GantryRobot.follow`.

        `again` returns the motion to go on with when the limit of the speed changes. Without that
        the machine stands as long as the motion is too fast.
        """
        if self.disabled:
            raise UserError(f"the {self.body.kind} is disabled")

        def adapt() -> None:
            if again is not None:
                self.body.follow(again())
            elif self._is_too_fast(self.body.motion):
                self._too_fast = True
                self._stand()

        self.last_move = self.target = None
        move = self._last = Move(self, self.begin(), None, adapt)
        if again is None and self._is_too_fast(motion):
            self._too_fast = True
            self._stand()
        else:
            self.body.follow(motion)
        self._begin_soon(move)
        return move

    def limit_speed(self, speed: float | None) -> None:
        """Keep to a top speed (m/s) from now on, or to none: the move under way is replanned.

        A followed motion that is faster ends: the machine brakes, and stands until the limit ends.
        """
        self._limit = math.inf if speed is None else speed
        if self._too_fast:
            self._too_fast = False
            self._go_on()
        elif not self.disabled and self._last is not None:
            self._last.adapt()

    def _allowed(self, speed_share: float) -> float:
        """Return a share of the top speeds, or the share that the limit of the speed leaves."""
        return min(speed_share, self._limit / self.top_speed)

    def _is_too_fast(self, motion: Motion) -> bool:
        """Return whether a motion is faster than the limit of the speed, now or later."""
        if self._limit == math.inf:
            return False
        too_fast = Moving(self._limit * (1 + ROUNDING) + ROUNDING)
        now = self._clock.now
        return first_time(too_fast, motion, motion, now, max(now, motion.end)) is not None

    def stop(self) -> Steps:
        """Brake, and wait for the end; the command under way is forgotten."""
        self.begin()
        if not self.disabled:
            self._brake()
        return self._rest()

    def wait(self, seconds: float) -> Steps:
        """Let `seconds` go by in which it is not disabled."""
        if not 0 <= seconds < math.inf:
            raise UserError(f"can't wait {seconds} s")
        return self._enabled_for(seconds, None)

    def work(self, seconds: float, command: int) -> Steps:
        """Work for `seconds` as a part of `command`; the value is True unless it was replaced."""
        return self._enabled_for(seconds, command)

    def hold(self, stands: bool) -> None:
        """Brake and stand until `hold(False)`: a protective stop."""
        self._held = stands
        if stands:
            self._stand()
        else:
            self._go_on()

    def close(self) -> None:
        """Count the time it was made to stand until now: the trial is over."""
        if self._enabled is not None:
            self.standing_time += self._clock.now - self._stands_since

    @property
    def _may_go_on(self) -> bool:
        """Whether nothing makes it stand any more."""
        return not self._held and not self._too_fast

    def _stand(self) -> None:
        if self._enabled is None:
            self._enabled = self._clock.event()
            self._stands_since = self._clock.now
            self._brake()
            self.braking_time += self.body.motion.end - self._clock.now
            self._notify("disabled")

    def _go_on(self) -> None:
        """Be free to move, if nothing makes it stand."""
        if self._enabled is not None and self._may_go_on:
            enabled, self._enabled = self._enabled, None
            self.standing_time += self._clock.now - self._stands_since
            enabled.succeed()
            self._notify("enabled")

    def _brake(self) -> None:
        self.body.follow(self.stopping(self.body.state, self._clock.now))
        moves, self._moves = self._moves, {}
        if moves or self._braking.callbacks:
            braking, self._braking = self._braking, self._clock.event()
            braking.succeed()
            for move in moves:
                then(braking, move.broken_off)

    def _begin_soon(self, move: Move) -> None:
        """Let a command of its own begin, once its controller has said all it says at once."""
        self._clock.call_at(self._clock.now, move.begin, Turn.VIOLATION)

    def await_arrival(self, move: Move) -> Event:
        """Return the arrival of the motion under way; `move` is broken off if it brakes before."""
        self._moves[move] = None
        arrival = self._clock.at(self.body.motion.end)
        then(arrival, move.arrived)
        return arrival

    def ended(self, move: Move) -> None:
        """Take note that a move is over."""
        self._moves.pop(move, None)

    def _rest(self) -> Steps:
        yield self._clock.at(self.body.motion.end)

    def _enabled_for(self, seconds: float, command: int | None) -> Steps:
        """Let `seconds` go by in which it is not disabled, unless `command` is replaced before."""
        while seconds > 0 and command in (None, self._commands):
            if self._enabled is not None:
                yield self._enabled
                continue
            begun = self._clock.now
            done = self._clock.at(begun + seconds)
            # Until it is done, or something breaks it off: time goes on counting from what is left.
            yield done | (self._braking if command is None else self._braking | self._replaced)
            elapsed = self._clock.now - begun
            if command is not None:
                self.working_time += elapsed
            seconds = 0.0 if done.processed else seconds - elapsed
        return command in (None, self._commands)


class Move(Event):
    """The end of a move: it happens at the arrival, or where the move is given up.

    Broken off where the gantry is made to stand, it sets out again by `set_out` afterwards; without
    that it is over. Nor does it go on once another command has taken the place of its `command`.
    When the limit of the speed changes, `change` lets the machine go on with another motion.
    """

    def __init__(
        self,
        drive: Drive,
        command: int,
        set_out: Callable[[], None] | None,
        change: Callable[[], None],
    ) -> None:
        super().__init__(drive.body.clock)
        self._drive = drive
        self._command = command
        self._set_out = set_out
        self._change = change
        self._arrival: Event | None = None

    def begin(self) -> None:
        """Wait for the arrival, once the gantry is free to move."""
        drive = self._drive
        if not drive.is_under_way(self._command):
            self._end()
        elif drive.enabled is not None:
            then(drive.enabled, self._go_on)
        else:
            self._arrival = drive.await_arrival(self)

    def adapt(self) -> None:
        """Go on with the motion that the limit of the speed allows, if this is still under way."""
        drive = self._drive
        if drive.is_under_way(self._command) and drive.body.motion.end > drive.body.clock.now:
            self._change()
            if self._arrival is not None and not drive.disabled:
                self._arrival = drive.await_arrival(self)

    def arrived(self, arrival: Event) -> None:
        """Be over, if this is the arrival that it waits for."""
        if arrival is self._arrival:
            self._end()

    def broken_off(self, _: Event) -> None:
        """Wait to go on, if it may."""
        if self._arrival is not None:
            self._arrival = None
            if self._set_out is None:
                self._end()
            else:
                self.begin()

    def _go_on(self, _: Event) -> None:
        if self._set_out is None or not self._drive.is_under_way(self._command):
            self._end()
        else:
            self._set_out()
            self._arrival = self._drive.await_arrival(self)

    def _end(self) -> None:
        self._arrival = None
        self._drive.ended(self)
        if self.callbacks:
            self.succeed()
        else:  # nobody waits for it: it has happened
            self._ok, self._value = True, None
            self.callbacks = None  # type: ignore[assignment]


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
            if not 0 < distance < math.inf:
                raise UserError(f"give the distance for person_close in metres, not {distance}")
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
