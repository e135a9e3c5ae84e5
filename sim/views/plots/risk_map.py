"""Risk over a floor: how near people came to the distance that the rules require, and how long."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, Literal

import numpy as np
from matplotlib.colors import LogNorm, Normalize, TwoSlopeNorm
from matplotlib.figure import Figure

from floorplan import Floorplan

from ...record.outcome import Outcome
from ...record.zone_exposure import moments, within
from .curves import Array
from .floor import draw_floor, floor_figure
from .style import Width, styled

CELL = 0.1
"""Metres. The side of a cell."""

Risk = Literal["margin", "time"]
"""The least margin to the required distance (m), or the time without it (s)."""

_BAR = 0.7
"""Inches. The width of the bar of colours."""

_HAIR = 1e-9
"""Metres. Cells that are beyond a radius by no more than this still count."""


@styled()
def risk_map(
    runs: Outcome | Sequence[Outcome], *, of: Risk = "margin", width: Width = "double"
) -> Figure:
    """Draw the risk at each spot that was under a person's body, in all `runs` together.

    `of` is "margin": the least that their distance to any machine was more than the rules required
    (negative where it was less); or "time": for how long it was less. `ValueError` if the runs are
    on different floors, or `of` is neither.
    """
    several = [runs] if isinstance(runs, Outcome) else list(runs)
    if not several:
        raise ValueError("a risk map needs at least one run")
    plan = several[0].floorplan
    if any(run.floorplan != plan for run in several):
        raise ValueError("the runs are not on the same floor, so that they make no common map")
    norm: Normalize
    if of == "margin":
        found = np.minimum.reduce([least_margins(run) for run in several])
        shown, label = np.ma.masked_invalid(found), "least margin to the required distance (m)"
        worst = min(float(shown.min()) if shown.count() else 0.0, -0.1)
        best = max(float(shown.max()) if shown.count() else 0.0, 0.1)
        norm, colours = TwoSlopeNorm(0.0, worst, best), "RdYlBu"
    elif of == "time":
        found = np.add.reduce([time_too_close(run) for run in several])
        shown, label = np.ma.masked_less_equal(found, 0.0), "time nearer than required (s)"
        most = max(float(found.max()), 0.1)
        norm, colours = LogNorm(most / 1000, most), "inferno_r"
    else:
        raise ValueError(f"a risk map is of margin or time, not {of!r}")
    figure, axes = floor_figure(plan, width, beside=_BAR)
    draw_floor(axes, plan, several[0].scene.machines)
    west, south, *_ = plan.boundary.bounds
    rows, columns = found.shape
    image = axes.imshow(
        shown,
        origin="lower",
        extent=(west, west + columns * CELL, south, south + rows * CELL),
        norm=norm,
        cmap=colours,
        interpolation="nearest",
        zorder=1.2,
    )
    bar = figure.colorbar(image, ax=axes, label=label, fraction=0.04, pad=0.02)
    bar.ax.yaxis.set_major_formatter("{x:g}")
    return figure


def least_margins(run: Outcome) -> Array:
    """Return the least margin (metres) to any machine in each cell, (rows, columns).

    Infinite where nobody was, or nothing was required. The first cell is in the south-west corner
    of the floor's bounds; nothing is required of a vehicle that stands.
    """
    least = np.full(_shape(run.floorplan), math.inf)
    for person in run.scene.people:
        times, _ = _moments(run, person.name)
        margin = np.full(len(times), math.inf)
        for other, machine in run.violations:
            if other == person.name:
                margin = np.minimum(margin, _margins(run, person.name, machine, times))
        cells = np.full(least.shape, math.inf)
        np.minimum.at(cells, _cells(run, person.name, times), margin)
        least = np.minimum(least, _spread(cells, person.radius, np.minimum, math.inf))
    return least


def time_too_close(run: Outcome) -> Array:
    """Return the time (seconds) for which people in each cell were nearer than required.

    The cells are as of `least_margins`.
    """
    total = np.zeros(_shape(run.floorplan))
    for person in run.scene.people:
        times, lengths = _moments(run, person.name)
        mine = [some for (who, _), some in run.violations.items() if who == person.name]
        intervals = [interval for some in mine for interval in some]
        near = within(times, intervals)
        cells = np.zeros(total.shape)
        np.add.at(cells, _cells(run, person.name, times[near]), lengths[near])
        total += _spread(cells, person.radius, np.add, 0.0)
    return total


def _moments(run: Outcome, person: str) -> tuple[Array, Array]:
    """Return the moments in which a person is on the floor, from their start on."""
    started = [e["t"] for e in run.events if e["kind"] == "human_started" and e["person"] == person]
    begin, end = run.presence[person]
    return moments(run.motions[person], max([begin, *started[:1]]), end if started else begin)


def _margins(run: Outcome, person: str, machine: str, times: Array) -> Array:
    """Return the margin (metres) to one machine at each instant; infinite if none is required."""
    margins = run.distance(person, machine, times) - run.required(person, machine, times)
    if run.scene.machine(machine).category == "vehicle":
        moves = np.hypot(*run.motions[machine].velocity(times).T) > 0.0
        margins = np.where(moves, margins, math.inf)
    return margins


def _shape(plan: Floorplan) -> tuple[int, int]:
    west, south, east, north = plan.boundary.bounds
    return (math.ceil((north - south) / CELL), math.ceil((east - west) / CELL))


def _cells(run: Outcome, person: str, times: Array) -> tuple[Any, Any]:
    """Return the row and column of the cell in which a person's centre is at each instant."""
    west, south, *_ = run.floorplan.boundary.bounds
    rows, columns = _shape(run.floorplan)
    x, y = run.motions[person].position(times).reshape(-1, 2).T
    row = np.clip(((y - south) / CELL).astype(int), 0, rows - 1)
    return row, np.clip(((x - west) / CELL).astype(int), 0, columns - 1)


def _spread(cells: Array, radius: float, join: Callable[..., Array], nothing: float) -> Array:
    """Join each cell with all cells within `radius` metres of it."""
    reach = math.ceil(radius / CELL)
    rows, columns = cells.shape
    padded = np.pad(cells, reach, constant_values=nothing)
    joined = np.full_like(cells, nothing)
    for i in range(-reach, reach + 1):
        for j in range(-reach, reach + 1):
            if math.hypot(i, j) * CELL < radius + _HAIR:
                joined = join(joined, padded[reach + i :, reach + j :][:rows, :columns])
    return joined
