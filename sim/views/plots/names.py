"""The names on a floor, where they cover nothing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import shapely
from matplotlib.axes import Axes
from shapely.geometry import LineString, Polygon, box
from shapely.geometry import Point as Spot

from floorplan import Floorplan, Point

from .curves import Array
from .style import BLACK, GREEN, obstacle_shade

_DARK = 0.6
"""Names on what is darker than this are white."""

_PLACE_SIZE = 6
"""Points. The letters of a station's name."""

_INSIDE_SIZE = 5.0
"""Points. The letters of the name of an obstacle or an AGV."""

_MARK = 3.5
"""Points. The radius of the mark of a station or of the safe zone."""

_LANE, _PATH = 0.3, 1.5
"""Points. The widths that count of the lines of lanes and paths: one can read across them."""

_UPRIGHT = 0.05
"""An upright name is worse than one of which less than this share covers something."""

_LEVEL_SIDES = ((0, 4), (0, -4), (5, 0), (-5, 0), (3, 3), (3, -3), (-3, -3), (-3, 3))
_UPRIGHT_SIDES = ((0, 5), (0, -5), (5, 0), (-5, 0))
_SIDES = [(side, False) for side in _LEVEL_SIDES] + [(side, True) for side in _UPRIGHT_SIDES]
"""Points from a mark to its name, and whether that stands upright; the best first."""


def draw_names(
    axes: Axes, plan: Floorplan, *, paths: Sequence[Array] = (), with_agvs: bool = False
) -> None:
    """Write the names of stations and the safe zone, and of obstacles where there is room.

    Those of places keep off obstacles, AGVs at their start, and the `paths` (N, 2), metres, that
    are drawn. AGVs have their own only if they are drawn there. All else has to be drawn by then:
    how much room there is depends on it.
    """
    point = _metres_per_point(axes)
    marks = [(station.name, station.position, BLACK) for station in plan.stations]
    if plan.safe_zone is not None:
        marks.append(("safe zone", plan.safe_zone.position, GREEN))
    starts = {lane.name: lane.footprint(lane.locations[lane.start]) for lane in plan.lanes}
    lanes = [LineString([lane.position(q) for q in lane.limits]) for lane in plan.lanes]
    taken = [obstacle.footprint for obstacle in plan.obstacles] + list(starts.values())
    taken += [Spot(at).buffer(_MARK * point) for _, at, _ in marks]
    taken += [lane.buffer(_LANE / 2 * point) for lane in lanes]
    taken += [line.buffer(_PATH / 2 * point) for path in paths for line in _unbroken(path)]
    free = plan.boundary.difference(shapely.union_all(taken))
    for name, at, colour in marks:
        free = free.difference(_write_beside(axes, at, name, colour, free))
    for obstacle in plan.obstacles:
        dark = obstacle.bottom < plan.human.height and obstacle_shade(obstacle) < _DARK
        _write_inside(axes, obstacle.footprint, obstacle.name, "white" if dark else BLACK)
    if with_agvs:
        for name, start in starts.items():
            _write_inside(axes, start, name, BLACK)


def _unbroken(path: Array) -> Iterator[LineString]:
    """The parts of a path between NaNs."""
    for part in np.split(path, np.flatnonzero(np.isnan(path[:, 0]))):
        points = part[~np.isnan(part[:, 0])]
        if len(points) > 1:
            yield LineString(points)


def _metres_per_point(axes: Axes) -> float:
    """Return the metres of the floor that a point of the picture takes."""
    figure: Any = axes.figure
    figure.draw_without_rendering()
    (west, _), (east, _) = axes.transData.transform([(0.0, 0.0), (1.0, 0.0)]).tolist()
    return float(figure.dpi / (east - west) / 72)


def _extent(axes: Axes, name: Any) -> Polygon:
    """Return the rectangle that a name covers, metres."""
    return box(*name.get_window_extent().transformed(axes.transData.inverted()).extents)


def _write_beside(axes: Axes, at: Point, text: str, colour: str, free: Any) -> Polygon:
    """Write a name beside its mark where most of it is `free`; return what it takes up.

    It stands on a plate of its own where it covers anything.
    """
    name: Any = axes.annotate(
        text, at, (0, 0), textcoords="offset points", size=_PLACE_SIZE, color=colour, zorder=4
    )

    def covered(side: tuple[Point, bool]) -> float:
        """Put the name there; return which share of it covers something, from 0 to 1."""
        (x, y), upright = side
        name.set(
            position=(x, y),
            ha="left" if x > 0 else "right" if x < 0 else "center",
            va="bottom" if y > 0 else "top" if y < 0 else "center",
            rotation=90 if upright else 0,
        )
        area = _extent(axes, name)
        return round(float(1.0 - area.intersection(free).area / area.area), 6)

    best = min(_SIDES, key=lambda side: covered(side) + side[1] * _UPRIGHT)
    if covered(best) > 0.0:
        name.set_bbox({"facecolor": "white", "alpha": 0.75, "linewidth": 0, "pad": 0.3})
    return _extent(axes, name)


def _write_inside(axes: Axes, area: Polygon, text: str, colour: str) -> None:
    """A name in an area, on one or two lines or upright: the first that fits, if any does."""
    west, south, east, north = area.bounds
    at = area.centroid if area.contains(area.centroid) else area.representative_point()
    look: dict[str, Any] = {"ha": "center", "va": "center", "linespacing": 1.0, "zorder": 4}
    name = axes.text(at.x, at.y, text, size=_INSIDE_SIZE, color=colour, **look)
    for written, upright in ((text, False), ("\n".join(text.rsplit("_", 1)), False), (text, True)):
        name.set(text=written, rotation=90 if upright else 0)
        left, low, right, high = _extent(axes, name).bounds
        if right - left <= east - west and high - low <= north - south:
            return
    name.remove()
