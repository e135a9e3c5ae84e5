"""The gantry as its controller sees it: what it can be told, and what it can see."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from simpy.events import Event, Process

from floorplan import Floorplan, Gantry
from navigation import Motion, State

from .body import Body
from .clock import Clock, Turn
from .drive import Drive, Steps
from .recordings.recorder import Record
from .rules import PAPER, RuleSet
from .tasks import Handling, Pose, Step, Task, Tasks, tasks_of
from .trials.trial import GantryEntry

Interruption = Literal["person_close", "disabled", "enabled"]
"""What can interrupt a controller that asked for it."""

OBSERVATION_RATE = 10.0
"""Hz. How often the gantry sees where people are."""

REACH = 1e-3
"""Metres. How near to a place the gantry's axis has to be to handle something there."""


@dataclass(frozen=True)
class Sighting:
    """A person as the gantry's sensors see them: x, y in metres, velocity in m/s."""

    name: str
    at: tuple[float, float]
    velocity: tuple[float, float]

    @property
    def speed(self) -> float:
        """The speed over the floor, m/s."""
        return math.hypot(*self.velocity)


@dataclass(frozen=True, kw_only=True)
class Surroundings:
    """What a gantry has around it: the people it sees, the places it works at, the rules.

    `locate(place)` is where an obstacle, a station or an AGV is, None while an AGV drives;
    `human_speed` is how fast people may come (m/s).
    """

    floorplan: Floorplan
    see: Callable[[], tuple[Sighting, ...]] = tuple
    locate: Callable[[str], tuple[float, float] | None]
    rules: RuleSet = PAPER
    human_speed: float = 1.0


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
        surroundings: Surroundings,
        *,
        record: Record,
    ) -> None:
        self.gantry = gantry
        self.floorplan = surroundings.floorplan
        self.rules = surroundings.rules
        self.human_speed = surroundings.human_speed
        self.handling = Handling()
        self.tasks = Tasks(clock)
        self.jobs_done = 0
        self.on_interest: Callable[[], None] = lambda: None
        self.drive = Drive(
            clock,
            gantry,
            gantry.start if entry.at is None else entry.at,
            record=record,
            disabled_or_enabled=self.interrupt,
        )
        self._clock = clock
        self._entry = entry
        self._surroundings = surroundings
        self._record = record
        self._floor_changed = clock.event()
        self._controller: Process | None = None
        self._interests: dict[str, float] = {}
        self._begin_round()

    # What it sees.

    @property
    def now(self) -> float:
        """The time, seconds."""
        return self._clock.now

    @property
    def body(self) -> Body:
        """The gantry as a body on the floor."""
        return self.drive.body

    @property
    def state(self) -> State:
        """Where it is and how it moves now."""
        return self.body.state

    @property
    def position(self) -> Pose:
        """Where it is now: x, y (metres), rotation (radians)."""
        return self.body.state.position

    @property
    def disabled(self) -> bool:
        """Whether it stands because the referee disabled it."""
        return self.drive.disabled

    def look(self, after: float = 0.0) -> Process:
        """The people around, as seen at the first observation `after` seconds from now or later.

        The value is a tuple of `Sighting`s: `people = yield gantry.look()`.
        """
        if not 0 <= after < math.inf:
            raise ValueError(f"can't wait {after} s")
        return self._clock.process(self._look(after))

    def interrupt_on(self, reason: Interruption, distance: float = math.inf) -> None:
        """From now on, interrupt the controller where it waits when this happens.

        It is interrupted in SimPy's manner: the `yield` raises `simpy.Interrupt` with `reason` as
        its cause. "person_close" happens when a person comes within `distance` metres of the
        gantry's axis, "disabled" and "enabled" when the referee stops it and lets it go on.
        """
        if reason not in ("person_close", "disabled", "enabled"):
            raise ValueError(f"nothing called {reason!r} interrupts a controller")
        if reason == "person_close" and not 0 < distance < math.inf:
            raise ValueError(f"give the distance for person_close in metres, not {distance}")
        self._interests[reason] = distance
        self.on_interest()

    # What it can be told.

    def move_to(
        self,
        x: float,
        y: float,
        rotation: float | None = None,
        *,
        speed_share: float = 1.0,
        resume: bool = True,
    ) -> Process:
        """Go to x, y (metres) and `rotation` (radians; None keeps it), to be waited for.

        It makes use of `speed_share` of its top speeds. A new move or a stop takes the place of
        this one; being disabled does so unless it is to `resume` by itself afterwards.
        `ValueError` if that is outside the gantry's range.
        """
        return self.drive.move(self._target(x, y, rotation), speed_share, resume)

    def preview(
        self, x: float, y: float, rotation: float | None = None, *, speed_share: float = 1.0
    ) -> Motion:
        """The motion that `move_to` would make from here and now; nothing moves by it."""
        return self.drive.preview(self._target(x, y, rotation), speed_share)

    def follow(self, motion: Motion) -> Process:
        """Go along `motion`, which begins here and now, to be waited for.

        A move or a stop takes its place; so does being disabled, and it isn't gone on with.
        `ValueError` while disabled.
        """
        return self.drive.follow(motion)

    def stop(self) -> Process:
        """Stop as fast as it can, to be waited for; the move under way is forgotten."""
        return self.drive.stop()

    def stopping(self, state: State, t: float) -> Motion:
        """The fastest stop from `state` at `t` (seconds); nothing moves by it."""
        return self.drive.stopping(state, t)

    def wait(self, seconds: float) -> Process:
        """Let `seconds` go by in which the gantry is not disabled."""
        return self.drive.work(seconds)

    def pick(self, place: str) -> Process:
        """Go to `place` (an obstacle, a station or an AGV by name) and take something there."""
        return self._clock.process(self._visit(Step("pick", self.handling.pick, place=place)))

    def place(self, place: str) -> Process:
        """Go to `place` and put down what was taken."""
        return self._clock.process(self._visit(Step("place", self.handling.place, place=place)))

    # What there is to do.

    @property
    def open_tasks(self) -> tuple[Task, ...]:
        """The tasks that may be begun or gone on with now, the preferred one first."""
        return self.tasks.open

    def next_task(self) -> Event:
        """The preferred open task, as soon as there is one; None when there won't be any."""
        return self.tasks.next()

    def do(self, task: Task) -> Process:
        """All of a task, the straight way."""
        return self._clock.process(self._do(task))

    def where(self, task: Task) -> Pose | None:
        """Where the task's next step is now: x, y, rotation; None if it can't be reached now.

        A step at an AGV can't be while the AGV drives, or stands beyond the rails.
        """
        return self._pose(_next_step(task))

    def way(self, task: Task) -> tuple[Pose, ...]:
        """Where the task's steps that are left would be now; nothing if one can't be reached."""
        rotation = self.position[2]
        poses = [self._pose(step, rotation) for step in task.steps_left]
        return () if None in poses else tuple(pose for pose in poses if pose is not None)

    def locate(self, task: Task) -> Process:
        """Begin the task, or go on with it: `where` its next step is, once it can be reached."""
        return self._clock.process(self._find(task))

    def handle(self, task: Task) -> Process:
        """Do what the task's next step needs, here. The value is whether it could be done."""
        return self._clock.process(self._handle(task))

    # What others do with it.

    def start(self, controller: Steps) -> None:
        """Let `controller` tell it what to do from now on."""
        self._controller = self._clock.process(controller)

    def interrupt(self, reason: str) -> None:
        """Interrupt the controller, if it asked for it and is waiting for something."""
        controller = self._controller
        if reason in self._interests and controller is not None and controller.is_alive:
            controller.interrupt(reason)

    @property
    def close_distance(self) -> float | None:
        """Metres within which a person's coming interrupts the controller, if it asked for it."""
        return self._interests.get("person_close")

    def floor_changed(self) -> None:
        """An AGV has come to rest."""
        changed, self._floor_changed = self._floor_changed, self._clock.event()
        changed.succeed()
        self.tasks.reconsider()

    def _target(self, x: float, y: float, rotation: float | None) -> Pose:
        return (x, y, self.position[2] if rotation is None else rotation)

    def _look(self, after: float) -> Steps:
        earliest = (self.now + after) * OBSERVATION_RATE
        yield self._clock.at(math.ceil(earliest - 1e-9) / OBSERVATION_RATE, Turn.NOTICE)
        return self._surroundings.see()

    def _pose(self, step: Step, rotation: float | None = None) -> Pose | None:
        """Where a step is now, if it can be reached now; `rotation` as it is if not given."""
        if step.target is not None:
            return step.target
        if step.place is None:
            return self.position
        at = self._surroundings.locate(step.place)
        if at is None:
            return None
        return self._target(at[0] + step.offset[0], at[1] + step.offset[1], rotation)

    def _find(self, task: Task) -> Steps:
        step = _next_step(task)
        self._begin(task)
        pose = self._pose(step)
        while pose is None:
            yield self._floor_changed
            pose = self._pose(step)
        return pose

    def _visit(self, step: Step) -> Steps:
        while (pose := self._pose(step)) is None:
            yield self._floor_changed
        yield self.move_to(*pose)
        yield self.wait(step.seconds)

    def _handle(self, task: Task) -> Steps:
        step = _next_step(task)
        pose = self._pose(step)
        moving = self.now < self.body.motion.end
        if pose is None or moving or math.dist(pose[:2], self.position[:2]) > REACH:
            return False
        self._begin(task)
        yield self.wait(step.seconds)
        task.advance()
        if task.finished:
            self._finish(task)
        return True

    def _do(self, task: Task) -> Steps:
        while task.next_step is not None:
            pose = yield self.locate(task)
            yield self.move_to(*pose)
            yield self.handle(task)

    def _begin(self, task: Task) -> None:
        if not task.announced:
            task.announced = True
            self._record("job_started", job=task.kind, **task.fields)

    def _finish(self, task: Task) -> None:
        if task.kind == "submit":
            self._record("order_submitted", **task.fields)
        else:
            self.jobs_done += 1
            self._record("job_done", job=task.kind, **task.fields)
        task.done()
        round_over = all(task.finished for task in self._round)
        if self._entry.repeat and round_over and self.now > self._round_began:
            self._begin_round()
        self.tasks.reconsider()

    def _begin_round(self) -> None:
        """Set out to do the jobs of the trial."""
        self._round_began = self.now
        self._round = tasks_of(self._entry.jobs, self.handling)
        self.tasks.add(self._round)


def _next_step(task: Task) -> Step:
    step = task.next_step
    if step is None:
        raise ValueError(f"{task} is done already")
    return step
