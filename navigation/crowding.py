"""Distances among many discs: the least of all pairs, without a close look at every one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .clearance import swath
from .kernels.discs import ROW, meeting
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
    its speeds allow; wherever that is nearer than the nearest pair known, the kernel says whether
    it comes nearer, and if so it is solved for.
    """
    if len(motions) < 2:
        return None
    count = max(math.ceil((end - begin) / STEP), 1)
    t = np.linspace(begin, end, count + 1)
    at = np.array([motion.position(t) for motion in motions])
    x, y = np.ascontiguousarray(at[..., 0]), np.ascontiguousarray(at[..., 1])
    radius, tops = np.array(radii), np.array(top_speeds)
    best = (math.inf, begin, (0, 1))
    # First a good upper bound: the nearest that any pair is at an instant that is looked at.
    seen = []
    for i in range(len(motions) - 1):
        dx, dy = x[i + 1 :] - x[i], y[i + 1 :] - y[i]
        squares = dx * dx + dy * dy
        rows_of = np.arange(len(squares))
        ks = np.argmin(squares, axis=1)
        apart = np.hypot(dx[rows_of, ks], dy[rows_of, ks]) - (radius[i + 1 :] + radius[i])
        seen.append(apart)
        row = int(np.argmin(apart))
        best = min(best, (float(apart[row]), float(t[ks[row]]), (i, i + 1 + row)))
    tables = [swath(motion, begin).table for motion in motions]
    rows = [np.searchsorted(table[1::ROW], t, side="right").tolist() for table in tables]
    jumps = [np.searchsorted(t, sorted(motion.jumps), side="right") - 1 for motion in motions]
    overlapping: set[tuple[int, int]] = set()
    for i in range(len(motions) - 1):
        # Between two instants at distances p and q a pair that comes closer by v at most is never
        # nearer than (p + q − v Δt) / 2; near half a step of its least instant is the same with p =
        # q.
        reach = (tops[i + 1 :] + tops[i]) * (t[1] - t[0])
        jumped = [bool(len(jumps[i])) or bool(len(some)) for some in jumps[i + 1 :]]
        near = np.flatnonzero((seen[i] - reach / 2 < max(best[0], 0.0) + _HAIR) | jumped)
        if not len(near):
            continue
        others = near + i + 1
        apart = np.hypot(x[others] - x[i], y[others] - y[i]) - (radius[others] + radius[i])[:, None]
        lower = (apart[:, :-1] + apart[:, 1:] - reach[near, None]) / 2
        for row, j in enumerate(others.tolist()):
            # No speed bounds a jump: the intervals in which one falls are always solved.
            lower[row, np.clip([*jumps[i], *jumps[j]], 0, count - 1).astype(int)] = -math.inf
        for row, k in np.argwhere(lower < max(best[0], 0.0)).tolist():
            pair = (i, int(others[row]))
            a, b = tables[i], tables[pair[1]]
            least = radii[i] + radii[pair[1]]
            since, until = float(t[k]), float(t[k + 1])
            nearer = least + max(best[0], 0.0) - _HAIR
            if meeting(a, b, nearer, since, until, rows[i][k], rows[pair[1]][k]) > until:
                continue
            when, centres = minimum_separation(motions[i], motions[pair[1]], since, until)
            if centres - least < -_HAIR:
                overlapping.add(pair)
            best = min(best, (centres - least, when, pair))
    return Nearest(*best, len(overlapping))
