"""Path planning among bodies with known motions: a wait or a detour, whichever arrives first.

A person who waits `d` seconds and then walks along a path touches a moving body for some values of
`d` only. The minimum safe delay is found by conservative advancement. If the body is first touched
at the place p at time t, and leaves p free at t', every delay that is longer by less than t' − t
brings the person to p while the body is there. So the delay grows by t' − t, no safe delay is
missed, and the monitor checks the delayed motion again, with its exact profile.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence

import numpy as np
import shapely
from numpy.typing import ArrayLike
from shapely.geometry import Polygon

from floorplan import Point
from floorplan.files.dataclass import dataclass

from .bodies import CollisionBody, Disc
from .catalog import Path, PlanningError
from .encounter import PERSON_HEIGHT, Cylinder, Shapes, Solid
from .kernels.watch import TooClose
from .monitor import RESOLUTION, first_time, minimum_separation, when
from .motion import Motion, join, standing
from .planner import PathPlanner
from .roadmap_planner import SLACK
from .separation import FixedDistance
from .walking import MAX_ACCELERATION, MAX_SPEED, walk, walk_at
from .world import CollisionWorld

GAP = 0.1
"""Metres. Minimum distance of a person from the surface of a moving body."""

PATIENCE = 60.0
"""Seconds. Maximum time to wait."""

_LEAST, _GROWTH = 1e-3, 1.04
"""Initial minimum increase of a delay (s), and the factor by which it grows each time, so that the
search ends beside a body that grazes the path or moves along it."""

_PLACES = 4
"""Number of waypoints before the place of a touch at which the person may wait."""

_THIN = 1e-3
"""Metres. Radius of a person reduced to the axis."""

_LEEWAY = 1e-5
"""Metres. Distance beyond `gap` at which a body has left a place."""

_SHORT = 0.5
"""Metres. Distance of a place to wait on the path before the place of a touch."""

_BRIEF = 1.0
"""Seconds. No detour is searched if a wait on the shortest path is at most this long."""

_TURN = 0.3
"""Radians. Largest turn of a body between two footprints that share a hull."""

_STRAIGHT = 1e-6
"""Metres. A detour by less is straight."""

Pose = tuple[float, float, float]
"""x, y (m) and rotation (rad)."""

Limits = tuple[float, float]
"""Top speed (m/s) and acceleration (m/s²)."""


@dataclass(frozen=True, eq=False)
class Mover:
    """Body with a known motion. It is stationary before and after.

    Parameters
    ----------
    name : str
        Name of the body in the collision world, if it has one there.
    motion : Motion
        Motion of its axis.
    solid : Box, Cylinder or Prism
        Solid that turns with the body.
    """

    name: str
    motion: Motion
    solid: Solid


@dataclass(frozen=True, eq=False)
class Passage:
    """Path among moving bodies, and a motion along it that touches none of them.

    Parameters
    ----------
    path : Path
        Path.
    motion : Motion
        Motion along the path.
    waits : tuple, optional
        Position (x, y) in metres and duration in seconds of each wait.
    """

    path: Path
    motion: Motion
    waits: tuple[tuple[Point, float], ...] = ()

    @property
    def arrives(self) -> float:
        """Time of arrival in seconds."""
        return self.motion.end


@dataclass(eq=False)
class _Watch:
    """Moving body, and the conditions under which it touches a person."""

    mover: Mover
    shapes: Shapes
    condition: TooClose
    still: TooClose
    """Condition until it starts. People pass standing bodies at any distance."""
    clear: TooClose
    """Condition until it has left a place. It is a little wider, so that a body that slides along
    at exactly the required distance does not touch again and again."""
    sets_out: float
    moves: list[tuple[float, float]]
    """Begin and end of each piece with a motion."""

    def touched(self, person: Motion, begin: float, end: float) -> float | None:
        """Return the first time in [begin, end] at which it touches the person, or None."""
        for condition, one, other in (
            (self.still, begin, min(end, self.sets_out)),
            (self.condition, max(begin, self.sets_out), end),
        ):
            if one <= other:
                pair = (person, self.mover.motion)
                touch = first_time(condition, *pair, one, other, shapes=self.shapes)
                if touch is not None:
                    return touch
        return None

    def occupies_from(self, place: Point, at: float) -> float:
        """Return when it occupies a place for good (s, not before `at`), or infinity."""
        rests = max(self.mover.motion.end, at)
        stands = standing(place)
        if self.touched(stands, rests, rests) is None:
            return math.inf
        pair = (stands, self.mover.motion)
        *_, (begin, _) = when(self.condition, *pair, at, rests + 1.0, shapes=self.shapes)
        return max(begin, self.sets_out)

    def leaves(self, place: Point, t: float) -> float:
        """Return the time at which it leaves a place that it touches at `t`, or infinity."""
        moves = next((max(begin, t) for begin, end in self.moves if end > t), math.inf)
        # A standing body leaves only after it has started.
        if moves > t:
            return math.inf if moves == math.inf else max(self.leaves(place, moves), moves)
        until = max(self.mover.motion.end, t) + 1.0
        standing_person = standing(place)
        pair = (standing_person, self.mover.motion)
        begin, end = next(when(self.clear, *pair, t, until, shapes=self.shapes), (t, t))
        if begin > t + RESOLUTION:  # it only grazes the place
            return t
        return math.inf if end >= until else end


def plan_among(
    planner: PathPlanner,
    start: ArrayLike,
    goal: ArrayLike,
    moving: Sequence[Mover],
    *,
    at: float = 0.0,
    heading: float = 0.0,
    max_speed: float = MAX_SPEED,
    max_acceleration: float = MAX_ACCELERATION,
    height: float = PERSON_HEIGHT,
    gap: float = GAP,
    patience: float = PATIENCE,
) -> Passage:
    """Return the passage from `start` to `goal` that arrives first.

    Candidates are the shortest path regardless of moving bodies, and paths around where they are
    now, where they stop, and everything that they cover. The person waits at most once: at the
    start, at a waypoint, or before a body would touch them. A wait of at most 1 s on the shortest
    path is preferred to all other paths.

    Parameters
    ----------
    planner : PathPlanner
        Planner of paths, with the person's radius.
    start, goal : array_like
        Positions (x, y) in metres.
    moving : sequence of Mover
        Moving bodies.
    at : float, optional
        Start time in seconds.
    heading : float, optional
        Heading at the start in radians.
    max_speed, max_acceleration : float, optional
        Limits of the person in m/s and m/s².
    height : float, optional
        Height of the person in metres.
    gap : float, optional
        Minimum distance in metres to bodies that have started to move. If the person is closer at
        the start, that distance is kept.
    patience : float, optional
        Maximum time to wait in seconds.

    Returns
    -------
    Passage
        Path and motion. The monitor has checked the motion.

    Raises
    ------
    PlanningError
        If no such passage was found.
    """
    watches = [_watch(planner, mover, start, at, height, gap) for mover in moving]
    best: Passage | None = None
    limits = (max_speed, max_acceleration)
    x, y = map(float, np.asarray(goal, dtype=float))
    latest = min((watch.occupies_from((x, y), at) for watch in watches), default=math.inf)
    for path in _paths(planner, start, goal, moving, at):
        for passage in _passages(path, watches, at, heading, limits, patience, latest):
            best, latest = passage, passage.arrives
        if best is None:
            # Other paths are longer. So no passage arrives before a body stays on the goal.
            if at + path.length / max_speed >= latest:
                break
        elif sum(wait for _, wait in best.waits) <= _BRIEF:
            break
    if best is not None:
        return best
    names = ", ".join(mover.name for mover in moving)
    message = f"no path was found among {names} with at most {patience:g} s to wait"
    raise PlanningError("not_found", message)


def _watch(
    planner: PathPlanner, mover: Mover, start: ArrayLike, at: float, height: float, gap: float
) -> _Watch:
    x, y = map(float, np.asarray(start, dtype=float))
    here = standing((x, y))

    def begins(radius: float) -> tuple[Shapes, float]:
        shapes = Shapes(person=Cylinder(radius=radius, top=height), machine=(mover.solid,))
        return shapes, minimum_separation(here, mover.motion, at, at, shapes=shapes)[1]

    shapes, least = begins(planner.radius)
    if least < _THIN:
        # Overlapping surfaces have distance 0 at any depth. So use a smaller cylinder that only
        # touches the body, to measure whether the person comes nearer.
        beside = begins(_THIN)[1]
        if beside < _THIN:
            raise PlanningError("start_blocked", f"the start {x:g}, {y:g} is inside {mover.name}")
        shapes, least = begins(beside)
    # A person who is closer at the start keeps that distance. Otherwise no motion would be free.
    room = least - 1e-6
    distance = min(gap, room)
    condition, still, clear = (
        TooClose(FixedDistance(least)) for least in (distance, min(SLACK, room), distance + _LEEWAY)
    )
    moves = [(one.begin, one.end) for one in mover.motion.pieces if not one.stands]
    sets_out = next((max(begin, at) for begin, end in moves if end > at), at)
    return _Watch(mover, shapes, condition, still, clear, sets_out, moves)


def _paths(
    planner: PathPlanner, start: ArrayLike, goal: ArrayLike, moving: Sequence[Mover], at: float
) -> Iterator[Path]:
    """Yield the distinct candidate paths. `PlanningError` if there is none."""
    there = {body.name for body in planner.world.bodies}
    free = planner.world.as_if(away=[mover.name for mover in moving if mover.name in there])
    direct = _path_in(free, planner, start, goal)
    yield direct
    seen, cut_off = [direct.points.tolist()], False
    line = shapely.linestrings(direct.points)
    # The best path leads around the present places of bodies, around their last ones, or around
    # all that they cover, depending on the times.
    covers: list[Callable[[Mover], list[Polygon]]] = [
        lambda mover: _footprints(mover, [at]),
        lambda mover: _footprints(mover, [math.inf]),
        lambda mover: _swept(mover, at),
    ]
    for cover in covers:
        if cut_off and cover is covers[-1]:  # it includes what cuts off the goal
            return
        covered = [part for mover in moving for part in cover(mover)]
        if not shapely.dwithin(covered, line, planner.radius + SLACK).any():
            continue  # the shortest path is the same
        parts = shapely.get_parts(shapely.union_all(covered))
        bodies = {f"what moves, {k}": Polygon(part.exterior) for k, part in enumerate(parts)}
        world = free.as_if(bodies)
        try:
            path = _path_in(world, planner, start, goal)
        except PlanningError:
            cut_off = True
            continue
        if path.points.tolist() not in seen:
            seen.append(path.points.tolist())
            yield path


def _path_in(
    world: CollisionWorld, planner: PathPlanner, start: ArrayLike, goal: ArrayLike
) -> Path:
    """Return the path of a planner in another world."""
    other = PathPlanner(
        world, planner.radius, planner.ignore, step=planner.step, planner=planner.choice
    )
    return other.plan(start, goal, seed=planner.seed)


def _footprints(mover: Mover, times: Sequence[float]) -> list[Polygon]:
    """Return the areas that a body covers at each of `times` (s)."""
    motion = mover.motion
    clipped = np.clip(times, motion.start, motion.end)
    places = motion.position(clipped)
    if isinstance(mover.solid, Cylinder):
        radius = mover.solid.radius
        discs = (Disc((x, y), radius) for x, y in places.tolist())
        return [CollisionBody.of(mover.name, disc).footprint for disc in discs]
    rotation = motion.rotation(clipped)[:, None]
    along, across = np.array(mover.solid.corners).T
    c, s = np.cos(rotation), np.sin(rotation)
    turned = np.stack([c * along - s * across, s * along + c * across], axis=-1)
    return [*shapely.polygons(places[:, None] + turned)]


def _swept(mover: Mover, at: float) -> list[Polygon]:
    """Return the areas that a body covers from `at` (s) on: one hull for each straight drive."""
    motion = mover.motion
    times, poses = [at], [motion.state(at).position]
    for piece in motion.pieces_from(at):
        begin, end = max(piece.begin, at), max(piece.end, at)
        turn = abs(motion.state(end).position[2] - poses[-1][2])
        steps = math.ceil(turn / _TURN) or 1
        for t in np.linspace(begin, end, steps + 1)[1:].tolist():
            pose = motion.state(t).position
            if len(poses) > 1 and _is_between(poses[-1], poses[-2], pose):
                del times[-1], poses[-1]
            times.append(t)
            poses.append(pose)
    placed = _footprints(mover, times)
    pairs = [shapely.MultiPolygon([*pair]) for pair in itertools.pairwise(placed)]
    return [*shapely.convex_hull(pairs or placed)]


def _is_between(pose: Pose, a: Pose, b: Pose) -> bool:
    """Return whether a pose is on the straight drive from a to b."""
    detour = math.dist(a[:2], pose[:2]) + math.dist(pose[:2], b[:2]) - math.dist(a[:2], b[:2])
    return a[2] == pose[2] == b[2] and detour < _STRAIGHT


def _passages(
    path: Path,
    watches: Sequence[_Watch],
    at: float,
    heading: float,
    limits: Limits,
    patience: float,
    latest: float,
) -> Iterator[Passage]:
    """Yield passages along `path` with at most one wait that arrive before `latest`.

    Each arrives before the previous one.
    """
    points: list[Point] = [(x, y) for x, y in path.points.tolist()]
    speed, acceleration = limits
    straight = walk(points, at, max_speed=speed, max_acceleration=acceleration)
    # A wait only delays the arrival.
    if straight.end >= latest:
        return
    touched = _first_touch(watches, straight, at, straight.end)
    if touched is None:
        yield Passage(path, straight)
        return
    first, _ = touched
    for before, after in _splits(points, straight.state(first).at):
        if len(before) == 1:
            before_it = standing(before[0], heading=heading, start=at)
        else:
            before_it = walk(before, at, max_speed=speed, max_acceleration=acceleration)
        wait = _delayed(before_it, after, watches, at, limits, patience, latest)
        if wait is not None:
            motion, delay = wait
            latest = motion.end
            yield Passage(path, motion, ((after[0], delay),))


def _splits(points: list[Point], touched: Point) -> Iterator[tuple[list[Point], list[Point]]]:
    """Yield a path in two parts, before and after each place to wait, beginning with the start.

    The places are the last waypoints before the place `touched`, and one just before it.
    """
    yield points[:1], points
    for k, (a, b) in enumerate(itertools.pairwise(points)):
        share = _share(a, b, touched)
        if share is None:
            continue
        # Each waypoint costs a search.
        for waits in range(max(k - _PLACES, 0) + 1, k + 1):
            yield points[: waits + 1], points[waits:]
        length = math.dist(a, b)
        short = share * length - _SHORT
        if short > 0:
            x, y = (a[i] + (b[i] - a[i]) * short / length for i in (0, 1))
            yield [*points[: k + 1], (x, y)], [(x, y), *points[k + 1 :]]
        return


def _share(a: Point, b: Point, place: Point) -> float | None:
    """Return the share of the segment from a to b before a place on it, or None if beside it."""
    length = math.dist(a, b)
    if length == 0 or abs(math.dist(a, place) + math.dist(place, b) - length) > 1e-6:
        return None
    return math.dist(a, place) / length


def _delayed(
    before: Motion,
    points: list[Point],
    watches: Sequence[_Watch],
    at: float,
    limits: Limits,
    patience: float,
    latest: float,
) -> tuple[Motion, float] | None:
    """Return the motion with the shortest safe wait after `before`, and the duration of the wait.

    It continues along `points`. None if no wait up to `patience` seconds is safe, or if it would
    not arrive before `latest`.
    """
    speed, acceleration = limits
    waits_from = max(before.end, at)
    last = min(waits_from + patience, latest)
    # The first touch on the way to the place, or during the wait.
    reached = _first_touch(watches, before, at, max(last, waits_from))
    blocked = math.inf if reached is None else reached[0]
    onwards_at = walk_at(points, max_speed=speed, max_acceleration=acceleration)
    delay = 0.0
    least = _LEAST
    order = [*watches]  # the body of the last touch is tested first
    while delay <= patience:
        sets_out = waits_from + delay
        onwards = onwards_at(sets_out)
        if blocked < sets_out or onwards.end >= latest:
            return None
        # Any touch suffices, because no shorter delay is safe beside this body.
        touches = (watch.touched(onwards, sets_out, onwards.end) for watch in order)
        touched = next(((k, t) for k, t in enumerate(touches) if t is not None), None)
        if touched is None:
            return join([before, onwards]), delay
        k, t = touched
        order.insert(0, order.pop(k))
        delay += max(order[0].leaves(onwards.state(t).at, t) - t, least)
        # Geometric growth ends a search with tiny steps.
        least *= _GROWTH
    return None


def _first_touch(
    watches: Sequence[_Watch], motion: Motion, begin: float, end: float
) -> tuple[float, _Watch] | None:
    """Return the time of the first touch on a motion, and the body, or None."""
    touches = [
        (t, k)
        for k, watch in enumerate(watches)
        if (t := watch.touched(motion, begin, end)) is not None
    ]
    if not touches:
        return None
    t, k = min(touches)
    return t, watches[k]
