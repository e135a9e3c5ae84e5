"""The paths of one question over each other, as SVG in the page's own colours."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from floorplan import Floorplan, Point
from navigation.benchmark import Attempt

from .charts import Look


@dataclass(frozen=True)
class Line:
    """A planner's path, as an attribute of SVG."""

    planner: str
    points: str
    look: Look
    words: str


@dataclass(frozen=True)
class Picture:
    """A floor with the paths of one question; y points down, as in SVG."""

    query: int
    view: str
    walls: str
    blocks: str
    agvs: str
    start: Point
    goal: Point
    lines: tuple[Line, ...]
    unit: float
    """Metres. A length that looks the same on every floor."""


def picture(plan: Floorplan, attempts: Sequence[Attempt], styles: dict[str, Look]) -> Picture:
    """Return the first answers of `attempts`, all to one question, on `plan`."""
    asked = attempts[0].asked
    west, south, east, north = plan.boundary.bounds
    extent = max(east - west, north - south)
    margin = 0.02 * extent
    standing = [o.footprint for o in plan.obstacles if o.overlaps(0.0, plan.human.height)]
    lanes = [plan.lane(name).footprint(at) for name, at in asked.agvs]
    return Picture(
        query=asked.query,
        view=_numbers(
            west - margin, -north - margin, east - west + 2 * margin, north - south + 2 * margin
        ),
        walls=_outlines([plan.boundary]),
        blocks=_outlines(standing),
        agvs=_outlines(lanes),
        start=(asked.start[0], -asked.start[1]),
        goal=(asked.goal[0], -asked.goal[1]),
        lines=tuple(_lines(attempts, styles)),
        unit=extent / 100,
    )


def telling(attempts: Sequence[Attempt]) -> int:
    """Return the question whose paths differ most in length; of those alike the longest."""
    found: dict[int, list[float]] = {}
    for attempt in attempts:
        if attempt.solved and attempt.asked.run == 0:
            found.setdefault(attempt.asked.query, []).append(attempt.length)

    def spread(query: int) -> tuple[float, float]:
        lengths = found[query]
        return (round(max(lengths) - min(lengths), 2), max(lengths))

    return max(found, key=spread, default=attempts[0].asked.query)


def _lines(attempts: Sequence[Attempt], styles: dict[str, Look]) -> Iterator[Line]:
    for attempt in attempts:
        name = attempt.asked.planner
        if attempt.points is None:
            yield Line(name, "", styles[name], attempt.reason.replace("_", " ") or "no path")
            continue
        words = f"{attempt.length:.2f} m"
        if math.isfinite(attempt.ratio):
            longer = round(100 * (attempt.ratio - 1), 2) + 0.0  # and no -0.00
            words += f", {longer:+.2f} %"
        if attempt.wrong:
            words += f", {attempt.wrong}"
        corners = " ".join(_numbers(x, -y, between=",") for x, y in attempt.points.tolist())
        yield Line(name, corners, styles[name], words)


def _outlines(areas: Sequence[shapely.Polygon]) -> str:
    """Return the rings of all areas as the data of one path."""
    rings = [ring for area in areas for ring in (area.exterior, *area.interiors)]
    return "".join(f"M{_corners(ring)}Z" for ring in rings)


def _corners(ring: shapely.LinearRing) -> str:
    points = shapely.get_coordinates(ring)[:-1] * np.array([1.0, -1.0])
    return "L".join(_numbers(x, y) for x, y in points.tolist())


def _numbers(*values: float, between: str = " ") -> str:
    return between.join(f"{value:.3f}".rstrip("0").rstrip(".") for value in values)
