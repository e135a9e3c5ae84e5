"""The gantry as its controller sees it: its commands and its sensors."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from simpy.events import Event, Process

from floorplan import Gantry, UserError
from navigation import Motion
from navigation.motion import State

from ...core.body import Machine, MachineShape
from ...core.clock import MOMENT, Turn
from ...core.entries import Pose
from ...core.events import EventKind, JobDone, JobStarted, OrderSubmitted, PartDropped
from ...core.scenario import GantryEntry
from ...core.stage import Stage
from ...safety.proximity import ApproachMonitor
from .drive import Drive, Interruption, Interrupts, Steps
from .tasks import Gripper, Handling, Passing, Step, Task, Tasks, tasks_of
from .worksites import Worksites

GANTRY = "gantry"
"""The name of the floor's own gantry, which events leave out."""

OBSERVATION_RATE = 10.0
"""Hz. Rate at which the gantry sees where people are."""


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


class GantryRobot(Machine):
    """The gantry, to be commanded by a controller.

    A controller is a function or class of one argument, this robot, that yields what its
    methods return: `yield gantry.move_to(-2.5, 0.5)`. It does one thing at a time: moving,
    stopping, picking, placing and handling take the place of what was under way. While the gantry
    is disabled it stands, and whatever was under way goes on afterwards. `record(event)` records
    an event, which may be of an `EventKind` of your own.
    """

    def __init__(
        self,
        stage: Stage,
        gantry: Gantry,
        entry: GantryEntry,
        name: str,
        *,
        controller: Callable[[GantryRobot], Steps],
    ) -> None:
        self.gantry = gantry
        self.floorplan = replace(stage.floorplan, gantry=gantry)
        self.rules = stage.rules
        self.human_speed = stage.fastest
        self.handling = Handling()
        self.tasks = Tasks(stage.clock)
        self.jobs_done = 0
        self.parts_dropped = 0
        self.gripper = Gripper(stage.clock, self._lose)
        self.gripper.will_lose(entry.drops)
        self.shape = gantry_shape(gantry, name)
        self.law = stage.rules.law_of(self.shape)
        self.record = stage.record if name == GANTRY else self._record_by_name
        self.drive = Drive(
            stage.clock,
            gantry,
            gantry.start if entry.at is None else entry.at,
            name=name,
            record=self.record,
            disabled_or_enabled=self.interrupt,
        )
        self.body = self.drive.body
        self._stage = stage
        self._interrupts = Interrupts()
        self._clock = stage.clock
        self._entry = entry
        self._controller = controller
        self._sites = Worksites(stage, gantry, self.drive)
        self._proximity: ApproachMonitor | None = None
        self._floor_changed = stage.clock.event()
        self._begin_round()

    def _record_by_name(self, event: EventKind) -> None:
        """Record an event of one of several gantries."""
        self._stage.record(event.of({**event.fields, "machine": self.name}))

    def begin(self) -> None:
        """Let its controller begin."""
        self._proximity = ApproachMonitor(self._stage, self, self._came_near)
        self.start(self._controller(self))

    # Its sensors.

    @property
    def now(self) -> float:
        """Simulated time (seconds)."""
        return self._clock.now

    @property
    def state(self) -> State:
        """Pose and velocity now."""
        return self.body.state

    @property
    def position(self) -> Pose:
        """Pose now: x, y (metres), rotation (radians)."""
        return self.body.state.position

    @property
    def disabled(self) -> bool:
        """True while it is made to stand: disabled, or in a protective stop."""
        return self.drive.disabled

    def look(self, after: float = 0.0) -> Event:
        """See the people around, at the first observation `after` seconds from now or later.

        The value is a tuple of `Sighting`s: `people = yield gantry.look()`.
        """
        if not 0 <= after < math.inf:
            raise UserError(f"can't wait {after} s")
        self._interrupts.command_given()
        earliest = (self.now + after) * OBSERVATION_RATE
        at = math.ceil(earliest - 1e-9) / OBSERVATION_RATE
        return self._clock.ask(at, self._sightings, Turn.NOTICE)

    def interrupt_on(self, reason: Interruption, distance: float = math.inf) -> None:
        """From now on, interrupt the controller where it waits when this happens.

        It is interrupted in SimPy's manner: the `yield` raises `simpy.Interrupt` with `reason` as
        its cause. "person_close" happens when a person comes within `distance` metres of the
        gantry's axis, "disabled" and "enabled" when the referee stops it and lets it go on,
        "part_dropped" when the part that it carries drops.

        After an interrupt there is no other until the controller gives a command outside the
        `except` that handles it; what happens meanwhile interrupts it then, each reason once. An
        interrupt ends the waiting alone: the gantry goes on with what it does until it is given
        another command. `ValueError` for another reason, or a distance that is none.
        """
        self._interrupts.ask_for(reason, distance)
        if self._proximity is not None:
            self._proximity.near(self._interrupts.close_distance)

    # Its commands.

    def move_to(
        self,
        x: float,
        y: float,
        rotation: float | None = None,
        *,
        speed_share: float = 1.0,
        resume: bool = True,
    ) -> Event:
        """Go to x, y (metres) and `rotation` (radians; None keeps it), to be waited for.

        It makes use of `speed_share` of its top speeds. A new move or a stop takes the place of
        this one; being disabled does so unless it is to `resume` by itself afterwards.
        `ValueError` if that is outside the gantry's range.
        """
        target = self._sites.at(x, y, rotation)
        move = self.drive.move(target, speed_share, resume=resume)
        self._interrupts.command_given()
        return move

    def preview(
        self, x: float, y: float, rotation: float | None = None, *, speed_share: float = 1.0
    ) -> Motion:
        """Return the motion that `move_to` would make from here and now; nothing moves by it."""
        return self.drive.preview(self._sites.at(x, y, rotation), speed_share)

    def follow(self, motion: Motion) -> Event:
        """Go along `motion`, which begins here and now, to be waited for.

        A move or a stop takes its place; so does being disabled, and it isn't gone on with.
        `ValueError` while disabled.
        """
        move = self.drive.follow(motion)
        self._interrupts.command_given()
        return move

    def stop(self) -> Process:
        """Stop as fast as it can, to be waited for; the move under way is forgotten."""
        return self._command(self.drive.stop())

    def stopping(self, state: State, t: float) -> Motion:
        """Return the fastest stop from `state` at `t` (seconds); nothing moves by it."""
        return self.drive.stopping(state, t)

    def wait(self, seconds: float) -> Process:
        """Let `seconds` go by in which the gantry is not disabled."""
        return self._command(self.drive.wait(seconds))

    def pick(self, place: str) -> Process:
        """Go to `place` (an obstacle, a station or an AGV by name) and take something there.

        The value is True if it was done, False if another command took its place before the end.
        """
        return self._visit("pick", self.handling.pick, place)

    def place(self, place: str) -> Process:
        """Go to `place` and put down what was taken; the value is as that of `pick`."""
        return self._visit("place", self.handling.place, place)

    # Its tasks.

    @property
    def open_tasks(self) -> tuple[Task, ...]:
        """The tasks that may be begun or gone on with now, the preferred one first."""
        return self.tasks.open

    def next_task(self) -> Event:
        """Wait for the preferred open task, which is the value; None when there won't be any."""
        self._interrupts.command_given()
        return self.tasks.next()

    def do(self, task: Task) -> Process:
        """Do the steps of a task that are left, on straight paths.

        The value is True if it is done, False if another command took the place of this one. A
        step that was broken off begins anew when it is done again.
        """
        return self._command(self._do(task, self.drive.begin()))

    def where(self, task: Task) -> Pose | None:
        """Return the pose (x, y, rotation) of the task's next step; None if out of reach now.

        A step at an AGV can't be while the AGV drives, or stands beyond the rails.
        """
        _next_step(task)
        step = self._catchable(task).next_step
        return None if step is None else self._sites.pose_for(step)

    def way(self, task: Task) -> tuple[Pose, ...]:
        """Return the poses of the task's steps that are left; none if one can't be reached now."""
        rotation = self.position[2]
        poses: list[Pose] = []
        for step in self._catchable(task).steps_left:
            pose = self._sites.pose_for(step, rotation)
            if pose is None:
                return ()
            poses.append(pose)
        return tuple(poses)

    def locate(self, task: Task) -> Event:
        """Begin the task, or go on with it: `where` its next step is, once it can be reached."""
        pose = self._sites.pose_for(_next_step(task))
        if pose is None:
            return self._command(self._find(task))
        self._interrupts.command_given()
        self._begin(task)
        return self._clock.happened(pose)

    def handle(self, task: Task) -> Process:
        """Do the work of the task's next step, here. The value is True if it was done.

        It was not if this is not the place, or if another command took the place of this one: the
        step then begins anew when it is handled again. `ValueError` if the task is done already.
        """
        if (task.given_up and task.finished) or not self._sites.stands_at(_next_step(task)):
            return self._command(_not_done())
        return self._command(self._handle(task, self.drive.begin()))

    # The simulation's side of it.

    def start(self, controller: Steps) -> None:
        """Let `controller` command it from now on."""
        self._interrupts.start(self._clock, controller)

    def interrupt(self, reason: str) -> None:
        """Interrupt the controller, as soon as it can be, if it asked for it."""
        self._interrupts.happened(reason)

    def hold(self, stands: bool) -> None:
        """Brake and stand until `hold(False)`, then go on: a protective stop."""
        self.drive.hold(stands)

    def disable(self, seconds: float) -> None:
        """Brake and stand for so long: a penalty."""
        self.drive.disable(seconds)

    def close(self) -> None:
        """Settle what is still open: the trial is over."""
        self.drive.close()

    def figures(self, motion: Motion, now: float) -> dict[str, Any]:
        """Return its figures; it is idle while it neither moves, handles nor is made to stand."""
        drive = self.drive
        moving = sum(piece.end - piece.begin for piece in motion.pieces if not piece.stands)
        # While it brakes because it is made to stand, both count.
        busy = moving - drive.braking_time + drive.working_time + drive.standing_time
        return {
            "disabled_time": drive.disabled_time,
            "idle_time": max(0.0, now - busy),
            "jobs_done": self.jobs_done,
            **({"parts_dropped": self.parts_dropped} if self.gripper.drops else {}),
        }

    def sight_changed(self) -> None:
        """Take note of who is near, if it sees people again."""
        distance, here = self._interrupts.close_distance, self.body.at
        people = self._stage.people if distance is not None else ()
        if any(math.dist(person.body.at, here) < (distance or 0.0) for person in people):
            self._came_near()

    def _came_near(self) -> None:
        if not self._stage.blind[self.name]:
            self.interrupt("person_close")

    def floor_changed(self) -> None:
        """Take note that a machine has come to rest on the floor."""
        changed, self._floor_changed = self._floor_changed, self._clock.event()
        changed.succeed()
        self.tasks.reconsider()

    def _command(self, steps: Steps) -> Process:
        self._interrupts.command_given()
        return self._clock.process(steps)

    def _sightings(self) -> tuple[Sighting, ...]:
        if self._stage.blind[self.name]:
            return ()
        seen = []
        for person in self._stage.people:
            position, velocity, _ = person.body.state
            seen.append(Sighting(person.name, position[:2], velocity[:2]))
        return tuple(seen)

    def _find(self, task: Task) -> Steps:
        _next_step(task)
        self._begin(task)
        pose: Pose | None = None
        while pose is None and (step := self._catchable(task).next_step) is not None:
            pose = yield from self._reached(step, task)
        return self.position if pose is None else pose

    def _catchable(self, task: Task) -> Task:
        """Return `task`, with another part in place of one that goes by and can't be met."""
        while (
            (step := task.next_step) is not None
            and step.passing
            and self._sites.pose_for(step) is None
        ):
            self._begin_again(task)
        return task

    def _reached(self, step: Step, task: Task | None = None) -> Steps:
        """Wait until a step can be reached; the value is its pose then.

        None if it is not the next of its task any more.
        """
        while (pose := self._sites.pose_for(step)) is None and (
            task is None or task.next_step is step
        ):
            yield self._floor_changed
        return pose

    def _visit(self, action: str, seconds: float, place: str) -> Process:
        """Go to a place and handle something there, as one command."""
        step, command = Step(action, seconds=seconds, place=place), self.drive.begin()

        def steps() -> Steps:
            yield from self._go_to(step, command)
            return (yield from self.drive.work(seconds, command))

        return self._command(steps())

    def _go_to(self, step: Step, command: int, task: Task | None = None) -> Steps:
        """As a part of `command`, go to where `step` is, once it can be reached."""
        pose = yield from self._reached(step, task)
        if pose is not None and self.drive.is_under_way(command):
            yield self.drive.move(pose, command=command)

    def _handle(self, task: Task, command: int) -> Steps:
        self._begin(task)
        step = _next_step(task)
        passing, seconds = step.passing, step.seconds
        comes_by = None if passing is None else self._sites.comes_by(passing)
        if comes_by is not None:
            seconds = max(seconds, comes_by - self.now)
        done: bool = yield from self.drive.work(seconds, command)
        if not done or task.next_step is not step:  # what it was about to put down has dropped
            return False
        if passing is not None:
            if comes_by is None or abs(comes_by - self.now) > MOMENT:
                return False  # it has been held up, and what it was to pick is past
            passing.taken()
        if step.action == "pick":
            self.gripper.close(task)
        elif step.place is not None:
            self.gripper.open()
        task.advance()
        if task.finished and (more := task.check()):
            task.begin_again(more)
        if task.finished:
            self._finish(task)
        return True

    def _do(self, task: Task, command: int) -> Steps:
        while self.drive.is_under_way(command):
            step = self._catchable(task).next_step
            if step is None:
                break
            self._begin(task)
            yield from self._go_to(step, command, task)
            # An AGV may have left in the meantime, or the part has dropped.
            there = step is task.next_step and self._sites.stands_at(step)
            if self.drive.is_under_way(command) and there:
                yield from self._handle(task, command)
        return task.finished

    def _begin(self, task: Task) -> None:
        if not task.announced:
            task.announced = True
            self.record(JobStarted.of({"job": task.kind, **task.fields}))

    def _lose(self, task: Task) -> None:
        """Let the part drop that is carried for `task`, and begin again with another."""
        self.parts_dropped += 1
        part, order = (task.fields.get(name) for name in ("part", "order"))
        self.record(PartDropped(part=part, order=order, at=self.body.at))
        self._begin_again(task)
        self.interrupt("part_dropped")

    def missed(self, passing: Passing) -> None:
        """Take note that it can't be picked any more: look for others in its place."""
        for task in [*self.tasks.picking(passing)]:
            self._begin_again(task)
        self.floor_changed()

    def _begin_again(self, task: Task) -> None:
        if steps := task.lost():
            task.begin_again(steps)
        else:
            task.give_up()
        self._go_on()

    def _finish(self, task: Task) -> None:
        if task.kind == "submit":
            self.record(OrderSubmitted.of(task.fields))
        elif not task.given_up:
            self.jobs_done += 1
            self.record(JobDone.of({"job": task.kind, **task.fields}))
        task.done()
        self._go_on()

    def _go_on(self) -> None:
        """Begin the next round of jobs if this one is over, and let tasks be chosen anew."""
        round_over = all(task.finished for task in self._round)
        if self._entry.repeat and round_over and self.now > self._round_began:
            self._begin_round()
        self.tasks.reconsider()

    def _begin_round(self) -> None:
        """Set out to do the jobs of the trial."""
        self._round_began = self.now
        self._round = tasks_of(self._entry.jobs, self.handling)
        self.tasks.add(self._round)


def gantry_shape(gantry: Gantry, name: str) -> MachineShape:
    """Return the shape of a gantry, as others see it."""
    length, width, bottom, top = gantry.torso
    return MachineShape(
        name=name,
        kind="gantry",
        category="robot",
        length=length,
        width=width,
        bottom=bottom,
        top=top,
        top_speed=math.hypot(gantry.x.max_speed, gantry.y.max_speed),
        reach=gantry.arm_reach,
        mount=gantry.arm_mount[0],
    )


def _not_done() -> Steps:
    return False
    yield


def _next_step(task: Task) -> Step:
    step = task.next_step
    if step is None:
        raise UserError(f"{task} is done already")
    return step
