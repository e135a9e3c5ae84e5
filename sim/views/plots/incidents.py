"""Violations and stops of a run, for the marks in its pictures."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes

from floorplan import Point

from ...machines.gantry.robot import GANTRY
from ...record.outcome import Outcome
from ..colours import VERMILION
from .curves import Span


def breaches(run: Outcome, span: Span) -> list[tuple[float, Point]]:
    """Return instant (seconds) and place of the person for every violation within `span`."""
    begin, end = span
    return sorted(
        (t, run.motions[person].state_before(t).at)
        for (person, _), intervals in run.violations.items()
        for t, _ in intervals
        if begin <= t <= end
    )


def mark_breaches(axes: Axes, places: Sequence[Point]) -> None:
    """Mark the `places` of violations on `axes`."""
    if places:
        axes.plot(
            *zip(*places, strict=True),
            "v",
            color=VERMILION,
            markersize=4.5,
            markeredgecolor="white",
            markeredgewidth=0.4,
            label="too close",
            zorder=5,
        )


def disabled_spans(run: Outcome, machine: str) -> list[Span]:
    """Return begin and end (seconds) of the times in which a machine was disabled."""
    spans: list[Span] = []
    since: float | None = None
    for event in run.events:
        if event.get("machine", GANTRY) != machine:
            continue
        if event["kind"] in ("gantry_disabled", "robot_malfunction") and since is None:
            since = event["t"]
        elif event["kind"] == "gantry_enabled" and since is not None:
            spans.append((since, event["t"]))
            since = None
    return spans if since is None else [*spans, (since, run.duration)]
