"""The time for which each spot of a floor was occupied by people."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from numpy.typing import NDArray

from floorplan import Floorplan
from navigation import Motion

from ...record.outcome import Outcome
from .curves import Array
from .floor import draw_floor, floor_figure, settle
from .style import Width, styled

CELL = 0.05
"""Metres. The side of a cell."""

_BAR = 0.6
"""Inches. The width of the bar of colours."""

MOMENT = 0.02
"""Seconds. The step at which moving people are sampled."""

_HAIR = 1e-9
"""Metres. Cells that are beyond a radius by no more than this still count."""


@styled()
def heat_map(runs: Outcome | Sequence[Outcome], *, width: Width = "double") -> Figure:
    """Draw the time for which each spot was under a person's body, in all `runs` together.

    People count from their start. The colours are logarithmic, so that places of waiting do not
    hide paths. `ValueError` if the runs are on different floors.
    """
    several = [runs] if isinstance(runs, Outcome) else list(runs)
    if not several:
        raise ValueError("a heat map needs at least one run")
    plan = several[0].floorplan
    if any(run.floorplan != plan for run in several):
        raise ValueError("the runs are not on the same floor, so that they make no common heat map")
    seconds = sum((time_covered(run) for run in several), np.zeros(_shape(plan)))
    figure, axes = floor_figure(plan, width, beside=_BAR)
    draw_floor(axes, plan, several[0].scene.machines)
    west, south, *_ = plan.boundary.bounds
    rows, columns = seconds.shape
    most = max(float(seconds.max()), 1.0)
    image = axes.imshow(
        np.ma.masked_less_equal(seconds, 0.0),
        origin="lower",
        extent=(west, west + columns * CELL, south, south + rows * CELL),
        norm=LogNorm(most / 1000, most),
        cmap="viridis",
        interpolation="nearest",
        zorder=1.2,
    )
    bar = figure.colorbar(image, ax=axes, label="time occupied (s)", fraction=0.04, pad=0.02)
    bar.ax.yaxis.set_major_formatter("{x:g}")
    return settle(figure)


def time_covered(run: Outcome) -> Array:
    """Return the time for which the middle of each cell was occupied: seconds, (rows, columns).

    The first cell is in the south-west corner of the floor's bounds.
    """
    started = {e["person"]: e["t"] for e in run.events if e["kind"] == "human_started"}
    seconds = np.zeros(_shape(run.floorplan))
    for person in run.scene.people:
        if person.name in started:
            motion = run.motions[person.name]
            at_centre = _time_in_cells(motion, started[person.name], run.duration, run.floorplan)
            seconds += _spread(at_centre, person.radius)
    return seconds


def _shape(plan: Floorplan) -> tuple[int, int]:
    west, south, east, north = plan.boundary.bounds
    return (math.ceil((north - south) / CELL), math.ceil((east - west) / CELL))


def _time_in_cells(motion: Motion, begin: float, end: float, plan: Floorplan) -> Array:
    """Return the time for which the body's centre was in each cell."""
    west, south, *_ = plan.boundary.bounds
    rows, columns = _shape(plan)
    middles: list[NDArray[Any]] = [np.empty(0)]
    weights: list[NDArray[Any]] = [np.empty(0)]
    for piece in motion.cut(begin, end).pieces:
        moves = any((*piece.x[1:], *piece.y[1:]))
        duration = piece.end - piece.begin
        moments = max(1, math.ceil(duration / MOMENT)) if moves else 1
        step = duration / moments
        middles.append(piece.begin + step * (np.arange(moments) + 0.5))
        weights.append(np.full(moments, step))
    x, y = motion.position(np.concatenate(middles)).T
    edges = ((south, south + rows * CELL), (west, west + columns * CELL))
    found = np.histogram2d(y, x, (rows, columns), edges, weights=np.concatenate(weights))
    return np.asarray(found[0])


def _spread(seconds: Array, radius: float) -> Array:
    """Add the time of each cell to all cells within `radius` metres of it."""
    reach = math.ceil(radius / CELL)
    rows, columns = seconds.shape
    padded = np.pad(seconds, reach)
    covered = np.zeros_like(seconds)
    for i in range(-reach, reach + 1):
        for j in range(-reach, reach + 1):
            if math.hypot(i, j) * CELL < radius + _HAIR:
                covered += padded[reach + i :, reach + j :][:rows, :columns]
    return covered
