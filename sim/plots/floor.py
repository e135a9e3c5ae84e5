"""A floor from above: what stands on it, where people go, and what the machines can reach."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from floorplan import Floorplan, Lane, Obstacle, Point

from .style import BLACK, GREEN, GREY, MACHINES, PALE, Width, explain, inches, new_figure, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from shapely.geometry import Polygon

TALL = 2.5
"""Metres. What is as high as this is drawn darkest."""

_DASHES = (0, (3, 2))

_DARK = 0.6
"""Names on what is darker than this are white."""

_HIGHEST = 9.0
"""Inches. The most that fits on a page."""

_NAME_SIZE = 5.0
"""Points. The letters of an obstacle's name."""

_LETTER_WIDTH = 0.58
"""A letter's width, as a share of its height."""

_BESIDE = 0.75
"""Inches that a picture of a floor needs for what stands beside the floor."""


def floorplan(plan: Floorplan, *, width: Width = "double") -> Figure:
    """The floor with everything that is named on it, AGVs where they start."""
    with styled():
        figure, axes = floor_figure(plan, width)
        draw_floor(axes, plan)
        draw_names(axes, plan, width)
        for lane in plan.lanes:
            _draw_agv(axes, lane, _scale(plan, width))
        if plan.gantry is not None:
            _draw_range(axes, plan)
        _label_lines(axes, plan)
        explain(figure, [axes], width)
        return figure


def floor_figure(plan: Floorplan, width: Width, *, beside: float = 0.0) -> tuple[Figure, Axes]:
    """A figure as high as the floor needs, and its axes; `beside` inches are left for more."""
    figure = new_figure(width, floor_height(plan, width, beside=beside))
    return figure, floor_axes(figure.add_subplot(), plan)


def floor_height(plan: Floorplan, width: Width, *, beside: float = 0.0) -> float:
    """How high a picture of the whole floor is, inches, if it is `beside` inches less wide."""
    west, south, east, north = plan.boundary.bounds
    across = inches(width) - _BESIDE - beside
    return min(across * float((north - south) / (east - west)) + _BESIDE, _HIGHEST)


def floor_axes(axes: Axes, plan: Floorplan) -> Axes:
    """Axes in metres that show the whole floor, undistorted."""
    west, south, east, north = plan.boundary.bounds
    margin = 0.01 * max(east - west, north - south)
    axes.set_aspect("equal")
    axes.set_xlim(west - margin, east + margin)
    axes.set_ylim(south - margin, north + margin)
    axes.set_xlabel("x (m)")
    axes.set_ylabel("y (m)")
    return axes


def draw_floor(axes: Axes, plan: Floorplan) -> None:
    """Walls, obstacles (the higher the darker; dashed what people walk under), lanes, stations."""
    for ring in (plan.boundary.exterior, *plan.boundary.interiors):
        axes.plot(*ring.xy, color=BLACK, linewidth=0.8, zorder=2)
    for lane in plan.lanes:
        low, high = map(lane.position, lane.limits)
        axes.plot(*zip(low, high, strict=True), color=GREY, linewidth=0.5, linestyle=":", zorder=1)
    for obstacle in plan.obstacles:
        _draw_obstacle(axes, obstacle, plan.human.height)
    for station in plan.stations:
        axes.plot(*station.position, "+", color=BLACK, markersize=5, markeredgewidth=0.8, zorder=3)
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


def draw_names(axes: Axes, plan: Floorplan, width: Width) -> None:
    """The names of stations and of the safe zone, and of obstacles where there is room for them."""
    for station in plan.stations:
        _write(axes, station.position, station.name)
    if plan.safe_zone is not None:
        _write(axes, plan.safe_zone.position, "safe zone", color=GREEN)
    scale = _scale(plan, width)
    for obstacle in plan.obstacles:
        dark = obstacle.bottom < plan.human.height and _shade(obstacle) < _DARK
        _write_inside(axes, obstacle.footprint, obstacle.name, scale, "white" if dark else BLACK)


