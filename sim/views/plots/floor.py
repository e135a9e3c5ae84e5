"""A floor from above: obstacles, stations, lanes, and the range of the gantry."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from shapely.geometry import Polygon

from floorplan import Floorplan, Gate, Lane, Obstacle

from ...core.machine import MachineShape
from ..colours import BLACK, GREEN, GREY, PALE, VERMILION
from .names import draw_names
from .style import MACHINES, Width, explain, inches, new_figure, obstacle_shade, styled

_DASHES = (0, (3, 2))

ARROW = 1.0
"""Metres. The length of the arrow through a one-way gate."""

_HIGHEST = 9.0
"""Inches. The most that fits on a page."""

_BESIDE = 0.75
"""Inches that a picture of a floor needs for what stands beside the floor."""


@styled()
def floorplan(plan: Floorplan, *, width: Width = "double") -> Figure:
    """Draw the floor with everything that has a name on it, AGVs where they start.

    The name of an obstacle or a location is left out where it would cover another thing.
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
    """Return a figure as high as the floor needs, and its axes; `beside` inches stay free."""
    figure = new_figure(width, floor_height(plan, width, beside=beside))
    return figure, floor_axes(figure.add_subplot(), plan)


def settle(figure: Figure) -> Figure:
    """Lay a figure out once before it is drawn, and return it.

    Beside a bar of colours axes that must not be distorted end up narrower than the layout takes
    them for; the next time it knows.
    """
    engine = figure.get_layout_engine()
    assert engine is not None  # as of `new_figure`
    engine.execute(figure)
    return figure


def floor_height(plan: Floorplan, width: Width, *, beside: float = 0.0) -> float:
    """Return the height of a picture of the whole floor, `beside` inches of it free; inches."""
    west, south, east, north = plan.boundary.bounds
    across = inches(width) - _BESIDE - beside
    return min(across * float((north - south) / (east - west)) + _BESIDE, _HIGHEST)


def floor_axes(axes: Axes, plan: Floorplan) -> Axes:
    """Let axes show the whole floor, undistorted, in metres; return them."""
    west, south, east, north = plan.boundary.bounds
    margin = 0.01 * max(east - west, north - south)
    axes.set_aspect("equal")
    axes.set_xlim(west - margin, east + margin)
    axes.set_ylim(south - margin, north + margin)
    axes.set_xlabel("x (m)")
    axes.set_ylabel("y (m)")
    return axes


def draw_floor(axes: Axes, plan: Floorplan, machines: Iterable[MachineShape] = ()) -> None:
    """Draw walls, obstacles (the higher the darker; overhead ones dashed), lanes and stations.

    Zones are dashed outlines, doors lines: green where they are open unless a trial says otherwise.
    Arrows point through one-way gates, which are dotted.

    The courses of `machines` are drawn as the lanes.
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
    """Fill a polygon, but not its holes."""
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
    """Explain the lines and marks on this floor in the legend."""
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
