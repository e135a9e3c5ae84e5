"""A body that walks: from where it is to a goal, around the obstacles of the moment."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

from floorplan import Human
from navigation import (
    Motion,
    PathPlanner,
    PlanningError,
    can_go_on,
    join,
    remaining_path,
    standing,
    stop_walking,
    walk,
)

from ..core.body import PERSON, Body
from ..core.clock import Alarm, Turn
from ..core.events import PathBlocked, Replanned
from ..core.stage import Stage

REPORT_DELAY = 0.1
"""Seconds until somebody who is sent to where they are already says that they are there."""

Place = tuple[float, float]


class Walker:
    """One person's legs. `arrived(goal)` is called whenever a goal is reached."""

    def __init__(
        self,
        stage: Stage,
        name: str,
        human: Human,
        planner: PathPlanner,
        *,
        at: Place,
        heading: float,
        arrived: Callable[[Place], None],
    ) -> None:
        self.human = human
        self.body = Body(
            stage.clock, name, PERSON, standing(at, heading=heading, start=stage.clock.now)
        )
        self.goal: Place | None = None
        self.speed_share = 1.0
        self.replans = 0
        self._clock = stage.clock
        self._planner = planner
        self._record = stage.record
        self._arrived = arrived
        self._arrival = Alarm(stage.clock, self._arrive, Turn.MOTION_ENDS)

    @property
    def heading(self) -> float:
        """Direction in which the person looks now (radians)."""
        return self.body.state.position[2]

    def prepare(self) -> None:
        """Compute beforehand what planning the first path would need."""
        self._planner.prepare()

    def go(self, goal: Place) -> None:
        """Walk to `goal` from now on; `PlanningError`, and no change, if there is no path."""
        motion = self._motion_to(goal)
        self.goal = goal
        self._arrival.set(max(motion.end, self._clock.now + REPORT_DELAY))
        self.body.follow(motion)

    def stop(self) -> None:
        """Brake, and stand."""
        self._forget_goal()
        self.body.follow(self.braking())

    def turn_to(self, point: Place) -> None:
        """Brake, stand, and look towards `point`."""
        self._forget_goal()
        braking = self.braking()
        x, y = braking.state(braking.end).at
        heading = math.atan2(point[1] - y, point[0] - x)
        self.body.follow(join([braking, standing((x, y), heading=heading, start=braking.end)]))

    def put(self, at: Place, heading: float) -> None:
        """Be at `at` from one instant to the next, standing."""
        self._forget_goal()
        self.body.follow(standing(at, heading=heading, start=self._clock.now))

    def check_path(self) -> PlanningError | None:
        """Replan if the path is no longer free; where there is none, stop and return the reason."""
        if self.goal is None:
            return None
        path = remaining_path(self.body.motion, self._clock.now)
        radius = self.human.radius
        if all(self._planner.world.segment_free(a, b, radius) for a, b in itertools.pairwise(path)):
            return None
        self._record(PathBlocked(person=self.body.name, goal=self.goal))
        try:
            self.go(self.goal)
        except PlanningError as why:
            self.stop()
            return why
        self.replans += 1
        self._record(Replanned(person=self.body.name, goal=self.goal))
        return None

    def _motion_to(self, goal: Place) -> Motion:
        now, state = self._clock.now, self.body.state
        points = self._path(state.at, goal)
        top, acceleration = self.human.max_speed * self.speed_share, self.human.max_acceleration
        goes_on = state.speed <= top and (
            len(points) < 2 or can_go_on(state, points[1], acceleration)
        )
        if goes_on:
            try:
                return walk(
                    points,
                    now,
                    max_speed=top,
                    max_acceleration=acceleration,
                    initial_speed=state.speed,
                )
            except ValueError:  # too short to come to rest on
                pass
        braking = self.braking()
        points = self._path(braking.state(braking.end).at, goal)
        onwards = walk(points, braking.end, max_speed=top, max_acceleration=acceleration)
        return join([braking, onwards])

    def _path(self, start: Place, goal: Place) -> list[Place]:
        try:
            path = self._planner.plan(start, goal)
        except PlanningError as why:
            if why.reason != "start_blocked":
                raise
            return [start, *self._step_out(start, goal, why)]
        return [*map(tuple, path.points.tolist())]

    def _step_out(self, start: Place, goal: Place, blocked: PlanningError) -> list[Place]:
        """Return a path to `goal` from the nearest place beside what blocks `start`."""
        failed: list[PlanningError] = []
        for place in self._planner.world.exits(start, self.human.radius):
            try:
                return [*map(tuple, self._planner.plan(place, goal).points.tolist())]
            except PlanningError as why:
                failed.append(why)
        raise (failed or [blocked])[0]

    def braking(self) -> Motion:
        """Return the motion that `stop` would make from here and now."""
        acceleration = self.human.max_acceleration
        return stop_walking(self.body.motion, self._clock.now, max_acceleration=acceleration)

    def _forget_goal(self) -> None:
        self.goal = None
        self._arrival.set(None)

    def _arrive(self) -> None:
        goal = self.goal
        assert goal is not None
        self.goal = None
        self._arrived(goal)
