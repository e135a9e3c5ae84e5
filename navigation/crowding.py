"""Distances among many discs: the least of all pairs, without a close look at every one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .monitor import minimum_separation
from .motion import Motion

STEP = 0.1
"""Seconds between the instants at which all pairs are looked at first."""

_HAIR = 1e-9


class Nearest(NamedTuple):
    """The nearest that any two came: metres between their surfaces, seconds, and their indices.

    `overlaps` is the number of pairs that overlapped at any time.
    """

    distance: float
    time: float
    pair: tuple[int, int]
    overlaps: int


def nearest_pair(
    motions: Sequence[Motion],
    radii: Sequence[float],
    top_speeds: Sequence[float],
    begin: float,
    end: float,
) -> Nearest | None:
    """Return the nearest that two of several discs came from `begin` to `end` (seconds).

    `motions` are those of their centres, `radii` in metres, `top_speeds` in m/s, which none of them
    exceeds but where it is put elsewhere. None for fewer than two. Exact as `minimum_separation`:
    between two instants that are looked at, a pair comes no nearer than its distance at both and
    its speeds allow, and wherever that is nearer than the nearest pair known it is solved for.
    """
    if len(motions) < 2:
        return None
    count = max(math.ceil((end - begin) / STEP), 1)
    t = np.linspace(begin, end, count + 1)
    at = np.array([motion.position(t) for motion in motions])
    best = (math.inf, begin, (0, 1))
    overlapping: set[tuple[int, int]] = set()
    jumps = [np.searchsorted(t, sorted(motion.jumps), side="right") - 1 for motion in motions]
    for i in range(len(motions) - 1):
        others = np.arange(i + 1, len(motions))
        apart = np.hypot(*np.moveaxis(at[others] - at[i], -1, 0))
        apart -= (np.array(radii)[others] + radii[i])[:, None]
        reach = (np.array(top_speeds)[others] + top_speeds[i])[:, None] * (t[1] - t[0])
        lower = (apart[:, :-1] + apart[:, 1:] - reach) / 2
        for row, j in enumerate(others):
            lower[row, np.clip([*jumps[i], *jumps[j]], 0, count - 1).astype(int)] = -math.inf
        while True:
            limit = max(min(best[0], float(apart.min())), 0.0) + _HAIR
            row, k = divmod(int(np.argmin(lower)), count)
            if lower[row, k] >= limit:
                break
            lower[row, k] = math.inf
            pair = (i, int(others[row]))
            when, centres = minimum_separation(
                motions[i], motions[pair[1]], float(t[k]), float(t[k + 1])
            )
            gap = centres - radii[i] - radii[pair[1]]
            if gap < -_HAIR:
                overlapping.add(pair)
            best = min(best, (gap, when, pair))
    return Nearest(*best, len(overlapping))
