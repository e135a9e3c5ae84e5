"""Figures over time: separation of bodies, and space-time diagrams."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from floorplan import UserError
from navigation import Motion
from navigation.kernels.watch import STANDING_SPEED

from ...core.body import MachineShape
from ...record.outcome import Outcome, span_of
from ...record.sampling import Span
from ..report_page import BLACK, BLUE, GREY, VERMILION
from .style import (
    MACHINES,
    OF_MANY,
    Array,
    Width,
    are_few,
    breaches,
    disabled_spans,
    explain,
    instants,
    label_time,
    mark_breaches,
    new_figure,
    person_colour,
    person_label,
    speeds,
    styled,
    while_present,
)

SHOWN = 3.0
"""Multiple of the largest required distance above which distances are cut off."""

ALWAYS_SHOWN = 4.0
"""Metres. Shorter distances are not cut off."""

COLUMNS = 400
"""Number of columns of equal duration in which a long run is drawn."""

DENSEST = 12
"""Number of samples per column from which a run is drawn in columns instead of curves."""

MARKS = 60
"""Maximum number of marks of violations."""

MOST = 6
"""Maximum number of pairs that are drawn without a selection."""

_SEPARATION_PANEL = 1.9
"""Inches. Height of one pair's panel."""

_DASHES = (
    "-",
    (0, (5, 2)),
    (0, (1, 1.2)),
    (0, (5, 1.5, 1, 1.5)),
    (0, (8, 3)),
    (0, (3, 1, 1, 1, 1, 1)),
)
"""Line styles of several vehicles."""

_ALIKE = 3
"""Decimals of margins (m) that are compared."""

Pair = tuple[str, str]


@styled()
def separation(
    run: Outcome,
    person: str | Sequence[str] | None = None,
    machine: str | None = None,
    *,
    within: Span | None = None,
    width: Width = "double",
) -> Figure:
    """Draw the distance over time, the required distance, and the violations.

    There is one panel for each person.

    Parameters
    ----------
    run : Run
        The run.
    person : str or sequence of str, optional
        Names of people. By default all are drawn. If there are more than `MOST`, those with the
        least margin are drawn, with a note.
    machine : str, optional
        Name of the machine. Defaults to the first robot. If there is none, the vehicle with the
        longest violation, or the first one that moves.
    within : (float, float), optional
        Begin and end in seconds. Defaults to the whole run.
    width : {"single", "double"}, optional
        Number of columns of a paper.

    Returns
    -------
    Figure
        The plot. No distance is required from stationary vehicles.

    Raises
    ------
    ValueError
        If there is no such pair of a person and a machine.
    """
    begin, end = span_of(run, within)
    named = [person] if isinstance(person, str) else person
    everybody = _pairs(run, named, machine)
    pairs, who = everybody, ""
    if named is None and len(everybody) > MOST:
        pairs, who = _nearest(run, everybody, (begin, end))
    figure = new_figure(width, _SEPARATION_PANEL * len(pairs) + 0.3)
    panels = figure.subplots(len(pairs), 1, sharex=True, squeeze=False)[:, 0]
    for axes, pair in zip(panels, pairs, strict=True):
        _draw_pair(axes, run, pair, (begin, end))
    panels[-1].set_xlim(begin, end)
    label_time(panels[-1], end - begin)
    if who:
        other = next(name for name, body in everybody if (name, body) not in pairs)
        lines = (
            f"The {len(pairs)} of {len(everybody)} people {who}.",
            f"Others are drawn by name (--person {other}).",
        )
        note = (" " if width == "double" else "\n").join(lines)
        figure.supxlabel(note, fontsize=7, color=GREY)
    explain(figure, panels, width)
    return figure


def _pairs(run: Outcome, named: Sequence[str] | None, machine: str | None) -> list[Pair]:
    people = [one.name for one in run.scene.people]
    machines = [machine.name for machine in run.scene.machines]
    if not (people and machines):
        raise UserError("a separation needs a person and a machine; this run has no such pair")
    wanted = [(name, people, "person") for name in named or ()]
    wanted += [(name, machines, "machine") for name in (machine,) if name is not None]
    for name, names, what in wanted:
        if name not in names:
            raise UserError(f"no {what} is called {name!r} (there are: {', '.join(names)})")
    chosen = [name for name in people if named is None or name in named]
    pairs = [[(name, body) for body in machines] for name in chosen]
    if machine is not None:
        return [pair for one in pairs for pair in one if pair[1] == machine]
    return [min(one, key=partial(_order, run)) for one in pairs]


def _order(run: Outcome, pair: Pair) -> tuple[bool, float, float]:
    """Return the sort key of a pair: robots before vehicles, then time too close, then start."""
    motion = run.motions[pair[1]]
    sets_out = min((piece.begin for piece in motion.pieces if piece.moves), default=np.inf)
    is_robot = run.scene.machine(pair[1]).category == "robot"
    close = sum(end - begin for begin, end in run.violations.get(pair, ()))
    return (not is_robot, 0.0 if is_robot else -close, float(sets_out))


