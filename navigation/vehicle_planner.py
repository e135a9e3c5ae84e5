"""Paths of vehicles with a footprint: guided by the roadmaps of discs, otherwise OMPL's in SE(2).

A path consists of straight drives and turns on the spot. FCL tests them. A drive is one query about
a box that encloses the swept area. For a rectangle along its heading, the box is that area. A turn
is free if the disc around it is, or otherwise if larger boxes at intermediate angles are.

Most vehicles turn in open places and pass narrow ones straight. So the shortest path of a disc that
is little wider than the vehicle guides the search. Its bends move to the nearest places where the
vehicle can turn. If that fails, RRT-Connect searches in SE(2).
"""

from __future__ import annotations

import itertools
import math
from collections import deque
from collections.abc import Iterator, Sequence
from typing import Any

import fcl
import numpy as np
import ompl.util as ou
import shapely
from numpy.typing import NDArray
from shapely import affinity
from shapely.geometry import Polygon

from floorplan import Point, UserError
from floorplan.files.dataclass import dataclass

from .bodies import region
from .catalog import PlanningError
from .planner import PathPlanner
from .pose_search import PoseSearch
from .sampling import TooManyChecksError, no_log
from .vehicles import Pose, VehicleLimits
from .world import CollisionWorld

SLACK = 1e-3
"""Clearance of a path in metres, so that rounding does not decide."""

_SAG = 0.02
"""Margin of the boxes of a turn in metres, so that they enclose the turn from one to the next."""

_ROOM = 0.1
"""Margin on each side of the narrowest disc that guides the search, in metres."""

_ITERATIONS = 2_500
"""Number of OMPL's iterations per search."""

_BIT = 0.1
"""Step in metres of the search for a place to turn, straight ahead or back."""

_TRIED = 3
"""Number of headings at a goal without one to which OMPL plans."""

_THICK = 1.0
"""Height of boxes for FCL in metres. Only the plane counts."""


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class VehiclePath:
    """Path of a vehicle: straight drives and turns on the spot.

    `poses` are (N, 3): x, y (metres) and rotation (radians), the start first. Each pose differs
    from the previous one in its place or in its rotation.
    """

    poses: NDArray[np.float64]

    def __repr__(self) -> str:
        return f"<VehiclePath of {self.length:.3f} m: {len(self.poses)} poses>"

    @property
    def length(self) -> float:
        """Length in metres."""
        return float(np.hypot(*np.diff(self.poses[:, :2], axis=0).T).sum())

    @property
    def turned(self) -> float:
        """Sum of all turns in radians."""
        return float(np.abs(np.diff(self.poses[:, 2])).sum())


