"""Zones that limit the speed of people."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise

import shapely

from floorplan import Point, Zone

from ...core.speed_zones import SLIGHT, Stretch, parts_between, slow_areas


class SpeedZones:
    """Speed limits of one person, by the position of their centre."""

    def __init__(self, zones: Iterable[Zone], name: str) -> None:
        self._zones = [(area, area.bounds, limit) for area, limit in slow_areas(zones, name)]

    def __bool__(self) -> bool:
        return bool(self._zones)

    def along(
        self, course: Sequence[Point], top_speed: float
    ) -> tuple[list[Point], float | list[float]]:
        """Return `course` with the points at which limits change, and the speed of each segment.

        The speed is a single `top_speed` (m/s) if the course is clear of all zones.
        """
        if not self._zones:
            return [*course], top_speed
        points, speeds = [course[0]], []
        for a, b in pairwise(course):
            for until, speed in self._parts(a, b, top_speed):
                points.append(until)
                speeds.append(speed)
        if all(speed == top_speed for speed in speeds):
            return [*course], top_speed
        return points, speeds

    def _parts(self, a: Point, b: Point, top_speed: float) -> list[tuple[Point, float]]:
        """Return the end and the limit of each part of a segment."""
        length = math.dist(a, b)
        if length < SLIGHT:
            return [(b, top_speed)]
        parts = []
        for _, end, limit in parts_between(0.0, length, top_speed, self._slow(a, b)):
            share = end / length
            at = (a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]))
            parts.append((b if end == length else at, limit))
        return parts

    def _slow(self, a: Point, b: Point) -> Iterator[Stretch]:
        """Yield the parts of a segment in zones (m from a)."""
        for area, (low_x, low_y, high_x, high_y), limit in self._zones:
            if (
                max(a[0], b[0]) < low_x
                or min(a[0], b[0]) > high_x
                or max(a[1], b[1]) < low_y
                or min(a[1], b[1]) > high_y
            ):
                continue
            shared = shapely.intersection(area, shapely.linestrings([a, b]))
            for piece in shapely.get_parts(shared):
                ends = [math.dist(a, at) for at in shapely.get_coordinates(piece).tolist()]
                # A segment that touches a corner shares an empty part with the zone.
                if ends and max(ends) - min(ends) > SLIGHT:
                    yield Stretch(min(ends), max(ends), limit)
