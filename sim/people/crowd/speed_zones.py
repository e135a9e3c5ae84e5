"""Zones in which somebody walks no faster than a speed."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise

import shapely

from floorplan import Point, Zone

SLIGHT = 1e-6
"""Metres. Shorter parts of a course count as nothing."""


class SpeedZones:
    """The speed limits of one person; what counts is where their centre is."""

    def __init__(self, zones: Iterable[Zone], name: str) -> None:
        mine = [zone for zone in zones if zone.max_speed is not None and zone.is_about(name)]
        self._zones = [(zone.area, zone.area.bounds, zone.max_speed) for zone in mine]

    def __bool__(self) -> bool:
        return bool(self._zones)

    def along(
        self, course: Sequence[Point], top_speed: float
    ) -> tuple[list[Point], float | list[float]]:
        """Return `course` with the points at which limits change, and the top speed of each leg.

        Only `top_speed` (m/s) where the course is clear of all zones.
        """
        points, speeds = [course[0]], []
        for a, b in pairwise(course):
            for until, speed in self._parts(a, b, top_speed):
                points.append(until)
                speeds.append(speed)
        if all(speed == top_speed for speed in speeds):
            return [*course], top_speed
        return points, speeds

    def _parts(self, a: Point, b: Point, top_speed: float) -> list[tuple[Point, float]]:
        """Return the ends of the parts of a leg that have one limit each, and that limit."""
        length = math.dist(a, b)
        inside: list[tuple[float, float, float]] = []
        for area, (low_x, low_y, high_x, high_y), limit in self._zones:
            assert limit is not None
            if (
                max(a[0], b[0]) < low_x
                or min(a[0], b[0]) > high_x
                or max(a[1], b[1]) < low_y
                or min(a[1], b[1]) > high_y
                or limit >= top_speed
                or length < SLIGHT
            ):
                continue
            shared = shapely.intersection(area, shapely.linestrings([a, b]))
            for piece in shapely.get_parts(shared):
                ends = [math.dist(a, at) for at in shapely.get_coordinates(piece).tolist()]
                # Past a corner of the zone the two share one part, which is empty.
                if ends and max(ends) - min(ends) > SLIGHT:
                    inside.append((min(ends), max(ends), limit))
        cuts = {e for low, high, _ in inside for e in (low, high)}
        # Between two cuts the limit is that of all zones around the middle.
        cuts = {e for e in cuts if SLIGHT < e < length - SLIGHT}
        parts = []
        for begin, end in pairwise([0.0, *sorted(cuts), length]):
            middle = (begin + end) / 2
            limits = [limit for low, high, limit in inside if low <= middle <= high]
            share = end / length if length else 0.0
            at = (a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]))
            parts.append((b if end == length else at, min([top_speed, *limits])))
        return parts
