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
from .tasks import Gripper, Handling, Passing, Step, Task, Tasks, Worksites, tasks_of

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
    """Gantry robot as seen by its controller.

    A controller is a function or class that takes this robot and returns a generator. It yields
    what the methods return, for example `yield gantry.move_to(-2.5, 0.5)`. The robot carries out
    one command at a time: a new one replaces the current one. If the gantry is disabled, it stays
    stationary and resumes the current command afterwards.

    Parameters
    ----------
    stage : Stage
        State of the simulation.
    gantry : Gantry
        Gantry of the floorplan.
    entry : GantryEntry
        Gantry of the trial.
    name : str
        Name of the gantry.
    controller : callable
        Function that takes this robot and returns a generator.

    Attributes
    ----------
    gantry : Gantry
        Range, limits and home pose.
    floorplan : Floorplan
        Floor with this gantry.
    rules : RuleSet
        Rules of the trial.
    law : object
        Law of the protective separation distance from people.
    human_speed : float
        Highest speed of people in m/s.
    record : callable
        Function that records an `EventKind`.
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
        """Start the controller."""
        self._proximity = ApproachMonitor(self._stage, self, self._came_near)
        self.start(self._controller(self))

    # Its sensors.

    @property
    def now(self) -> float:
        """Simulated time in seconds."""
        return self._clock.now

    @property
    def state(self) -> State:
        """Current pose and velocity."""
        return self.body.state

    @property
    def position(self) -> Pose:
        """Current pose: x and y in metres and rotation in radians."""
        return self.body.state.position

    @property
    def disabled(self) -> bool:
        """Whether the gantry is disabled or in a protective stop."""
        return self.drive.disabled

    def look(self, after: float = 0.0) -> Event:
        """Observe the people. The value of the event is a tuple of `Sighting`.

        Parameters
        ----------
        after : float, optional
            Minimum delay in seconds. The observation is the next one of `OBSERVATION_RATE` after
            it.

        Returns
        -------
        Event
            Event to yield: `people = yield gantry.look()`.

        Raises
        ------
        ValueError
            If the delay is negative or infinite.
        """
        if not 0 <= after < math.inf:
            raise UserError(f"can't wait {after} s")
        self._interrupts.command_given()
        earliest = (self.now + after) * OBSERVATION_RATE
        at = math.ceil(earliest - 1e-9) / OBSERVATION_RATE
        return self._clock.ask(at, self._sightings, Turn.NOTICE)

    def interrupt_on(self, reason: Interruption, distance: float = math.inf) -> None:
        """Interrupt the controller from now on when something happens while it waits.

        As in SimPy, the `yield` raises `simpy.Interrupt` with `reason` as its cause. The current
        motion continues until the next command. After an interrupt there is no other one until the
        controller gives a command outside the `except` block that handles it. Reasons that occur
        meanwhile interrupt it then, each once.

        Parameters
        ----------
        reason : {"person_close", "disabled", "enabled", "part_dropped"}
            A person is closer than `distance`, the referee stops the gantry or releases it, or the
            gripper drops the carried part.
        distance : float, optional
            Distance in metres of a person from the axis of the gantry.

        Raises
        ------
        ValueError
            If the reason is unknown or the distance invalid.
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
        """Start to move to a pose.

        Parameters
        ----------
        x, y : float
            Position in metres.
        rotation : float, optional
            Rotation in radians. By default it does not change.
        speed_share : float, optional
            Share of the top speeds to use.
        resume : bool, optional
            Whether the move continues after the gantry was disabled.

        Returns
        -------
        Event
            Event to yield. It occurs when the move ends or another command replaces it.

        Raises
        ------
        ValueError
            If the pose is outside the range of the gantry.
        """
        target = self._sites.at(x, y, rotation)
        move = self.drive.move(target, speed_share, resume=resume)
        self._interrupts.command_given()
        return move

    def preview(
        self, x: float, y: float, rotation: float | None = None, *, speed_share: float = 1.0
    ) -> Motion:
        """Return the motion that `move_to` would start now.

        Parameters
        ----------
        x, y, rotation, speed_share
            See `move_to`.
        """
        return self.drive.preview(self._sites.at(x, y, rotation), speed_share)

    def follow(self, motion: Motion) -> Event:
        """Start to follow a motion. It does not continue after the gantry was disabled.

        Parameters
        ----------
        motion : Motion
            Motion that begins at the current time and pose.

        Returns
        -------
        Event
            Event to yield. It occurs when the motion ends or another command replaces it.

        Raises
        ------
        ValueError
            If the gantry is disabled.
        """
        move = self.drive.follow(motion)
        self._interrupts.command_given()
        return move

    def stop(self) -> Process:
        """Start the fastest stop, and discard the current command.

        Returns
        -------
        Process
            Event to yield.
        """
        return self._command(self.drive.stop())

    def stopping(self, state: State, t: float) -> Motion:
        """Return the fastest stop without moving.

        Parameters
        ----------
        state : State
            Initial pose and velocity.
        t : float
            Start time in seconds.
        """
        return self.drive.stopping(state, t)

    def wait(self, seconds: float) -> Process:
        """Wait. Time in which the gantry is disabled does not count.

        Parameters
        ----------
        seconds : float
            Duration in seconds.

        Returns
        -------
        Process
            Event to yield.
        """
        return self._command(self.drive.wait(seconds))

    def pick(self, place: str) -> Process:
        """Move to a place and pick up a part.

        Parameters
        ----------
        place : str
            Name of an obstacle, a station or an AGV.

        Returns
        -------
        Process
            Event to yield. Its value is False if another command replaced this one, otherwise True.
        """
        return self._visit("pick", self.handling.pick, place)

    def place(self, place: str) -> Process:
        """Move to a place and put down the part.

        Parameters
        ----------
        place : str
            Name of an obstacle, a station or an AGV.

        Returns
        -------
        Process
            Event to yield. Its value is False if another command replaced this one, otherwise True.
        """
        return self._visit("place", self.handling.place, place)

    # Its tasks.

    @property
    def open_tasks(self) -> tuple[Task, ...]:
        """Tasks that can be started or continued now, in order of preference."""
        return self.tasks.open

    def next_task(self) -> Event:
        """Wait for a task.

        Returns
        -------
        Event
            Event to yield. Its value is the preferred open task, or None if there will be none.
        """
        self._interrupts.command_given()
        return self.tasks.next()

    def do(self, task: Task) -> Process:
        """Carry out the remaining steps of a task on straight paths.

        An interrupted step is repeated from its begin.

        Parameters
        ----------
        task : Task
            The task.

        Returns
        -------
        Process
            Event to yield. Its value is False if another command replaced this one, otherwise True.
        """
        return self._command(self._do(task, self.drive.begin()))

    def where(self, task: Task) -> Pose | None:
        """Return the pose of the next step of a task, or None if it is out of reach.

        A step at an AGV is out of reach while the AGV drives or is outside the range of the gantry.

        Parameters
        ----------
        task : Task
            The task.
        """
        _next_step(task)
        step = self._catchable(task).next_step
        return None if step is None else self._sites.pose_for(step)

    def way(self, task: Task) -> tuple[Pose, ...]:
        """Return the poses of the remaining steps of a task, empty if one is out of reach.

        Parameters
        ----------
        task : Task
            The task.
        """
        rotation = self.position[2]
        poses: list[Pose] = []
        for step in self._catchable(task).steps_left:
            pose = self._sites.pose_for(step, rotation)
            if pose is None:
                return ()
            poses.append(pose)
        return tuple(poses)

    def locate(self, task: Task) -> Event:
        """Start or continue a task, and wait until its next step is in reach.

        Parameters
        ----------
        task : Task
            The task.

        Returns
        -------
        Event
            Event to yield. Its value is the pose of the next step.
        """
        pose = self._sites.pose_for(_next_step(task))
        if pose is None:
            return self._command(self._find(task))
        self._interrupts.command_given()
        self._begin(task)
        return self._clock.happened(pose)

    def handle(self, task: Task) -> Process:
        """Carry out the next step of a task at the current pose.

        An interrupted step is repeated from its begin.

        Parameters
        ----------
        task : Task
            The task.

        Returns
        -------
        Process
            Event to yield. Its value is False if the gantry is elsewhere or another command
            replaced this one, otherwise True.

        Raises
        ------
        ValueError
            If the task is done.
        """
        if (task.given_up and task.finished) or not self._sites.stands_at(_next_step(task)):
            return self._command(_not_done())
        return self._command(self._handle(task, self.drive.begin()))

    # The simulation's side of it.

    def start(self, controller: Steps) -> None:
        """Start or replace the controller.

        Parameters
        ----------
        controller : generator
            Generator returned by a controller.
        """
        self._interrupts.start(self._clock, controller)

    def interrupt(self, reason: str) -> None:
        """Interrupt the controller as soon as possible if it has asked for that.

        Parameters
        ----------
        reason : str
            Reason. See `interrupt_on`.
        """
        self._interrupts.happened(reason)

    def hold(self, stands: bool) -> None:
        """Start or end a protective stop.

        Parameters
        ----------
        stands : bool
            True to brake and stay stationary, False to continue.
        """
        self.drive.hold(stands)

    def disable(self, seconds: float) -> None:
        """Disable the gantry as a penalty.

        Parameters
        ----------
        seconds : float
            Duration in seconds.
        """
        self.drive.disable(seconds)

    def close(self) -> None:
        """Finish at the end of the trial."""
        self.drive.close()

    def figures(self, motion: Motion, now: float) -> dict[str, Any]:
        """Return values for the summary. A gantry that may move but does not is idle.

        Parameters
        ----------
        motion : Motion
            Track of the whole trial.
        now : float
            Time in seconds.
        """
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
        """Handle the begin or end of a blackout."""
        distance, here = self._interrupts.close_distance, self.body.at
        people = self._stage.people if distance is not None else ()
        if any(math.dist(person.body.at, here) < (distance or 0.0) for person in people):
            self._came_near()

    def _came_near(self) -> None:
        if not self._stage.blind[self.name]:
            self.interrupt("person_close")

    def floor_changed(self) -> None:
        """Handle that a machine has stopped on the floor."""
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
        """Handle that a part can no longer be picked by choosing another one.

        Parameters
        ----------
        passing : Passing
            The part on the conveyor.
        """
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
