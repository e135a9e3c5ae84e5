"""A run without its warm-up."""

from __future__ import annotations

from functools import cached_property

from floorplan.files.dataclass import dataclass

from .outcome import Outcome
from .sampling import Span, Stay, zone_exposures

JUDGED = frozenset({"violation", "penalty", "teleport", "contact"})
"""Kinds of events that are findings. Those of the warm-up are omitted."""


@dataclass(frozen=True, kw_only=True, repr=False)
class AfterWarmUp(Outcome):
    """Outcome of a run from `since` (s) on.

    Motions and events of bodies are those of the whole run. A violation that lasts beyond the
    warm-up begins at its end.
    """

    since: float

    @cached_property
    def stays(self) -> dict[str, tuple[Span, ...]]:
        """Intervals (s) in which each body is on the floor after the warm-up."""
        return {
            name: tuple((max(begin, self.since), end) for begin, end in spans if end > self.since)
            for name, spans in super().stays.items()
        }


def after_warm_up(run: Outcome, since: float) -> Outcome:
    """Return a run without its warm-up, which ends at `since` (s), or the run itself at 0."""
    if since <= 0.0:
        return run
    return AfterWarmUp(
        run.scene,
        run.duration,
        summary=run.summary,
        events=tuple(e for e in run.events if e["kind"] not in JUDGED or e["t"] >= since),
        motions=run.motions,
        violations={
            pair: tuple((max(begin, since), end) for begin, end in spans if end > since)
            for pair, spans in run.violations.items()
        },
        thoughts=run.thoughts,
        requirements=run.requirements,
        since=since,
    )


def started(run: Outcome) -> dict[str, float]:
    """Return the start (s) of each person who started."""
    return {e["person"]: e["t"] for e in reversed(run.events) if e["kind"] == "human_started"}


def zones_of(run: Outcome) -> dict[str, dict[str, float]]:
    """Return the exposure of people in each zone, by its name."""
    starts = started(run)
    stays = [
        Stay(
            run.motions[name],
            (max(begin, start), end),
            [span for mine in run.violations_of(name).values() for span in mine],
        )
        for name, start in starts.items()
        for begin, end in run.stays[name]
    ]
    return zone_exposures(run.floorplan.zones, stays)


def contacts_of(run: Outcome, what: str = "person") -> int:
    """Return the number of contacts of machines with a "person" or, if `what` is "with", others."""
    return sum(event["kind"] == "contact" and what in event for event in run.events)
