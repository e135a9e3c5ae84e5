"""Gantries: their commands, tasks and passing places."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import shapely
from shapely.geometry import Polygon
from simpy.events import Event, Process
from typing_extensions import override

from floorplan import Gantry, Point, UserError
from navigation import Motion

from ...core.body import MachineShape, checked, commands
from ...core.clock import MOMENT
from ...core.entries import Pose
from ...core.events import OrderSubmitted, PartDropped, RobotMalfunction
from ...core.scenario import GantryEntry
from ...core.stage import Stage
from ..arguments import instance
from ..commanding import Steps
from ..controllers import STAY
from ..policy_driven import PolicyDriven
from ..tasks import Passing, Step, Task
from ..traffic.evading import Evading, Evasion
from .drive import GantryDrive
from .tasks import Gripper, Handling, Worksites, tasks_of

GANTRY = "gantry"
"""Name of the gantry of the floor, which events omit."""


SLOWEST = 0.05
"""Lowest share of the speed that a policy can choose."""

ARRIVED = 1e-6
"""Metres and radians. Rounding of the pose at the end of a move."""

PASSING = 0.5
"""Metres between candidates for passing places."""

FARTHEST = 20
"""Number of candidates along each axis, on each side."""


class GantryRobot(PolicyDriven, Evading):
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

    _drive: GantryDrive

    FOR_CONTROLLERS = PolicyDriven.FOR_CONTROLLERS | {
        *("gantry", "floorplan", "law", "pick", "place", "where", "way")
    }

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
        self.handling = Handling()
        self.parts_dropped = 0
        self.gripper = Gripper(stage.clock, self._lose)
        self.gripper.will_lose(entry.drops)
        self.record = stage.record if name == GANTRY else self._record_by_name
        drive = GantryDrive(
            stage.clock,
            gantry,
            gantry.start if entry.at is None else entry.at,
            name=name,
            record=self.record,
            disabled_or_enabled=self.interrupt,
        )
        shape = gantry_shape(gantry, name)
        super().__init__(stage, shape, drive, controller, repeat=entry.repeat)
        self._entry = entry
        self.on_contact = entry.on_contact
        self._sites = Worksites(stage, gantry, drive)
        self._floor_changed = stage.clock.event()
        self._begin_round()

    # Commands.

    @commands
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

    @commands
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

    # Tasks.

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

    @checked
    @override
    def locate(self, task: Task) -> Event:
        pose = self._sites.pose_for(_next_step(instance("locate(task)", task, Task)))
        if pose is None:
            return self._command(self._find(task))
        self._interrupts.command_given()
        self._begin(task)
        return self._clock.happened(pose)

    @commands
    @override
    def handle(self, task: Task) -> Process:
        instance("handle(task)", task, Task)
        if (task.given_up and task.finished) or not self._sites.stands_at(_next_step(task)):
            return self._command(_not_done())
        return self._command(self._handle(task, self._drive.begin()))

    # For policies.

    @property
    @override
    def goal_pose(self) -> Pose | None:
        return self.where(self.open_tasks[0]) if self.open_tasks else None

    @property
    @override
    def action_bounds(self) -> tuple[list[float], list[float]]:
        axes = self.gantry.x, self.gantry.y
        return [*(axis.low for axis in axes), SLOWEST], [*(axis.high for axis in axes), 1.0]

    @property
    @override
    def stop_action(self) -> list[float]:
        return [*self.position[:2], 1.0]

    @override
    def act(self, action: Sequence[float], until: float, radius: float) -> Steps:
        if not isinstance(action, Sequence) or len(action) not in (2, 3):
            raise UserError(f"the target must be (x, y) or (x, y, speed share), not {action!r}")
        x, y, share = (*action, 1.0)[:3]
        goal = self.goal_pose
        if goal is None or math.dist(goal[:2], (x, y)) > radius:
            self.move_to(x, y, speed_share=share)
        elif self.body.motion.end <= self.now and math.dist(self.position, goal) < ARRIVED:
            yield self.handle(self.open_tasks[0])
        else:
            self.move_to(*goal, speed_share=share)

    # For the simulation.

    @property
    @override
    def loaded(self) -> bool:
        return self.gripper.holds_part

    @override
    def disable(self, seconds: float) -> None:
        self._drive.disable(seconds)

    def malfunction(self, seconds: float) -> None:
        """Stop the gantry because of a malfunction.

        Parameters
        ----------
        seconds : float
            Duration in seconds.
        """
        self._drive.disable(seconds, RobotMalfunction)

    @property
    @override
    def goal(self) -> Point | None:
        target = self._drive.target
        return None if target is None else target[:2]

    @override
    def evade(self, taken: Sequence[Polygon], courses: Sequence[Polygon]) -> Evasion | None:
        target = self._drive.target
        place = self._passing_place(taken, courses)
        if target is None or place is None:
            return None
        self._drive.let_pass_at(place, target)
        return Evasion(aside=place)

    @override
    def make_way(self, taken: Sequence[Polygon], courses: Sequence[Polygon]) -> bool:
        if self._entry.controller in STAY or self.disabled or self.tasks.unfinished:
            return False
        place = self._passing_place(taken, courses)
        if place is None:
            return False
        self._drive.move(place, command=self._drive.begin())
        return True

    def _passing_place(self, taken: Sequence[Polygon], courses: Sequence[Polygon]) -> Pose | None:
        """Return the nearest pose off the courses of others, with a free line to it."""
        x, y, rotation = self.position
        here = self.shape.footprint((x, y), rotation)
        blocked, busy = shapely.union_all([*taken]), shapely.union_all([*taken, *courses])
        steps = [PASSING * k for k in range(-FARTHEST, FARTHEST + 1)]
        offsets = sorted(itertools.product(steps, steps), key=lambda by: (math.hypot(*by), by))
        for dx, dy in offsets:
            pose = (x + dx, y + dy, rotation)
            if self.gantry.faults(pose):
                continue
            there = self.shape.footprint(pose[:2], rotation)
            if not there.intersects(busy):
                line = shapely.union_all([here, there]).convex_hull
                if not line.intersects(blocked):
                    return pose
        return None

    @override
    def figures(self, motion: Motion, now: float) -> dict[str, Any]:
        return {
            "disabled_time": self._drive.disabled_time,
            "idle_time": self._idle_time(motion, now),
            "jobs_done": self.jobs_done,
            **({"parts_dropped": self.parts_dropped} if self.gripper.drops else {}),
        }

    @override
    def floor_changed(self) -> None:
        changed, self._floor_changed = self._floor_changed, self._clock.event()
        changed.succeed()
        self.tasks.reconsider()

    def _find(self, task: Task) -> Steps:
        _next_step(task)
        self._begin(task)
        pose: Pose | None = None
        while pose is None and (step := self._catchable(task).next_step) is not None:
            pose = yield from self._reached(step, task)
        return self.position if pose is None else pose

    def _catchable(self, task: Task) -> Task:
        """Return `task`, with another part if the present one on the conveyor cannot be met."""
        while (
            (step := task.next_step) is not None
            and step.passing
            and self._sites.pose_for(step) is None
        ):
            self._begin_again(task)
        return task

    def _reached(self, step: Step, task: Task | None = None, command: int | None = None) -> Steps:
        """Wait until a step can be reached, and return its pose.

        None if it is no longer the next step of its task, or `command` was replaced.
        """
        while (pose := self._sites.pose_for(step)) is None and (
            task is None or task.next_step is step
        ):
            if command is None:
                yield self._floor_changed
            elif self._drive.is_under_way(command):
                yield self._floor_changed | self._drive.replaced
            else:
                break
        return pose

    def _visit(self, action: str, seconds: float, place: str) -> Process:
        """Go to a place and handle a part there, as one command."""
        instance(f"{action}(place)", place, str)
        step, command = Step(action, seconds=seconds, place=place), self._drive.begin()

        def steps() -> Steps:
            yield from self._go_to(step, command)
            return (yield from self._drive.work(seconds, command))

        return self._command(steps())

    def _go_to(self, step: Step, command: int, task: Task | None = None) -> Steps:
        """As a part of `command`, go to a step when it can be reached."""
        pose = yield from self._reached(step, task, command)
        if pose is not None and self._drive.is_under_way(command):
            yield self._drive.move(pose, command=command)

    def _handle(self, task: Task, command: int) -> Steps:
        self._begin(task)
        step = _next_step(task)
        passing, seconds = step.passing, step.seconds
        comes_by = None if passing is None else self._sites.comes_by(passing)
        if comes_by is not None:
            seconds = max(seconds, comes_by - self.now)
        done: bool = yield from self._drive.work(seconds, command)
        if not done or task.next_step is not step:  # the carried part has dropped
            return False
        if passing is not None:
            if comes_by is None or abs(comes_by - self.now) > MOMENT:
                return False  # delayed, so that the part has passed
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
        while self._drive.is_under_way(command):
            step = self._catchable(task).next_step
            if step is None:
                break
            self._begin(task)
            yield from self._go_to(step, command, task)
            # The AGV may have left, or the part may have dropped.
            there = step is task.next_step and self._sites.stands_at(step)
            if self._drive.is_under_way(command) and there:
                yield from self._handle(task, command)
        return task.finished

    def _lose(self, task: Task) -> None:
        """Drop the part of a task, and begin the task again with another part."""
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

    @override
    def _record_done(self, task: Task) -> None:
        if task.kind == "submit":
            self.record(OrderSubmitted.of(task.fields))
        else:
            super()._record_done(task)

    @override
    def _new_round(self) -> list[Task]:
        return tasks_of(self._entry.jobs, self.handling)


def gantry_shape(gantry: Gantry, name: str) -> MachineShape:
    """Return the shape of a gantry."""
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
