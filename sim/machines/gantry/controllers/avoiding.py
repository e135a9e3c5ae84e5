"""Plans its ways round people, prefers tasks away from them, and steps aside for them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
from shapely import LineString, Point

from navigation import GantryPlanner, Motion, PlanningError

from ..drive import Steps
from ..robot import REACH, GantryRobot, Sighting
from ..tasks import Pose, Task
from .caution import Caution

ROOM = 0.2
"""Metres. How much more than the protective distance it keeps from people where it can."""

PACES = (1.0, 0.3, 0.1)
"""m/s. A way round somebody keeps away so far that it can be gone at one of these, if possible."""

FORESIGHT = 5.0
"""Seconds. How far ahead it takes people to go on as they do."""

GLANCE = 0.5
"""Seconds. How finely it looks ahead."""

SECOND_THOUGHTS = 1.0
"""Seconds. How often it asks itself whether what it does is still the best."""

PATIENCE = 6.0
"""Seconds. For how long an order may be blocked until the tasks of the next are thought of."""

REFUGES = 5
"""It steps aside to one of so many times so many places, spread over its range."""


def avoiding(gantry: GantryRobot) -> Steps:
    """The nearest task that is clear of people, one after the other; else out of their way."""
    caution = Caution(gantry)
    outlook = Outlook(gantry, caution)
    while (yield gantry.next_task()) is not None:
        people = yield gantry.look()
        task, pose = outlook.choose(people)
        if task is None:
            if (yield from caution.go(outlook.refuge(people), seconds=SECOND_THOUGHTS)):
                yield gantry.look(0.1)
            continue
        yield gantry.locate(task)
        if (yield from caution.go(pose, seconds=SECOND_THOUGHTS)):
            yield gantry.handle(task)


class Outlook:
    """Where the gantry can go without coming near people who go on as they do."""

    def __init__(self, gantry: GantryRobot, caution: Caution) -> None:
        self._gantry = gantry
        self._zone = caution.required(0.0) + ROOM
        self._rooms = [caution.room_to_move(pace) + ROOM for pace in PACES]
        self._free_at = gantry.now
        self._way: tuple[Pose, tuple[Pose, ...], float] = (gantry.position, (), 0.0)
        self._planner = GantryPlanner(gantry.floorplan)
        x, y = (
            np.linspace(axis.low, axis.high, REFUGES).tolist()
            for axis in (gantry.gantry.x, gantry.gantry.y)
        )
        self._refuges = tuple(itertools.product(x, y))

    def choose(self, people: Sequence[Sighting]) -> tuple[Task | None, Pose]:
        """The task to go on with, and where to go for it now; None if none can be done now."""
        gantry = self._gantry
        tasks = [task for task in gantry.open_tasks if task.begun] or gantry.open_tasks
        ways = [(task, way) for task in tasks for way in [gantry.way(task)] if way]
        groups = list(dict.fromkeys(task.group for task, _ in ways))
        for group in groups[:1] if gantry.now < self._free_at + PATIENCE else groups:
            found = self._choose([(task, way) for task, way in ways if task.group == group], people)
            if found is not None:
                self._free_at = gantry.now
                return found
        return None, gantry.position

    def _choose(
        self, ways: Sequence[tuple[Task, tuple[Pose, ...]]], people: Sequence[Sighting]
    ) -> tuple[Task, Pose] | None:
        """The task with the shortest way that is clear, and where to go for it now."""
        here = self._gantry.position
        tried: set[Pose] = set()
        for task, (pose, *_) in sorted(ways, key=lambda entry: _length((here, *entry[1]))):
            step = task.next_step
            if pose in tried or step is None:
                continue
            tried.add(pose)
            if self._is_clear(self._gantry.preview(*pose), people, step.seconds):
                return task, pose
            detour = self._detour(pose, people)
            if detour is not None:
                return task, detour
        return None

    def refuge(self, people: Sequence[Sighting]) -> Pose:
        """Where to step aside: of some places, the one on the way to which people are farthest."""
        if not people:
            return self._gantry.position
        x, y, rotation = self._gantry.position
        speed, acceleration = (
            self._gantry.gantry.x.max_speed,
            self._gantry.gantry.x.max_acceleration,
        )
        lag = speed / acceleration / 2

        def nearest(place: tuple[float, float]) -> float:
            length = math.dist((x, y), place)
            return min(
                math.hypot(
                    x + share * (place[0] - x) - person[0], y + share * (place[1] - y) - person[1]
                )
                for t, expected in glances
                for share in [min(1.0, speed * max(0.0, t - lag) / length) if length else 0.0]
                for person in expected
            )

        glances = [
            (t, [_expected(person, t) for person in people])
            for t in np.arange(0.0, FORESIGHT + GLANCE, 2 * GLANCE).tolist()
        ]
        if nearest((x, y)) >= self._zone:
            return (x, y, rotation)
        return (*max(((x, y), *self._refuges), key=nearest), rotation)

    def _is_clear(self, way: Motion, people: Sequence[Sighting], seconds: float) -> bool:
        """Whether it can keep moving on `way`, and stand at its end for `seconds`."""
        now = self._gantry.now
        stay = max(way.end + seconds, now + FORESIGHT)
        moving = self._clearance(way, people, now, way.end)
        return moving >= self._rooms[-1] and (
            self._clearance(way, people, way.end, stay) >= self._zone
        )

    def _clearance(
        self, motion: Motion, people: Sequence[Sighting], begin: float, end: float
    ) -> float:
        """The least distance to anybody from `begin` to `end` (seconds), in metres."""
        times = np.append(np.arange(begin, end, GLANCE), end)
        after = np.minimum(times - self._gantry.now, FORESIGHT)[:, None]
        gantry = motion.position(times)
        away = [gantry - (np.array(p.at) + after * np.array(p.velocity)) for p in people]
        return min((float(np.hypot(*offset.T).min()) for offset in away), default=math.inf)

    def _detour(self, pose: Pose, people: Sequence[Sighting]) -> Pose | None:
        """Where to go first to get to `pose` round everybody; None if there is no way."""
        places = [_expected(person, after) for person in people for after in (0.0, FORESIGHT)]
        goal, way, radius = self._way
        if goal == pose and way:
            # A way once chosen is kept while it is clear, so that it does not waver between two.
            here = self._gantry.position
            way = way[1:] if math.dist(here[:2], way[0][:2]) < REACH else way
            line = LineString([here[:2], *(point[:2] for point in (*way, pose))])
            if way and all(line.distance(Point(place)) > radius - 2 * ROOM for place in places):
                self._way = (pose, way, radius)
                return way[0]
        self._way = (pose, *self._plan(pose, places))
        way = self._way[1]
        return way[0] if way else None

    def _plan(
        self, pose: Pose, places: Sequence[tuple[float, float]]
    ) -> tuple[tuple[Pose, ...], float]:
        """A way to `pose` that keeps away from `places`, and how far (metres)."""
        nearest = min(math.dist(pose[:2], place) for place in places)
        for room in self._rooms:
            # The goal may be nearer than one would like to pass, but not so near as to stop there.
            radius = min(room, nearest - ROOM)
            if radius < self._zone:
                break
            keep_out = [(*place, radius) for place in places]
            try:
                path = self._planner.plan(self._gantry.position, pose, keep_out=keep_out)
            except PlanningError:
                continue
            return tuple((x, y, rotation) for x, y, rotation in path.points[1:].tolist()), radius
        return (), 0.0


def _expected(person: Sighting, after: float) -> tuple[float, float]:
    """Where somebody will be after so many seconds who goes on as now for a while."""
    (x, y), (vx, vy) = person.at, person.velocity
    seconds = min(after, FORESIGHT)
    return (x + vx * seconds, y + vy * seconds)


def _length(way: Sequence[Pose]) -> float:
    return sum(math.dist(a[:2], b[:2]) for a, b in itertools.pairwise(way))
