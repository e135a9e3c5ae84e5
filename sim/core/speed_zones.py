"""Speed limits of zones along a course: its parts with their top speeds."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import shapely

from floorplan import Point, Zone

SLIGHT = 1e-6
"""Metres. Shorter parts of a course do not count."""


class Stretch(NamedTuple):
    """Stretch of a course: its begin and end (m), and the top speed there (m/s)."""

    begin: float
    end: float
    top_speed: float


def slow_areas(zones: Iterable[Zone], name: str) -> list[tuple[shapely.Polygon, float]]:
    """Return the areas that limit the speed of a person or machine, and the limits (m/s)."""
    return [
        (zone.area, zone.max_speed)
        for zone in zones
        if zone.max_speed is not None and zone.is_about(name)
    ]


def parts_between(
    low: float, high: float, top_speed: float, slow: Iterable[Stretch]
) -> list[Stretch]:
    """Return the parts of a course from `low` to `high` (m), in order, each with one top speed.

    Where parts of `slow` overlap, the lowest limit holds.
    """
    limits = [one for one in slow if one.top_speed < top_speed]
    cuts = {q for one in limits for q in one[:2] if low + SLIGHT < q < high - SLIGHT}
    parts: list[Stretch] = []
    for begin, end in pairwise([low, *sorted(cuts), high]):
        middle = (begin + end) / 2
        there = [one.top_speed for one in limits if one.begin <= middle <= one.end]
        top = min([top_speed, *there])
        last = parts[-1] if parts else None
        if last is not None and (last.top_speed == top or end - begin < SLIGHT):
            parts[-1] = Stretch(last.begin, end, min(top, last.top_speed))
        else:
            parts.append(Stretch(begin, end, top))
    return parts


def extent(
    area: shapely.Geometry, swept: shapely.Polygon, origin: Point, direction: Point
) -> tuple[float, float] | None:
    """Return the first and last metre that a swept area shares with another, or None.

    They are measured from `origin` in a direction.
    """
    shared = shapely.intersection(area, swept)
    if shared.area <= SLIGHT**2:
        return None
    along = (shapely.get_coordinates(shared) - origin) @ np.array(direction)
    return float(along.min()), float(along.max())
