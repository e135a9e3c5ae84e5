"""Commanding of machines: moves that can be replaced or stopped, and interrupts of controllers."""

from __future__ import annotations

import math
import sys
from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Sequence
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
from .arguments import number

Steps = Generator[Event, Any, Any]
"""Steps of a controller: a generator of events to wait for, in SimPy's manner."""

RETRY = 2.0
"""Seconds after which a blocked vehicle plans again, if nothing has changed on the floor."""


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
        self._move: Move | None = None
        """The move under way."""
        self.target: Pose | None = None
        """Target of the last move."""
        self.last_move: tuple[Pose, float] | None = None
        """Target and share of the top speeds of the last command, if that was a move."""
        self._replaced = clock.event()
        self._braking = clock.event()
        self._previewed_at, self._previewed_on = -1.0, body.motion
        self._previews: dict[tuple[tuple[float, ...], float], Motion] = {}
        """The motions from here and now: a controller asks for one before it moves."""

    @abstractmethod
    def destination(self, target: Sequence[float]) -> Pose:
        """Return the pose in which a move to x, y, and a rotation if there is one, ends."""

    def preview(self, target: Sequence[float], speed_share: float) -> Motion:
        """Return the motion from here and now to `target`, at that share of the top speeds.

        `ValueError` if the machine can't get there, or the share is not in 0 … 1.
        """
        now, motion = self._clock.now, self.body.motion
        if self._previewed_at != now or self._previewed_on is not motion:
            self._previewed_at, self._previewed_on = now, motion
            self._previews.clear()
        key = (tuple(map(float, target)), self._allowed(speed_share))
        found = self._previews.get(key)
        if found is None:
            found = self._planned(*key)
            self._previews[key] = found
        return found

    @abstractmethod
    def _planned(self, target: tuple[float, ...], speed_share: float) -> Motion:
        """Return a motion for `preview`, at a share that the limit of the speed allows."""

    def resumed(self, target: Pose, speed_share: float) -> Motion:
        """Return the motion with which a move goes on after the machine was made to stand."""
        return self.preview(target, speed_share)

    def try_again(self) -> Event | None:
        """Return the event at which a move that came to rest early goes on, if it may."""
        return None

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

    @property
    def replaced(self) -> Event:
        """The event that another command replaces the one under way."""
        return self._replaced

    def begin(self) -> int:
        """Begin a command, which takes the place of the one under way; return its number."""
        self._commands += 1
        if self._move is not None:
            self._move.end()
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
            move.go_on()
        return move

    def follow(self, motion: Motion, again: Callable[[], Motion] | None = None) -> Event:
        """Go along `motion`, which begins here and now; see `GantryRobot.follow`.

        `again` returns the motion to go on with when the limit of the speed changes. Without that
        the machine stands as long as the motion is too fast.
        """
        if self.disabled:
            raise UserError(f"the {self.body.kind} is disabled")

        def slower() -> Motion | None:
            if again is not None:
                return again()
            if self._is_too_fast(self.body.motion):
                self._stand_too_fast()
            return None

        self.begin()
        self.last_move = self.target = None
        move = self._move = Move(self, None, slower)
        if again is None and self._is_too_fast(motion):
            self._stand_too_fast()
        else:
            move.follow(motion)
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
        elif not self.disabled and self._move is not None:
            self._move.adapt()

    def _stand_too_fast(self) -> None:
        self._too_fast = True
        self._stand()

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
        return self._until(self.body.motion.end)

    def wait(self, seconds: float) -> Steps:
        """Let `seconds` go by in which it is not disabled."""
        return self._enabled_for(number("wait(seconds)", seconds, 0.0), None)

    def work(self, seconds: float, command: int, *, stays: bool = False) -> Steps:
        """Work for `seconds` as a part of `command`; the value is True unless it was replaced.

        If the machine `stays` where it is anyway, it need not be free to move.
        """
        return self._enabled_for(seconds, command, stays=stays)

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
            self._count_standing()

    @property
    def _may_go_on(self) -> bool:
        """Whether nothing makes it stand any more."""
        return not self._held and not self._too_fast

    def _stand(self) -> None:
        if self._enabled is None:
            self._enabled = self._clock.event()
            self._stands_since = self._clock.now
            self._brake()
            self._notify("disabled")

    def _go_on(self) -> None:
        """Be free to move, if nothing makes it stand."""
        if self._enabled is not None and self._may_go_on:
            self._count_standing()
            enabled, self._enabled = self._enabled, None
            enabled.succeed()
            self._notify("enabled")

    def _count_standing(self) -> None:
        """Count the time at rest, without the braking before, which may still last."""
        rests_from = max(self._stands_since, self.body.motion.end)
        self.standing_time += max(0.0, self._clock.now - rests_from)

    def _brake(self) -> None:
        self.body.follow(self.stopping(self.body.state, self._clock.now))
        if self._move is not None:
            self._move.broken_off()
        if self._braking.callbacks:
            braking, self._braking = self._braking, self._clock.event()
            braking.succeed()

    def _begin_soon(self, move: Move) -> None:
        """Let a command of its own begin, once its controller has said all it says at once."""
        self._clock.call_at(self._clock.now, move.go_on, Turn.VIOLATION)

    def is_move(self, move: Move) -> bool:
        """Return whether this is the move under way."""
        return move is self._move

    def extend(self, move: Event | None, longer: Callable[[], Motion]) -> None:
        """Go on with a longer motion if `move` is under way."""
        if self._move is not None and move is self._move:
            self._move.extend(longer())

    def ended(self) -> None:
        """Handle the end of the move under way."""
        self._move = None

    def _until(self, t: float) -> Steps:
        yield self._clock.at(t)

    def _enabled_for(self, seconds: float, command: int | None, *, stays: bool = False) -> Steps:
        """Let `seconds` go by in which it is not disabled, unless `command` is replaced before.

        All seconds count if it `stays`.
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
            # Until it is done, or something breaks it off: time goes on counting from what is left.
            yield done | change
            elapsed = self._clock.now - begun
            if command is not None and enabled is None:
                self.working_time += elapsed
            seconds = 0.0 if done.processed else seconds - elapsed
        return command in (None, self._commands)


class Move(Event):
    """The end of a move: it happens at the arrival, or where the move is given up.

    A move that is broken off, because the machine is made to stand, goes on with the motion of
    `resumed` as soon as the machine is free. Without `resumed` it ends. It also ends when another
    command replaces it. When the limit of the speed changes, it goes on with the motion of
    `adapted`, if there is one.
    """

    def __init__(
        self,
        drive: Drive,
        resumed: Callable[[], Motion] | None,
        adapted: Callable[[], Motion | None],
    ) -> None:
        super().__init__(drive.body.clock)
        self._drive = drive
        self._resumed = resumed
        self._adapted = adapted
        self._motion: Motion | None = None
        """The motion that it follows, unless the machine brakes or stands."""
        self._arrival: Event | None = None

    def follow(self, motion: Motion) -> None:
        """Follow a motion that begins here and now."""
        self._motion = motion
        self._drive.body.follow(motion)

    def go_on(self, _: Event | None = None) -> None:
        """Wait for the arrival, or until the machine is free to move."""
        drive = self._drive
        if not drive.is_move(self):
            return
        if drive.enabled is not None:
            then(drive.enabled, self.go_on)
            return
        if self._motion is None:
            if self._resumed is None:
                self.end()
                return
            self.follow(self._resumed())
        self._await_arrival()

    def adapt(self) -> None:
        """Go on with the motion that the limit of the speed allows."""
        if self._motion is not None and self._motion.end > self._drive.body.clock.now:
            motion = self._adapted()
            if motion is not None:
                self.extend(motion)

    def extend(self, motion: Motion) -> None:
        """Go on with another motion that begins here and now."""
        self.follow(motion)
        if self._arrival is not None:
            self._await_arrival()

    def broken_off(self) -> None:
        """Go on once the machine is free, if it may. One that has not begun waits to begin."""
        self._motion = None
        if self._arrival is not None:
            self._arrival = None
            if self._resumed is None:
                self.end()
            else:
                self.go_on()

    def end(self) -> None:
        """End the move, whether it has arrived or is given up."""
        self._arrival = None
        self._drive.ended()
        if self.callbacks:
            self.succeed()
        else:  # nobody waits for it: it has happened
            self._ok, self._value = True, None
            self.callbacks = None  # type: ignore[assignment]

    def _await_arrival(self) -> None:
        # A machine that is made to stand as it sets out has broken the move off again.
        if self._motion is not None:
            self._arrival = self._drive.body.clock.at(self._motion.end)
            then(self._arrival, self._arrived)

    def _arrived(self, arrival: Event) -> None:
        if arrival is not self._arrival:
            return
        again = self._drive.try_again()
        if again is None or self._resumed is None:
            self.end()
        else:
            self._arrival = self._motion = None
            then(again, self.go_on)


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
            if not number("interrupt_on(distance)", distance) > 0:
                raise UserError(f"interrupt_on(distance) must be more than 0, not {distance}")
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
