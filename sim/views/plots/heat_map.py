"""The time for which each spot of a floor was occupied by people."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from floorplan import Floorplan
from navigation import Motion

from ...record.cells import cells_of, spread
from ...record.outcome import Outcome
from ...record.zone_exposure import moments
from .cells import draw_cells, on_one_floor
from .curves import Array
from .style import Width, styled

CELL = 0.05
"""Metres. The side of a cell."""


@styled()
def heat_map(runs: Outcome | Sequence[Outcome], *, width: Width = "double") -> Figure:
    """Draw the time for which each spot was under a person's body, in all `runs` together.

    People count from their start. The colours are logarithmic, so that places of waiting do not
    hide paths. `ValueError` if the runs are on different floors.
    """
    several = on_one_floor(runs, "heat map")
    plan = several[0].floorplan
    seconds = sum((time_covered(run) for run in several), np.zeros(cells_of(plan, CELL)))
    most = max(float(seconds.max()), 1.0)
    return draw_cells(
        plan,
        several[0].scene.machines,
        np.ma.masked_less_equal(seconds, 0.0),
        CELL,
        label="time occupied (s)",
        norm=LogNorm(most / 1000, most),
        colours="viridis",
        width=width,
    )


def time_covered(run: Outcome) -> Array:
    """Return the time for which the middle of each cell was occupied: seconds, (rows, columns).

    The first cell is in the south-west corner of the floor's bounds.
    """
    started = {e["person"]: e["t"] for e in run.events if e["kind"] == "human_started"}
    seconds = np.zeros(cells_of(run.floorplan, CELL))
    for person in run.scene.people:
        if person.name in started:
            motion = run.motions[person.name]
            at_centre = _time_in_cells(motion, started[person.name], run.duration, run.floorplan)
            seconds += spread(at_centre, CELL, person.radius, np.add, 0.0)
    return seconds


def _time_in_cells(motion: Motion, begin: float, end: float, plan: Floorplan) -> Array:
    """Return the time for which the body's centre was in each cell."""
    west, south, *_ = plan.boundary.bounds
    rows, columns = cells_of(plan, CELL)
    times, lengths = moments(motion, begin, end)
    x, y = motion.position(times).reshape(-1, 2).T
    edges = ((south, south + rows * CELL), (west, west + columns * CELL))
    found = np.histogram2d(y, x, (rows, columns), edges, weights=lengths)
    return np.asarray(found[0])