def _nearest(run: Outcome, pairs: list[Pair], span: Span) -> tuple[list[Pair], str]:
    """Return the pairs with the least margin in order, and a description.

    Equal margins are ordered by the number of violations, then by distance.
    """
    # A person who is teleported immediately has no sample at the position of the violation.
    violations: dict[Pair, list[float]] = {pair: [] for pair in pairs}
    for event in run.events:
        if event["kind"] == "violation" and span[0] <= event["t"] <= span[1]:
            margins = violations.get((event["person"], event["with"]), [])
            margins.append(event["distance"] - event["required"])

    def order(pair: Pair) -> tuple[float, int, float]:
        _, distance, required = _curves(run, pair, span)
        nearest, margin = (
            np.fmin.reduce(d, initial=np.inf) for d in (distance, distance - required)
        )
        least = min([*violations[pair], float(margin)])
        return round(least, _ALIKE), -len(violations[pair]), float(nearest)

    keys = {pair: order(pair) for pair in pairs}
    chosen = sorted(pairs, key=keys.__getitem__)[:MOST]
    is_required = any(keys[pair][0] < np.inf for pair in chosen)
    return chosen, "with the least margin" if is_required else "who came nearest"


class _Curves(NamedTuple):
    """Times (s), distances and required distances (m), (N,) each, NaN if there is none."""

    t: Array
    distance: Array
    required: Array


def _curves(run: Outcome, pair: Pair, span: Span) -> _Curves:
    """Return the curves of a person and a machine."""
    t = instants([run.motions[name] for name in pair], *span)
    return _Curves(t, run.distance(*pair, t), _required(run, pair, t))


def _draw_pair(axes: Axes, run: Outcome, pair: Pair, span: Span) -> None:
    t, distance, required = _curves(run, pair, span)
    close = distance < required
    highest = np.inf
    if np.isfinite(required).any():
        highest = max(ALWAYS_SHOWN, SHOWN * float(np.nanmax(required)))
    if len(t) > COLUMNS * DENSEST:
        _draw_columns(axes, t, distance, required, span)
    else:
        axes.fill_between(
            t,
            distance,
            required,
            where=close,
            facecolor=VERMILION,
            alpha=0.35,
            linewidth=0,
            interpolate=True,
        )
        axes.plot(t, distance, color=BLUE, label="distance")
        axes.plot(
            t, required, color=BLACK, linestyle="--", linewidth=0.9, label="required distance"
        )
    axes.set_ylim(0.0, min(highest, 1.08 * float(np.nanmax(distance))))
    surfaces = run.scene.rules.between == "surfaces"
    axes.set_ylabel("between surfaces (m)" if surfaces else "distance (m)")
    axes.set_title(f"{pair[0]} and {pair[1]}", loc="left")
    _mark_violations(axes, run, pair, span)
    _mark_disabled(axes, run, pair[1])


def _draw_columns(axes: Axes, t: Array, distance: Array, required: Array, span: Span) -> None:
    """Draw the range of dense curves in each column of time."""
    edges = np.linspace(*span, COLUMNS + 1)
    is_finite = np.isfinite(distance)
    column = np.clip(np.searchsorted(edges, t[is_finite], "right") - 1, 0, COLUMNS - 1)
    nearest = np.full(COLUMNS, np.inf)
    farthest = np.full(COLUMNS, -np.inf)
    largest = np.full(COLUMNS, -np.inf)
    np.minimum.at(nearest, column, distance[is_finite])
    np.maximum.at(farthest, column, distance[is_finite])
    np.fmax.at(largest, column, required[is_finite])
    for ends in (nearest, farthest, largest):
        ends[~np.isfinite(ends)] = np.nan
    middles = (edges[1:] + edges[:-1]) / 2
    axes.fill_between(middles, nearest, farthest, facecolor=BLUE, alpha=0.15, linewidth=0)
    axes.plot(middles, nearest, color=BLUE, label="nearest distance")
    axes.plot(
        middles,
        largest,
        color=BLACK,
        linestyle="--",
        linewidth=0.9,
        label="largest required distance",
    )


def _required(run: Outcome, pair: Pair, t: Array) -> Array:
    """Return the required distances (m) at these times (N,), NaN if there is none."""
    required = np.full(len(t), np.nan)
    is_sampled = ~np.isnan(t)
    required[is_sampled] = run.required(*pair, t[is_sampled])
    if run.scene.machine(pair[1]).category == "vehicle":
        motion, shapes = run.motions[pair[1]], run.scene.shapes(*pair)
        pace = speeds(motion, t)
        if shapes is not None:
            pace[is_sampled] = np.maximum(
                pace[is_sampled], shapes.reach * _turning(motion, t[is_sampled])
            )
        required[is_sampled & ~(pace > STANDING_SPEED)] = np.nan
    return required


