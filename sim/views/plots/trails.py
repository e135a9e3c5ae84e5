"""The paths of people and machines on the floor, and the places of violations."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from shapely.geometry import Polygon

from ...record.outcome import Outcome
from ..colours import PALE, PALE_ORANGE
from .curves import Array, Span, instants, span_of, while_present
from .floor import draw_floor, fill_area, floor_figure
from .incidents import breaches, mark_breaches
from .names import draw_names
from .style import MACHINES, OF_MANY, Width, are_few, explain, person_colour, person_label, styled

_THIN = 1.0
"""Points. The line of the person who is drawn last."""

_EDGES = 2.4
"""Points by which the line of each person before is wider, so that it shows on both sides."""

_WIDEST = 8.0
"""Points. Of several people the edges are smaller, so that no line is wider than this."""

_GAP = 0.3
"""The white on both sides of a line, as a share of the edges: tells greys apart, too."""


_ABBREVIATION = 3
"""A kind of no more letters than this is one, and written in capitals."""


@styled()
def trails(run: Outcome, *, within: Span | None = None, width: Width = "double") -> Figure:
    """Draw the paths of people and machines on the floor, `within` a stretch of time (seconds).

    The path of a person who is put elsewhere is broken there. Where people took the same path,
    the lines of those who come later in their order lie on the wider lines of those before.
    """
    begin, end = span_of(run, within)
    figure, axes = floor_figure(run.floorplan, width)
    draw_floor(axes, run.floorplan, run.scene.machines)
    paths = [_draw_path(axes, run, body, (begin, end)) for body in run.motions]
    places = [at for _, at in breaches(run, (begin, end))]
    mark_breaches(axes, places)
    explain(figure, [axes], width)
    outlines = {machine.name: _outline(run, machine.name, end) for machine in run.scene.machines}
    draw_names(axes, run.floorplan, paths=paths, marked=places, machines=outlines)
    return figure


def _outline(run: Outcome, name: str, t: float) -> Polygon:
    """The outline of a machine at `t` (seconds)."""
    motion = run.motions[name]
    return run.scene.machine(name).footprint(motion.state(t).at, float(motion.rotation(t)))


def _draw_path(axes: Axes, run: Outcome, body: str, span: Span) -> Array:
    """Draw the path of a body; return its points (N, 2), NaN where it is broken."""
    motion = run.motions[body]
    there = while_present(run, body, span)
    if there is None:
        return np.empty((0, 2))
    path = motion.position(instants([motion], *there))
    people = [person.name for person in run.scene.people]
    if body in people:
        index = people.index(body)
        later = len(people) - 1 - index
        few = are_few(len(people))
        edges = min(_EDGES, (_WIDEST - _THIN) / len(people)) if few else 0.0
        width = (_THIN if few else OF_MANY) + later * edges
        axes.plot(
            *path.T,
            color=person_colour(index),
            linewidth=width,
            path_effects=[withStroke(linewidth=width + _GAP * edges, foreground="white")],
            label=person_label(body, len(people)),
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
    """Return the label of a kind of machine, hidden from the legend where it stands already."""
    name = kind.upper() if len(kind) <= _ABBREVIATION else kind.replace("_", " ")
    return f"_{name}" if name in axes.get_legend_handles_labels()[1] else name
