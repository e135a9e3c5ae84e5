"""Areas that a machine sweeps: unions of convex polygons that always contain its footprint.

A polygon contains the footprint in every pose between two samples. On a straight line, it is the
hull of both ends. On a curve, samples are at most `TURN` apart, and corners are farther away by the
factor 1 / cos(`TURN` / 2), so that the chords between them contain their arcs. A turn on the spot
covers the footprint at both of its ends, and the sectors of the corners between them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property, lru_cache

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import Polygon

from floorplan.files.dataclass import dataclass
from navigation import Motion, Piece
from navigation.motion import value

from ...core.body import Machine, MachineShape
from ...core.entries import Pose

CLEAR = 0.01
"""Metres. Distance of a machine from the border of its claim."""

TURN = 0.1
"""Radians. Longest step between samples of a turn."""

STEP = 0.1
"""Seconds. Longest step between samples of a curve."""

_GROUP = 0.25
"""Radians, and metres. Samples of a curve within this distance share a polygon."""

_SECTOR = 3.0
"""Radians. Longest part of a turn on the spot, so that the sectors of corners are convex."""

_STRAIGHT = 1e-6
"""Metres. Tolerance of straight lines."""


BETWEEN_STOPS = 0.2
"""Seconds between stops from a part, if these leave the line of the motion."""

RESTS = 1e-6
"""m/s and rad/s. Slower machines are at rest."""

Bounds = tuple[float, float, float, float]
"""Minimum x and y, maximum x and y, metres."""


class Area:
    """Union of convex polygons, which `draw` returns when they are needed.

    Most areas are far from each other, so that the rectangle `around` is sufficient.
    """

    def __init__(self, around: Bounds, draw: Callable[[], NDArray[np.object_]]) -> None:
        self._around = around
        self._draw = draw

    @classmethod
    def of(cls, areas: Sequence[Area]) -> Area:
        """Return the union of areas."""
        x, y, most_x, most_y = zip(*(area._around for area in areas), strict=True)
        around = min(x), min(y), max(most_x), max(most_y)
        return cls(around, lambda: np.concatenate([area.parts for area in areas]))

    @cached_property
    def parts(self) -> NDArray[np.object_]:
        """The polygons as an array."""
        return self._draw()

    @cached_property
    def bounds(self) -> Bounds:
        """Bounds of the polygons."""
        x, y, most_x, most_y = shapely.total_bounds(self.parts).tolist()
        return x, y, most_x, most_y

    @property
    def polygons(self) -> list[Polygon]:
        """The polygons."""
        return [*self.parts]

    def gap(self, other: Area) -> float:
        """Return the distance between the bounds of both areas (m)."""
        a, b = self.bounds, other.bounds
        x, y = max(a[0] - b[2], b[0] - a[2], 0.0), max(a[1] - b[3], b[1] - a[3], 0.0)
        return math.hypot(x, y)

    def distance(self, other: Area) -> float:
        """Return the distance between both areas (m)."""
        return float(shapely.distance(self.parts[:, None], other.parts).min())

    def meets(self, other: Area) -> bool:
        """Return whether both areas have a common point."""
        if _apart(self._around, other._around) or _apart(self.bounds, other.bounds):
            return False
        return bool(shapely.intersects(self.parts[:, None], other.parts).any())


def _apart(a: Bounds, b: Bounds) -> bool:
    return a[0] > b[2] or b[0] > a[2] or a[1] > b[3] or b[1] > a[3]


class Footprint:
    """Convex hull of a footprint, enlarged by `clear` metres, and the areas that it sweeps."""

    def __init__(self, shape: MachineShape, clear: float) -> None:
        self._corners, self._reach = _corners(shape, clear)
        self._is_around_axis = bool(shapely.Polygon(self._corners).contains(shapely.Point(0, 0)))

    def at(self, pose: Pose) -> Area:
        """Return the area that is covered in a pose."""
        return self.along([pose])

    def swept(self, motion: Motion, begin: float, end: float) -> Area:
        """Return the area that is swept on a motion from `begin` to `end` (s)."""
        return self.along(poses_on(motion, begin, end))

    def along(self, poses: Sequence[Pose]) -> Area:
        """Return the area that is swept along poses, such as those of `poses_on`."""
        x, y, _ = zip(*poses, strict=True)
        reach = self._reach
        around = min(x) - reach, min(y) - reach, max(x) + reach, max(y) + reach
        return Area(around, lambda: np.array(self._hulls(poses)))

    def _hulls(self, poses: Sequence[Pose]) -> list[Polygon]:
        at = np.array(poses)
        c, s = np.cos(at[:, 2:]), np.sin(at[:, 2:])
        x = c * self._corners[:, 0] - s * self._corners[:, 1]
        y = s * self._corners[:, 0] + c * self._corners[:, 1]
        place, corners = at[:, None, :2], np.stack([x, y], axis=-1)
        covered, wider = place + corners, place + corners / math.cos(TURN / 2)
        hulls: list[NDArray[np.float64]] = []
        first = 0
        while not hulls or first < len(poses) - 1:
            last = first + 1
            shared = self._shared(poses, first)
            while last + 1 < len(poses) and shared(poses, first, last + 1):
                last += 1
            span = slice(first, last + 1)
            if shared is _share_a_place:
                turned = at[span, 2]
                hulls += [covered[first + turned.argmin()], covered[first + turned.argmax()]]
                hulls += [np.vstack([place[first], one]) for one in wider[span].swapaxes(0, 1)]
            else:
                hulls.append((covered if shared is _share_a_line else wider)[span].reshape(-1, 2))
            first = last
        of = np.repeat(np.arange(len(hulls)), [len(points) for points in hulls])
        return [*shapely.convex_hull(shapely.multipoints(np.concatenate(hulls), indices=of))]

    def _shared(self, poses: Sequence[Pose], first: int) -> Callable[..., bool]:
        """Return the condition for poses from `first` on that share polygons."""
        if len(poses) == 1 or poses[first][2] == poses[first + 1][2]:
            return _share_a_line
        if self._is_around_axis and _share_a_place(poses, first, first + 1):
            return _share_a_place
        return _are_near


@lru_cache(maxsize=256)
def footprint_of(shape: MachineShape, clear: float) -> Footprint:
    """Return the footprint of machines of a shape, which they share."""
    return Footprint(shape, clear)


def _corners(shape: MachineShape, clear: float) -> tuple[NDArray[np.float64], float]:
    """Return the corners of the hull of a footprint, enlarged by `clear` metres, and its reach."""
    outline = shapely.convex_hull(shape.footprint((0.0, 0.0), 0.0))
    larger = shapely.buffer(outline, clear, join_style="mitre")
    corners = shapely.get_coordinates(larger)[:-1]
    return corners, float(np.hypot(*corners.T).max()) / math.cos(TURN / 2) + _STRAIGHT


@lru_cache(maxsize=4096)
def may_meet(one: MachineShape, other: MachineShape) -> bool:
    """Return whether two machines have common heights, and their lanes meet if they have any."""
    if not one.box.is_level_with(other.box):
        return False
    mine, theirs = _lane(one), _lane(other)
    return mine is None or theirs is None or mine.meets(theirs)


def _lane(shape: MachineShape) -> Area | None:
    """Return the area of the straight lane of a machine, or None if it has none."""
    if shape.direction is None or len(shape.course) != 2:
        return None
    heading = math.atan2(shape.direction[1], shape.direction[0])
    return footprint_of(shape, CLEAR).along([(x, y, heading) for x, y in shape.course])


def poses_on(motion: Motion, begin: float, end: float) -> list[Pose]:
    """Return poses along a motion: ends of pieces, and samples of curves and turns."""
    poses = [motion.state(begin).position]
    for piece in motion.pieces_from(begin, end):
        a, b = max(piece.begin, begin), min(piece.end, end)
        if a >= b:
            continue
        count = 1 if _is_line(piece) else _steps(piece, b - a)
        for k in range(1, count + 1):
            u = a + (b - a) * k / count - piece.begin
            poses.append((value(piece.x, u), value(piece.y, u), value(piece.rotation, u)))
    return poses


def is_straight(poses: Sequence[Pose]) -> bool:
    """Return whether poses are on a line, or a turn on the spot."""
    return len(poses) < 3 or _share_a_line(poses, 0, len(poses) - 1) or _same_place(poses)


def _is_line(piece: Piece) -> bool:
    """Return whether a piece is a part of a line without a reversal."""
    if any(piece.rotation[1:]):
        return False
    (_, vx, ax, jx), (_, vy, ay, jy) = piece.x, piece.y
    u = piece.end - piece.begin
    across = (vx * ay - vy * ax) * u**3, (vx * jy - vy * jx) * u**4, (ax * jy - ay * jx) * u**5
    if max(map(abs, across)) > _STRAIGHT**2:
        return False
    wx, wy = (v + u * (2 * a + u * 3 * j) for v, a, j in ((vx, ax, jx), (vy, ay, jy)))
    return vx * wx + vy * wy >= -_STRAIGHT


def _steps(piece: Piece, seconds: float) -> int:
    _, v, a, j = piece.rotation
    u = piece.end - piece.begin
    turned = abs(v) * u + abs(a) * u**2 + abs(j) * u**3
    steps = math.ceil(turned * seconds / max(u, 1e-9) / TURN)
    return max(1, steps, math.ceil(seconds / STEP) if piece.moves else 1)


def _are_near(poses: Sequence[Pose], first: int, last: int) -> bool:
    (ax, ay, turned), (bx, by, turning) = poses[first], poses[last]
    return abs(bx - ax) + abs(by - ay) < _GROUP and abs(turning - turned) < _GROUP


def _share_a_place(poses: Sequence[Pose], first: int, last: int) -> bool:
    """Return whether poses are a turn on the spot by less than `_SECTOR`."""
    turns = [pose[2] for pose in poses[first : last + 1]]
    return _same_place(poses[first : last + 1]) and max(turns) - min(turns) < _SECTOR


def _share_a_line(poses: Sequence[Pose], first: int, last: int) -> bool:
    """Return whether poses have one rotation and lie on a line."""
    (ax, ay, rotation), (bx, by, _) = poses[first], poses[last]
    length = math.dist((ax, ay), (bx, by))
    return all(
        pose[2] == rotation
        and abs((bx - ax) * (pose[1] - ay) - (by - ay) * (pose[0] - ax)) <= _STRAIGHT * length
        for pose in poses[first : last + 1]
    )


def _same_place(poses: Sequence[Pose]) -> bool:
    x, y, _ = poses[0]
    return all(abs(pose[0] - x) + abs(pose[1] - y) < _STRAIGHT for pose in poses)


@dataclass(frozen=True, kw_only=True)
class Part:
    """Next part of a motion: its end (s), and the poses on it and on every stop from it."""

    end: float
    courses: list[list[Pose]]

    @classmethod
    def of(cls, machine: Machine, motion: Motion, now: float, seconds: float) -> Part:
        """Return the part of a motion that begins now (s) and takes approximately `seconds`.

        It ends where the machine comes to rest, if that is early enough.
        """
        end = _end_of_part(motion, now, seconds)
        courses = [poses_on(motion, now, end)]
        stops = []
        if straight := is_straight(courses[0]):
            stops = [_stop(machine, motion, t) for t in (end, (now + end) / 2)]
            straight = all(map(is_straight, stops))
        if not straight:
            count = math.ceil((end - now) / BETWEEN_STOPS)
            stops = [
                _stop(machine, motion, now + (end - now) * k / count) for k in range(count + 1)
            ]
            courses.append([stop[-1] for stop in stops])  # contains the ends of all other stops
        return cls(end=end, courses=[*courses, *stops])


def _stop(machine: Machine, motion: Motion, t: float) -> list[Pose]:
    """Return the poses of a stop. If it is unknown, this is its first pose."""
    state = motion.state(t)
    stop = machine.stopping(state, t)
    return [state.position] if stop is None else poses_on(stop, t, stop.end)


def _end_of_part(motion: Motion, now: float, seconds: float) -> float:
    """Return the end of the part: at rest, or after a time (s)."""
    for piece in motion.pieces_from(now):
        if piece.end > now + 1.5 * seconds:
            break
        if piece.end > now and max(map(abs, motion.state_before(piece.end).velocity)) < RESTS:
            return piece.end
    return min(now + seconds, motion.end)
