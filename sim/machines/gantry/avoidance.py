"""Avoidance of people by the gantry: the choice of its tasks and courses."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
from shapely import LineString, Point

from navigation import GantryPlanner, Motion, PlanningError
from navigation.kernels.lookout import most_remote, nearest_on

from ...core.entries import Pose
from ..caution import Caution
from ..commanded import Sighting
from ..commanding import Steps
from ..tasks import Task
from .robot import GantryRobot
from .tasks import REACH

ROOM = 0.2
"""Metres. Distance that it keeps beyond the protective separation distance, if possible."""

PACES = (1.0, 0.3, 0.1)
"""m/s. Speeds whose required distances a path around people keeps, in the order of preference."""

FORESIGHT = 5.0
"""Seconds for which people are expected to keep their velocity."""

GLANCE = 0.5
"""Seconds between compared positions."""

_GLANCES = [2 * GLANCE * k for k in range(1 + int(FORESIGHT / (2 * GLANCE)))]
"""Seconds ahead at which refuges are compared."""

SECOND_THOUGHTS = 1.0
"""Seconds after which task and path are chosen again."""

PATIENCE = 6.0
"""Seconds for which an order may be blocked before the tasks of the next are considered."""

REFUGES = 5
"""Number of refuges along each axis, spread over the range."""


def avoiding(gantry: GantryRobot) -> Steps:
    """Do the nearest task that is away from people, or move away from them."""
    caution = Caution(gantry)
    outlook = CourseChoice(gantry, caution)
    while (yield gantry.next_task()) is not None:
        people = yield from caution.look()
        task, pose = outlook.choose(people)
        if task is None:
            if outlook.is_hindered:
                caution.record_waiting(None, people)
            if (yield from caution.go(outlook.refuge(people), seconds=SECOND_THOUGHTS)):
                yield gantry.look(0.1)
            continue
        yield gantry.locate(task)
        if (yield from caution.go(pose, seconds=SECOND_THOUGHTS)):
            yield gantry.handle(task)


class CourseChoice:
    """Choice of tasks and paths away from people, who are expected to keep their velocity."""

    def __init__(self, gantry: GantryRobot, caution: Caution) -> None:
        self._gantry = gantry
        self._caution = caution
        self.is_hindered = False
        """Whether people were near every path when none was chosen."""
        self._zone = caution.required_between_centres(0.0) + ROOM
        self._rooms = [caution.room_to_move(pace) + ROOM for pace in PACES]
        self._free_at = gantry.now
        self._standing = gantry.body.motion
        self._from_here: dict[Pose, Motion] = {}
        """Motions from the present standstill, by target."""
        self._path: tuple[Pose, tuple[Pose, ...], float] = (gantry.position, (), 0.0)
        self._planner = GantryPlanner(gantry.floorplan)
        x, y = (
            np.linspace(axis.low, axis.high, REFUGES).tolist()
            for axis in (gantry.gantry.x, gantry.gantry.y)
        )
        self._refuges = [*itertools.chain.from_iterable(itertools.product(x, y))]
        """x and y of each, one after the other."""

    def choose(self, people: Sequence[Sighting]) -> tuple[Task | None, Pose]:
        """Return the next task and the pose to go to. The task is None if none can be done now."""
        gantry = self._gantry
        tasks = gantry.open_tasks
        tasks = tuple(task for task in tasks if task.begun) or tasks
        paths = [(task, path) for task in tasks for path in [gantry.way(task)] if path]
        self.is_hindered = bool(paths)
        groups = list(dict.fromkeys(task.group for task, _ in paths))
        for group in groups[:1] if gantry.now < self._free_at + PATIENCE else groups:
            of_group = [(task, path) for task, path in paths if task.group == group]
            choice = self._choose(of_group, people)
            if choice is not None:
                self._free_at = gantry.now
                return choice
        return None, gantry.position

    def _choose(
        self, paths: Sequence[tuple[Task, tuple[Pose, ...]]], people: Sequence[Sighting]
    ) -> tuple[Task, Pose] | None:
        """Return the task with the shortest clear path, and the pose to go to."""
        here = self._gantry.position
        rows = _rows(people)
        tried: set[Pose] = set()
        for task, (pose, *_) in sorted(paths, key=lambda entry: _length((here, *entry[1]))):
            step = task.next_step
            # Several tasks may begin at one pose.
            if pose in tried or step is None:
                continue
            tried.add(pose)
            if self._is_clear(*self._motion_to(pose), rows, step.seconds):
                return task, pose
            detour = self._detour(pose, people)
            if detour is not None:
                return task, detour
        return None

    def refuge(self, people: Sequence[Sighting]) -> Pose:
        """Return the refuge on whose path people are farthest away.

        The present pose is free if no person comes into the zone there.
        """
        if not people:
            return self._gantry.position
        x, y, rotation = self._gantry.position
        axis = self._gantry.gantry.x
        # The time that a uniform acceleration to v costs is v / (2 a).
        lag = axis.max_speed / axis.max_acceleration / 2
        places = [x, y, *self._refuges]
        k = most_remote(places, _rows(people), _GLANCES, FORESIGHT, axis.max_speed, lag, self._zone)
        return (places[2 * k], places[2 * k + 1], rotation)

    def _motion_to(self, pose: Pose) -> tuple[Motion, float]:
        """Return the motion to `pose`, and the time of this motion that is now (s).

        At rest, one motion from here serves for all times.
        """
        gantry = self._gantry
        standing = gantry.body.motion
        if gantry.now < standing.end:
            return self._caution.preview(pose), gantry.now
        if self._standing is not standing:
            self._standing = standing
            self._from_here.clear()
        motion = self._from_here.get(pose)
        if motion is None:
            motion = self._caution.preview(pose)
            if motion is standing:
                return motion, gantry.now
            self._from_here[pose] = motion
        return motion, motion.start

    def _is_clear(self, motion: Motion, now: float, people: list[float], seconds: float) -> bool:
        """Return whether it can keep moving on `motion`, and stay at its end for `seconds`."""
        table = motion.table
        moving = nearest_on(table, people, now, now, motion.end, GLANCE, FORESIGHT)
        if moving < self._rooms[-1]:
            return False
        stay = max(motion.end + seconds, now + FORESIGHT)
        return nearest_on(table, people, now, motion.end, stay, GLANCE, FORESIGHT) >= self._zone

    def _detour(self, pose: Pose, people: Sequence[Sighting]) -> Pose | None:
        """Return the first waypoint of a path to `pose` around people, or None."""
        places = [_expected(person, after) for person in people for after in (0.0, FORESIGHT)]
        goal, path, radius = self._path
        if goal == pose and path:
            # Do not replace a clear path, so that the gantry does not alternate between two.
            here = self._gantry.position
            path = path[1:] if math.dist(here[:2], path[0][:2]) < REACH else path
            line = LineString([here[:2], *(point[:2] for point in (*path, pose))])
            if path and all(line.distance(Point(place)) > radius - 2 * ROOM for place in places):
                self._path = (pose, path, radius)
                return path[0]
        self._path = (pose, *self._plan(pose, places))
        path = self._path[1]
        return path[0] if path else None

    def _plan(
        self, pose: Pose, places: Sequence[tuple[float, float]]
    ) -> tuple[tuple[Pose, ...], float]:
        """Return waypoints to `pose` away from `places`, and their distance from these (m).

        There are no waypoints if there is no such path.
        """
        nearest = min(math.dist(pose[:2], place) for place in places)
        # Paths pass people no farther away than the goal is.
        radii = [min(room, nearest - ROOM) for room in self._rooms]
        radii = [radius for radius in dict.fromkeys(radii) if radius >= self._zone]
        paths = {radius: self._around(pose, places, radius) for radius in radii[:1]}
        if "unreachable" in paths.values():
            # Unreachable with the smallest radius means unreachable with all.
            paths[radii[-1]] = self._around(pose, places, radii[-1])
            if paths[radii[-1]] == "unreachable":
                return (), 0.0
        for radius in radii:
            path = paths.get(radius) or self._around(pose, places, radius)
            if not isinstance(path, str):
                return path, radius
            if path == "start_blocked":  # a person is within the reach of the arm
                break
        return (), 0.0

    def _around(
        self, pose: Pose, places: Sequence[tuple[float, float]], radius: float
    ) -> tuple[Pose, ...] | str:
        """Return waypoints to `pose` at `radius` metres from `places`, or the reason for none."""
        keep_out = [(*place, radius) for place in places]
        try:
            path = self._planner.plan(self._gantry.position, pose, keep_out=keep_out)
        except PlanningError as why:
            return why.reason
        return tuple((x, y, rotation) for x, y, rotation in path.points[1:].tolist())


def _rows(people: Sequence[Sighting]) -> list[float]:
    """Return x, y and velocity of each person, one after the other."""
    return [value for person in people for value in (*person.at, *person.velocity)]


def _expected(person: Sighting, after: float) -> tuple[float, float]:
    """Return the position of a person after a time (s) at their present velocity."""
    (x, y), (vx, vy) = person.at, person.velocity
    seconds = min(after, FORESIGHT)
    return (x + vx * seconds, y + vy * seconds)


def _length(path: Sequence[Pose]) -> float:
    return sum(math.dist(a[:2], b[:2]) for a, b in itertools.pairwise(path))
