"""Maps of a floor in cells, each in the colour of its figure."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from textwrap import wrap
from typing import Any

from matplotlib.colors import Normalize, TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from floorplan import Floorplan, UserError

from ...core.machine import MachineShape
from ...record.outcome import Outcome
from .floor import draw_floor, floor_figure, settle
from .style import Width

_TICKS = MaxNLocator(4)

_LETTER = 0.065
"""Inches. The width of a letter beside the bar of colours, on average."""


def on_one_floor(runs: Outcome | Sequence[Outcome], what: str) -> list[Outcome]:
    """Return `runs` as a list; `ValueError` if there is none, or they are on different floors.

    `what` says in the error what they were to make.
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
    """Draw what is `shown` of a floor: a masked array (rows, columns) of cells `cell` metres wide.

    The first is in the south-west corner of the floor's bounds. The bar of colours takes `beside`
    inches, with its `label`.
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
    if isinstance(norm, TwoSlopeNorm):  # its halves, below and above 0, have scales of their own
        ends = ((norm.vmin or 0.0, 0.0), (0.0, norm.vmax or 0.0))
        marks = {t for low, high in ends for t in _TICKS.tick_values(low, high) if low <= t <= high}
        bar.set_ticks(sorted(marks))
    bar.ax.yaxis.set_major_formatter("{x:g}")
    return settle(figure)
