"""Vehicles that drive freely: their commands, missions and twists."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from shapely.geometry import Polygon
from simpy.events import Event, Process

from floorplan import Point, UserError
from navigation import Motion, PlanningError
from navigation.vehicles import Twist, TwistCourse

from ...core.body import OnContact, checked, commands
from ...core.clock import Alarm, Turn
from ...core.entries import Pose
from ...core.stage import Stage
from ..arguments import instance, number
from ..commanding import Steps
from ..policy_driven import PolicyDriven
from ..tasks import Step, Task
from ..traffic.evading import Evading, Evasion
from .drive import VehicleDrive
from .missions import Mission, task_of
from .shape import Chassis

AHEAD = 60.0
"""Seconds of a twist that are planned at a time, and that other machines can expect."""


class Amr(PolicyDriven, Evading):
    """A vehicle that drives freely. Its tasks are the missions of the trial."""

    _drive: VehicleDrive

    FOR_CONTROLLERS = PolicyDriven.FOR_CONTROLLERS | {
        *("missions", "complete", "twist", "twist_now", "turn_to", "limits")
    }

    def __init__(
        self,
        stage: Stage,
        name: str,
        vehicle: Chassis,
        at: Pose,
        *,
        missions: Sequence[Mission] = (),
        every: float | None = None,
        repeat: bool = False,
        priority: int = 0,
        makes_way: bool = True,
        on_contact: OnContact = "stop",
        controller: Callable[[Amr], Steps],
    ) -> None:
        super().__init__(
            stage,
            vehicle.shape(name),
            VehicleDrive(stage, name, vehicle, at, self.interrupt),
            controller,
            repeat=repeat,
            every=every,
        )
        self.record = self._record_by_name
        self.limits = vehicle.limits
        self.priority = priority
        self.on_contact = on_contact
        self._makes_way = makes_way
        self._missions = tuple(missions)
        self._located = tuple(
            replace(mission, go=mission.goal(stage.floorplan)) for mission in missions
        )
        self._rest = Alarm(stage.clock, self._comes_to_rest, Turn.MOTION_ENDS)
        self._course: tuple[TwistCourse, float, float] | None = None
        """Course of the last twist, its begin and its duration (s)."""
        self._twist: Event | None = None
        """Last twist."""
        self._extension = Alarm(stage.clock, self._extend_twist, Turn.MOTION_ENDS)
        self.body.on_change.append(self._motion_changed)
        self._begin_round()

    # Sensors.

    @property
    def missions(self) -> tuple[Mission, ...]:
        """Remaining missions of this round, the current one first.

        `go` is a position (x, y) in metres, with a rotation in radians if the trial gives one.
        """
        pairs = zip(self._located, self._round, strict=True)
        return tuple(mission for mission, task in pairs if not task.finished)

    # Commands.

    @commands
    def turn_to(self, rotation: float, *, speed_share: float = 1.0) -> Event:
        """Turn on the spot to `rotation` (radians). Return an event to yield."""
        x, y, _ = self.position
        rotation = number("turn_to(rotation)", rotation)
        return self.move_to(x, y, rotation, speed_share=speed_share)

    @commands
    def twist(self, twist: Sequence[float], seconds: float) -> Event:
        """Drive with a twist for `seconds`, then stop unless there is another command.

        The twist is (v, ω), or (vx, vy, ω): m/s forwards and to the left, rad/s. `UserError` if it
        is not finite or too fast. `AHEAD` seconds of a longer twist are planned at a time.
        """
        seconds, requested = number("twist(seconds)", seconds, 0.0), Twist.of(twist)
        until = self.now + seconds
        requested.check(self.limits)

        def begun(remaining: float) -> Motion:
            slow = self._drive.slowed(requested)
            self._course = TwistCourse(self.state, slow, self.limits), self.now, remaining
            return self._planned_twist()

        self._drive.forget_route()
        self._twist = self._follow(begun(seconds), lambda: begun(max(0.0, until - self.now)))
        return self._twist

    def _planned_twist(self) -> Motion:
        """Return the motion of the current twist for `AHEAD` seconds at most."""
        assert self._course is not None
        (course, begun, seconds), now = self._course, self.now
        until = min(seconds, now - begun + AHEAD)
        motion = course.motion(self.position, now, until, now - begun)
        half = now + AHEAD / 2
        node = motion.pieces_from(half)[0].begin  # where the velocity of a spline is exact
        again = node if node > now + AHEAD / 4 else half
        self._extension.set(again if until < seconds else None)
        return motion

    def _extend_twist(self) -> None:
        self._drive.extend(self._twist, self._planned_twist)

    def steer(self, twist: Sequence[float], until: float) -> None:
        """Drive with a twist until a time (s). A stationary vehicle does not start with zeros."""
        may_move = self.only_waits or not self.disabled
        if may_move and (self.body.motion.end > self.now or any(Twist.of(twist))):
            self.twist(twist, until - self.now)

    def avoid(self, people: Mapping[str, Point], aside: float) -> bool:
        """Plan around people from now on. Return whether the present route is given up.

        Routes keep `aside` metres from the bodies of people if there is room for that.
        """
        return self._drive.avoid(people, aside)

    # Tasks.

    @checked
    def locate(self, task: Task) -> Event:
        """Wait for a route to the next step of a task, whose pose is the value of the event."""
        return self._command(self._find(instance("locate(task)", task, Task)))

    @commands
    def handle(self, task: Task) -> Process:
        """Carry out the next step of a task here. The value of the event is True if done."""
        instance("handle(task)", task, Task)
        return self._command(self._handle(task, self._drive.begin()))

    @checked
    def complete(self) -> None:
        """Count the current mission as done. `UserError` if there is none.

        For functions and classes with a rate, which carry out missions themselves.
        """
        task = self._current
        if task is None:
            raise UserError("there is no mission to complete")
        self._begin(task)
        self._advance(task)

    # For policies.

    @property
    def goal_pose(self) -> Pose | None:
        """The position of the first mission that has one, with any rotation."""
        goals = [mission.go for mission in self.missions if isinstance(mission.go, tuple)]
        return (goals[0][0], goals[0][1], math.nan) if goals else None

    @property
    def action_bounds(self) -> tuple[list[float], list[float]]:
        """Lowest and highest twist, without m/s to the left for a differential drive."""
        limits = self.limits
        high = [limits.speed, *filter(None, [limits.side_speed]), limits.turn_speed]
        return [-value for value in high], high

    @property
    def stop_action(self) -> list[float]:
        """Twist of zeros."""
        return [0.0] * len(self.action_bounds[0])

    def count_goals(self, radius: float) -> None:
        """Complete missions until one leads to a position farther than `radius` metres."""
        self.begin_mission()
        while self.missions:
            goal = self.missions[0].go
            if isinstance(goal, tuple) and math.dist(goal[:2], self.position[:2]) > radius:
                return
            self.complete()

    def act(self, action: Sequence[float], until: float, radius: float) -> Steps:
        """Drive with a twist until the next tick. See `PolicyDriven.act`."""
        self.steer(action, until)
        return
        yield

    # For the simulation.

    def begin_mission(self) -> None:
        """Record the start of the current mission, once."""
        if (task := self._current) is not None:
            self._begin(task)

    @property
    def _current(self) -> Task | None:
        return next((task for task in self._round if not task.finished), None)

    @property
    def loaded(self) -> bool:
        """Whether it carries a load."""
        return self.shape.loaded

    def floor_changed(self) -> None:
        """Plan another route if the present one is blocked."""
        self._drive.floor_changed()
        under_way = self.body.motion.end > self.now and not self.disabled
        if under_way and not self._drive.route_is_free():
            self._drive.forget_route()
            # Brake, and plan from the end of the stop.
            self._drive.hold(True)
            self._drive.hold(False)

    @property
    def planned_at(self) -> float:
        """Time at which its present motion was planned, or the one from which it stops (s)."""
        return self._drive.planned_at

    @property
    def may_leave(self) -> bool:
        """Whether it makes way when it is idle."""
        return self._makes_way

    @property
    def goal(self) -> Point | None:
        """End (x, y) of its route, if there is one."""
        return self._drive.goal

    def detour(self, taken: Sequence[Polygon], most: float) -> bool:
        """Choose another path to the goal around other machines. See `Evading.detour`."""
        return self._drive.detour(taken, most)

    def evade(self, taken: Sequence[Polygon], courses: Sequence[Polygon]) -> Evasion | None:
        """Choose another path to the goal, or to a passing place first. See `Evading.evade`."""
        return self._drive.evade(taken, courses)

    def make_way(self, taken: Sequence[Polygon], courses: Sequence[Polygon]) -> bool:
        """Move off the courses of other machines if it has no mission. See `Evading.make_way`."""
        if not self._makes_way or self.is_held or any(not task.finished for task in self._round):
            return False
        return self._drive.make_way(taken, courses)

    def figures(self, motion: Motion, now: float) -> dict[str, Any]:
        """Return its figures. It is idle while it neither moves, works nor is stopped."""
        return {"jobs_done": self.jobs_done, "idle_time": self._idle_time(motion, now)}

    def _motion_changed(self) -> None:
        self._rest.set(max(self.body.motion.end, self.now))

    def _comes_to_rest(self) -> None:
        self._stage.came_to_rest(self)

    def _goal(self, step: Step) -> tuple[float, ...]:
        """Return x, y, and the rotation if required, of a step."""
        if step.target is None:
            return self.position
        x, y, rotation = step.target
        if step.action == "turn":
            return (*self.position[:2], rotation)
        return (x, y) if math.isnan(rotation) else (x, y, rotation)

    def _find(self, task: Task) -> Steps:
        """Wait for a route to the next step of a task, and return its pose."""
        self._begin(task)
        step = task.next_step
        assert step is not None
        return (yield from self._routed(step, None))

    def _routed(self, step: Step, command: int | None) -> Steps:
        """Wait for a route to a step, and return the pose at its end.

        None if `command` was replaced.
        """
        goal = self._goal(step)
        while command is None or self._drive.is_under_way(command):
            try:
                return self._drive.destination(goal)
            except PlanningError as why:
                self._drive.record_blocked(goal, why)
            change = self._drive.change_of_floor()
            yield change if command is None else change | self._drive.replaced
        return None

    def _do(self, task: Task, command: int) -> Steps:
        while self._drive.is_under_way(command) and (step := task.next_step) is not None:
            self._begin(task)
            goal = self._goal(step)
            while self._drive.is_under_way(command) and not self._drive.is_at(goal):
                pose = yield from self._routed(step, command)
                if self._drive.is_under_way(command):
                    yield self._drive.move(pose, command=command)
            if self._drive.is_under_way(command):
                yield from self._handle(task, command)
        return task.finished

    def _handle(self, task: Task, command: int) -> Steps:
        self._begin(task)
        step = task.next_step
        if step is None or not self._drive.is_at(self._goal(step)):
            return False
        done: bool = yield from self._drive.work(step.seconds, command, stays=step.action == "wait")
        if not done or task.next_step is not step:
            return False
        self._advance(task)
        return True

    def _advance(self, task: Task) -> None:
        task.advance()
        if task.finished:
            self._finish(task)

    def _new_round(self) -> list[Task]:
        tasks = [task_of(mission, self._stage.floorplan) for mission in self._missions]
        for k, task in enumerate(tasks):
            task.stage = k
        return tasks
