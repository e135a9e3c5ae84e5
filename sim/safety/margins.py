"""Minimum margins of a run: distance minus required distance, over continuous time."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from navigation import Enclosure, Encounter, Motion, Shapes
from navigation.monitor import least_over
from navigation.separation import AnyLaw

from .laws import Curve

Span = tuple[float, float]
"""Begin and end, s."""


SMALLEST = 1e-9
"""Smallest amount in the summary of a run, m."""


class Margin(NamedTuple):
    """Minimum margin between a person and a machine (m), its time (s), and their names."""

    value: float
    time: float
    person: str
    machine: str

    @property
    def figures(self) -> dict[str, float | str]:
        """The margin as the summary of a run contains it."""
        # Values have nine decimals. A slightly negative margin must remain negative.
        value = min(self.value, -SMALLEST) if self.value < 0.0 else self.value
        return {**self._asdict(), "value": value}


class RecordedRequirement:
    """Law with the required distance of a run: a curve of lines between points.

    It replaces a law that depends on plans, which are known only during the run.
    """

    def __init__(self, curve: Curve) -> None:
        self._curve = curve
        self._times = [time for time, _ in curve]

    def required(self, encounter: Encounter, begin: float, end: float) -> Enclosure:
        """Return the required distance from `begin` to `end` (s), in metres."""
        k, n = bisect_right(self._times, begin), bisect_left(self._times, end)
        first = self._at(k, begin)
        last = self._at(n, end) if begin < end else first
        slope = (last - first) / (end - begin) if begin < end else 0.0
        off = [metres - first - slope * (t - begin) for t, metres in self._curve[k:n]]
        low, high = min((*off, 0.0)), max((*off, 0.0))
        return Enclosure(value=(first + last + low + high) / 2, slope=slope, slack=(high - low) / 2)

    def _at(self, k: int, t: float) -> float:
        """Return the required distance at `t` (s), between the points `k` - 1 and `k`."""
        if k in (0, len(self._curve)):
            return self._curve[max(k - 1, 0)][1]
        (begin, low), (end, high) = self._curve[k - 1 : k + 1]
        return low + (high - low) * (t - begin) / (end - begin)


class Encountered(NamedTuple):
    """A person beside a machine during a run.

    Distances are measured from the motion `measured` of a point of the machine, or between the
    surfaces of `shapes`. Violations count in `spans`. The machine moves in the parts `moving`.
    """

    person: str
    machine: str
    law: AnyLaw
    walk: Motion
    measured: Motion
    shapes: Shapes | None
    spans: Sequence[Span]
    moving: Sequence[Span]


def least_margins(beside: Iterable[Encountered]) -> tuple[Margin | None, Margin | None]:
    """Return the minimum margin of all pairs, and the minimum while the machine moves.

    None if no time counts. Of equal margins, the first is returned.
    """
    pairs = [(_least(one, one.spans), one) for one in beside if one.spans]
    overall = min((margin for margin, _ in pairs), default=None)
    moving: Margin | None = None
    for margin, one in sorted(pairs, key=lambda pair: pair[0]):
        if moving is not None and moving <= margin:
            break  # the margin of a moving machine is at least the overall one
        if any(begin <= margin.time <= end for begin, end in one.moving):
            least = margin
        elif one.moving:
            least = _least(one, one.moving)
        else:
            continue
        moving = least if moving is None else min(moving, least)
    return overall, moving


def _least(one: Encountered, spans: Sequence[Span]) -> Margin:
    time, margin = least_over(one.law, one.walk, one.measured, spans, one.shapes)
    return Margin(margin, time, one.person, one.machine)


def moving_spans(
    motion: Motion, begin: float = -math.inf, end: float = math.inf, *, turning: bool = False
) -> list[Span]:
    """Return the times (s) in which a machine moves without a stop, within a span.

    With `turning`, turns on the spot count.
    """
    spans: list[Span] = []
    for piece in motion.pieces_from(begin, end):
        moves = piece.moves or (turning and not piece.stands)
        if not moves or piece.end <= begin:
            continue
        since, until = max(piece.begin, begin), min(piece.end, end)
        if spans and spans[-1][1] == since:
            spans[-1] = (spans[-1][0], until)
        else:
            spans.append((since, until))
    return spans
