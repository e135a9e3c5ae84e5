"""Mean density and mean speed of people over a floor: Gaussian profiles, as of PedPy."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np
from matplotlib.colors import PowerNorm
from matplotlib.figure import Figure

from floorplan import UserError

from ...record.cells import cells_of
from ...record.outcome import Outcome
from .cells import draw_cells, on_one_floor
from .curves import Array, Span, span_of
from .style import Width, styled

CELL = 0.1
"""Metres. The side of a cell."""

KERNEL = 1.0
"""Metres. Full width at half maximum of the Gaussian over which a person is spread."""

STEP = 0.1
"""Seconds between two looks at where people are."""

MOST_LOOKS = 20_000
"""Number of looks; of a long run they are further apart."""

AT_ONCE = 1000
"""Number of looks that are worked out together."""

FAINT = 0.01
"""Share of the highest density below which nothing is shown."""

Of = Literal["density", "speed"]


@styled()
def density_map(
    runs: Outcome | Sequence[Outcome],
    *,
    of: Of = "density",
    within: Span | None = None,
    width: Width = "double",
) -> Figure:
    """Draw the mean density (1/m²) of people in all `runs`, or `of` their speed (m/s) the mean.

    `within` (from, to in seconds) is the part of each run that counts. The colours of densities
    are spread, so that paths show beside places of waiting. `ValueError` if the runs are on
    different floors, or it is `of` something else.
    """
    if of not in ("density", "speed"):
        raise UserError(f"a density map is of density or speed, not {of!r}")
    several = on_one_floor(runs, "density map")
    plan = several[0].floorplan
    profiles = [profiles_of(run, within) for run in several]
    density = np.mean([found for found, _ in profiles], axis=0)
    flow = np.mean([found * speed for found, speed in profiles], axis=0)
    most = float(density.max())
    values = density if of == "density" else flow / np.where(density > 0, density, 1.0)
    is_density = of == "density"
    return draw_cells(
        plan,
        several[0].scene.machines,
        np.ma.masked_where(density <= FAINT * most, values),
        CELL,
        label="mean density (1/m²)" if is_density else "mean speed (m/s)",
        norm=PowerNorm(0.5 if is_density else 1.0, 0.0, float(values.max()) or 1.0),
        colours="viridis",
        width=width,
    )


def profiles_of(run: Outcome, within: Span | None = None) -> tuple[Array, Array]:
    """Return mean density (1/m²) and mean speed (m/s) at the middles of cells: (rows, columns).

    The first cell is in the south-west corner of the floor's bounds. Speed is weighted by density,
    and 0 where nobody came near.
    """
    west, south, *_ = run.floorplan.boundary.bounds
    rows, columns = cells_of(run.floorplan, CELL)
    middles_x, middles_y = (
        low + CELL * (np.arange(count) + 0.5) for low, count in ((west, columns), (south, rows))
    )
    begin, end = span_of(run, within)
    count = min(max(1, round((end - begin) / STEP)), MOST_LOOKS)
    times = begin + (np.arange(count) + 0.5) * (end - begin) / count
    density, flow = np.zeros((2, middles_y.size, middles_x.size))
    for person in run.scene.people:
        here = times[run.is_present(person.name, times)]
        for some in np.array_split(here, math.ceil(here.size / AT_ONCE) or 1):
            x, y = run.motions[person.name].position(some).T
            speed = np.hypot(*run.motions[person.name].velocity(some).T)
            across, along = _gaussian(middles_y, y) / count, _gaussian(middles_x, x)
            density += across @ along.T
            flow += (across * speed) @ along.T
    return density, flow / np.where(density > 0, density, 1.0)


def _gaussian(middles: Array, places: Array) -> Array:
    """Return how dense people at `places` along an axis are in the `middles` of cells, per m."""
    sigma = KERNEL / (2.0 * math.sqrt(2.0 * math.log(2.0)))
    apart = np.subtract.outer(middles, places) / sigma
    return np.asarray(np.exp(-(apart**2) / 2.0) / (math.sqrt(2.0 * math.pi) * sigma))
