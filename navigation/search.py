"""A* over a roadmap and the bends around the bodies that a path meets.

See P. E. Hart, N. J. Nilsson and B. Raphael, "A formal basis for the heuristic determination of
minimum cost paths", IEEE Transactions on Systems Science and Cybernetics 4 (1968).
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from floorplan import Point

from .bodies import Body
from .corners import Bends, Floats
from .roadmap import BodyBends, Ends, Link, Roadmap

_Entry = tuple[float, float, int, int]
"""Lower bound of a path's length, length up to its last link, and that link."""

Free = Callable[[int, int, Point, Point], bool]
"""Function that returns whether the link between two places is free, by their numbers and points.

Numbers below that of the roadmap's bends are those of bends.
"""

PATIENCE = 200
"""Number of links after which a search asks whether there is a path at all."""


_SOON = 32
"""Number of places at the top of the queue that the roadmap is to link at once."""


def shortest_path(
    roadmap: Roadmap,
    ends: Ends,
    bodies: Sequence[Body],
    free: Free,
    hopeless: Callable[[], bool],
) -> list[Point] | None:
    """Return the shortest path on `roadmap` round `bodies`, or None where there is none.

    `free` decides about each link that the search takes. `hopeless()` is asked once if the search
    takes long, and ends it if it is true.
    """
    return _Search(roadmap, ends, [roadmap.around(body) for body in bodies], free).run(hopeless)


class _Search:
    """One A* search. Links are checked only when the search takes them.

    The floor's bends have the numbers below N; those of bodies, then the start and the goal
    follow.
    """

    def __init__(
        self,
        roadmap: Roadmap,
        ends: Ends,
        around: Sequence[BodyBends],
        free: Free,
    ) -> None:
        self._free = free
        self._fixed = len(roadmap.bends)
        extra = np.array(
            [*itertools.chain(*(part.bends.point for part in around)), ends.start, ends.goal]
        )
        self._start = self._fixed + len(extra) - 2
        self._goal = self._start + 1
        self._roadmap = roadmap
        self._points = roadmap.bends.point
        self._extra = [(float(x), float(y)) for x, y in extra]
        self._links: list[list[Link]] = [[] for _ in extra]
        self._links[-2] += ends.from_start
        self._to_goal = dict(ends.to_goal)
        if ends.straight:
            self._to_goal[self._start] = math.dist(ends.start, ends.goal)
        self._back: dict[int, list[Link]] = {}
        if around:
            self._link_bodies(roadmap, around, extra)
        self._left = self._bounds(roadmap, ends.goal)

    def _link_bodies(self, roadmap: Roadmap, around: Sequence[BodyBends], extra: Floats) -> None:
        loose = Bends.join([part.bends for part in around])
        along = loose.point[None] - extra[:, None]
        length = np.hypot(along[..., 0], along[..., 1])
        there = loose.graze(along)
        here = np.ones_like(there)
        here[:-2] = loose.graze(along[:-2].swapaxes(0, 1)).T
        there[-2:] |= length[-2:] <= loose.reach * 1.01
        one, other = np.nonzero(there & here & (length > 0))
        seen = roadmap.visible(extra[one], loose.point[other])
        for i, j in zip(one[seen].tolist(), other[seen].tolist(), strict=True):
            k = self._fixed + j
            if i == len(extra) - 1:
                self._to_goal[k] = length[i, j]
            else:
                self._links[i].append((k, length[i, j]))
        k = self._fixed
        for part in around:
            for links in part.links:
                self._links[k - self._fixed].extend(links)
                for to, far in links:
                    self._back.setdefault(to, []).append((k, far))
                k += 1

    def _bounds(self, roadmap: Roadmap, goal: Point) -> list[float]:
        """Lower bounds of the path length left from each place (metres): the heuristic of A*.

        From a bend of the floor the path goes on over others to one that is linked to the goal, or
        to a body's bend, from where it is not shorter than the straight line.
        """
        away = np.array(self._extra) - np.array(goal)
        loose: list[float] = np.hypot(away[:, 0], away[:, 1]).tolist()
        last = [(k, far) for k, far in self._to_goal.items() if k < self._fixed]
        for k, links in self._back.items():
            last += [(k, far + loose[to - self._fixed]) for to, far in links]
        fixed: list[float] = roadmap.distances_to(goal, last).tolist()
        return fixed + loose

    def run(self, hopeless: Callable[[], bool]) -> list[Point] | None:
        """Return the points of the shortest path, or None."""
        best = {self._start: 0.0}
        before: dict[int, int] = {}
        left = self._left
        queue: list[_Entry] = []
        self._expand(self._start, 0.0, best, queue)
        taken = 0
        while queue:
            taken += 1
            if taken == PATIENCE and hopeless():
                return None
            _, so_far, here, there = heapq.heappop(queue)
            if so_far >= best.get(there, math.inf):
                continue
            if not self._free(here, there, self._point(here), self._point(there)):
                continue
            best[there] = so_far
            before[there] = here
            if there == self._goal:
                return self._trace(before)
            if left[there] < math.inf:
                self._expand(there, so_far, best, queue)
        return None

    def _expand(
        self,
        here: int,
        so_far: float,
        best: dict[int, float],
        queue: list[_Entry],
    ) -> None:
        left = self._left
        for there, length in self._links_of(here, queue):
            then = so_far + length
            if then < best.get(there, math.inf):
                heapq.heappush(queue, (then + left[there], then, here, there))
        if here in self._to_goal:
            then = so_far + self._to_goal[here]
            heapq.heappush(queue, (then, then, here, self._goal))

    def _links_of(self, here: int, queue: list[_Entry]) -> list[Link]:
        if here >= self._fixed:
            return self._links[here - self._fixed]
        links = self._roadmap.links_of(here, self._next(queue))
        return links + self._back[here] if here in self._back else links

    def _next(self, queue: list[_Entry]) -> Iterator[int]:
        """The floor's bends that will be taken soon: a heap has those not far from its top."""
        return (there for _, _, _, there in queue[:_SOON] if there < self._fixed)

    def _point(self, index: int) -> Point:
        if index >= self._fixed:
            return self._extra[index - self._fixed]
        x, y = self._points[index].tolist()
        return (x, y)

    def _trace(self, before: dict[int, int]) -> list[Point]:
        index = self._goal
        points = [self._point(index)]
        while index != self._start:
            index = before[index]
            points.append(self._point(index))
        return points[::-1]
