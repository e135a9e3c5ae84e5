"""Maps of a floor in cells: occupancy, density, speed and risk."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from textwrap import wrap
from typing import Any, Literal

import numpy as np
from matplotlib.colors import LogNorm, Normalize, PowerNorm, TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from floorplan import Floorplan, UserError
from navigation import Motion

from ...core.body import MachineShape
from ...record.incidents import CELL, Risk, risk, risk_of_all
from ...record.outcome import Outcome, span_of
from ...record.sampling import Span, cells_of, moments, spread
from ...record.warm_up import started
from ..report_page import GREY
from .floor import draw_floor, floor_figure
from .style import Array, Width, settle, styled

_TICKS = MaxNLocator(4)

_LETTER = 0.065
"""Inches. Mean width of a letter beside the colour bar."""


def on_one_floor(runs: Outcome | Sequence[Outcome], what: str) -> list[Outcome]:
    """Return `runs` as a list.

    Raises `ValueError` if there is none, or if they are on different floors. `what` is the name of
    the picture in the message.
    """
    several = [runs] if isinstance(runs, Outcome) else list(runs)
    if not several:
        raise UserError(f"a {what} needs at least one run")
    if any(run.floorplan != several[0].floorplan for run in several):
        raise UserError(f"the runs are not on the same floor, so that they make no common {what}")
    return several


def draw_cells(
    plan: Floorplan,
    machines: Iterable[MachineShape],
    shown: Any,
    cell: float,
    *,
    label: str,
    norm: Normalize,
    colours: str,
    width: Width,
    beside: float = 0.6,
) -> Figure:
    """Draw values of a floor: a masked array (rows, columns) of cells with side `cell` (m).

    The first cell is in the south-west corner of the bounds of the floor. The colour bar takes
    `beside` inches and has a `label`.
    """
    figure, axes = floor_figure(plan, width, beside=beside)
    draw_floor(axes, plan, machines)
    west, south, *_ = plan.boundary.bounds
    rows, columns = shown.shape
    image = axes.imshow(
        shown,
        origin="lower",
        extent=(west, west + columns * cell, south, south + rows * cell),
        norm=norm,
        cmap=colours,
        interpolation="nearest",
        zorder=1.2,
    )
    lines = wrap(label, int(figure.get_figheight() / _LETTER))
    bar = figure.colorbar(image, ax=axes, label="\n".join(lines), fraction=0.04, pad=0.02)
    if isinstance(norm, TwoSlopeNorm):  # the halves below and above 0 have different scales
        ends = ((norm.vmin or 0.0, 0.0), (0.0, norm.vmax or 0.0))
        marks = {t for low, high in ends for t in _TICKS.tick_values(low, high) if low <= t <= high}
        bar.set_ticks(sorted(marks))
    bar.ax.yaxis.set_major_formatter("{x:g}")
    return settle(figure)


HEAT_CELL = 0.05
"""Metres. Side of a cell."""


@styled()
def heat_map(runs: Outcome | Sequence[Outcome], *, width: Width = "double") -> Figure:
    """Draw the time for which each cell was occupied by people, summed over all runs.

    Colours are logarithmic, so that waiting does not hide paths.

    Parameters
    ----------
    runs : Run or sequence of Run
        Runs on the same floor.
    width : {"single", "double"}, optional
        Number of columns of a paper.

    Returns
    -------
    Figure
        The plot.

    Raises
    ------
    ValueError
        If the runs are on different floors or without people.
    """
    several = on_one_floor(runs, "heat map")
    if not any(run.scene.people for run in several):
        raise UserError("a heat map needs a person; there is none")
    plan = several[0].floorplan
    seconds = sum((time_covered(run) for run in several), np.zeros(cells_of(plan, HEAT_CELL)))
    most = max(float(seconds.max()), 1.0)
    return draw_cells(
        plan,
        several[0].scene.machines,
        np.ma.masked_less_equal(seconds, 0.0),
        HEAT_CELL,
        label="time occupied (s)",
        norm=LogNorm(most / 1000, most),
        colours="viridis",
        width=width,
    )


def time_covered(run: Outcome) -> Array:
    """Return the time (s) for which the centre of each cell was occupied, (rows, columns).

    The first cell is in the south-west corner of the bounds of the floor.
    """
    starts = started(run)
    seconds = np.zeros(cells_of(run.floorplan, HEAT_CELL))
    for person in run.scene.people:
        if person.name in starts:
            motion = run.motions[person.name]
            at_centre = _time_in_cells(motion, starts[person.name], run.duration, run.floorplan)
            seconds += spread(at_centre, HEAT_CELL, person.radius, np.add, 0.0)
    return seconds


def _time_in_cells(motion: Motion, begin: float, end: float, plan: Floorplan) -> Array:
    """Return the time (s) for which the body's centre was in each cell."""
    west, south, *_ = plan.boundary.bounds
    rows, columns = cells_of(plan, HEAT_CELL)
    times, lengths = moments(motion, begin, end)
    x, y = motion.position(times).reshape(-1, 2).T
    edges = ((south, south + rows * HEAT_CELL), (west, west + columns * HEAT_CELL))
    histogram = np.histogram2d(y, x, (rows, columns), edges, weights=lengths)
    return np.asarray(histogram[0])


