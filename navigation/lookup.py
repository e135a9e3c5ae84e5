"""Shortest paths on a small floor without bodies, looked up in the distances between all bends.

A shortest path leaves the start to a bend and comes to the goal from one. What lies between is
known beforehand; which of these links are free is asked only of those that a shortest path may
take, the most promising first.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from floorplan import Point

from .roadmap import Ends, Link, Roadmap

Ask = Callable[[int, int, Point, Point], bool]
"""Function that returns whether a link is free, by the numbers and points of its ends."""

_END = -1
"""Number of a place that is no bend."""


class LookUp:
    """The links between two places and the bends of `roadmap`, asked of `ask` one by one."""

    def __init__(self, roadmap: Roadmap, start: Point, goal: Point, ask: Ask) -> None:
        assert roadmap.between is not None
        self._roadmap = roadmap
        self._places = (start, goal)
        self._ask = ask
        self._bends, self._far = zip(*roadmap.passable_from(start, goal), strict=True)
        # Nothing is known of a link (0), or it is free (1), or it is not (-1).
        self._known: list[NDArray[np.int8]] = [np.zeros(len(b), np.int8) for b in self._bends]

    def path(self) -> list[Point] | None:
        """Return the points of the shortest path, with the floor's obstacles alone.

        None if there is none, or if a link is refused that the roadmap takes for free: then only a
        search can tell.
        """
        first, last = self._bends
        if not (len(first) and len(last)):
            return None
        total = self._roadmap.between[np.ix_(first, last)]  # type: ignore[index]
        total += self._far[0][:, None]
        total += self._far[1]
        columns = len(last)
        while True:
            row, column = divmod(int(total.argmin()), columns)
            if not total[row, column] < np.inf:
                return None
            if not self._is_free(0, row):
                total[row] = np.inf
            elif not self._is_free(1, column):
                total[:, column] = np.inf
            else:
                return self._along(self._roadmap.between_bends(int(first[row]), int(last[column])))

    def ends(self) -> Ends:
        """Return the links that have not been found blocked."""
        links: list[list[Link]] = []
        for bends, far, known in zip(self._bends, self._far, self._known, strict=True):
            left = known >= 0
            links.append([*zip(bends[left].tolist(), far[left].tolist(), strict=True)])
        return Ends(*self._places, links[0], dict(links[1]), True)

    def _is_free(self, end: int, index: int) -> bool:
        """Return whether the link from the start (0) or to the goal (1) to a bend is free."""
        known = self._known[end]
        if known[index] == 0:
            bend = int(self._bends[end][index])
            at, place = self._roadmap.point(bend), self._places[end]
            free = self._ask(bend, _END, at, place) if end else self._ask(_END, bend, place, at)
            known[index] = 1 if free else -1
        return bool(known[index] > 0)

    def _along(self, chain: list[int]) -> list[Point] | None:
        """Return the points of the path over the bends of these numbers if its links are free."""
        points = [self._roadmap.point(bend) for bend in chain]
        for k in range(len(chain) - 1):
            if not self._ask(chain[k], chain[k + 1], points[k], points[k + 1]):
                return None
        return [self._places[0], *points, self._places[1]]