def _turning(motion: Motion, t: Array) -> Array:
    """Return the turn rate (rad/s) of a body at `t` (N,)."""
    return np.asarray(np.abs(motion.cubics(t)[:, 2, 1]))


def _mark_violations(axes: Axes, run: Outcome, pair: Pair, span: Span) -> None:
    """Mark the begin of each violation, and shade its duration."""
    begin, end = span
    intervals = run.violations.get(pair, ())
    seen = [(max(a, begin), min(b, end)) for a, b in intervals if b >= begin and a <= end]
    times = [since for since, _ in seen]
    if len(seen) > MARKS:
        grain = (end - begin) / MARKS
        times = [
            begin + (k + 0.5) * grain for k in sorted({int((t - begin) / grain) for t in times})
        ]
    else:
        for since, until in seen:
            axes.axvspan(since, until, facecolor=VERMILION, alpha=0.15, linewidth=0)
    if times:
        axes.plot(
            times,
            [1.0] * len(times),
            "v",
            color=VERMILION,
            markersize=5,
            transform=axes.get_xaxis_transform(),
            clip_on=False,
            label="violation" if len(seen) <= MARKS else "violations",
            zorder=5,
        )


def _mark_disabled(axes: Axes, run: Outcome, machine: str) -> None:
    """Draw a bar at the bottom while the machine was disabled."""
    bars = [(begin, end - begin) for begin, end in disabled_spans(run, machine)]
    if bars and len(bars) <= COLUMNS / 4:
        axes.broken_barh(
            bars,
            (0.0, 0.035),
            facecolor=GREY,
            linewidth=0,
            transform=axes.get_xaxis_transform(),
            label=f"{machine} disabled",
        )


_SPACE_TIME_PANEL = 2.3
"""Inches. Height of one axis's panel."""


@styled()
def space_time(run: Outcome, *, within: Span | None = None, width: Width = "double") -> Figure:
    """Draw x and y of people and machines over time, as bands as wide as the bodies.

    Bodies whose bands overlap in both panels at the same time are at the same place. Horizontal
    lines are stations.

    Parameters
    ----------
    run : Run
        The run.
    within : (float, float), optional
        Begin and end in seconds. Defaults to the whole run.
    width : {"single", "double"}, optional
        Number of columns of a paper.

    Returns
    -------
    Figure
        The plot.
    """
    span = span_of(run, within)
    figure = new_figure(width, 2 * _SPACE_TIME_PANEL + 0.3)
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
    """Return robots, machines that move, and then people."""
    return [*_shown_machines(run), *(person.name for person in run.scene.people)]


def _shown_machines(run: Outcome) -> list[str]:
    return [
        machine.name
        for machine in run.scene.machines
        if machine.category == "robot"
        or any(piece.moves for piece in run.motions[machine.name].pieces)
    ]


def _draw_body(axes: Axes, run: Outcome, body: str, axis: int, span: Span) -> None:
    motion = run.motions[body]
    there = while_present(run, body, span)
    if there is None:
        return
    t = instants([motion], *there)
    at = np.where(run.is_present(body, t), motion.position(t)[:, axis], np.nan)
    dashes = _dashes(run, body)
    people = [person.name for person in run.scene.people]
    if body in people:
        index = people.index(body)
        half = np.full(len(t), run.scene.people[index].radius)
        colour, label = person_colour(index), person_label(body, len(people))
    else:
        machine = run.scene.machine(body)
        half = _half_extent(machine, motion, t, axis)
        colour = MACHINES[machine.category]
        # Vehicles without their own dashes are named beside their bands.
        label = body if machine.category == "robot" or dashes else f"_{body}"
    line, shade = (0.9, 0.3) if body not in people or are_few(len(people)) else (OF_MANY, 0.15)
    axes.fill_between(t, at - half, at + half, facecolor=colour, alpha=shade, linewidth=0)
    axes.plot(t, at, color=colour, linewidth=line, linestyle=dashes or "-", label=label)
    if label != body and body not in people and axis == 1:
        axes.annotate(body, (there[0], at[0]), (2, 2), textcoords="offset points", size=6)


def _dashes(run: Outcome, vehicle: str) -> Any:
    """Return the style of a vehicle's line, or None if there is one vehicle or too many."""
    vehicles = [
        name for name in _shown_machines(run) if run.scene.machine(name).category != "robot"
    ]
    if not 1 < len(vehicles) <= len(_DASHES) or vehicle not in vehicles:
        return None
    return _DASHES[vehicles.index(vehicle)]


def _half_extent(machine: MachineShape, motion: Motion, t: Array, axis: int) -> Array:
    """Return half the extent (m) of a machine along x (0) or y (1) at these times, (N,)."""
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
