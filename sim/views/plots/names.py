"""The names on a floor, where they cover nothing."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import shapely
from matplotlib.axes import Axes
from shapely.geometry import LineString, Polygon, box
from shapely.geometry import Point as Spot

from floorplan import Floorplan, Point

from ..colours import BLACK, GREEN, GREY
from .curves import Array
from .style import obstacle_shade

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

_MOST_COVERED = 0.3
"""A name beside an obstacle or a machine is left out if more than this share covers something."""

_UPRIGHT = 0.05
"""An upright name is worse than one of which less than this share covers something."""

_LEVEL_SIDES = ((0, 4), (0, -4), (5, 0), (-5, 0), (3, 3), (3, -3), (-3, -3), (-3, 3))
_UPRIGHT_SIDES = ((0, 5), (0, -5), (5, 0), (-5, 0))
_SIDES = [(side, False) for side in _LEVEL_SIDES] + [(side, True) for side in _UPRIGHT_SIDES]
"""Points from a mark to its name, and whether that stands upright; the best first."""


def draw_names(
    axes: Axes,
    plan: Floorplan,
    *,
    paths: Sequence[Array] = (),
    marked: Sequence[Point] = (),
    machines: Mapping[str, Polygon] | None = None,
    all_names: bool = False,
) -> None:
    """Write the names of stations and the safe zone, and of obstacles in which there is room.

    Those of places keep off obstacles, AGVs at their start, and the `paths` (N, 2) and `marked`
    places that are drawn, metres; `machines` (by name the outlines that are drawn) have theirs in
    or beside them. With `all_names` obstacles without room have theirs beside them, and so have the
    locations of lanes, unless it would cover too much. All else has to be drawn by then: how much
    room there is depends on it.
    """
    outlines = machines or {}
    point = _metres_per_point(axes)
    marks = [(station.name, station.position, BLACK) for station in plan.stations]
    if plan.safe_zone is not None:
        marks.append(("safe zone", plan.safe_zone.position, GREEN))
    starts = {lane.name: lane.footprint(lane.locations[lane.start]) for lane in plan.lanes}
    lanes = [LineString([lane.position(q) for q in lane.limits]) for lane in plan.lanes]
    taken = [obstacle.footprint for obstacle in plan.obstacles] + list(starts.values())
    taken += [Spot(at).buffer(_MARK * point) for at in (*(at for _, at, _ in marks), *marked)]
    taken += [lane.buffer(_LANE / 2 * point) for lane in lanes]
    taken += outlines.values()
    taken += [line.buffer(_PATH / 2 * point) for path in paths for line in _unbroken(path)]
    free = plan.boundary.difference(shapely.union_all(taken))
    for name, at, colour in marks:
        taken_up = _write_beside(axes, at, name, colour, free)
        free = free if taken_up is None else free.difference(taken_up)
    for obstacle in plan.obstacles:
        dark = obstacle.bottom < plan.human.height and obstacle_shade(obstacle) < _DARK
        written = _write_inside(axes, obstacle.footprint, obstacle.name, "white" if dark else BLACK)
        if all_names and not written:
            free = _write_if_free(axes, obstacle.footprint, obstacle.name, BLACK, free, point)
    for name, outline in outlines.items():
        if not _write_inside(axes, outline, name, BLACK):
            free = _write_if_free(axes, outline, name, BLACK, free, point)
    if all_names:
        for lane in plan.lanes:
            for name, q in lane.locations.items():
                if name != lane.start:
                    spot = Spot(lane.position(q)).buffer(point)
                    free = _write_if_free(axes, spot, name, GREY, free, point)


def stand_beside(name: Any, side: Point) -> None:
    """Put an annotation so many points from what it names, on that side of it."""
    x, y = side
    name.set(
        position=side,
        ha="left" if x > 0 else "right" if x < 0 else "center",
        va="bottom" if y > 0 else "top" if y < 0 else "center",
    )


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


def _write_if_free(
    axes: Axes, area: Polygon, text: str, colour: str, free: Any, point: float
) -> Any:
    """Write a name beside an area unless it covers too much; return what is `free` then.

    `point` is how many metres a point takes.
    """
    west, south, east, north = area.bounds
    middle = ((west + east) / 2, (south + north) / 2)
    half = ((east - west) / 2 / point - _MARK, (north - south) / 2 / point - _MARK)
    taken = _write_beside(
        axes, middle, text, colour, free, half=half, size=_INSIDE_SIZE, most=_MOST_COVERED
    )
    return free if taken is None else free.difference(taken)


def _write_beside(
    axes: Axes,
    at: Point,
    text: str,
    colour: str,
    free: Any,
    *,
    half: Point = (0.0, 0.0),
    size: float = _PLACE_SIZE,
    most: float = 1.0,
) -> Polygon | None:
    """Write a name beside its mark where most of it is `free`; return what it takes up.

    It stands on a plate of its own where it covers anything, and nowhere if it covers more than the
    share `most`. `half` is by how many points the thing reaches farther than a mark, along x and y.
    """
    name: Any = axes.annotate(
        text, at, (0, 0), textcoords="offset points", size=size, color=colour, zorder=4
    )

    def covered(side: tuple[Point, bool]) -> float:
        """Put the name there; return which share of it covers something, from 0 to 1."""
        (x, y), upright = side
        stand_beside(name, (x + np.sign(x) * half[0], y + np.sign(y) * half[1]))
        name.set_rotation(90 if upright else 0)
        area = _extent(axes, name)
        return round(float(1.0 - area.intersection(free).area / area.area), 6)

    best = min(_SIDES, key=lambda side: covered(side) + side[1] * _UPRIGHT)
    share = covered(best)
    if share > most:
        name.remove()
        return None
    if share > 0.0:
        name.set_bbox({"facecolor": "white", "alpha": 0.75, "linewidth": 0, "pad": 0.3})
    return _extent(axes, name)


def _write_inside(axes: Axes, area: Polygon, text: str, colour: str) -> bool:
    """Write a name in an area, on one or two lines or upright; return False if none fits."""
    west, south, east, north = area.bounds
    at = area.centroid if area.contains(area.centroid) else area.representative_point()
    look: dict[str, Any] = {"ha": "center", "va": "center", "linespacing": 1.0, "zorder": 4}
    name = axes.text(at.x, at.y, text, size=_INSIDE_SIZE, color=colour, **look)
    for written, upright in ((text, False), ("\n".join(text.rsplit("_", 1)), False), (text, True)):
        name.set(text=written, rotation=90 if upright else 0)
        left, low, right, high = _extent(axes, name).bounds
        if right - left <= east - west and high - low <= north - south:
            return True
    name.remove()
    return False
