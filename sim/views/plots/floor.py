"""Drawing of a floor from above, with labels that do not overlap."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.text import Text
from matplotlib.transforms import Affine2D
from shapely.geometry import LineString, Point as Spot, Polygon, box

from floorplan import Floorplan, Gate, Lane, Obstacle, Point

from ...core.body import MachineShape
from ..report_page import BLACK, GREEN, GREY, PALE, VERMILION
from .style import (
    MACHINES,
    Array,
    Width,
    explain,
    inches,
    new_figure,
    obstacle_shade,
    settle,
    styled,
)

_DARK = 0.6
"""Lightness below which names on an obstacle are white."""

_PLACE_SIZE = 6
"""Points. Font size of names of stations."""

_INSIDE_SIZE = 5.0
"""Points. Font size of names of obstacles and AGVs."""

_MARK = 3.5
"""Points. Radius of the mark of a station or of the safe zone."""

_LANE, _PATH = 0.3, 1.5
"""Points. Widths of the lines of lanes and paths that names should not cover."""

_MOST_COVERED = 0.3
"""Maximum share of a name beside an obstacle or a machine that may cover something."""

_UPRIGHT = 0.05
"""Penalty of an upright name, as a share of covered area."""

_LEVEL_SIDES = ((0, 4), (0, -4), (5, 0), (-5, 0), (3, 3), (3, -3), (-3, -3), (-3, 3))
_UPRIGHT_SIDES = ((0, 5), (0, -5), (5, 0), (-5, 0))
_SIDES = [(side, False) for side in _LEVEL_SIDES] + [(side, True) for side in _UPRIGHT_SIDES]
"""Offsets (points) of a name from its mark and whether it is upright, the best first."""


def draw_names(
    axes: Axes,
    plan: Floorplan,
    *,
    paths: Sequence[Array] = (),
    marked: Sequence[Point] = (),
    machines: Mapping[str, Polygon] | None = None,
    all_names: bool = False,
) -> None:
    """Write the names of stations and the safe zone, and of obstacles with enough room.

    Names of places avoid obstacles, AGVs at their start, `paths` (N, 2) and `marked` positions (m).
    `machines`, outlines by name, have their names inside or beside them. With `all_names`,
    obstacles without enough room and locations of lanes have their names beside them, unless that
    covers too much. Everything else must have been drawn before, because it determines the free
    space.
    """
    outlines = machines or {}
    labels = _Labels(axes)
    marks = [(station.name, station.position, BLACK) for station in plan.stations]
    if plan.safe_zone is not None:
        marks.append(("safe zone", plan.safe_zone.position, GREEN))
    starts = {lane.name: lane.footprint(lane.locations[lane.start]) for lane in plan.lanes}
    lanes = [LineString([lane.position(q) for q in lane.limits]) for lane in plan.lanes]
    point = labels.point
    taken = [obstacle.footprint for obstacle in plan.obstacles] + list(starts.values())
    taken += [Spot(at).buffer(_MARK * point) for at in (*(at for _, at, _ in marks), *marked)]
    taken += [lane.buffer(_LANE / 2 * point) for lane in lanes]
    taken += outlines.values()
    taken += [line.buffer(_PATH / 2 * point) for path in paths for line in _unbroken(path)]
    labels.free = plan.boundary.difference(shapely.union_all(taken))
    for name, at, colour in marks:
        labels.write_beside(at, name, colour)
    for obstacle in plan.obstacles:
        dark = obstacle.bottom < plan.human.height and obstacle_shade(obstacle) < _DARK
        colour = "white" if dark else BLACK
        written = labels.write_inside(obstacle.footprint, obstacle.name, colour)
        if all_names and not written:
            labels.write_if_free(obstacle.footprint, obstacle.name, BLACK)
    for name, outline in outlines.items():
        if not labels.write_inside(outline, name, BLACK):
            labels.write_if_free(outline, name, BLACK)
    if all_names:
        for lane in plan.lanes:
            for name, q in lane.locations.items():
                if name != lane.start:
                    labels.write_if_free(Spot(lane.position(q)).buffer(point), name, GREY)


def stand_beside(name: Any, side: Point) -> None:
    """Place an annotation at an offset (points) from its mark."""
    x, y = side
    name.set(
        position=side,
        ha="left" if x > 0 else "right" if x < 0 else "center",
        va="bottom" if y > 0 else "top" if y < 0 else "center",
    )


def _unbroken(path: Array) -> Iterator[LineString]:
    """Yield the parts of a path between NaNs."""
    for part in np.split(path, np.flatnonzero(np.isnan(path[:, 0]))):
        points = part[~np.isnan(part[:, 0])]
        if len(points) > 1:
            yield LineString(points)


class _Labels:
    """The labels of a floor, and the area that is `free` for further ones.

    Everything else must have been drawn, because the layout of the figure depends on it.
    """

    free: Any

    def __init__(self, axes: Axes) -> None:
        figure: Any = axes.figure
        settle(figure)
        axes.apply_aspect()
        self.axes = axes
        self._dpi = figure.dpi
        self._to_pixels = Affine2D(axes.transData.get_affine().get_matrix())
        self._to_metres = self._to_pixels.inverted()
        self._pixel = 1 / float(self._to_pixels.get_matrix()[0, 0])
        self.point = self._pixel * self._dpi / 72
        """Metres of the floor per point of the picture."""

    def write_if_free(self, area: Polygon, text: str, colour: str) -> None:
        """Write a name beside an area unless it covers too much."""
        west, south, east, north = area.bounds
        middle = ((west + east) / 2, (south + north) / 2)
        half = ((east - west) / 2 / self.point - _MARK, (north - south) / 2 / self.point - _MARK)
        self.write_beside(middle, text, colour, half=half, size=_INSIDE_SIZE, most=_MOST_COVERED)

    def write_beside(
        self,
        at: Point,
        text: str,
        colour: str,
        *,
        half: Point = (0.0, 0.0),
        size: float = _PLACE_SIZE,
        most: float = 1.0,
    ) -> None:
        """Write a name beside its mark where most of its area is free.

        The name has a plate if it covers anything. It is omitted if it covers more than the share
        `most`. `half` is the half size (points) of the named object beyond that of a mark, along x
        and y.
        """
        offsets = [(x + np.sign(x) * half[0], y + np.sign(y) * half[1]) for (x, y), _ in _SIDES]
        sizes = [_text_size(text, size, self._dpi, upright=upright) for _, upright in _SIDES]
        areas = self._areas(at, offsets, sizes)
        near = shapely.intersection(self.free, box(*shapely.total_bounds(areas)))
        free = shapely.area(shapely.intersection(near, areas)) / shapely.area(areas)
        covered = np.round(1.0 - free, 6)
        best = int(np.argmin(covered + [upright * _UPRIGHT for _, upright in _SIDES]))
        if covered[best] > most:
            return
        look: dict[str, Any] = {"size": size, "color": colour, "zorder": 4}
        name = self.axes.annotate(text, at, (0, 0), textcoords="offset points", **look)
        stand_beside(name, offsets[best])
        name.set_rotation(90 if _SIDES[best][1] else 0)
        if covered[best] > 0.0:
            name.set_bbox({"facecolor": "white", "alpha": 0.75, "linewidth": 0, "pad": 0.3})
        self.free = self.free.difference(areas[best])

    def write_inside(self, area: Polygon, text: str, colour: str) -> bool:
        """Write a name in an area, on one or two lines or upright. Return False if none fits."""
        west, south, east, north = area.bounds
        lines = "\n".join(text.rsplit("_", 1))
        for written, upright in ((text, False), (lines, False), (text, True)):
            size = _text_size(written, _INSIDE_SIZE, self._dpi, upright=upright, linespacing=1.0)
            across, along = self._pixel * size
            if across <= east - west and along <= north - south:
                at = area.centroid
                at = at if area.contains(at) else area.representative_point()
                look: dict[str, Any] = {"ha": "center", "va": "center", "linespacing": 1.0}
                look |= {"size": _INSIDE_SIZE, "color": colour, "zorder": 4}
                self.axes.text(at.x, at.y, written, rotation=90 if upright else 0, **look)
                return True
        return False

    def _areas(self, at: Point, offsets: Sequence[Point], sizes: Sequence[Array]) -> Array:
        """Return the rectangles (m) of a name at offsets (points), with `sizes` in pixels."""
        shifts = np.array(offsets)
        pixels = np.array(sizes)
        # A name begins at a positive offset, ends at a negative one, and is centred at zero.
        low = self._to_pixels.transform(at) + shifts * (self._dpi / 72)
        low = low + pixels * (np.sign(shifts) - 1) / 2
        corners = np.stack((low, low + pixels), axis=1).reshape(-1, 2)
        bounds = self._to_metres.transform(corners).reshape(-1, 4)
        return np.asarray(shapely.box(*bounds.T))


@cache
def _text_size(
    text: str, size: float, dpi: float, *, upright: bool, linespacing: float | None = None
) -> Array:
    """Return the width and height (pixels) of a text with letters of `size` points."""
    measured: Any = Text(
        text=text, size=size, rotation=90 if upright else 0, linespacing=linespacing
    )
    measured.set_figure(Figure(dpi=dpi))
    return np.array(measured.get_window_extent(RendererAgg(1, 1, dpi)).size)


_DASHES = (0, (3, 2))

ARROW = 1.0
"""Metres. Length of the arrow through a one-way gate."""

_HIGHEST = 9.0
"""Inches. Maximum height of a picture."""

_BESIDE = 0.75
"""Inches. Room for axis labels beside a floor."""


@styled()
def floorplan(plan: Floorplan, *, width: Width = "double") -> Figure:
    """Draw a floor with all names and AGVs at their start.

    Names of obstacles and locations that would cover something are omitted.

    Parameters
    ----------
    plan : Floorplan
        The floor.
    width : {"single", "double"}, optional
        Number of columns of a paper.

    Returns
    -------
    Figure
        The plot.
    """
    figure, axes = floor_figure(plan, width)
    draw_floor(axes, plan)
    for lane in plan.lanes:
        _draw_agv(axes, lane)
    if plan.gantry is not None:
        _draw_range(axes, plan)
    _label_lines(axes, plan)
    explain(figure, [axes], width)
    starts = {lane.name: lane.footprint(lane.locations[lane.start]) for lane in plan.lanes}
    draw_names(axes, plan, machines=starts, all_names=True)
    return figure


def floor_figure(plan: Floorplan, width: Width, *, beside: float = 0.0) -> tuple[Figure, Axes]:
    """Return a figure with the height of the floor, and its axes. `beside` (inches) stays free."""
    figure = new_figure(width, floor_height(plan, width, beside=beside))
    return figure, floor_axes(figure.add_subplot(), plan)


def floor_height(plan: Floorplan, width: Width, *, beside: float = 0.0) -> float:
    """Return the height (inches) of a picture of the whole floor. `beside` (inches) stays free."""
    west, south, east, north = plan.boundary.bounds
    across = inches(width) - _BESIDE - beside
    return min(across * float((north - south) / (east - west)) + _BESIDE, _HIGHEST)


def floor_axes(axes: Axes, plan: Floorplan) -> Axes:
    """Set axes to the whole floor in metres, undistorted, and return them."""
    west, south, east, north = plan.boundary.bounds
    margin = 0.01 * max(east - west, north - south)
    axes.set_aspect("equal")
    axes.set_xlim(west - margin, east + margin)
    axes.set_ylim(south - margin, north + margin)
    axes.set_xlabel("x (m)")
    axes.set_ylabel("y (m)")
    return axes


def draw_floor(axes: Axes, plan: Floorplan, machines: Iterable[MachineShape] = ()) -> None:
    """Draw walls, obstacles, lanes and stations.

    Higher obstacles are darker, and overhead ones are dashed. Zones are dashed outlines. Doors are
    lines, green if they are open by default. Arrows point through one-way gates, which are dotted.
    Courses of `machines` are drawn like lanes.
    """
    for ring in (plan.boundary.exterior, *plan.boundary.interiors):
        axes.plot(*ring.xy, color=BLACK, linewidth=0.8, zorder=2)
    lanes = [tuple(map(lane.position, lane.limits)) for lane in plan.lanes]
    for line in dict.fromkeys([*lanes, *(machine.course for machine in machines)]):
        x, y = np.reshape(line, (-1, 2)).T
        axes.plot(x, y, color=GREY, linewidth=0.5, linestyle=":", zorder=1)
    for obstacle in plan.obstacles:
        _draw_obstacle(axes, obstacle, plan.human.height)
    for zone in plan.zones:
        look = {"facecolor": "none", "edgecolor": VERMILION if zone.forbidden else GREY}
        fill_area(axes, zone.area, linewidth=0.6, linestyle=_DASHES, zorder=1.4, **look)
    for door in plan.doors:
        x, y = np.array(door.ends).T
        axes.plot(x, y, color=GREEN if door.is_open else BLACK, linewidth=1.5, zorder=2.2)
    for gate in plan.one_ways:
        _draw_gate(axes, gate)
    for station in plan.stations:
        axes.plot(
            *station.position, "+", color=BLACK, markersize=5, markeredgewidth=0.8, zorder=3.4
        )
    if plan.safe_zone is not None:
        axes.plot(
            *plan.safe_zone.position,
            marker="o",
            markersize=7,
            markerfacecolor="none",
            markeredgecolor=GREEN,
            linestyle="none",
            zorder=3,
        )


def fill_area(axes: Axes, area: Polygon, **look: object) -> None:
    """Fill a polygon without its holes."""
    rings = [area.exterior, *area.interiors]
    outline = Path.make_compound_path(*(Path(ring.coords, closed=True) for ring in rings))
    axes.add_patch(PathPatch(outline, **look))


def _draw_obstacle(axes: Axes, obstacle: Obstacle, person: float) -> None:
    if obstacle.bottom >= person:
        look = {"facecolor": "none", "edgecolor": GREY, "linestyle": _DASHES}
    else:
        shade = obstacle_shade(obstacle)
        look = {"facecolor": str(round(shade, 3)), "edgecolor": str(round(shade - 0.2, 3))}
    fill_area(axes, obstacle.footprint, linewidth=0.4, zorder=1.5, **look)


def _draw_gate(axes: Axes, gate: Gate) -> None:
    (ends_x, ends_y), (nx, ny) = np.array(gate.ends).T, gate.normal
    axes.plot(ends_x, ends_y, color=GREEN, linewidth=1.2, linestyle=":", zorder=2.2)
    x, y, half = ends_x.mean(), ends_y.mean(), ARROW / 2
    axes.annotate(
        "",
        (x + half * nx, y + half * ny),
        (x - half * nx, y - half * ny),
        arrowprops={
            "arrowstyle": "-|>",
            "color": GREEN,
            "linewidth": 1.2,
            "shrinkA": 0,
            "shrinkB": 0,
        },
        zorder=2.3,
    )


def _draw_agv(axes: Axes, lane: Lane) -> None:
    q = lane.locations[lane.start]
    fill_area(axes, lane.footprint(q), facecolor=PALE, edgecolor=BLACK, linewidth=0.6, zorder=2.5)
    for place in lane.locations.values():
        axes.plot(*lane.position(place), "s", color=GREY, markersize=2, zorder=1.5)


def _draw_range(axes: Axes, plan: Floorplan) -> None:
    assert plan.gantry is not None
    x, y = plan.gantry.x, plan.gantry.y
    corners = [(x.low, y.low), (x.high, y.low), (x.high, y.high), (x.low, y.high)]
    axes.fill(
        *zip(*corners, strict=True),
        facecolor="none",
        edgecolor=MACHINES["robot"],
        linewidth=0.8,
        linestyle="-.",
        zorder=2,
    )


def _label_lines(axes: Axes, plan: Floorplan) -> None:
    """Explain the lines and marks of this floor in the legend."""
    looks: list[tuple[bool, str, dict[str, Any]]] = [
        (bool(plan.stations), "station", {"color": BLACK, "marker": "+", "linestyle": "none"}),
        (
            any(obstacle.bottom >= plan.human.height for obstacle in plan.obstacles),
            "overhead",
            {"color": GREY, "linewidth": 0.6, "linestyle": _DASHES},
        ),
        (bool(plan.lanes), "AGV lane", {"color": GREY, "linewidth": 0.8, "linestyle": ":"}),
        (
            plan.gantry is not None,
            "gantry's range",
            {"color": MACHINES["robot"], "linewidth": 0.8, "linestyle": "-."},
        ),
    ]
    for there, label, look in looks:
        if there:
            axes.plot([], [], label=label, **look)
