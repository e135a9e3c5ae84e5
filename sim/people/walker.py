"""Walks of a person from the current position to a goal, around the current obstacles."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Collection

from floorplan import Point
from navigation import (
    CollisionWorld,
    Motion,
    PathPlanner,
    PlanningError,
    join,
    remaining_path,
    standing,
    walk,
)
from navigation.moving_obstacles import Passage

from ..core.clock import Alarm, Turn
from ..core.events import PathBlocked, Replanned
from ..core.stage import Stage
from .crowd.crowd import Crowd
from .crowd.traveller import Traveller
from .crowd.vehicles import TOUCH, among_vehicles, any_moves

LEEWAY = 0.05
"""Metres. Additional distance from vehicles, to adapt the course to other people."""

SLOWER = 10.0
"""Maximum additional duration (s) of a walk compared with its length at top speed."""


class Walker:
    """Walks of one person along planned paths, as other people and moving vehicles allow.

    `arrived(goal)` is called at each goal, and `blocked` after others have blocked the person for
    too long. `late(goal)` is called after a wait for a vehicle, if the person was moved meanwhile.
    """

    def __init__(
        self,
        stage: Stage,
        traveller: Traveller,
        planner: PathPlanner,
        crowd: Crowd,
        *,
        arrived: Callable[[Point], None],
        blocked: Callable[[], None],
        late: Callable[[Point], None],
    ) -> None:
        self.traveller = traveller
        self.human = traveller.human
        self.body = traveller.body
        self.goal: Point | None = None
        self.speed_share = 1.0
        self.replans = 0
        self._stage = stage
        self._clock = stage.clock
        self._planner = planner
        self._record = stage.record
        self._arrived = arrived
        self._late = late
        self._onward: list[Point] = []
        self._goes_on_at = 0.0
        self._setting_out = Alarm(stage.clock, self._go_on, Turn.MOTION_ENDS)
        self._crowd = crowd
        crowd.enter(
            traveller,
            reroute=lambda at: self._path(at, self.traveller.goal or self._bound_for())[1:],
            arrive=self._arrive,
            blocked=blocked,
        )

    @property
    def world(self) -> CollisionWorld:
        """World of the planner, in which the zones forbidden to the person are closed."""
        return self._planner.world

    @property
    def heading(self) -> float:
        """Current heading (rad)."""
        return self.body.state.position[2]

    def prepare(self) -> None:
        """Compute in advance what the first path needs."""
        self._planner.prepare()

    def go(self, goal: Point) -> None:
        """Walk to `goal`. Raises `PlanningError`, without any change, if there is no path."""
        points = self._path(self.body.at, goal)
        self.goal = goal
        self._setting_out.set(None)
        self._onward = []
        top = self.human.max_speed * self.speed_share
        passage = self._passage_from_rest(goal, points, top)
        if passage is None:
            self._crowd.set_out(self.traveller, goal, points[1:], top)
        else:
            self._follow_passage(passage, top)
        self._step_out_of_closures()

    def _follow_passage(self, passage: Passage, top: float) -> None:
        """Walk past a vehicle, with a wait for it if that is quickest."""
        points, self._onward = [*map(tuple, passage.path.points.tolist())], []
        now, delay = self._clock.now, 0.0
        if passage.waits:
            ((place, delay),) = passage.waits
            points, self._onward = _parted(points, place)
        if len(points) > 1:
            motion = walk(points, now, max_speed=top, max_acceleration=self.human.max_acceleration)
            self._goes_on_at = motion.end + delay
            self._crowd.set_out(self.traveller, points[-1], points[1:], top)
        else:
            self._goes_on_at = now + delay
            self._wait_here()

    def _wait_here(self) -> None:
        """Stand until the vehicle has passed."""
        self._crowd.rest(self.traveller)
        self._setting_out.set(max(self._goes_on_at, self._clock.now))

    def _passage_from_rest(self, goal: Point, points: list[Point], top: float) -> Passage | None:
        """Return the passage of a standing person among vehicles, or None if no vehicle matters."""
        now, acceleration = self._clock.now, self.human.max_acceleration
        if self.body.motion.end > now:
            return None
        length = sum(math.dist(a, b) for a, b in itertools.pairwise(points))
        if not any_moves(self._stage, now + length / top + SLOWER):
            return None
        if self.traveller.zones.along(points, top)[1] != top:  # slower than the search assumes
            return None
        try:
            motion = walk(points, now, max_speed=top, max_acceleration=acceleration)
        except ValueError:  # no distance to walk
            return None
        return among_vehicles(
            self._stage, self._planner, self.human, self.body, goal, motion, top, TOUCH + LEEWAY
        )

    def _go_on(self) -> None:
        """Continue on the path after a wait. Report `late` if the person was moved."""
        goal, onward = self._bound_for(), self._onward
        if self.body.at == onward[0]:
            top = self.human.max_speed * self.speed_share
            self._onward = []
            self._crowd.set_out(self.traveller, goal, onward[1:], top)
        else:
            self._forget_goal()
            self._stage.place_machines()
            self._late(goal)

    def stop(self) -> None:
        """Brake to a standstill."""
        braking = self.braking()
        self._forget_goal()
        self.body.follow(braking)
        self._step_out_of_closures()

    def turn_to(self, point: Point) -> None:
        """Brake, and turn to `point`."""
        braking = self.braking()
        self._forget_goal()
        x, y = braking.state(braking.end).at
        heading = math.atan2(point[1] - y, point[0] - x)
        self.body.follow(join([braking, standing((x, y), heading=heading, start=braking.end)]))
        self._step_out_of_closures()

    def put(self, at: Point, heading: float) -> None:
        """Move the person to `at` instantly, standing."""
        self._forget_goal()
        self.body.follow(standing(at, heading=heading, start=self._clock.now))

    def halt_if_blocked(self) -> bool:
        """Stop before an obstacle if the motion is no longer free. Return whether it was free."""
        is_free = self._is_clear(self.body.motion)
        if not is_free and not self._crowd.is_empty:
            self._crowd.halt(self.traveller, self._is_clear)
        return is_free

    @property
    def _end(self) -> Point:
        """Position at the end of the current motion."""
        return self.body.motion.state(self.body.motion.end).at

    def check_path(self, came: Collection[str]) -> PlanningError | None:
        """Replan if the path is no longer free. Without any path, stop and return the reason.

        `came` are the names of new obstacles.
        """
        if self.traveller.recorded:
            return None
        end = self._end
        is_free = self.halt_if_blocked()
        if self.goal is None:
            self._step_out_of_closures()
            return None
        # During a wait the rest of the path is not part of the route in the crowd.
        paths = self.traveller.route, self._onward
        if is_free and all(map(self._is_free, paths)) and not self._is_cut_off(end, came):
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

    def _is_free(self, path: list[Point]) -> bool:
        world, radius = self.world, self.human.radius
        return all(world.segment_free(a, b, radius) for a, b in itertools.pairwise(path))

    def _is_clear(self, motion: Motion) -> bool:
        """Return whether a motion is free of obstacles from now on."""
        return self._is_free(remaining_path(motion, self._clock.now))

    def _step_out_of_closures(self) -> None:
        """Walk to the nearest free place if the motion ends in a closed door or area.

        People may be too near to stop in front of a door that closes.
        """
        if not self._stage.active_closures:
            return
        rest, radius = self._end, self.human.radius
        touched = {body.name for body in self.world.hits(rest, rest, radius)}
        if touched.isdisjoint(self._stage.active_closures):
            return
        exits = self.world.exits(rest, radius)
        if exits:
            free = (place for place in exits if self._crowd.has_room(self.traveller, place))
            place = next(free, exits[0])
            self._onward, self._goes_on_at = [place], self._clock.now
            self._crowd.set_out(self.traveller, place, [place], self.human.max_speed)

    def _is_cut_off(self, end: Point, came: Collection[str]) -> bool:
        """Return whether a new obstacle blocks the leg from the `end` of the motion to the route.

        Older obstacles do not count, because people in a crowd stop beside their route.
        """
        return any(
            body.name in came
            for onwards in self.traveller.route[:1]
            for body in self.world.hits(end, onwards, self.human.radius)
        )

    def _bound_for(self) -> Point:
        assert self.goal is not None
        return self.goal

    def _path(self, start: Point, goal: Point) -> list[Point]:
        try:
            path = self._planner.plan(start, goal)
        except PlanningError as why:
            if why.reason != "start_blocked":
                raise
            return [start, *self._step_out(start, goal, why)]
        return [*map(tuple, path.points.tolist())]

    def _step_out(self, start: Point, goal: Point, blocked: PlanningError) -> list[Point]:
        """Return a path to `goal` from the nearest free place beside `start`."""
        failed: list[PlanningError] = []
        for place in self.world.exits(start, self.human.radius):
            try:
                return [*map(tuple, self._planner.plan(place, goal).points.tolist())]
            except PlanningError as why:
                failed.append(why)
        # The first failure says more than that the start is blocked.
        raise (failed or [blocked])[0]

    def braking(self) -> Motion:
        """Return the motion of `stop` from now on."""
        return self._crowd.braking(self.traveller)

    def _forget_goal(self) -> None:
        self.goal = None
        self._setting_out.set(None)
        self._onward = []
        self._crowd.rest(self.traveller)

    def _arrive(self) -> None:
        if self.goal is None:  # the person has stepped out of a closed area
            self._crowd.rest(self.traveller)
            self._step_out_of_closures()
            return
        goal = self.goal
        if self.traveller.goal != goal:
            self._wait_here()
            return
        self._forget_goal()
        self._arrived(goal)


def _parted(points: list[Point], place: Point) -> tuple[list[Point], list[Point]]:
    """Return a path up to `place` on it, and from there to the end."""
    if place in points:
        k = points.index(place)
        return points[: k + 1], points[k:]
    pairs = [*itertools.pairwise(points)]
    # The place is on the leg whose length it changes least. The lengths are equal up to rounding.
    beside = [math.dist(a, place) + math.dist(place, b) - math.dist(a, b) for a, b in pairs]
    k = beside.index(min(beside))
    return [*points[: k + 1], place], [place, *points[k + 1 :]]
