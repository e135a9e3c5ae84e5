"""Plans its ways round people, prefers tasks away from them, and steps aside for them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from navigation import GantryPlanner, Motion, PlanningError

from ..drive import Steps
from ..gantry import GantryRobot, Sighting
from ..tasks import Pose, Task
from .caution import Caution

ROOM = 0.2
"""Metres. How much more than the protective distance it keeps from people where it can."""

FORESIGHT = 5.0
"""Seconds. How far ahead it takes people to go on as they do."""

GLANCE = 0.5
"""Seconds. How finely it looks ahead."""

SECOND_THOUGHTS = 1.0
"""Seconds. How often it asks itself whether what it does is still the best."""

REFUGES = 5
"""It steps aside to one of so many times so many places, spread over its range."""


def avoiding(gantry: GantryRobot) -> Steps:
    """The nearest task that is clear of people, one after the other; else out of their way."""
    caution = Caution(gantry)
    outlook = Outlook(gantry, caution.required(0.0) + ROOM)
    while (yield gantry.next_task()) is not None:
        people = yield gantry.look()
        task, pose = outlook.choose(people)
        if task is None:
            if (yield from caution.go(outlook.refuge(people), seconds=SECOND_THOUGHTS)):
                yield gantry.look(0.1)
            continue
        yield gantry.locate(task)
        if (yield from caution.go(pose, seconds=SECOND_THOUGHTS)) and pose == gantry.where(task):
            yield gantry.handle(task)


class Outlook:
    """Where the gantry can go without coming near people who go on as they do."""

    def __init__(self, gantry: GantryRobot, zone: float) -> None:
        self._gantry = gantry
        self._zone = zone
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
        shortest: dict[Pose, tuple[float, Task]] = {}
        for task in tasks:
            way = gantry.way(task)
            if way and (way[0] not in shortest or _length(way) < shortest[way[0]][0]):
                shortest[way[0]] = (_length(way), task)
        here = gantry.position
        for pose, (_, task) in sorted(
            shortest.items(), key=lambda item: math.dist(item[0][:2], here[:2]) + item[1][0]
        ):
            step = task.next_step
            assert step is not None  # it is open
            if self._clearance(gantry.preview(*pose), people, step.seconds) >= self._zone:
                return task, pose
            detour = self._detour(pose, people)
            if detour is not None:
                return task, detour
        return None, here

    def refuge(self, people: Sequence[Sighting]) -> Pose:
        """Where to step aside: of some places, the one on the way to which people are farthest."""
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
        return (*max(((x, y), *self._refuges), key=nearest), rotation)

    def _clearance(self, motion: Motion, people: Sequence[Sighting], seconds: float) -> float:
        """The least distance to anybody on the way and for `seconds` after it (metres)."""
        now = self._gantry.now
        times = np.arange(now, max(motion.end + seconds, now + FORESIGHT) + GLANCE, GLANCE)
        after = np.minimum(times - now, FORESIGHT)[:, None]
        gantry = motion.position(times)
        away = [gantry - (np.array(p.at) + after * np.array(p.velocity)) for p in people]
        return min((float(np.hypot(*offset.T).min()) for offset in away), default=math.inf)

    def _detour(self, pose: Pose, people: Sequence[Sighting]) -> Pose | None:
        """Where to go first to get to `pose` round everybody; None if there is no way."""
        discs = [(*_expected(p, after), self._zone) for p in people for after in (0.0, FORESIGHT)]
        if any(math.dist(pose[:2], disc[:2]) < disc[2] for disc in discs):
            return None
        try:
            path = self._planner.plan(self._gantry.position, pose, keep_out=discs)
        except PlanningError:
            return None
        x, y, rotation = path.points[1].tolist()
        return (x, y, rotation)


def _expected(person: Sighting, after: float) -> tuple[float, float]:
    """Where somebody will be after so many seconds who goes on as now for a while."""
    (x, y), (vx, vy) = person.at, person.velocity
    seconds = min(after, FORESIGHT)
    return (x + vx * seconds, y + vy * seconds)


def _length(way: Sequence[Pose]) -> float:
    return sum(math.dist(a[:2], b[:2]) for a, b in itertools.pairwise(way))
