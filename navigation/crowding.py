"""Distances among many discs: the least of all pairs, without a close look at every one."""

from __future__ import annotations

import itertools
import math
from array import array
from collections.abc import Iterator, MutableSequence, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .clearance import swath
from .kernels.crowding import nearer_between, nearest_seen, see
from .kernels.discs import meeting
from .monitor import minimum_separation
from .motion import Motion, join, standing

STEP = 0.1
"""Seconds between the instants at which all pairs are looked at first."""

WINDOW = 512
"""Number of instants that are looked at together: who is far from others all through is left out,
and a long run takes no more memory than a short one."""

AWAY = 1e8
"""Metres. Those who are not there are moved so far off, and as far from each other."""

_HAIR = 1e-9

_Window: TypeAlias = "tuple[int, list[float], tuple[array[float], array[float], array[float]]]"


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
    spans: Sequence[tuple[float, float]] | None = None,
) -> Nearest | None:
    """Return the nearest that two of several discs came from `begin` to `end` (seconds).

    `motions` are those of their centres, `radii` in metres, `top_speeds` in m/s, which none of them
    exceeds but where it is put elsewhere. With `spans` each is there only from one instant to
    another (seconds). None if no two are there at once. Exact as `minimum_separation`: between two
    instants that are looked at, a pair comes no nearer than its distance at both and its speeds
    allow; wherever that is nearer than the nearest pair known, the kernel says whether it comes
    nearer, and if so it is solved for.
    """
    if spans is not None:
        motions = [
            _present(motion, max(since, begin), min(until, end), begin, end, AWAY * (k + 1))
            for k, (motion, (since, until)) in enumerate(zip(motions, spans, strict=True))
        ]
    if len(motions) < 2:
        return None
    count = max(math.ceil((end - begin) / STEP), 1)
    t = np.linspace(begin, end, count + 1)
    times = t.tolist()
    tables = [swath(_reaching_back(motion, begin), begin).table for motion in motions]
    sizes = [*map(float, radii)]
    steps = [float(speed * (t[1] - t[0])) for speed in top_speeds]
    jumps = [_intervals(t, sorted(motion.jumps)) for motion in motions]
    of_discs = (sizes, steps, jumps)
    # First a good upper bound: the nearest that any pair is at an instant that is looked at.
    nearest = math.inf
    for first, window, seen in _windows(tables, times):
        one, other, at, metres = nearest_seen(*seen, first, *of_discs, nearest)
        if metres < nearest:
            nearest, i, j, k = metres, one, other, at
            xs, ys, _ = seen
            one, other = (n * len(window) + k - first for n in (i, j))
            apart = math.hypot(xs[one] - xs[other], ys[one] - ys[other]) - (radii[i] + radii[j])
    best = (apart, times[k], (i, j))
    overlapping: set[tuple[int, int]] = set()
    found = [
        nearer_between(*seen, first, *of_discs, window, tables, max(apart, 0.0))
        for first, window, seen in _windows(tables, times)
    ]
    nearer = itertools.chain.from_iterable(found)
    for i, j, k in sorted(zip(nearer, nearer, nearer, strict=True)):
        least, since, until = radii[i] + radii[j], times[k], times[k + 1]
        if meeting(tables[i], tables[j], least + max(best[0], 0.0) - _HAIR, since, until) > until:
            continue
        when, centres = minimum_separation(motions[i], motions[j], since, until)
        if centres - least < -_HAIR:
            overlapping.add((i, j))
        best = min(best, (centres - least, when, (i, j)))
    if spans is not None and best[0] > AWAY / 2:
        return None
    return Nearest(*best, len(overlapping))


def _present(
    motion: Motion, since: float, until: float, begin: float, end: float, away: float
) -> Motion:
    """Return a motion from `begin` to `end` that is `away` metres off but from `since` to `until`.

    All instants are in seconds.
    """
    if since <= begin and until >= end:
        return motion
    off = (away, away)
    there = [motion.cut(since, until)] if since < until else []
    before = [standing(off, start=begin)] if since > begin or not there else []
    after = [standing(off, start=until)] if there and until < end else []
    return join([*before, *there, *after], end=end)


def _reaching_back(motion: Motion, begin: float) -> Motion:
    """Return a motion that stands from `begin` (seconds) until it starts, as kernels need it."""
    if motion.start <= begin:
        return motion
    x, y, heading = motion.state(begin).position
    return join([standing((x, y), heading=heading, start=begin), motion])


def _windows(tables: list[MutableSequence[float]], times: list[float]) -> Iterator[_Window]:
    """Yield the number of the first instant of each window, its instants, and what is seen then.

    Two windows that follow each other share an instant, and the room for what is seen.
    """
    rows = array("q", bytes(8 * len(tables)))
    boxes = array("d", bytes(32 * len(tables)))
    xs = ys = array("d")
    for first in range(0, len(times) - 1, WINDOW):
        window = times[first : first + WINDOW + 1]
        size = len(window) * len(tables)
        if len(xs) != size:
            xs, ys = (array("d", bytes(8 * size)) for _ in range(2))
        see(tables, window, rows, xs, ys, boxes)
        yield first, window, (xs, ys, boxes)


def _intervals(t: NDArray[np.float64], instants: Sequence[float]) -> list[float]:
    """Return the numbers of the intervals between `t` that instants fall into, in order.

    As floats, as the kernels have lists of numbers.
    """
    found = np.clip(np.searchsorted(t, instants, side="right") - 1, 0, len(t) - 2)
    return [float(k) for k in found]
