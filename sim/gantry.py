"""The gantry as its controller sees it: moves, picks, places and waits that can be yielded."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import Any

from simpy.events import Event, Process

from floorplan import Gantry
from navigation import gantry_limits, gantry_move, gantry_stop, standing

from .body import Body
from .clock import Alarm, Clock, Turn
from .recorder import Record
from .trial import GantryEntry, Job

Steps = Generator[Event, Any, None]
"""What a controller is: a generator of events to wait for, in SimPy's manner."""


@dataclass(frozen=True)
class Handling:
    """How long the gantry's hand takes, seconds (our choice; none are published)."""

    pick: float = 2.0
    place: float = 2.0


class GantryRobot:
    """The gantry, to be told what to do.

    A controller is a function or class of one argument, this robot, that yields what its
    methods return: `yield gantry.move_to(-2.5, 0.5)`. While the gantry is disabled it stands,
    and whatever was under way goes on afterwards.
    """

    def __init__(
        self,
        clock: Clock,
        gantry: Gantry,
        entry: GantryEntry,
        *,
        record: Record,
        locate: Callable[[str], tuple[float, float]],
    ) -> None:
        x, y, rotation = entry.at or gantry.start
        self.body = Body(clock, "gantry", "gantry", standing((x, y), heading=rotation))
        self.jobs = entry.jobs
        self.repeat = entry.repeat
        self.jobs_done = 0
        self.disabled_time = 0.0
        self.handling = Handling()
        self._clock = clock
        self._locate = locate
        self._gantry = gantry
        self._limits = gantry_limits(gantry)
        self._record = record
        self._enabled: Event | None = None
        self._disabled_at = 0.0
        self._interruption = clock.event()
        self._ready = Alarm(clock, self._enable, Turn.MOTION_ENDS)

    @property
    def now(self) -> float:
        """The time, seconds."""
        return self._clock.now

    @property
    def position(self) -> tuple[float, float, float]:
        """Where it is now: x, y (metres), rotation (radians)."""
        return self.body.state.position

    @property
    def disabled(self) -> bool:
        """Whether it stands because the referee disabled it."""
        return self._enabled is not None

    def move_to(self, x: float, y: float, rotation: float | None = None) -> Process:
        """Go to x, y (metres) and `rotation` (radians; None keeps it), to be waited for.

        `ValueError` if that is outside the gantry's range.
        """
        target = (x, y, self.position[2] if rotation is None else rotation)
        faults = self._gantry.faults(target)
        if faults:
            raise ValueError("; ".join(faults))
        return self._clock.process(self._move(target))

    def wait(self, seconds: float) -> Process:
        """Let `seconds` go by in which the gantry is not disabled."""
        if not seconds >= 0:
            raise ValueError(f"can't wait {seconds} s")
        return self._clock.process(self._work(seconds))

    def pick(self, place: str) -> Process:
        """Go to `place` (an obstacle, a station or an AGV by name) and take something there."""
        return self._clock.process(self._handle(place, self.handling.pick))

    def place(self, place: str) -> Process:
        """Go to `place` and put down what was taken."""
        return self._clock.process(self._handle(place, self.handling.place))

    def do(self, job: Job) -> Process:
        """One job of the trial, whatever its kind; records that it is done."""
        return self._clock.process(self._do(job))

    def disable(self, seconds: float) -> None:
        """Stop as fast as it can, and stand for `seconds` from now on."""
        self._record("gantry_disabled", seconds=seconds)
        self._ready.set(self._clock.now + seconds)
        if self._enabled is not None:
            return
        self._enabled = self._clock.event()
        self._disabled_at = self._clock.now
        self._interrupt()
        self.body.follow(gantry_stop(self.body.state, self._clock.now, limits=self._limits))

    def close(self) -> None:
        """The trial is over: count the time it was disabled until now."""
        if self.disabled:
            self.disabled_time += self._clock.now - self._disabled_at

    def _enable(self) -> None:
        self.disabled_time += self._clock.now - self._disabled_at
        self._record("gantry_enabled")
        enabled, self._enabled = self._enabled, None
        assert enabled is not None
        enabled.succeed()

    def _interrupt(self) -> None:
        self._interruption.succeed()
        self._interruption = self._clock.event()

    def _move(self, target: tuple[float, float, float]) -> Steps:
        while True:
            if self._enabled is not None:
                yield self._enabled
            motion = gantry_move(self.body.state, target, self._clock.now, limits=self._limits)
            self.body.follow(motion)
            arrival = self._clock.at(motion.end)
            yield arrival | self._interruption
            if arrival.processed:
                return

    def _work(self, seconds: float) -> Steps:
        while seconds > 0:
            if self._enabled is not None:
                yield self._enabled
            begun = self._clock.now
            done = self._clock.at(begun + seconds)
            yield done | self._interruption
            if done.processed:
                return
            seconds -= self._clock.now - begun

    def _handle(self, place: str, seconds: float) -> Steps:
        x, y = self._locate(place)
        yield self.move_to(x, y)
        yield self.wait(seconds)

    def _do(self, job: Job) -> Steps:
        if job.kind == "move":
            yield self.move_to(*job.target)
        elif job.kind == "wait":
            yield self.wait(job.seconds)
        elif job.kind == "pick_place":
            yield self.pick(job.pick)
            yield self.place(job.place)
        if job.kind == "submit":
            self._record("order_submitted", order=job.order)
            return
        self.jobs_done += 1
        fields = {"part": job.part, "from": job.pick, "to": job.place}
        self._record("job_done", job=job.kind, **(fields if job.kind == "pick_place" else {}))