class VehiclePlanner:
    """Planner of paths for a vehicle on the floor of a collision world.

    Parameters
    ----------
    world : CollisionWorld
        Floor and bodies, in their state at each query.
    footprint : Polygon
        Area that the vehicle covers at the origin with the heading 0, metres. It turns about the
        origin.
    limits : VehicleLimits, optional
        Limits of the vehicle, which determine possible drives and durations.
    seed : int, optional
        Seed of OMPL's samples.

    Raises
    ------
    UserError
        If the footprint is no polygon around the origin.
    """

    def __init__(
        self,
        world: CollisionWorld,
        footprint: Polygon,
        *,
        limits: VehicleLimits | None = None,
        seed: int = 0,
    ) -> None:
        if fault := footprint_fault(footprint):
            raise UserError(f"footprint {fault}")
        self.world = world
        self.footprint = footprint
        self.limits = limits or VehicleLimits()
        self.seed = seed
        self._corners = [(float(x), float(y)) for x, y in footprint.exterior.coords[:-1]]
        self._outer = float(np.hypot(*np.array(self._corners).T).max())
        half_turned = affinity.scale(footprint, -1.0, -1.0, origin=(0.0, 0.0))
        self._is_same_backwards = not self.limits.holonomic and half_turned.equals(footprint)
        self._inner = float(footprint.exterior.distance(shapely.Point(0.0, 0.0)))
        # Half a step of δ from a box, the distance of a corner is at most r sin(δ / 2).
        self._step = 2 * math.asin(min(_SAG / self._outer, 1.0))
        self._walls = world.walls(max(self._inner - SLACK, 0.0))
        self._shape = region(footprint)
        self._box = fcl.Box(1.0, 1.0, _THICK)
        self._boxes = fcl.CollisionObject(self._box, fcl.Transform())
        self._side = np.array([1.0, 1.0, _THICK])
        self._middle, self._rotation = np.zeros(3), np.zeros(4)
        (_, low), (_, high) = self._extent(1.0, 0.0)
        width = high - low
        narrow = min(width / 2 + _ROOM, self._outer)
        self._guides = [
            PathPlanner(world, radius)
            for radius in dict.fromkeys((narrow, self._outer + 2 * SLACK))
        ]
        self._ball = fcl.CollisionObject(fcl.Sphere(self._outer + SLACK), fcl.Transform())

    def fits(self, pose: Sequence[float]) -> bool:
        """Return whether the vehicle touches nothing in a pose (x, y, rotation)."""
        x, y, rotation = map(float, pose)
        if self._is_walled((x, y), (x, y)):
            return False
        self._put(self._shape, (x, y), rotation)
        (low_x, low_y), (high_x, high_y) = self._extent(math.cos(rotation), -math.sin(rotation))
        return self.world.clear_of(self._shape, (x + low_x, y + low_y, x + high_x, y + high_y))

    def plan(
        self, start: Sequence[float], goal: Sequence[float], *, thorough: bool = True
    ) -> VehiclePath:
        """Return a path from `start` to `goal` on which the vehicle touches nothing.

        Parameters
        ----------
        start : sequence of float
            x, y (metres) and rotation (radians).
        goal : sequence of float
            x and y. With a rotation, the vehicle turns to it at the end.
        thorough : bool, optional
            Whether to search in SE(2) if the paths of discs lead nowhere.

        Returns
        -------
        VehiclePath
            The fastest of the paths found, by an estimate.

        Raises
        ------
        PlanningError
            If the vehicle does not fit its start or goal ("start_blocked", "goal_blocked"), if
            even the disc inside its footprint has no path ("unreachable"), or if the search found
            none ("not_found").
        """
        begin = _pose(start, "start")
        end = _pose(goal, "goal") if len(goal) == 3 else None
        if not self.fits(begin):
            raise PlanningError("start_blocked", self.what_is_in_the_way(begin, "at the start"))
        to = (float(goal[0]), float(goal[1]))
        ends = [end] if end is not None else [*self._headings(begin, to)]
        if not ends:
            turned = ((*to, turn) for turn in self._turns(begin))
            fewest = min(turned, key=lambda pose: len(self._touched(pose)))
            raise PlanningError("goal_blocked", self.what_is_in_the_way(fewest, "at the goal"))
        if end is not None and not self.fits(end):
            raise PlanningError("goal_blocked", self.what_is_in_the_way(end, "at the goal"))
        poses = self._guided(begin, to, end)
        if poses is None:
            self._require_passage(begin, to)
            poses = self._sampled(begin, to, ends, end) if thorough else None
        if poses is None:
            message = (
                f"no path was found for the footprint from {_shown(begin)} to {_shown((*to,))}"
            )
            raise PlanningError("not_found", message)
        return VehiclePath(poses=np.array(_distinct(poses)))

    def free_along(self, poses: Sequence[Sequence[float]]) -> bool:
        """Return whether the vehicle touches nothing on a path through `poses`."""
        for one, other in itertools.pairwise(poses):
            a, b = (one[0], one[1]), (other[0], other[1])
            if a != b:
                if not self._drive_free(a, b, one[2]):
                    return False
            elif not self._turn_free(a, one[2], other[2]):
                return False
        return True

    def _headings(self, begin: Pose, to: Point) -> list[Pose]:
        """Return free poses at a goal without a rotation, the rotation of the start first."""
        return [pose for turn in self._turns(begin) if self.fits(pose := (*to, turn))]

    @staticmethod
    def _turns(begin: Pose) -> list[float]:
        return [begin[2], *(k * math.pi / 12 for k in range(24))]

    def _guided(self, begin: Pose, to: Point, end: Pose | None) -> list[Pose] | None:
        """Return a path that is straight, or along the path of a disc.

        If the vehicle cannot turn at an end, it may drive straight to a place nearby.
        """
        for first in self._nearby(begin):
            for last in [None] if end is None else self._nearby(end):
                path = (
                    self._along_way(first, to, None)
                    if last is None
                    else (self._along_way(first, (last[0], last[1]), last[2]))
                )
                if path is None:
                    continue
                poses = path if first == begin else [begin, *path]
                if last is None or end is None or last == end:
                    return poses
                turned = poses[-1][2]  # the heading of the goal, apart from whole turns
                return [*poses, (*to, turned)]
        return None

    def _along_way(self, begin: Pose, to: Point, rotation: float | None) -> list[Pose] | None:
        """Return the fastest path that is straight, or along the path of a disc."""
        legs = self.between(begin, to, rotation)
        if legs is not None:
            return [begin, *legs]
        paths = []
        for planner in self._guides:
            try:
                waypoints = planner.plan((begin[0], begin[1]), to).points.tolist()
            except PlanningError:
                continue
            places = [
                place for at in waypoints[1:-1] if (place := self._room_to_turn((at[0], at[1])))
            ]
            poses = _Chain(self, begin, to, rotation).shortened(places)
            if poses is not None:
                paths.append(poses)
        return min(paths, key=self.seconds, default=None)

    def _nearby(self, pose: Pose) -> Iterator[Pose]:
        """Yield a pose, and the nearest one ahead or back where the vehicle can turn."""
        yield pose
        at, c, s = (pose[0], pose[1]), math.cos(pose[2]), math.sin(pose[2])
        radius = self._outer + 2 * SLACK
        if self.world.free(at, radius):
            return
        for k in range(1, math.ceil(2 * self._outer / _BIT) + 1):
            for away in (k * _BIT, -k * _BIT):
                there = (at[0] + away * c, at[1] + away * s)
                if self.world.free(there, radius) and self._drive_free(at, there, pose[2]):
                    yield (*there, pose[2])
                    return

    def _room_to_turn(self, at: Point) -> Point | None:
        """Return the place nearest to `at` where the vehicle can turn completely."""
        radius = self._outer + 2 * SLACK
        return at if self.world.free(at, radius) else self.world.nearest_free(at, radius)

    def _sampled(
        self, begin: Pose, to: Point, ends: Sequence[Pose], end: Pose | None
    ) -> list[Pose] | None:
        """Return the path of RRT-Connect within its budget."""
        low_x, low_y, high_x, high_y = self.world.plan.boundary.bounds
        for k, target in enumerate(ends[:_TRIED]):
            with no_log():
                ou.RNG.setSeed(self.seed + k + 1)
                search = PoseSearch((low_x, low_y), (high_x, high_y), self._link, self.fits)
                try:
                    states = search.run(begin, target, _ITERATIONS // len(ends[:_TRIED]))
                except TooManyChecksError:
                    states = None
                finally:
                    search.release()
            if states is not None:
                chain = _Chain(self, begin, to, None if end is None else end[2])
                shorter = chain.shortened([state[:2] for state in states[1:-1]])
                joined = self._joined(states)
                return min([joined, shorter or joined], key=self.seconds)
        return None

    def _link(self, one: Pose, other: Pose) -> bool:
        return self.between(one, (other[0], other[1]), other[2]) is not None

    def between(self, one: Pose, to: Point, rotation: float | None) -> list[Pose] | None:
        """Return the poses of turn, drive and turn from one pose on, or None if not free."""
        a = (one[0], one[1])
        if math.dist(a, to) < SLACK:
            return self._turn(a, one[2], one[2] if rotation is None else rotation)
        for heading in self._ways(one, to):
            # The drive first, because it is one query.
            if not self._drive_free(a, to, heading):
                if self._is_same_backwards:
                    return None
                continue
            first = self._turn(a, one[2], heading)
            if first is None:
                continue
            last = self._turn(to, first[-1][2], first[-1][2] if rotation is None else rotation)
            if last is not None:
                return [*first, (*to, first[-1][2]), *last]
        return None

    def _ways(self, one: Pose, to: Point) -> list[float]:
        """Return the headings in which the vehicle can drive straight to a place."""
        ahead = math.atan2(to[1] - one[1], to[0] - one[0])
        ways = [ahead, ahead + math.pi]
        return [one[2], *ways] if self.limits.holonomic else ways

    def _turn(self, at: Point, begin: float, end: float) -> list[Pose] | None:
        """Return the pose after a turn, in the shorter direction if that is free."""
        short = math.remainder(end - begin, math.tau)
        for turn in (short, short - math.copysign(math.tau, short)):
            if abs(turn) < 1e-9:
                return [(*at, begin)]
            if self._turn_free(at, begin, begin + turn):
                return [(*at, begin + turn)]
        return None

    def _drive_free(self, a: Point, b: Point, rotation: float) -> bool:
        """Return whether a straight drive with the heading `rotation` is free."""
        gates = self.world.gates
        if gates.lines and not gates.allow(a, b):
            return False
        if self._is_walled(a, b):
            return False
        length = math.dist(a, b)
        c, s = (b[0] - a[0]) / length, (b[1] - a[1]) / length
        turned = math.atan2(s, c) - rotation
        (low, right), (high, left) = self._extent(math.cos(turned), math.sin(turned))
        along, across = (low - SLACK, high + SLACK + length), (right - SLACK, left + SLACK)
        return self._box_free(a, (c, s), along, across)

    def _turn_free(self, at: Point, begin: float, end: float) -> bool:
        """Return whether a turn on the spot is free."""
        x, y = at
        r = self._outer + SLACK
        self._put(self._ball, at, 0.0)
        if self.world.clear_of(self._ball, (x - r, y - r, x + r, y + r)):
            return True
        count = max(1, math.ceil(abs(end - begin) / self._step))
        (low, right), (high, left) = self._extent(1.0, 0.0)
        more = _SAG + SLACK
        spans = (low - more, high + more), (right - more, left + more)
        # Boxes in the middle of each step enclose the turn to its ends. Neighbours mostly meet the
        # same obstacle, so the order bisects the turn.
        untested = deque([(0, count)])
        while untested:
            first, last = untested.popleft()
            k = (first + last) // 2
            angle = begin + (end - begin) * (k + 0.5) / count
            if not self._box_free(at, (math.cos(angle), math.sin(angle)), *spans):
                return False
            untested += [span for span in ((first, k), (k + 1, last)) if span[0] < span[1]]
        return True

    def _is_walled(self, a: Point, b: Point) -> bool:
        """Return whether the disc inside the footprint meets the edges of the floor from a to b."""
        return not self._walls.clear(a, b)

    def _box_free(
        self, at: Point, direction: Point, along: tuple[float, float], across: tuple[float, float]
    ) -> bool:
        """Return whether a box is free, with spans along and across `direction` from `at`."""
        (x, y), (c, s) = at, direction
        ahead, aside = (along[0] + along[1]) / 2, (across[0] + across[1]) / 2
        length, width = along[1] - along[0], across[1] - across[0]
        middle = (x + ahead * c - aside * s, y + ahead * s + aside * c)
        self._side[0], self._side[1] = length, width
        self._box.side = self._side
        self._put(self._boxes, middle, math.atan2(s, c))
        reach_x = (abs(c) * length + abs(s) * width) / 2
        reach_y = (abs(s) * length + abs(c) * width) / 2
        return self.world.clear_of(
            self._boxes,
            (middle[0] - reach_x, middle[1] - reach_y, middle[0] + reach_x, middle[1] + reach_y),
        )

    def _put(self, shape: Any, at: Point, rotation: float) -> None:
        turn, middle = self._rotation, self._middle
        turn[0], turn[3] = math.cos(rotation / 2), math.sin(rotation / 2)
        middle[0], middle[1] = at
        shape.setQuatRotation(turn)
        shape.setTranslation(middle)

    def _extent(self, cosine: float, sine: float) -> tuple[Point, Point]:
        """Return minimum and maximum of the corners' coordinates on turned axes."""
        along = [x * cosine + y * sine for x, y in self._corners]
        across = [y * cosine - x * sine for x, y in self._corners]
        return (min(along), min(across)), (max(along), max(across))

    def _joined(self, states: Sequence[Pose]) -> list[Pose]:
        """Return the poses of OMPL's path as it is."""
        poses = [states[0]]
        for state in states[1:]:
            legs = self.between(poses[-1], state[:2], state[2])
            if legs is None:  # OMPL's rotation differs by a multiple of 2 π
                return [*poses, *states[states.index(state) :]]
            poses += legs
        return poses

    def seconds(self, poses: Sequence[Pose]) -> float:
        """Return the approximate duration of a path."""
        limits, total = self.limits, 0.0
        for one, other in itertools.pairwise(poses):
            length, turn = math.dist(one[:2], other[:2]), abs(other[2] - one[2])
            if length > 0:
                total += length / limits.speed + limits.speed / limits.acceleration
            if turn > 0:
                total += turn / limits.turn_speed + limits.turn_speed / limits.turn_acceleration
        return total

    def _require_passage(self, begin: Pose, to: Point) -> None:
        """Raise `PlanningError` if even the disc inside the footprint has no path."""
        if self._inner <= SLACK:
            return
        if not self.world.reaches((begin[0], begin[1]), to, self._inner):
            message = (
                f"the vehicle has no path from {_shown(begin)} to {_shown((*to,))}: not even a"
                f" disc of {self._inner:.3g} m, which its footprint contains, gets there"
            )
            raise PlanningError("unreachable", message)

    def _touched(self, pose: Pose) -> list[str]:
        """Return the names of the obstacles that the footprint touches in a pose."""
        x, y, rotation = pose
        there = affinity.translate(
            affinity.rotate(self.footprint, rotation, origin=(0, 0), use_radians=True), x, y
        )
        names = [name for name, shape in self.world.things() if shape.intersects(there)]
        return names if self.world.plan.boundary.covers(there) else ["the boundary", *names]

    def what_is_in_the_way(self, pose: Pose, where: str = "at") -> str:
        """Return a sentence about the obstacles that the footprint touches in a pose."""
        names = self._touched(pose)
        what = f"touches {', '.join(names)}" if names else "has no room"
        return f"the footprint {what} {where} {_shown(pose)}"


class _Chain:
    """Path from place to place, by turns on the spot and drives."""

    def __init__(
        self, planner: VehiclePlanner, begin: Pose, to: Point, rotation: float | None
    ) -> None:
        self._planner = planner
        self._begin = begin
        self._to = to
        self._rotation = rotation
        self._legs_between: dict[tuple[Pose, Point], list[Pose] | None] = {}

    def shortened(self, places: Sequence[Point]) -> list[Pose] | None:
        """Return the poses of the path without places that only delay it."""
        planner, left = self._planner, [*places]
        best = self._through(left)
        improved = True
        while improved:
            improved = False
            for k in range(len(left)):
                fewer = left[:k] + left[k + 1 :]
                poses = self._through(fewer)
                if poses is not None and (
                    best is None or planner.seconds(poses) < planner.seconds(best)
                ):
                    best, left, improved = poses, fewer, True
                    break
        return best

    def _through(self, places: Sequence[Point]) -> list[Pose] | None:
        """Return the poses of the path through the places, or None if not free."""
        poses = [self._begin]
        for place in places:
            legs = self._legs(poses[-1], place)
            if legs is None:
                return None
            poses += legs
        last = self._planner.between(poses[-1], self._to, self._rotation)
        return None if last is None else [*poses, *last]

    def _legs(self, pose: Pose, place: Point) -> list[Pose] | None:
        key = (pose, place)
        if key not in self._legs_between:
            self._legs_between[key] = self._planner.between(pose, place, None)
        return self._legs_between[key]


def footprint_fault(footprint: Polygon) -> str:
    """Return why a polygon cannot be a footprint of a vehicle, or an empty text."""
    if not isinstance(footprint, Polygon) or footprint.is_empty or not footprint.is_valid:
        return "must be a simple polygon"
    if footprint.interiors:
        return "must have no holes"
    if not footprint.contains(shapely.Point(0.0, 0.0)):
        return "must contain (0, 0), about which the vehicle turns"
    return ""


def _pose(pose: Sequence[float], end: str) -> Pose:
    values = np.asarray(pose, dtype=float)
    if values.shape != (3,) or not np.isfinite(values).all():
        raise UserError(f"the {end} must be a finite x, y and rotation, found {pose!r}")
    x, y, rotation = values.tolist()
    return (x, y, rotation)


def _distinct(poses: Sequence[Pose]) -> list[Pose]:
    """Return the poses without consecutive duplicates."""
    return [poses[0], *(b for a, b in itertools.pairwise(poses) if a != b)]


def _shown(pose: Sequence[float]) -> str:
    return f"({', '.join(f'{value:.3g}' for value in pose)})"
