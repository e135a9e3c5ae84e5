"""The names on a floor, where they cover nothing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from shapely.geometry import LineString, Polygon, box
from shapely.geometry import Point as Spot

from floorplan import Floorplan, Lane, Point

from .curves import Array
from .style import BLACK, GREEN, obstacle_shade

_DARK = 0.6
"""Names on what is darker than this are white."""

_PLACE_SIZE = 6
"""Points. The letters of a station's name."""

_INSIDE_SIZE = 5.0
"""Points. The letters of the name of an obstacle or an AGV."""

_LETTER_WIDTH = 0.58
"""A letter's width, as a share of its height."""

_MARK = 3.5
"""Points. The radius of the mark of a station or of the safe zone."""

_LANE, _WAY = 0.3, 1.5
"""Points. As how wide the line of a lane, and that of a way, count: one can read across them."""

_UPRIGHT = 0.05
"""An upright name is worse than one of which less than this share covers something."""


class _Side(NamedTuple):
    """Where a name stands beside its mark: how far off (points), aligned how, upright or not."""

    x: float
    y: float
    aligned: str
    upon: str
    upright: bool = False


_SIDES = (
    _Side(0, 4, "center", "bottom"),
    _Side(0, -4, "center", "top"),
    _Side(5, 0, "left", "center"),
    _Side(-5, 0, "right", "center"),
    _Side(3, 3, "left", "bottom"),
    _Side(3, -3, "left", "top"),
    _Side(-3, -3, "right", "top"),
    _Side(-3, 3, "right", "bottom"),
    _Side(0, 5, "center", "bottom", upright=True),
    _Side(0, -5, "center", "top", upright=True),
    _Side(5, 0, "left", "center", upright=True),
    _Side(-5, 0, "right", "center", upright=True),
)
"""The places for a name, the best first."""


def draw_names(
    axes: Axes, plan: Floorplan, *, ways: Sequence[Array] = (), with_agvs: bool = False
) -> None:
    """The names of stations and of the safe zone, and of obstacles where there is room for them.

    Those of places keep off obstacles, AGVs at their start, and the `ways` (N, 2), metres, that
    are drawn. AGVs have their own only if they are drawn there. All else has to be drawn by then:
    how much room there is depends on it.
    """
    scale = _scale(axes)
    marks = [(station.name, station.position, BLACK) for station in plan.stations]
    if plan.safe_zone is not None:
        marks.append(("safe zone", plan.safe_zone.position, GREEN))
    taken = _Taken(plan.boundary)
    taken.areas += [obstacle.footprint for obstacle in plan.obstacles]
    taken.areas += [_start(lane) for lane in plan.lanes]
    taken.areas += [Spot(at).buffer(_MARK / scale) for _, at, _ in marks]
    tracks = [LineString([lane.position(q) for q in lane.limits]) for lane in plan.lanes]
    taken.lines += [(track, _LANE / scale) for track in tracks]
    taken.lines += [(line, _WAY / scale) for way in ways for line in _unbroken(way)]
    for name, at, colour in marks:
        taken.areas.append(_write_beside(axes, at, name, colour, taken))
    for obstacle in plan.obstacles:
        dark = obstacle.bottom < plan.human.height and obstacle_shade(obstacle) < _DARK
        colour = "white" if dark else BLACK
        _write_inside(axes, obstacle.footprint, obstacle.name, scale, colour)
    if with_agvs:
        for lane in plan.lanes:
            _write_inside(axes, _start(lane), lane.name, scale, BLACK)


@dataclass
class _Taken:
    """What names should not cover, metres; each line with its width."""

    boundary: Polygon
    areas: list[Polygon] = field(default_factory=list)
    lines: list[tuple[LineString, float]] = field(default_factory=list)

    def share(self, area: Polygon) -> float:
        """How much of an area would be over something else, or outside; 0 if nothing would."""
        covered = area.difference(self.boundary).area
        covered += sum(area.intersection(other).area for other in self.areas)
        crossed = (area.intersection(line).length * width for line, width in self.lines)
        covered += max(crossed, default=0.0)
        return float(covered / area.area)


def _unbroken(way: Array) -> Iterator[LineString]:
    """The parts of a way between NaNs."""
    for part in np.split(way, np.flatnonzero(np.isnan(way[:, 0]))):
        points = part[~np.isnan(part[:, 0])]
        if len(points) > 1:
            yield LineString(points)


def _start(lane: Lane) -> Polygon:
    return lane.footprint(lane.locations[lane.start])


def _scale(axes: Axes) -> float:
    """How many points of the picture a metre of the floor takes."""
    figure: Any = axes.figure
    figure.draw_without_rendering()
    (west, _), (east, _) = axes.transData.transform([(0.0, 0.0), (1.0, 0.0)]).tolist()
    return float(72 * (east - west) / figure.dpi)


def _write_beside(axes: Axes, at: Point, text: str, colour: str, taken: _Taken) -> Polygon:
    """A name beside its mark where it covers the least; what it takes up itself.

    It stands on a plate of its own where it covers anything.
    """
    name: Any = axes.annotate(
        text, at, (0, 0), textcoords="offset points", size=_PLACE_SIZE, color=colour, zorder=4
    )

    def put(side: _Side) -> Polygon:
        name.set_position((side.x, side.y))
        name.set(ha=side.aligned, va=side.upon, rotation=90 if side.upright else 0)
        return box(*name.get_window_extent().transformed(axes.transData.inverted()).extents)

    best = min(_SIDES, key=lambda side: taken.share(put(side)) + side.upright * _UPRIGHT)
    area = put(best)
    if taken.share(area) > 0.0:
        name.set_bbox({"facecolor": "white", "alpha": 0.75, "linewidth": 0, "pad": 0.3})
    return area


def _write_inside(axes: Axes, area: Polygon, text: str, scale: float, colour: str) -> None:
    """A name in an area, on one or two lines or upright: the first way that fits, if any does."""
    west, south, east, north = area.bounds
    wide, high = (east - west) * scale, (north - south) * scale
    two_lines = "\n".join(text.rsplit("_", 1))
    for written, upright in ((text, False), (two_lines, False), (text, True)):
        lines = written.splitlines()
        length = _LETTER_WIDTH * _INSIDE_SIZE * max(map(len, lines))
        height = 1.2 * _INSIDE_SIZE * len(lines)
        if length <= (high if upright else wide) and height <= (wide if upright else high):
            inside = area.representative_point()
            at = area.centroid if area.contains(area.centroid) else inside
            axes.text(
                at.x,
                at.y,
                written,
                size=_INSIDE_SIZE,
                color=colour,
                rotation=90 if upright else 0,
                ha="center",
                va="center",
                linespacing=1.0,
                zorder=4,
            )
            return
