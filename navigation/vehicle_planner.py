"""Paths of vehicles with a footprint: guided by the roadmaps of discs, otherwise OMPL's in SE(2).

A path consists of straight drives and turns on the spot. A drive covers a box that encloses the
swept area. A turn is free if the disc around it is, or otherwise if larger boxes at intermediate
angles are. The searches test edges in the plane, and FCL tests the boxes of the resulting path.

Most vehicles turn in open places and pass narrow ones straight. So the shortest path of a disc that
is little wider than the vehicle guides the search. Its bends move to the nearest places where the
vehicle can turn. If that fails, RRT-Connect searches in SE(2).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence

import fcl
import numpy as np
import ompl.util as ou
import shapely
from numpy.typing import NDArray
from shapely import affinity
from shapely.geometry import Polygon
from shapely.geometry.polygon import orient

from floorplan import Point, UserError
from floorplan.files.dataclass import dataclass

from .bodies import CollisionBody
from .catalog import PlanningError
from .kernels.edges import Room
from .kernels.footprints import FootprintRoom
from .kernels.numbers import numbers_of
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
        corners = shapely.get_coordinates(footprint)[:-1]
        outer = float(np.hypot(*corners.T).max())
        half_turned = affinity.scale(footprint, -1.0, -1.0, origin=(0.0, 0.0))
        self._inner = float(footprint.exterior.distance(shapely.Point(0.0, 0.0)))
        self._room = FootprintRoom(
            numbers_of(corners),
            [numbers_of(part) for part in _convex_parts(footprint)],
            outer,
            SLACK,
            _SAG,
            self.limits.holonomic,
            not self.limits.holonomic and half_turned.equals(footprint),
        )
        self._bodies: Sequence[CollisionBody] | None = None
        self._turning: Room
        self._box = fcl.Box(1.0, 1.0, _THICK)
        self._boxes = fcl.CollisionObject(self._box, fcl.Transform())
        self._side = np.array([1.0, 1.0, _THICK])
        self._middle, self._rotation = np.zeros(3), np.zeros(4)
        narrow = min(float(np.ptp(corners[:, 1])) / 2 + _ROOM, outer)
        self._guides = [
            PathPlanner(world, radius) for radius in dict.fromkeys((narrow, outer + 2 * SLACK))
        ]
        self._outer = outer

    @property
    def room(self) -> FootprintRoom:
        """Room for the vehicle among the present bodies."""
        bodies = self.world.bodies
        if bodies is not self._bodies:
            self._bodies, walls, gates = bodies, self.world.walls, self.world.gates.lines
            outlines = [body.outline for body in bodies]
            self._room.room = Room(walls, 0.0, outlines, gates)
            self._room.disc = Room(walls, self._outer + SLACK, outlines, gates)
            self._turning = Room(walls, self._outer + 2 * SLACK, outlines, gates)
        return self._room

    def fits(self, pose: Sequence[float]) -> bool:
        """Return whether the vehicle touches nothing in a pose (x, y, rotation)."""
        x, y, rotation = map(float, pose)
        return self.room.fits(x, y, rotation)

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
        path = None if poses is None else _distinct(poses)
        if path is None or not self.free_along(path):
            message = (
                f"no path was found for the footprint from {_shown(begin)} to {_shown((*to,))}"
            )
            raise PlanningError("not_found", message)
        return VehiclePath(poses=np.array(path))

    def free_along(self, poses: Sequence[Sequence[float]]) -> bool:
        """Return whether the vehicle touches nothing on a path through `poses`."""
        return all(itertools.starmap(self._is_free, itertools.pairwise(poses)))

    def _is_free(self, one: Sequence[float], other: Sequence[float]) -> bool:
        """Return whether a drive or turn is free, by FCL."""
        (ax, ay, begin), (bx, by, end) = one, other
        if (ax, ay) != (bx, by):
            box = self._room.drive_box(ax, ay, bx, by, begin)
            return self.world.gates.allow((ax, ay), (bx, by)) and self._box_free(box)
        if self.world.free((ax, ay), self._outer + SLACK):
            return True
        angles = self._room.turn_angles(begin, end)
        return all(self._box_free(self._room.turn_box(ax, ay, angle)) for angle in angles)

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
        (x, y, rotation), room = pose, self.room
        if self._turning.holds(x, y):
            return
        c, s = math.cos(rotation), math.sin(rotation)
        for k in range(1, math.ceil(2 * self._outer / _BIT) + 1):
            for away in (k * _BIT, -k * _BIT):
                there = (x + away * c, y + away * s)
                if self._turning.holds(*there) and room.drive_free(x, y, *there, rotation):
                    yield (*there, rotation)
                    return

    def _room_to_turn(self, at: Point) -> Point | None:
        """Return the place nearest to `at` where the vehicle can turn completely."""
        if self._turning.holds(*at):
            return at
        return self.world.nearest_free(at, self._outer + 2 * SLACK)

    def _sampled(
        self, begin: Pose, to: Point, ends: Sequence[Pose], end: Pose | None
    ) -> list[Pose] | None:
        """Return the path of RRT-Connect within its budget."""
        low_x, low_y, high_x, high_y = self.world.plan.boundary.bounds
        room = self.room
        for k, target in enumerate(ends[:_TRIED]):
            with no_log():
                ou.RNG.setSeed(self.seed + k + 1)
                search = PoseSearch(
                    (low_x, low_y),
                    (high_x, high_y),
                    lambda one, other: room.between(one, other[:2], other[2]) is not None,
                    lambda pose: room.fits(*pose),
                )
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

    def between(self, one: Pose, to: Point, rotation: float | None) -> list[Pose] | None:
        """Return the poses of turn, drive and turn from one pose on, or None if not free."""
        return self.room.between(one, to, math.nan if rotation is None else rotation)

    def _box_free(self, corners: Sequence[float]) -> bool:
        """Return whether a box touches nothing, by FCL."""
        (ax, ay), (bx, by), (cx, cy), (dx, dy) = zip(*[iter(corners)] * 2, strict=True)
        self._side[0], self._side[1] = math.dist((ax, ay), (bx, by)), math.dist((bx, by), (cx, cy))
        self._box.side = self._side
        half = math.atan2(by - ay, bx - ax) / 2
        self._rotation[0], self._rotation[3] = math.cos(half), math.sin(half)
        self._middle[0], self._middle[1] = (ax + cx) / 2, (ay + cy) / 2
        self._boxes.setQuatRotation(self._rotation)
        self._boxes.setTranslation(self._middle)
        x, y = (ax, bx, cx, dx), (ay, by, cy, dy)
        return self.world.clear_of(self._boxes, (min(x), min(y), max(x), max(y)))

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


def _convex_parts(footprint: Polygon) -> list[NDArray[np.float64]]:
    """Return the corners of convex parts of a footprint, counterclockwise."""
    is_convex = footprint.convex_hull.area - footprint.area < 1e-12
    triangles = [*shapely.constrained_delaunay_triangles(footprint).geoms]
    parts = [footprint.convex_hull] if is_convex else triangles
    return [shapely.get_coordinates(orient(part))[:-1] for part in parts]


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
