"""Presence: from when to when people are on the floor."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from navigation import Motion

from ..core.recorder import Event

Span = tuple[float, float]
"""From when to when, seconds."""

ROUNDING = 1e-8
"""Seconds. Instants of events are rounded to less than this."""


def presence(
    motions: Mapping[str, Motion], events: Iterable[Event], duration: float
) -> dict[str, Span]:
    """Return when each body of a run is on the floor; nobody comes twice.

    Those who are awaited are not before they have entered, and who has left is not any more. The
    instants are those of the motions, to which events are rounded.
    """
    spans = dict.fromkeys(motions, (0.0, duration))
    for event in events:
        kind, person = event["kind"], event.get("person")
        if kind not in ("awaited", "entered", "left") or person not in spans:
            continue
        begin, end = spans[person]
        if kind == "awaited":
            spans[person] = (duration, duration)
        elif kind == "entered":
            spans[person] = (_exact(motions[person], event["t"]), end)
        else:
            spans[person] = (begin, _exact(motions[person], event["t"]))
    return spans


def _exact(motion: Motion, t: float) -> float:
    """Return the instant of the jump that was recorded for `t` (seconds)."""
    return next((jump for jump in motion.jumps if abs(jump - t) < ROUNDING), t)
