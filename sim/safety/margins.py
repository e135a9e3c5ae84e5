"""Least margins of a run: distance minus required distance, minimised over continuous time."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from navigation import Enclosure, Encounter, Motion, Shapes, minimum_margin
from navigation.separation import AnyLaw

from .laws import Curve

Span = tuple[float, float]
"""From when to when, seconds."""


SMALLEST = 1e-9
"""Metres. The least amount that the summary of a run tells from 0."""


class Margin(NamedTuple):
    """The least margin between a person and a machine: metres, seconds, and their names."""

    value: float
    time: float
    person: str
    machine: str

    @property
    def figures(self) -> dict[str, float | str]:
        """The margin as the summary of a run contains it."""
        # Figures have nine decimals: a margin that is just negative stays negative.
        value = min(self.value, -SMALLEST) if self.value < 0.0 else self.value
        return {**self._asdict(), "value": value}


class RecordedRequirement:
    """Law that requires what was required in a run: a curve of lines between points.

    It stands for a law that looks at more than speeds, of which the plans are known only then.
    """

    def __init__(self, curve: Curve) -> None:
        self._curve = curve
        self._times = [time for time, _ in curve]

    def required(self, encounter: Encounter, begin: float, end: float) -> Enclosure:
        """Return the distance in metres that was required from `begin` to `end` (seconds)."""
        k, n = bisect_right(self._times, begin), bisect_left(self._times, end)
        first = self._at(k, begin)
        last = self._at(n, end) if begin < end else first
        slope = (last - first) / (end - begin) if begin < end else 0.0
        off = [metres - first - slope * (t - begin) for t, metres in self._curve[k:n]]
        low, high = min((*off, 0.0)), max((*off, 0.0))
        return Enclosure(value=(first + last + low + high) / 2, slope=slope, slack=(high - low) / 2)

    def _at(self, k: int, t: float) -> float:
        """Return what is required at `t` (seconds), between the points `k` - 1 and `k`."""
        if k in (0, len(self._curve)):
            return self._curve[max(k - 1, 0)][1]
        (begin, low), (end, high) = self._curve[k - 1 : k + 1]
        return low + (high - low) * (t - begin) / (end - begin)


class Encountered(NamedTuple):
    """A person beside a machine during a run.

    `measured` is the motion of the point of the machine from which distances are measured, unless
    they are measured between the surfaces of `shapes`. `spans` are those in which a violation
    counts, `moving` those of them in which the machine moves.
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
    """Return the least margin of all pairs, and the least of those while the machine moves.

    None where nothing counts. The first of several such instants and pairs.
    """
    pairs = [(_least(one, one.spans), one) for one in beside if one.spans]
    overall = min((margin for margin, _ in pairs), default=None)
    moving: Margin | None = None
    for margin, one in sorted(pairs, key=lambda pair: pair[0]):
        if moving is not None and moving <= margin:
            break  # while it moves no pair comes nearer than over all
        if any(begin <= margin.time <= end for begin, end in one.moving):
            found = margin
        elif one.moving:
            found = _least(one, one.moving)
        else:
            continue
        moving = found if moving is None else min(moving, found)
    return overall, moving


def _least(one: Encountered, spans: Sequence[Span]) -> Margin:
    motions, shapes = (one.walk, one.measured), one.shapes
    found = (minimum_margin(*motions, one.law, *span, shapes=shapes) for span in spans)
    margin, time = min((margin, time) for time, margin in found)
    return Margin(margin, time, one.person, one.machine)


def moving_spans(
    motion: Motion, begin: float = -math.inf, end: float = math.inf, *, turning: bool = False
) -> list[Span]:
    """Return from when to when (seconds) a machine moves without a stop, within a span.

    With `turning`, it also moves while it turns on the spot.
    """
    found: list[Span] = []
    for piece in motion.pieces_from(begin, end):
        moves = piece.moves or (turning and not piece.stands)
        if not moves or piece.end <= begin:
            continue
        since, until = max(piece.begin, begin), min(piece.end, end)
        if found and found[-1][1] == since:
            found[-1] = (found[-1][0], until)
        else:
            found.append((since, until))
    return found