DENSITY_CELL = 0.1
"""Metres. Side of a cell."""

KERNEL = 1.0
"""Metres. Full width at half maximum of the Gaussian over which a person is spread."""

STEP = 0.1
"""Seconds between two samples."""

MOST_LOOKS = 20_000
"""Maximum number of samples."""

AT_ONCE = 1000
"""Number of samples that are evaluated together."""

FAINT = 0.01
"""Share of the highest density below which cells are empty."""

Of = Literal["density", "speed"]


@styled()
def density_map(
    runs: Outcome | Sequence[Outcome],
    *,
    of: Of = "density",
    within: Span | None = None,
    width: Width = "double",
) -> Figure:
    """Draw the mean density or speed of people on the floor.

    Parameters
    ----------
    runs : Run or sequence of Run
        Runs on the same floor.
    of : {"density", "speed"}, optional
        Mean density (1/m²), with a non-linear colour scale, or mean speed (m/s).
    within : (float, float), optional
        Begin and end in seconds of the part of each run. Defaults to the whole run.
    width : {"single", "double"}, optional
        Number of columns of a paper.

    Returns
    -------
    Figure
        The plot.

    Raises
    ------
    ValueError
        If the runs are on different floors, or `of` is unknown.
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
        DENSITY_CELL,
        label="mean density (1/m²)" if is_density else "mean speed (m/s)",
        norm=PowerNorm(0.5 if is_density else 1.0, 0.0, float(values.max()) or 1.0),
        colours="viridis",
        width=width,
    )


def profiles_of(run: Outcome, within: Span | None = None) -> tuple[Array, Array]:
    """Return mean density (1/m²) and mean speed (m/s) at the centres of cells, (rows, columns).

    The first cell is in the south-west corner of the bounds of the floor. Speed is weighted by
    density, and 0 in cells without people.
    """
    west, south, *_ = run.floorplan.boundary.bounds
    rows, columns = cells_of(run.floorplan, DENSITY_CELL)
    middles_x, middles_y = (
        low + DENSITY_CELL * (np.arange(count) + 0.5)
        for low, count in ((west, columns), (south, rows))
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
    """Return the density (1/m) of people at `places` along an axis in the `middles` of cells."""
    sigma = KERNEL / (2.0 * math.sqrt(2.0 * math.log(2.0)))
    apart = np.subtract.outer(middles, places) / sigma
    return np.asarray(np.exp(-(apart**2) / 2.0) / (math.sqrt(2.0 * math.pi) * sigma))


_BAR = 0.7
"""Inches. Width of the colour bar."""

_NEVER = "Nobody was nearer than required for any time: violations, if any, ended at once."


def risk_map(
    runs: Outcome | Sequence[Outcome], *, of: Risk = "margin", width: Width = "double"
) -> Figure:
    """Draw the risk in each cell that was occupied by people.

    Parameters
    ----------
    runs : Run or sequence of Run
        Runs on the same floor.
    of : {"margin", "time", "severity"}, optional
        "margin": minimum of the distance to any machine minus the required distance (m). "time":
        duration of violations (s). "severity": highest relative speed during violations (m/s).
    width : {"single", "double"}, optional
        Number of columns of a paper.

    Returns
    -------
    Figure
        The plot.

    Raises
    ------
    ValueError
        If the runs are on different floors, contain no people or machines, or `of` is unknown.
    """
    several = on_one_floor(runs, "risk map")
    if not any(run.scene.people and run.scene.machines for run in several):
        raise UserError("a risk map needs a person and a machine; there is no such pair")
    plan = several[0].floorplan
    joint = risk_of_all([risk(run, of) for run in several], of)
    return drawn_risk(plan, several[0].scene.machines, joint, of=of, width=width)


@styled()
def drawn_risk(
    plan: Floorplan,
    machines: Iterable[MachineShape],
    values: Array,
    *,
    of: Risk = "margin",
    width: Width = "double",
) -> Figure:
    """Draw the risk in each cell (rows, columns) of a floor."""
    norm: Normalize
    if of == "margin":
        shown, label = np.ma.masked_invalid(values), "least margin to the required distance (m)"
        worst = min(float(shown.min()) if shown.count() else 0.0, -0.1)
        best = max(float(shown.max()) if shown.count() else 0.0, 0.1)
        norm, colours = TwoSlopeNorm(0.0, worst, best), "RdYlBu"
    else:
        shown = np.ma.masked_less_equal(values, 0.0)
        most = max(float(values.max()), 0.1)
        if of == "time":
            label, norm = "time nearer than required (s)", LogNorm(most / 1000, most)
        else:
            label, norm = "relative speed while nearer than required (m/s)", Normalize(0.0, most)
        colours = "inferno_r"
    figure = draw_cells(
        plan,
        machines,
        shown,
        CELL,
        label=label,
        norm=norm,
        colours=colours,
        width=width,
        beside=_BAR,
    )
    if of != "margin" and not shown.count():
        figure.supxlabel(_NEVER, fontsize=7, color=GREY)
    return figure
