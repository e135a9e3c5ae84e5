"""Shortest paths on a small floor without bodies, looked up in the distances between all bends.

A shortest path leaves the start to a bend and comes to the goal from one. What lies between is
known beforehand; which of these links are free is asked only of those that a shortest path may
take, the most promising first.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from floorplan import Point

from .corners import Floats
from .roadmap import Roadmap
from .sight import Ints

_AT_ONCE = 6
"""Number of links that are asked for together."""

Ask = Callable[[int, int, Point, Point], bool]
"""Function that returns whether a link is free, by the numbers and points of its ends."""


class _End:
    """The bends to which a path may go from `place`, with their distances (metres)."""

    def __init__(self, roadmap: Roadmap, place: Point) -> None:
        self.place = np.array(place)
        self.bend, self.length = roadmap.passable_from(place)
        self.there = roadmap.bends.point[self.bend]
        self.known = np.zeros(len(self.bend), dtype=bool)

    def unknown(self, promise: Floats) -> Ints:
        """Return the most promising ones of which it is not known whether they can be seen.

        `promise` (K,) has the lower bounds of the lengths of paths over each.
        """
        unknown = np.flatnonzero(~self.known & (promise < np.inf))
        if len(unknown) > _AT_ONCE:
            unknown = unknown[np.argpartition(promise[unknown], _AT_ONCE)[:_AT_ONCE]]
        return unknown


def look_up(roadmap: Roadmap, start: Point, goal: Point, ask: Ask) -> list[Point] | None:
    """Return the points of the shortest path on `roadmap`, with the floor's obstacles alone.

    None if there is none, or if `ask` refuses a link that the roadmap takes for free: then only a
    search can tell.
    """
    assert roadmap.between is not None
    first, last = _End(roadmap, start), _End(roadmap, goal)
    if not (len(first.bend) and len(last.bend)):
        return None
    total = roadmap.between[np.ix_(first.bend, last.bend)]
    total += first.length[:, None]
    total += last.length
    while True:
        row, column = divmod(int(total.argmin()), total.shape[1])
        if not total[row, column] < np.inf:
            return None
        if first.known[row] and last.known[column]:
            break
        ways, others = first.unknown(total.min(axis=1)), last.unknown(total.min(axis=0))
        ends = np.repeat([first.place, last.place], [len(ways), len(others)], axis=0)
        seen = roadmap.visible(ends, np.concatenate([first.there[ways], last.there[others]]))
        first.known[ways] = last.known[others] = True
        total[ways[~seen[: len(ways)]]] = np.inf
        total[:, others[~seen[len(ways) :]]] = np.inf
    chain = roadmap.between_bends(int(first.bend[row]), int(last.bend[column]))
    points = [start, *((float(x), float(y)) for x, y in roadmap.bends.point[chain]), goal]
    numbers = [-1, *chain, -1]
    for k in range(len(points) - 1):
        if not ask(numbers[k], numbers[k + 1], points[k], points[k + 1]):
            return None
    return points
