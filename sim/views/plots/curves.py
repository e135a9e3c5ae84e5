"""The instants at which motions are sampled so that they are drawn truly.

Between changes of a motion all curves are smooth, and a few points a second are enough; at a
change both sides of it are there, and at a jump the line is broken.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from floorplan import UserError
from navigation import Motion

from ...record.outcome import Outcome

Array = NDArray[np.float64]

Span = tuple[float, float]
"""Begin and end, seconds."""

STEP = 0.1
"""Seconds. The longest step between two instants of a curve."""


def span_of(run: Outcome, within: Span | None) -> Span:
    """Return the part of a run to draw: `within`, clipped to the run, or all of it.

    `ValueError` if nothing is left.
    """
    begin, end = within or (0.0, run.duration)
    begin, end = max(begin, 0.0), min(end, run.duration)
    if not begin < end:
        raise UserError(
            f"there is nothing between {begin:g} and {end:g} s: the run goes from 0 to"
            f" {run.duration:g} s"
        )
    return begin, end


def while_present(run: Outcome, body: str, span: Span) -> Span | None:
    """Return the part of `span` in which a body is on the floor, None if it never is."""
    begin, end = run.presence[body]
    begin, end = max(span[0], begin), min(span[1], end)
    return (begin, end) if begin < end else None


def instants(motions: Sequence[Motion], begin: float, end: float) -> Array:
    """Return instants (N,) to draw these motions from `begin` to just before `end` (seconds).

    Every change is there twice: as the last instant before it, and as itself. Where a body is
    put elsewhere, NaN stands between the two, so that no line is drawn across. Straight stretches
    of a single motion have their ends only.
    """
    changes = {begin, end}
    for motion in motions:
        edges = [t for piece in motion.pieces for t in (piece.begin, piece.end)]
        changes.update(t for t in edges if begin < t < end)
    jumps = {t for motion in motions for t in motion.jumps}
    cuts = sorted(changes)
    stretches: list[Array] = []
    for since, until in itertools.pairwise(cuts):
        if since in jumps and stretches:
            stretches.append(np.array([np.nan]))
        straight = len(motions) == 1 and _is_straight(motions[0], since)
        steps = 1 if straight else math.ceil((until - since) / STEP)
        stretches.append(np.linspace(since, np.nextafter(until, since), steps + 1))
    return np.concatenate(stretches)


def _is_straight(motion: Motion, t: float) -> bool:
    """True if from `t` (seconds) to the next change x and y are linear, and nothing turns."""
    piece = motion.pieces_from(t)[0]
    return t >= motion.end or not any((*piece.x[2:], *piece.y[2:], *piece.rotation[1:]))


def speeds(motion: Motion, t: Array) -> Array:
    """Return the speed over the floor: (N,) m/s, NaN where `t` is NaN."""
    vx, vy = motion.velocity(t).T
    return np.where(np.isnan(t), np.nan, np.hypot(vx, vy))
