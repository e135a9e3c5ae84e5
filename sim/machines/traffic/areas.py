"""Areas that a machine sweeps: unions of convex polygons that always contain its footprint."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property, lru_cache

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import Polygon

from navigation import Motion
from navigation.kernels.areas import TURN, Polygons, end_of_part, is_on_line, poses_along, swept
from navigation.kernels.numbers import numbers, numbers_of
from navigation.motion import Table

from ...core.body import Machine, MachineShape
from ...core.entries import Pose

CLEAR = 0.01
"""Metres. Distance of a machine from the border of its claim."""

BETWEEN_STOPS = 0.2
"""Seconds between stops from a part, if these leave the line of the motion."""

_ROUNDING = 1e-6
"""Metres. Tolerance of the reach of a footprint."""

Bounds = tuple[float, float, float, float]
"""Minimum x and y, maximum x and y, metres."""


class Area:
    """Union of convex polygons, which `draw` returns when they are needed.

    Most areas are far from each other, so that a rectangle `around` is sufficient. By default it
    has the bounds of the polygons.
    """

    def __init__(self, draw: Callable[[], list[Table]], around: Bounds | None = None) -> None:
        self._draw = draw
        self._around = around

    @classmethod
    def of(cls, areas: Sequence[Area]) -> Area:
        """Return the union of areas."""
        return cls(lambda: [part for area in areas for part in area._polygons.polygons])

    @cached_property
    def _polygons(self) -> Polygons:
        return Polygons(self._draw())

    @cached_property
    def parts(self) -> NDArray[np.object_]:
        """The polygons as an array."""
        rings = [np.array(corners).reshape(-1, 2) for corners in self._polygons.polygons]
        return np.array([Polygon(ring) for ring in rings])

    @cached_property
    def bounds(self) -> Bounds:
        """Bounds of the polygons."""
        return self._polygons.extent()

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
        a, b = self._around or self.bounds, other._around or other.bounds
        if a[0] > b[2] or b[0] > a[2] or a[1] > b[3] or b[1] > a[3]:
            return False
        return self._polygons.meet(other._polygons)


class Footprint:
    """Convex hull of a footprint, enlarged by `clear` metres, and the areas that it sweeps."""

    def __init__(self, shape: MachineShape, clear: float) -> None:
        corners, self.reach = _corners(shape, clear)
        self._corners = numbers_of(corners)
        self._wider = numbers_of(corners / math.cos(TURN / 2))
        self._is_around_axis = bool(shapely.Polygon(corners).contains(shapely.Point(0, 0)))

    def at(self, pose: Pose) -> Area:
        """Return the area that is covered in a pose."""
        return self.along([numbers(pose)])

    def swept(self, motion: Motion, begin: float, end: float) -> Area:
        """Return the area that is swept on a motion from `begin` to `end` (s)."""
        return self.along([poses_along(motion.table, begin, end)])

    def along(self, courses: Sequence[Table]) -> Area:
        """Return the area that is swept along courses, such as those of a `Part`."""
        return Area(lambda: self.polygons_along(courses))

    def polygons_along(self, courses: Sequence[Table]) -> list[Table]:
        """Return the corners of the polygons of `along`."""
        return [
            polygon
            for poses in courses
            for polygon in swept(poses, self._corners, self._wider, self._is_around_axis)
        ]


@lru_cache(maxsize=256)
def footprint_of(shape: MachineShape, clear: float) -> Footprint:
    """Return the footprint of machines of a shape, which they share."""
    return Footprint(shape, clear)


def _corners(shape: MachineShape, clear: float) -> tuple[NDArray[np.float64], float]:
    """Return the corners of the hull of a footprint, enlarged by `clear` metres, and its reach."""
    outline = shapely.convex_hull(shape.footprint((0.0, 0.0), 0.0))
    larger = shapely.buffer(outline, clear, join_style="mitre")
    corners = shapely.get_coordinates(larger)[:-1]
    return corners, float(np.hypot(*corners.T).max()) / math.cos(TURN / 2) + _ROUNDING


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
    return footprint_of(shape, CLEAR).along(
        [numbers(c for x, y in shape.course for c in (x, y, heading))]
    )


class Part:
    """Next part of a motion, which begins now (s) and takes approximately `seconds`.

    It ends where the machine comes to rest, if that is early enough.

    Attributes
    ----------
    end : float
        End of the part (s).
    """

    def __init__(self, machine: Machine, motion: Motion, now: float, seconds: float) -> None:
        self.end = end_of_part(motion.table, now, seconds)
        self._machine = machine
        self._motion = motion
        self._now = now
        self._course = poses_along(motion.table, now, self.end)

    @property
    def begin(self) -> Pose:
        """First pose."""
        x, y, rotation = self._course[:3]
        return x, y, rotation

    @cached_property
    def courses(self) -> list[Table]:
        """Poses on the part, and on every stop from it."""
        now, end = self._now, self.end
        if is_on_line(self._course):
            stops = [self._stop(t) for t in (end, (now + end) / 2)]
            if all(map(is_on_line, stops)):
                return [self._course, *stops]
        count = math.ceil((end - now) / BETWEEN_STOPS)
        stops = [self._stop(now + (end - now) * k / count) for k in range(count + 1)]
        ends = numbers(c for stop in stops for c in stop[-3:])  # contains those of all other stops
        return [self._course, ends, *stops]

    def _stop(self, t: float) -> Table:
        """Return the poses of a stop. If it is unknown, this is its first pose."""
        state = self._motion.state(t)
        stop = self._machine.stopping(state, t)
        return numbers(state.position) if stop is None else poses_along(stop.table, t, stop.end)

    @cached_property
    def _around(self) -> Bounds:
        """Bounds of all poses. Stops lead ahead on a line, and anywhere near on a curve."""
        x, y, rotation = self._course[::3], self._course[1::3], self._course[2::3]
        away, dx, dy = self._machine.stopping_distance, x[-1] - x[0], y[-1] - y[0]
        _, (vx, vy, turning), (ax, ay, spin) = self._motion.state(self.end)
        low, high = (-away, -away), (away, away)
        if (
            is_on_line(self._course)
            and (rotation[0] == rotation[-1] or dx == dy == 0.0)
            and not (turning or spin)
            and abs(ax * vy - ay * vx) <= _ROUNDING
        ):
            length = max(math.hypot(dx, dy), _ROUNDING)
            ahead, aside = dx * away / length, dy * away / length
            low, high = (min(ahead, 0.0), min(aside, 0.0)), (max(ahead, 0.0), max(aside, 0.0))
        return min(x) + low[0], min(y) + low[1], max(x) + high[0], max(y) + high[1]

    def area(self, footprint: Footprint) -> Area:
        """Return the area that a footprint sweeps on the part and on every stop from it."""
        low_x, low_y, high_x, high_y = self._around
        r = footprint.reach
        around = low_x - r, low_y - r, high_x + r, high_y + r
        return Area(lambda: footprint.polygons_along(self.courses), around)
