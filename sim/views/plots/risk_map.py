"""Risk over a floor: how near people came to the distance that the rules require, and how long."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.colors import LogNorm, Normalize, TwoSlopeNorm
from matplotlib.figure import Figure

from floorplan import Floorplan, UserError

from ...core.machine import MachineShape
from ...record.outcome import Outcome
from ...record.risk import CELL, Risk, risk, risk_of_all
from ..colours import GREY
from .cells import draw_cells, on_one_floor
from .curves import Array
from .style import Width, styled

_BAR = 0.7
"""Inches. The width of the bar of colours."""

_NEVER = "Nobody was nearer than required for any time: violations, if any, ended at once."


def risk_map(
    runs: Outcome | Sequence[Outcome], *, of: Risk = "margin", width: Width = "double"
) -> Figure:
    """Draw the risk at each spot that was under a person's body, in all `runs` together.

    `of` is "margin": the least that their distance to any machine was more than the rules required
    (negative where it was less); "time": for how long it was less; or "severity": the highest
    speed of the two relative to each other meanwhile. `ValueError` if the runs are on different
    floors, in none of them are people and machines, or `of` is none of these.
    """
    several = on_one_floor(runs, "risk map")
    if not any(run.scene.people and run.scene.machines for run in several):
        raise UserError("a risk map needs a person and a machine; there is no such pair")
    plan = several[0].floorplan
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
