"""A planned path across a floor, and the clearance along it."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from navigation import CollisionWorld, Path

from ..colours import BLUE, GREY, PALE, VERMILION
from .floor import draw_floor, fill_area, floor_axes, floor_height
from .names import draw_names
from .style import Width, new_figure, styled

STEP = 0.05
"""Metres along the path between two places at which the clearance is taken."""

FAR = 1.0
"""Metres. More clearance than this is not shown on the floor."""

_BELOW = 1.4
"""Inches for the profile below the floor."""

_NARROWEST: dict[str, Any] = {
    "marker": "o",
    "color": VERMILION,
    "markersize": 4,
    "fillstyle": "none",
}


@styled()
def path(world: CollisionWorld, planned: Path, *, radius: float, width: Width = "double") -> Figure:
    """Draw a path on its floor, with the free room on both sides; below, the clearance along it.

    `radius` (metres) is that of the person who is to walk it.
    """
    along, points = _places(planned.points)
    clearances = np.array([world.distance((x, y)) for x, y in points.tolist()])
    height = floor_height(world.plan, width)
    figure = new_figure(width, height + _BELOW)
    rows = figure.add_gridspec(2, 1, height_ratios=(height, _BELOW))
    axes = floor_axes(figure.add_subplot(rows[0]), world.plan)
    axes.set_title(f"{planned.length:.2f} m long, {planned.clearance:.2f} m clear", loc="left")
    draw_floor(axes, world.plan)
    for body in world.bodies:
        fill_area(axes, body.footprint, facecolor=PALE, edgecolor=GREY, linewidth=0.5, zorder=1.5)
    _draw_path(axes, planned, points, clearances)
    _draw_profile(figure.add_subplot(rows[1]), along, clearances, radius)
    draw_names(axes, world.plan, paths=[planned.points])
    return figure


def _places(path: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return distances along a path (N,) and the points there (N, 2), metres; corners included."""
    legs = np.hypot(*np.diff(path, axis=0).T)
    corners = np.concatenate([[0.0], np.cumsum(legs)])
    count = max(2, int(np.ceil(corners[-1] / STEP)) + 1)
    along = np.unique(np.concatenate([np.linspace(0.0, corners[-1], count), corners]))
    return along, np.column_stack([np.interp(along, corners, path[:, k]) for k in (0, 1)])


def _draw_path(
    axes: Axes, planned: Path, points: NDArray[np.float64], clearances: NDArray[np.float64]
) -> None:
    room = shapely.union_all(shapely.buffer(shapely.points(points), np.minimum(clearances, FAR)))
    for part in getattr(room, "geoms", [room]):
        fill_area(axes, part, facecolor=BLUE, alpha=0.15, linewidth=0, zorder=1.2)
    axes.plot(*planned.points.T, color=BLUE, linewidth=1.2, zorder=3)
    axes.plot(*planned.points[0], "o", color=BLUE, markersize=4, zorder=3)
    axes.plot(*planned.points[-1], "*", color=BLUE, markersize=8, zorder=3)
    axes.plot(*points[int(clearances.argmin())], zorder=4, **_NARROWEST)


def _draw_profile(
    axes: Axes, along: NDArray[np.float64], clearances: NDArray[np.float64], radius: float
) -> None:
    axes.plot(along, clearances, color=BLUE)
    axes.fill_between(along, clearances, color=BLUE, alpha=0.15, linewidth=0)
    axes.axhline(radius, color=GREY, linewidth=0.8, linestyle="--")
    narrow = int(clearances.argmin())
    # Its name stands at the end that is farther from the narrowest place, which has a figure.
    at, away, aligned = (0.0, 2, "left") if along[narrow] > along[-1] / 2 else (1.0, -2, "right")
    axes.annotate(
        f"radius {radius:g} m",
        (at, radius),
        (away, 2),
        xycoords=axes.get_yaxis_transform(),
        textcoords="offset points",
        ha=aligned,
        size=7,
        color=GREY,
    )
    axes.plot(along[narrow], clearances[narrow], **_NARROWEST)
    axes.annotate(
        f"{clearances[narrow]:.2f} m",
        (along[narrow], clearances[narrow]),
        (0, 5),
        textcoords="offset points",
        ha="center",
        size=7,
        color=VERMILION,
    )
    axes.set_xlim(0.0, max(along[-1], 1e-9))
    axes.set_ylim(0.0, max(1.15 * float(clearances.max()), 2 * radius))
    axes.set_xlabel("distance along the path (m)")
    axes.set_ylabel("clearance (m)")
