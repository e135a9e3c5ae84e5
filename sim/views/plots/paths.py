"""Figures of a planned path, and of the paths of people and machines."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray
from shapely import affinity
from shapely.geometry import Point as Spot, Polygon

from navigation import CollisionWorld, Path

from ...record.outcome import Outcome, span_of
from ...record.sampling import Span
from ..report_page import BLUE, GREY, PALE, PALE_ORANGE, VERMILION
from .floor import draw_floor, draw_names, fill_area, floor_axes, floor_figure, floor_height
from .style import (
    MACHINES,
    OF_MANY,
    Array,
    Width,
    are_few,
    breaches,
    explain,
    instants,
    mark_breaches,
    new_figure,
    person_colour,
    person_label,
    styled,
    while_present,
)

STEP = 0.05
"""Metres along the path between two samples of the clearance."""

FAR = 1.0
"""Metres. Maximum clearance that is drawn on the floor."""

_BELOW = 1.4
"""Inches. Height of the profile below the floor."""

_NARROWEST: dict[str, Any] = {
    "marker": "o",
    "color": VERMILION,
    "markersize": 4,
    "fillstyle": "none",
}


@styled()
def path(world: CollisionWorld, planned: Path, *, radius: float, width: Width = "double") -> Figure:
    """Draw a path on its floor with the free space beside it, and the clearance along it.

    Parameters
    ----------
    world : CollisionWorld
        Collision world of the path.
    planned : Path
        Path.
    radius : float
        Radius of the person in metres.
    width : {"single", "double"}, optional
        Number of columns of a paper.

    Returns
    -------
    Figure
        The plot.
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
    _draw_planned_path(axes, planned, points, clearances)
    _draw_profile(figure.add_subplot(rows[1]), along, clearances, radius)
    draw_names(axes, world.plan, paths=[planned.points])
    return figure


