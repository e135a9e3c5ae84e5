"""Risk over a floor: how near people came to the distance that the rules require, and how long."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.colors import LogNorm, Normalize, TwoSlopeNorm
from matplotlib.figure import Figure

from floorplan import Floorplan

from ...core.machine import MachineShape
from ...record.outcome import Outcome
from ...record.risk import CELL, Risk, risk, risk_of_all
from .curves import Array
from .floor import draw_floor, floor_figure, settle
from .style import Width, styled

_BAR = 0.7
"""Inches. The width of the bar of colours."""


def risk_map(
    runs: Outcome | Sequence[Outcome], *, of: Risk = "margin", width: Width = "double"
) -> Figure:
    """Draw the risk at each spot that was under a person's body, in all `runs` together.

    `of` is "margin": the least that their distance to any machine was more than the rules required
    (negative where it was less); "time": for how long it was less; or "severity": the highest
    speed of the two relative to each other meanwhile. `ValueError` if the runs are on different
    floors, or `of` is none of these.
    """
    several = [runs] if isinstance(runs, Outcome) else list(runs)
    if not several:
        raise ValueError("a risk map needs at least one run")
    plan = several[0].floorplan
    if any(run.floorplan != plan for run in several):
        raise ValueError("the runs are not on the same floor, so that they make no common map")
    found = risk_of_all([risk(run, of) for run in several], of)
    return drawn_risk(plan, several[0].scene.machines, found, of=of, width=width)


@styled()
def drawn_risk(
    plan: Floorplan,
    machines: Iterable[MachineShape],
    found: Array,
    *,
    of: Risk = "margin",
    width: Width = "double",
) -> Figure:
    """Draw the risk that was `found` in each cell (rows, columns) of a floor."""
    norm: Normalize
    if of == "margin":
        shown, label = np.ma.masked_invalid(found), "least margin to the required distance (m)"
        worst = min(float(shown.min()) if shown.count() else 0.0, -0.1)
        best = max(float(shown.max()) if shown.count() else 0.0, 0.1)
        norm, colours = TwoSlopeNorm(0.0, worst, best), "RdYlBu"
    else:
        shown = np.ma.masked_less_equal(found, 0.0)
        most = max(float(found.max()), 0.1)
        if of == "time":
            label, norm = "time nearer than required (s)", LogNorm(most / 1000, most)
        else:
            label, norm = "relative speed while nearer than required (m/s)", Normalize(0.0, most)
        colours = "inferno_r"
    figure, axes = floor_figure(plan, width, beside=_BAR)
    draw_floor(axes, plan, machines)
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
    return settle(figure)