def fill_area(axes: Axes, area: Polygon, **look: object) -> None:
    """Fill a polygon, but not its holes."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    rings = [area.exterior, *area.interiors]
    outline = Path.make_compound_path(*(Path(ring.coords, closed=True) for ring in rings))
    axes.add_patch(PathPatch(outline, **look))


def machine_size(plan: Floorplan, body: str) -> tuple[float, float]:
    """Length and width (metres) of the gantry's torso, or of the AGV of that name."""
    if body == "gantry" and plan.gantry is not None:
        return plan.gantry.torso[:2]
    lane = plan.lane(body)
    return (lane.length, lane.width)


def machine_outline(plan: Floorplan, body: str, at: Point, rotation: float) -> list[Point]:
    """The corners of the gantry's torso or of an AGV at `at`, turned by `rotation` (radians)."""
    (x, y), c, s = at, math.cos(rotation), math.sin(rotation)
    length, width = machine_size(plan, body)
    half = [(u * length / 2, v * width / 2) for u, v in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    return [(x + u * c - v * s, y + u * s + v * c) for u, v in half]


def _scale(plan: Floorplan, width: Width) -> float:
    """How many points of the picture a metre of the floor takes."""
    west, _, east, _ = plan.boundary.bounds
    return 72 * (inches(width) - _BESIDE) / float(east - west)


def _shade(obstacle: Obstacle) -> float:
    """How light an obstacle is, from 0 to 1: the higher the darker."""
    return 0.86 - 0.42 * min(obstacle.top / TALL, 1.0)


def _draw_obstacle(axes: Axes, obstacle: Obstacle, person: float) -> None:
    if obstacle.bottom >= person:
        look = {"facecolor": "none", "edgecolor": GREY, "linestyle": _DASHES}
    else:
        shade = _shade(obstacle)
        look = {"facecolor": str(round(shade, 3)), "edgecolor": str(round(shade - 0.2, 3))}
    fill_area(axes, obstacle.footprint, linewidth=0.4, zorder=1.5, **look)


def _draw_agv(axes: Axes, lane: Lane, scale: float) -> None:
    q = lane.locations[lane.start]
    fill_area(axes, lane.footprint(q), facecolor=PALE, edgecolor=BLACK, linewidth=0.6, zorder=2.5)
    _write_inside(axes, lane.footprint(q), lane.name, scale, BLACK)
    for place in lane.locations.values():
        axes.plot(*lane.position(place), "s", color=GREY, markersize=2, zorder=1.5)


def _draw_range(axes: Axes, plan: Floorplan) -> None:
    assert plan.gantry is not None
    x, y = plan.gantry.x, plan.gantry.y
    corners = [(x.low, y.low), (x.high, y.low), (x.high, y.high), (x.low, y.high)]
    axes.fill(
        *zip(*corners, strict=True),
        facecolor="none",
        edgecolor=MACHINES["gantry"],
        linewidth=0.8,
        linestyle="-.",
        zorder=2,
    )


def _write(axes: Axes, at: Point, text: str, color: str = BLACK) -> None:
    axes.annotate(
        text, at, (0, 5), textcoords="offset points", size=6, color=color, ha="center", zorder=4
    )


def _write_inside(axes: Axes, area: Polygon, text: str, scale: float, colour: str) -> None:
    """A name in an area, on one or two lines or upright: the first way that fits, if any does."""
    west, south, east, north = area.bounds
    wide, high = (east - west) * scale, (north - south) * scale
    two_lines = "\n".join(text.rsplit("_", 1))
    for written, upright in ((text, False), (two_lines, False), (text, True)):
        lines = written.splitlines()
        length = _LETTER_WIDTH * _NAME_SIZE * max(map(len, lines))
        height = 1.2 * _NAME_SIZE * len(lines)
        if length <= (high if upright else wide) and height <= (wide if upright else high):
            inside = area.representative_point()
            at = area.centroid if area.contains(area.centroid) else inside
            axes.text(
                at.x,
                at.y,
                written,
                size=_NAME_SIZE,
                color=colour,
                rotation=90 if upright else 0,
                ha="center",
                va="center",
                linespacing=1.0,
                zorder=4,
            )
            return


def _label_lines(axes: Axes, plan: Floorplan) -> None:
    """Say in the legend what the lines and marks on this floor are."""
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
            {"color": MACHINES["gantry"], "linewidth": 0.8, "linestyle": "-."},
        ),
    ]
    for there, label, look in looks:
        if there:
            axes.plot([], [], label=label, **look)
