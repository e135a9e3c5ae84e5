"""Avoidance of people by the gantry: moves that can always stop, and choice of courses."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
from shapely import LineString, Point
from simpy.events import Event

from navigation import GantryPlanner, Motion, PlanningError
from navigation.kernels.lookout import most_remote, nearest_on
from navigation.motion import State

from ...core.entries import Pose
from ...core.events import GantryYielded
from ...safety.stopping_check import Pedestrian, Stoppable, StoppingCheck
from ..commanded import CommandedMachine, Sighting
from ..commanding import Steps
from ..tasks import Task
from .robot import GantryRobot
from .tasks import REACH

SHARES = (1.0, 0.5, 0.25, 0.1)
"""The shares of its top speeds that the gantry chooses from."""

LEAST = 0.2
"""Seconds for which a motion must be safe to be commanded."""

AGAIN = 2.0
"""Seconds after which it looks for a faster motion than that under way."""

ARRIVED = 1e-6
"""Metres and radians. Nearer than this is there."""

INSTANT = 1e-6
"""Seconds. Less than this is no time at all."""


class Caution:
    """Motion of a gantry that keeps the protective separation distance from people.

    Each commanded motion is safe until the next observation, and so is a stop from there.

    Parameters
    ----------
    gantry : GantryRobot
        The gantry.
    """

    def __init__(self, gantry: CommandedMachine) -> None:
        self._gantry = gantry
        self._human_speed = gantry.human_speed
        self._foresight = StoppingCheck(gantry.law, gantry.shape.top_speed)
        self._move: Event = gantry.stop()
        self._under_way: tuple[Motion, Pose, float] | None = None
        self._stuck: tuple[Motion, Pose, Sequence[Sighting]] | None = None
        """The standstill, and what it was before it, from which no motion was safe."""
        self._hindered_by: str | None = None
        """The person for whom the slowest motion was not safe."""
        self._has_recorded = False
        """Whether it has recorded that it waits, since it last moved."""
        self._seen: tuple[Sighting, ...] = ()
        self._seen_at = -math.inf

    def look(self) -> Steps:
        """Observe the people, once at each time. Use it with `yield from`.

        Yields
        ------
        Event
            Waiting time.
        """
        if self._seen_at != self._gantry.now:
            people: tuple[Sighting, ...] = yield self._gantry.look()
            self._take_note(people)
        return self._seen

    def go(self, pose: Pose, *, seconds: float = math.inf) -> Steps:
        """Move to a pose as fast as is safe. Use it with `yield from`.

        If no motion is safe, the gantry stops and waits until one is.

        Parameters
        ----------
        pose : (float, float, float)
            x and y in metres and rotation in radians.
        seconds : float, optional
            Maximum duration in seconds. The current motion continues after it.

        Yields
        ------
        Event
            Waiting time.

        Returns
        -------
        bool
            Whether the gantry has reached the pose.
        """
        gantry = self._gantry
        end = gantry.now + seconds
        people = yield from self.look()
        while not self._is_at(pose) or gantry.now < gantry.body.motion.end:
            # Less than this is what rounding leaves of the time it was given.
            if end - gantry.now < INSTANT:
                return False
            share = self._share_to(pose)
            found, safe = self._fastest(pose, people)
            if found == 0.0 and self._under_way is not None:
                gantry.stop()
                self._under_way = None
            elif found != share:
                self._has_recorded = False
                self._move = gantry.move_to(*pose, speed_share=found, resume=False)
                self._under_way = (gantry.body.motion, pose, found)
            if found == 0.0 and not gantry.disabled:
                self.record_waiting(self._hindered_by, people)
            # For `safe` seconds nobody can matter, so it looks no sooner.
            look = gantry.look(min(safe, end - gantry.now))
            yield look | self._move if found > 0.0 else look
            if look.processed:
                self._take_note(look.value or ())
            people = yield from self.look()
        return True

    def _is_at(self, pose: Pose) -> bool:
        here = self._gantry.position
        turn = math.remainder(here[2] - pose[2], math.tau)
        return math.dist((*here[:2], turn), (*pose[:2], 0.0)) <= ARRIVED

    def preview(self, pose: Pose, share: float = 1.0) -> Motion:
        """Return the motion to a pose without moving. It is the current motion if that leads there.

        Parameters
        ----------
        pose : (float, float, float)
            x and y in metres and rotation in radians.
        share : float, optional
            Share of the top speeds to use.
        """
        gantry = self._gantry
        under_way = share == self._share_to(pose)
        return gantry.body.motion if under_way else gantry.preview(*pose, speed_share=share)

    def safe_for(self, motion: Motion, people: Sequence[Sighting]) -> float:
        """Return the duration in seconds for which a motion and a stop after it are safe, or 0.

        Parameters
        ----------
        motion : Motion
            Motion that begins now.
        people : sequence of Sighting
            Observed people.
        """
        gantry = self._gantry
        plan = Stoppable(motion, gantry.drive.stops)
        seen = [Pedestrian(person.name, person.at, self._human_speed) for person in people]
        until, who = self._foresight.safe_until(plan, seen, gantry.now, LEAST)
        self._hindered_by = None if who is None else who.name
        return until - gantry.now if who is not None else max(until - gantry.now, LEAST)

    def room_to_move(self, speed: float) -> float:
        """Return the distance in metres from people at which motion is possible.

        Parameters
        ----------
        speed : float
            Speed of the gantry in m/s.
        """
        moving = State(self._gantry.position, (speed, 0.0, 0.0), (0.0, 0.0, 0.0))
        # What the stop from that speed takes, in metres and in seconds, in which people come
        # nearer.
        stop = self._gantry.stopping(moving, 0.0)
        metres = math.dist(stop.state(0.0).at, stop.state(stop.end).at)
        return self.required(speed) + metres + self._human_speed * (stop.end + LEAST)

    def required(self, robot_speed: float) -> float:
        """Return the required distance in metres from people.

        Laws of motions are evaluated at the top speed of the gantry, which it may reach.

        Parameters
        ----------
        robot_speed : float
            Speed of the gantry in m/s.
        """
        return self._foresight.required(self._human_speed, robot_speed)

    def record_waiting(self, name: str | None, people: Sequence[Sighting]) -> None:
        """Record that the gantry waits for a person, once until it moves again.

        Parameters
        ----------
        name : str or None
            Name of the person, or None for the nearest one.
        people : sequence of Sighting
            Observed people.
        """
        if self._has_recorded or not people:
            return
        here = self._gantry.position[:2]
        nearest = min(people, key=lambda one: (one.name != name, math.dist(one.at, here)))
        self._has_recorded = True
        self._gantry.record(
            GantryYielded(
                person=nearest.name,
                distance=math.dist(nearest.at, here),
                required=self.required(self._gantry.state.speed),
            )
        )

    def _take_note(self, people: tuple[Sighting, ...]) -> None:
        self._seen, self._seen_at = people, self._gantry.now

    def _share_to(self, pose: Pose) -> float:
        """Return the share of its speeds at which it moves to `pose`; 0 if it does not."""
        if self._under_way is None:
            return 0.0
        motion, target, share = self._under_way
        return share if motion is self._gantry.body.motion and target == pose else 0.0

    def _fastest(self, pose: Pose, people: Sequence[Sighting]) -> tuple[float, float]:
        """Return the greatest safe share of the top speeds, and the seconds for which it is safe.

        If none is safe: 0, and the seconds until the next look.
        """
        gantry = self._gantry
        if not gantry.disabled:
            motion = gantry.body.motion
            now_at = (motion, pose, people) if motion.end <= gantry.now else None
            # What was not safe from a standstill is not while nobody has moved since.
            if now_at is None or self._stuck != now_at:
                # From the fastest on: the first that is safe is taken.
                for candidate in SHARES:
                    motion = self.preview(pose, candidate)
                    seconds = self.safe_for(motion, people)
                    if seconds > 0.0:
                        return candidate, seconds if candidate == 1.0 else min(seconds, AGAIN)
                self._stuck = now_at
        nearest = min((math.dist(p.at, gantry.position[:2]) for p in people), default=math.inf)
        lacking = self.required(0.0) - nearest
        return 0.0, max(LEAST, lacking / self._human_speed)


ROOM = 0.2
"""Metres beyond the protective separation distance that it keeps from people where it can."""

PACES = (1.0, 0.3, 0.1)
"""m/s. A path round somebody leaves the distance that one of these speeds needs, if possible."""

FORESIGHT = 5.0
"""Seconds for which it expects people to go on at their present velocity."""

GLANCE = 0.5
"""Seconds between the instants ahead at which it compares positions."""

_GLANCES = [2 * GLANCE * k for k in range(1 + int(FORESIGHT / (2 * GLANCE)))]
"""Seconds ahead at which it compares refuges."""

SECOND_THOUGHTS = 1.0
"""Seconds after which it chooses its task and path anew."""

PATIENCE = 6.0
"""Seconds for which an order may be blocked before the tasks of the next are considered."""

REFUGES = 5
"""It steps aside to one of so many times so many places, spread over its range."""


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
    """Choice of where to go without coming near people, if those keep their velocity."""

    def __init__(self, gantry: GantryRobot, caution: Caution) -> None:
        self._gantry = gantry
        self._caution = caution
        self.is_hindered = False
        """Whether people were near every path when none was chosen."""
        self._zone = caution.required(0.0) + ROOM
        self._rooms = [caution.room_to_move(pace) + ROOM for pace in PACES]
        self._free_at = gantry.now
        self._standing = gantry.body.motion
        self._from_here: dict[Pose, Motion] = {}
        """Motions from where the gantry stands, by their ends."""
        self._path: tuple[Pose, tuple[Pose, ...], float] = (gantry.position, (), 0.0)
        self._planner = GantryPlanner(gantry.floorplan)
        x, y = (
            np.linspace(axis.low, axis.high, REFUGES).tolist()
            for axis in (gantry.gantry.x, gantry.gantry.y)
        )
        self._refuges = [*itertools.chain.from_iterable(itertools.product(x, y))]
        """x and y of each in turn."""

    def choose(self, people: Sequence[Sighting]) -> tuple[Task | None, Pose]:
        """Return the task to go on with (None if none can be done now), and the pose to go to."""
        gantry = self._gantry
        tasks = gantry.open_tasks
        # What is begun is finished first.
        tasks = tuple(task for task in tasks if task.begun) or tasks
        paths = [(task, path) for task in tasks for path in [gantry.way(task)] if path]
        self.is_hindered = bool(paths)
        groups = list(dict.fromkeys(task.group for task, _ in paths))
        for group in groups[:1] if gantry.now < self._free_at + PATIENCE else groups:
            of_group = [(task, path) for task, path in paths if task.group == group]
            found = self._choose(of_group, people)
            if found is not None:
                self._free_at = gantry.now
                return found
        return None, gantry.position

    def _choose(
        self, paths: Sequence[tuple[Task, tuple[Pose, ...]]], people: Sequence[Sighting]
    ) -> tuple[Task, Pose] | None:
        """Return the task with the shortest path that is clear, and the pose to go to for it."""
        here = self._gantry.position
        rows = _rows(people)
        tried: set[Pose] = set()
        for task, (pose, *_) in sorted(paths, key=lambda entry: _length((here, *entry[1]))):
            step = task.next_step
            # Several tasks may begin at one place, which need be looked at once.
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
        """Return the pose to step aside to: of some, that on the path to which people are farthest.

        It is the present pose if nobody comes into the zone there.
        """
        if not people:
            return self._gantry.position
        x, y, rotation = self._gantry.position
        axis = self._gantry.gantry.x
        # Speeding up evenly to v costs v / (2 a) seconds against having had it from the start.
        lag = axis.max_speed / axis.max_acceleration / 2
        places = [x, y, *self._refuges]
        k = most_remote(places, _rows(people), _GLANCES, FORESIGHT, axis.max_speed, lag, self._zone)
        return (places[2 * k], places[2 * k + 1], rotation)

    def _motion_to(self, pose: Pose) -> tuple[Motion, float]:
        """Return the motion to `pose`, and the instant of it that is now (seconds).

        While the gantry stands, that from here begins later and later, but is the same one.
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
        """Return True if it can keep moving on `motion`, and stand at its end for `seconds`."""
        table = motion.table
        moving = nearest_on(table, people, now, now, motion.end, GLANCE, FORESIGHT)
        if moving < self._rooms[-1]:
            return False
        stay = max(motion.end + seconds, now + FORESIGHT)
        return nearest_on(table, people, now, motion.end, stay, GLANCE, FORESIGHT) >= self._zone

    def _detour(self, pose: Pose, people: Sequence[Sighting]) -> Pose | None:
        """Return the first waypoint of a path to `pose` round everybody; None if there is none."""
        places = [_expected(person, after) for person in people for after in (0.0, FORESIGHT)]
        goal, path, radius = self._path
        if goal == pose and path:
            # A path once chosen is kept while it is clear, so that it does not waver between two.
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
        """Return waypoints to `pose` that keep away from `places`, and the distance kept (metres).

        Without waypoints, and 0, if there is no such path.
        """
        nearest = min(math.dist(pose[:2], place) for place in places)
        # The goal may be nearer than one would like to pass, but not so near as to stop there.
        radii = [min(room, nearest - ROOM) for room in self._rooms]
        radii = [radius for radius in dict.fromkeys(radii) if radius >= self._zone]
        answers = {radius: self._round(pose, places, radius) for radius in radii[:1]}
        if "unreachable" in answers.values():
            # Where the smallest leaves no path either, none does.
            answers[radii[-1]] = self._round(pose, places, radii[-1])
            if answers[radii[-1]] == "unreachable":
                return (), 0.0
        for radius in radii:
            answer = answers.get(radius) or self._round(pose, places, radius)
            if not isinstance(answer, str):
                return answer, radius
            if answer == "start_blocked":  # somebody is within the arm's reach
                break
        return (), 0.0

    def _round(
        self, pose: Pose, places: Sequence[tuple[float, float]], radius: float
    ) -> tuple[Pose, ...] | str:
        """Return waypoints to `pose` at `radius` metres from `places`, or why there are none."""
        keep_out = [(*place, radius) for place in places]
        try:
            path = self._planner.plan(self._gantry.position, pose, keep_out=keep_out)
        except PlanningError as why:
            return why.reason
        return tuple((x, y, rotation) for x, y, rotation in path.points[1:].tolist())


def _rows(people: Sequence[Sighting]) -> list[float]:
    """Return x, y and velocity of each of the people in turn."""
    return [c for person in people for c in (*person.at, *person.velocity)]


def _expected(person: Sighting, after: float) -> tuple[float, float]:
    """Return the place where somebody will be after so many seconds, who keeps their velocity."""
    (x, y), (vx, vy) = person.at, person.velocity
    seconds = min(after, FORESIGHT)
    return (x + vx * seconds, y + vy * seconds)


def _length(path: Sequence[Pose]) -> float:
    return sum(math.dist(a[:2], b[:2]) for a, b in itertools.pairwise(path))