def _places(path: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return distances along a path (N,) and the points there (N, 2), with corners.

    Units are metres.
    """
    legs = np.hypot(*np.diff(path, axis=0).T)
    corners = np.concatenate([[0.0], np.cumsum(legs)])
    count = max(2, int(np.ceil(corners[-1] / STEP)) + 1)
    along = np.unique(np.concatenate([np.linspace(0.0, corners[-1], count), corners]))
    return along, np.column_stack([np.interp(along, corners, path[:, k]) for k in (0, 1)])


def _draw_planned_path(
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
    # The label is at the end that is farther from the labelled narrowest point.
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


TRAIL = 8.0
"""Duration in seconds of the path that is drawn behind a body."""

MOST_FIELDS = 20
"""Maximum number of stops by protective fields that are drawn, the latest ones."""

INSTANT = 1e-6
"""Seconds. Shorter times make no path."""

_THIN = 1.0
"""Points. Line width of the person who is drawn last."""

_EDGES = 2.4
"""Points by which the line of each earlier person is wider, so that it shows on both sides."""

_WIDEST = 5.8
"""Points. Maximum line width of several people."""

_GAP = 0.3
"""White on both sides of a line as a share of the edges, which separates similar greys."""


_ABBREVIATION = 3
"""Maximum number of letters of a kind that is written in capitals."""


@styled()
def trails(run: Outcome, *, within: Span | None = None, width: Width = "double") -> Figure:
    """Draw the paths of people and machines on the floor.

    A path is interrupted at a teleport. If paths overlap, lines of later people are drawn on wider
    lines of earlier ones. Dotted outlines are protective fields that a person entered and that
    stopped a machine, at the latest `MOST_FIELDS` stops.

    Parameters
    ----------
    run : Run
        The run.
    within : (float, float), optional
        Begin and end in seconds. Defaults to the whole run.
    width : {"single", "double"}, optional
        Number of columns of a paper.

    Returns
    -------
    Figure
        The plot.
    """
    begin, end = span_of(run, within)
    figure, axes = floor_figure(run.floorplan, width)
    draw_floor(axes, run.floorplan, run.scene.machines)
    paths = [_draw_path(axes, run, body, (begin, end)) for body in run.motions]
    _draw_field_stops(axes, run, (begin, end))
    places = [at for _, at in breaches(run, (begin, end))]
    mark_breaches(axes, places)
    explain(figure, [axes], width)
    outlines = {machine.name: _outline(run, machine.name, end) for machine in run.scene.machines}
    draw_names(axes, run.floorplan, paths=paths, marked=places, machines=outlines)
    return figure


@styled()
def moment(run: Outcome, t: float, person: str, machine: str, *, width: Width = "double") -> Figure:
    """Draw the bodies at `t` (s) with recent paths, and the required distance of two."""
    figure, axes = floor_figure(run.floorplan, width)
    draw_floor(axes, run.floorplan, run.scene.machines)
    span = (max(0.0, t - TRAIL), max(t, INSTANT))
    present = [one for one in run.motions if while_present(run, one, span)]
    paths = [
        _draw_path(axes, run, body, span, edged=False, named=body == person) for body in present
    ]
    here, there = (run.motions[name].state(t).at for name in (person, machine))
    axes.plot(*zip(here, there, strict=True), color=VERMILION, linewidth=0.8, linestyle=(0, (3, 3)))
    required = float(run.required(person, machine, [t])[0])
    shapes = run.scene.shapes(person, machine)
    circle = Spot(here).buffer(required + (0.0 if shapes is None else shapes.person.radius), 64)
    look: dict[str, Any] = {"edgecolor": VERMILION, "linewidth": 0.8, "zorder": 2}
    fill_area(axes, circle, facecolor=(VERMILION, 0.12), label="required distance", **look)
    for index, one in enumerate(run.scene.people):
        if one.name in present:
            disc = Spot(run.motions[one.name].state(t).at).buffer(one.radius)
            colour = person_colour(index)
            fill_area(axes, disc, facecolor=colour, edgecolor="white", linewidth=0.4, zorder=5)
    explain(figure, [axes], width)
    outlines = {one.name: _outline(run, one.name, t) for one in run.scene.machines}
    draw_names(axes, run.floorplan, paths=paths, marked=[here], machines=outlines)
    return figure


def _draw_field_stops(axes: Axes, run: Outcome, span: Span) -> None:
    """Draw the protective fields that stopped machines, where people entered them."""
    entered: dict[tuple[str, str], tuple[float, str]] = {}
    stops = []
    for event in run.events:
        pair = (event.get("machine", ""), event.get("person", ""))
        if event["kind"] == "field_occupied" and event["field"] == "protective":
            entered[pair] = event["t"], event["set"]
        elif event["kind"] == "field_stop" and pair in entered and span[0] <= event["t"] <= span[1]:
            stops.append((pair[0], *entered[pair]))
    for name, t, chosen in stops[-MOST_FIELDS:]:
        motion = run.motions[name]
        field = next(one for one in run.scene.fields[name].sets if one.name == chosen)
        x, y = motion.state(t).at
        turned = affinity.rotate(
            Polygon(field.protective), float(motion.rotation(t)), (0.0, 0.0), use_radians=True
        )
        area = affinity.translate(turned, x, y)
        label = _once(axes, "protective field at a stop")
        look: dict[str, Any] = {"facecolor": "none", "edgecolor": VERMILION, "linestyle": ":"}
        fill_area(axes, area, linewidth=0.6, label=label, zorder=3.3, **look)


def _outline(run: Outcome, name: str, t: float) -> Polygon:
    """Return the outline of a machine at `t` (s)."""
    motion = run.motions[name]
    return run.scene.machine(name).footprint(motion.state(t).at, float(motion.rotation(t)))


def _draw_path(
    axes: Axes, run: Outcome, body: str, span: Span, *, edged: bool = True, named: bool = True
) -> Array:
    """Draw the path of a body. Return its points (N, 2), with NaN at breaks.

    If `edged`, lines of people have different widths, so that one shows below another. The legend
    contains a person if `named`.
    """
    motion = run.motions[body]
    there = while_present(run, body, span)
    if there is None:
        return np.empty((0, 2))
    t = instants([motion], *there)
    path = motion.position(t)
    path[~run.is_present(body, t)] = np.nan
    people = [person.name for person in run.scene.people]
    if body in people:
        index = people.index(body)
        later = len(people) - 1 - index
        few = are_few(len(people))
        edges = min(_EDGES, (_WIDEST - _THIN) / len(people)) if few and edged else 0.0
        width = (_THIN if few else OF_MANY) + later * edges
        axes.plot(
            *path.T,
            color=person_colour(index),
            linewidth=width,
            path_effects=[withStroke(linewidth=width + _GAP * edges, foreground="white")],
            label=person_label(body, len(people)) if named else f"_{body}",
            zorder=3.2,
        )
    else:
        machine = run.scene.machine(body)
        look: dict[str, Any] = {"linewidth": 0.9, "zorder": 3}
        colour, label = MACHINES[machine.category], _once(axes, machine.kind)
        dashes = "-" if machine.category == "robot" else (0, (4, 1.5))
        axes.plot(*path.T, color=colour, label=label, linestyle=dashes, **look)
        face = PALE_ORANGE if machine.category == "robot" else PALE
        fill_area(axes, _outline(run, body, there[1]), facecolor=face, edgecolor=colour, **look)
    return path


def _once(axes: Axes, kind: str) -> str:
    """Return the label of a kind of machine, hidden if the legend contains it already."""
    name = kind.upper() if len(kind) <= _ABBREVIATION else kind.replace("_", " ")
    return f"_{name}" if name in axes.get_legend_handles_labels()[1] else name
