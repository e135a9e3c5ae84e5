"""A space–time diagram: x and y of people and machines over time."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from navigation import Motion

from ...core.machine import MachineShape
from ...record.outcome import Outcome
from ..colours import GREY
from .curves import Array, Span, instants, span_of, while_present
from .incidents import breaches, mark_breaches
from .style import (
    MACHINES,
    OF_MANY,
    Width,
    are_few,
    explain,
    label_time,
    new_figure,
    person_colour,
    person_label,
    styled,
)

_PANEL = 2.3
"""Inches. The height of one axis's panel."""


@styled()
def space_time(run: Outcome, *, within: Span | None = None, width: Width = "double") -> Figure:
    """Draw x and y of all that moves, over time (seconds), as bands as wide as the bodies.

    Two bodies whose bands meet in both panels at an instant are at one place. Stations are the
    lines across.
    """
    span = span_of(run, within)
    figure = new_figure(width, 2 * _PANEL + 0.3)
    panels = figure.subplots(2, 1, sharex=True)
    for axis, axes in enumerate(panels):
        _draw_stations(axes, run, axis)
        for body in _shown(run):
            _draw_body(axes, run, body, axis, span)
        mark_breaches(axes, [(t, at[axis]) for t, at in breaches(run, span)])
        axes.set_ylabel(f"{'xy'[axis]} (m)")
        axes.margins(y=0.04)
    panels[1].set_xlim(*span)
    label_time(panels[1], span[1] - span[0])
    explain(figure, [panels[0]], width)
    return figure


def _shown(run: Outcome) -> list[str]:
    """Machines that move at all, robots in any case, and then people."""
    machines = [
        machine.name
        for machine in run.scene.machines
        if machine.category == "robot"
        or any(piece.moves for piece in run.motions[machine.name].pieces)
    ]
    return [*machines, *(person.name for person in run.scene.people)]


def _draw_body(axes: Axes, run: Outcome, body: str, axis: int, span: Span) -> None:
    motion = run.motions[body]
    there = while_present(run, body, span)
    if there is None:
        return
    t = instants([motion], *there)
    at = motion.position(t)[:, axis]
    people = [person.name for person in run.scene.people]
    if body in people:
        index = people.index(body)
        half = np.full(len(t), run.scene.people[index].radius)
        colour, label = person_colour(index), person_label(body, len(people))
    else:
        machine = run.scene.machine(body)
        half = _half_extent(machine, motion, t, axis)
        colour = MACHINES[machine.category]
        # Vehicles, of which there may be many, have their names at their bands.
        label = body if machine.category == "robot" else f"_{body}"
    line, shade = (0.9, 0.3) if body not in people or are_few(len(people)) else (OF_MANY, 0.15)
    axes.fill_between(t, at - half, at + half, facecolor=colour, alpha=shade, linewidth=0)
    axes.plot(t, at, color=colour, linewidth=line, label=label)
    if label != body and body not in people and axis == 1:
        axes.annotate(body, (there[0], at[0]), (2, 2), textcoords="offset points", size=6)


def _half_extent(machine: MachineShape, motion: Motion, t: Array, axis: int) -> Array:
    """Return half the extent of a machine along x (0) or y (1) at these instants: (N,) metres."""
    turn = motion.rotation(t) - axis * math.pi / 2
    return np.abs(machine.length / 2 * np.cos(turn)) + np.abs(machine.width / 2 * np.sin(turn))


def _draw_stations(axes: Axes, run: Outcome, axis: int) -> None:
    named: dict[float, list[str]] = {}
    for station in run.floorplan.stations:
        named.setdefault(station.position[axis], []).append(station.name)
    for at, names in named.items():
        axes.axhline(at, color=GREY, linewidth=0.4, linestyle=":", zorder=0)
        axes.annotate(
            "\n".join(names),
            (1.0, at),
            (3, 0),
            xycoords=axes.get_yaxis_transform(),
            textcoords="offset points",
            size=6,
            va="center",
            color=GREY,
        )
