"""Distance that a law required of two bodies all through a run, as lines between points."""

from __future__ import annotations

import itertools
from collections.abc import Callable

from navigation import AnyLaw, ApproachLaw, FixedDistance, SeparationLaw, required_along

from ..core.plans import Plans

Curve = tuple[tuple[float, float], ...]
"""Points (seconds, metres) in order of time; two at one instant are a jump."""

EXACT = 0.01
"""Metres. Greatest error of the lines."""

STRIDE = 0.5
"""Seconds. A rise and fall of the curve that is shorter than this may be missed."""


def is_plain(law: AnyLaw) -> bool:
    """Return True if `law` computes the required distance from its terms and two speeds alone."""
    return type(law) in (SeparationLaw, ApproachLaw, FixedDistance)


def requirement_curve(law: AnyLaw, person: Plans, machine: Plans, end: float) -> Curve:
    """Return the distance that `law` required until `end` (seconds), at each instant of the plans.

    `person` and `machine` are the motions that the two set out on, whatever came of them.
    """
    changes = sorted({t for t in (*person.changes, *machine.changes) if t < end} | {end})
    points: list[tuple[float, float]] = []
    for begin, until in itertools.pairwise(changes):
        motions = (person.at(begin), machine.at(begin))
        required = required_along(law, *motions)
        cuts = {begin, until}
        cuts |= {p.begin for motion in motions for p in motion.pieces if begin < p.begin < until}
        for a, b in itertools.pairwise(sorted(cuts)):
            points += _lines(required, a, b)
    return tuple(_without_needless(points))


def _lines(
    required: Callable[[float], float], begin: float, end: float
) -> list[tuple[float, float]]:
    # Cut first: halving that looks at the middle alone overlooks what rises and falls beside it.
    strides = max(1, round((end - begin) / STRIDE))
    points = [(begin, required(begin))]
    for k in range(1, strides + 1):
        t = begin + (end - begin) * k / strides
        points += _halved(required, points[-1], (t, required(t)))
    return points


def _halved(
    required: Callable[[float], float], a: tuple[float, float], b: tuple[float, float]
) -> list[tuple[float, float]]:
    """Return the points after `a` up to `b` between which the curve is straight."""
    t = (a[0] + b[0]) / 2
    middle = (t, required(t))
    # Half the error: away from its middle the curve may be a little farther off the line.
    if abs(middle[1] - (a[1] + b[1]) / 2) <= EXACT / 2 or b[0] - a[0] < EXACT:
        return [b]
    return _halved(required, a, middle) + _halved(required, middle, b)


def _without_needless(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return the same curve without points on the line between their neighbours."""
    kept: list[tuple[float, float]] = []
    for point in points:
        if kept and point == kept[-1]:
            continue
        if len(kept) > 1 and _on_line(kept[-2], kept[-1], point):
            kept.pop()
        kept.append(point)
    return kept


def _on_line(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> bool:
    if not a[0] < b[0] < c[0]:
        return False
    between = a[1] + (c[1] - a[1]) * (b[0] - a[0]) / (c[0] - a[0])
    return abs(between - b[1]) < EXACT / 100
