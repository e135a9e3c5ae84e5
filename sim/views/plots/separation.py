"""The distance of a person to a machine over time, and the required distance."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from floorplan import UserError
from navigation import STANDING_SPEED

from ...record.outcome import Outcome
from ..colours import BLACK, BLUE, GREY, VERMILION
from .curves import Array, Span, instants, span_of, speeds
from .incidents import disabled_spans
from .style import Width, explain, label_time, new_figure, styled

SHOWN = 3.0
"""Distances of more than this many times the largest required one are cut off."""

COLUMNS = 400
"""A long run is drawn in so many columns of equal time."""

DENSEST = 12
"""Instants in a column, from which a run is a long one: its curves would be a solid block."""

MARKS = 60
"""Of a long run's violations, no more marks than this stand above the plot."""

MOST = 6
"""So many pairs are drawn, a page of them, where there are more and nobody was named."""

_PANEL = 1.9
"""Inches. The height of one pair's panel."""

_ALIKE = 3
"""Decimals. Margins (metres) that are the same to so many count as equal."""

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
    """Draw the distance over time, the required one, and the time in which it was not kept.

    One panel for each person (or the ones called `person`) beside `machine`: by default the first
    robot, or where there is none, the vehicle that they were too close to for longest, or that
    drives first. Of more than `MOST` people who were not named, those with the least margin to the
    required distance are drawn, the least first, and a line below says so. Nothing is required of a
    vehicle that stands. `ValueError` if there is no such pair.
    """
    begin, end = span_of(run, within)
    named = [person] if isinstance(person, str) else person
    everybody = _pairs(run, named, machine)
    pairs, who = everybody, ""
    if named is None and len(everybody) > MOST:
        pairs, who = _nearest(run, everybody, (begin, end))
    figure = new_figure(width, _PANEL * len(pairs) + 0.3)
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
    asked = [(name, people, "person") for name in named or ()]
    asked += [(name, machines, "machine") for name in (machine,) if name is not None]
    for name, known, what in asked:
        if name not in known:
            raise UserError(f"no {what} is called {name!r} (there are: {', '.join(known)})")
    chosen = [name for name in people if named is None or name in named]
    pairs = [[(name, body) for body in machines] for name in chosen]
    if machine is not None:
        return [pair for one in pairs for pair in one if pair[1] == machine]
    return [min(one, key=partial(_order, run)) for one in pairs]


def _order(run: Outcome, pair: Pair) -> tuple[bool, float, float]:
    """Robots before vehicles; those by the time too close, then as they set out."""
    motion = run.motions[pair[1]]
    sets_out = min((piece.begin for piece in motion.pieces if piece.moves), default=np.inf)
    is_robot = run.scene.machine(pair[1]).category == "robot"
    close = sum(end - begin for begin, end in run.violations.get(pair, ()))
    return (not is_robot, 0.0 if is_robot else -close, float(sets_out))


def _nearest(run: Outcome, pairs: list[Pair], span: Span) -> tuple[list[Pair], str]:
    """Return the pairs with the least margin, the least first, and what they are, in words.

    Of equal margins that with more violations comes first, as where each puts the person elsewhere,
    and then the nearer one; where nothing was required of any, that is all.
    """
    # A person who is put elsewhere as they appear was never seen where the violation was.
    violations: dict[Pair, list[float]] = {pair: [] for pair in pairs}
    for event in run.events:
        if event["kind"] == "violation" and span[0] <= event["t"] <= span[1]:
            found = violations.get((event["person"], event["with"]), [])
            found.append(event["distance"] - event["required"])

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


def _curves(run: Outcome, pair: Pair, span: Span) -> tuple[Array, Array, Array]:
    """Return instants (s), distances and required distances (m): (N,), NaN where none is."""
    t = instants([run.motions[name] for name in pair], *span)
    return t, run.distance(*pair, t), _required(run, pair, t)


def _draw_pair(axes: Axes, run: Outcome, pair: Pair, span: Span) -> None:
    t, distance, required = _curves(run, pair, span)
    close = distance < required
    highest = SHOWN * float(np.nanmax(required)) if np.isfinite(required).any() else np.inf
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
    axes.set_ylabel("distance (m)")
    axes.set_title(f"{pair[0]} and {pair[1]}", loc="left")
    _mark_violations(axes, run, pair, span)
    _mark_disabled(axes, run, pair[1])


def _draw_columns(axes: Axes, t: Array, distance: Array, required: Array, span: Span) -> None:
    """Draw what is too dense for curves: in each column of time the ends of what was there."""
    edges = np.linspace(*span, COLUMNS + 1)
    known = np.isfinite(distance)
    column = np.clip(np.searchsorted(edges, t[known], "right") - 1, 0, COLUMNS - 1)
    nearest = np.full(COLUMNS, np.inf)
    farthest = np.full(COLUMNS, -np.inf)
    largest = np.full(COLUMNS, -np.inf)
    np.minimum.at(nearest, column, distance[known])
    np.maximum.at(farthest, column, distance[known])
    np.fmax.at(largest, column, required[known])
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
    """Return the required distance at these instants (N,), metres; NaN where there is none."""
    required = np.full(len(t), np.nan)
    known = ~np.isnan(t)
    required[known] = run.required(*pair, t[known])
    if run.scene.machine(pair[1]).category == "vehicle":
        required[known & ~(speeds(run.motions[pair[1]], t) > STANDING_SPEED)] = np.nan
    return required


def _mark_violations(axes: Axes, run: Outcome, pair: Pair, span: Span) -> None:
    """Mark the begin of each violation, and shade the time that it lasted."""
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
    """Draw a bar at the bottom for the time in which the machine was disabled."""
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
