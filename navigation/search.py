"""A* over a roadmap and the bends around the bodies that a path meets.

See P. E. Hart, N. J. Nilsson and B. Raphael, "A formal basis for the heuristic determination of
minimum cost paths", IEEE Transactions on Systems Science and Cybernetics 4 (1968).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from heapq import heappop, heappush

import numpy as np

from floorplan import Point

from .bodies import Body
from .corners import Bends, Floats
from .roadmap import BodyBends, Ends, Link, Roadmap

Entry = tuple[float, float, int, int]
"""Lower bound of a path's length, length up to its last link, and the places of that link."""

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
) -> tuple[list[Point] | None, int]:
    """Return the shortest path on `roadmap` round `bodies`, or None where there is none.

    `free` decides about each link that the search takes, but for those that the roadmap has been
    told of, whose number is returned as well. `hopeless()` is asked once if the search takes long,
    and ends it if it is true.
    """
    return _Search(roadmap, ends, [roadmap.around(body) for body in bodies], free).run(hopeless)


class _Search:
    """One A* search. Links are asked for only when the search takes them.

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
        self._around = around
        self._extra = [(float(x), float(y)) for x, y in extra]
        self._links: dict[int, list[Link]] = {}
        self._to_goal = dict(ends.to_goal)
        if ends.straight:
            self._to_goal[self._start] = math.dist(ends.start, ends.goal)
        self._among_bodies(extra)
        self._links[self._start] += ends.from_start
        self._left = self._bounds(extra, ends)

    def _among_bodies(self, extra: Floats) -> None:
        """List the lines from one bend of a body to another, and between these and both ends."""
        count = len(extra) - 2
        self._links = {self._fixed + k: [] for k in range(count + 1)}
        if not count:
            return
        loose = Bends.join([part.bends for part in self._around])
        dx, dy = loose.beyond(extra)
        length = np.hypot(dx, dy)
        there = loose.graze(dx, dy)
        there[:-2] &= loose.graze(dx[:-2].T, dy[:-2].T).T
        there[-2:] |= length[-2:] <= loose.reach * 1.01
        one, other = np.nonzero(there & (length > 0))
        for i, k, far in zip(
            one.tolist(), (self._fixed + other).tolist(), length[one, other].tolist(), strict=True
        ):
            if i == count + 1:
                self._to_goal[k] = far
            else:
                self._links[self._fixed + i].append((k, far))

    def _bounds(self, extra: Floats, ends: Ends) -> list[float]:
        """Lower bounds of the path length left from each place (metres): the heuristic of A*.

        From a bend of the floor the path goes on over others to one that is linked to the goal, or
        to a body's bend, from where it is not shorter than the straight line.
        """
        away = extra - np.array(ends.goal)
        straight = np.hypot(away[:, 0], away[:, 1])
        last = np.full(self._fixed, math.inf)
        last[[*ends.to_goal]] = [*ends.to_goal.values()]
        for first, part in self._parts():
            np.minimum.at(last, part.to, part.length + straight[first + part.of])
        fixed = self._roadmap.distances_to(ends.goal, last)
        return [*fixed.tolist(), *straight.tolist()]

    def run(self, hopeless: Callable[[], bool]) -> tuple[list[Point] | None, int]:
        """Return the points of the shortest path, or None, and how many links were known."""
        alone = not self._around
        chain, used = _shortest(
            self._start,
            self._goal,
            self._roadmap.links if alone else [None] * self._fixed,
            self._links_of,
            self._to_goal,
            self._left,
            self._roadmap.asked if alone else {},
            lambda here, there: self._free(here, there, self._point(here), self._point(there)),
            PATIENCE,
            hopeless,
        )
        return None if chain is None else [self._point(place) for place in chain], used

    def _links_of(self, here: int, queue: list[Entry]) -> list[Link]:
        if here == self._start:
            return self._links[here]
        if here < self._fixed:
            links = self._roadmap.links_of(here, self._next(queue))
            return links + self._back_from(here) if self._around else links
        return self._links[here] + self._onward_from(here)

    def _onward_from(self, here: int) -> list[Link]:
        """Return the lines from a body's bend to those of the floor."""
        found: list[Link] = []
        for first, part in self._parts():
            (lines,) = np.nonzero(first + part.of == here - self._fixed)
            found += zip(part.to[lines].tolist(), part.length[lines].tolist(), strict=True)
        return found

    def _back_from(self, here: int) -> list[Link]:
        """Return the lines from a bend of the floor to those of bodies."""
        found: list[Link] = []
        for first, part in self._parts():
            (lines,) = np.nonzero(part.to == here)
            numbers = self._fixed + first + part.of[lines]
            found += zip(numbers.tolist(), part.length[lines].tolist(), strict=True)
        return found

    def _parts(self) -> Iterator[tuple[int, BodyBends]]:
        """Yield the bends around each body, with the number among bodies' bends of the first."""
        first = 0
        for part in self._around:
            yield first, part
            first += len(part.bends)

    def _next(self, queue: list[Entry]) -> Iterator[int]:
        """The floor's bends that will be taken soon: a heap has those not far from its top."""
        return (there for _, _, _, there in queue[:_SOON] if there < self._fixed)

    def _point(self, index: int) -> Point:
        if index >= self._fixed:
            return self._extra[index - self._fixed]
        return self._roadmap.point(index)


def _shortest(
    start: int,
    goal: int,
    links: Sequence[list[Link] | None],
    expand: Callable[[int, list[Entry]], list[Link]],
    to_goal: dict[int, float],
    left: list[float],
    known: dict[int, bool],
    free: Callable[[int, int], bool],
    patience: int,
    hopeless: Callable[[], bool],
) -> tuple[list[int] | None, int]:
    """Return the numbers of the places of the shortest path from `start` to `goal`, or None.

    `links[here]` are the links from a place, where they are known; `expand(here, queue)` returns
    them elsewhere. Links to the goal stand in `to_goal`. `left` are lower bounds of the lengths
    from places to the goal; no path leads on where that is infinite. `free(here, there)` decides
    about a link when the search takes it, unless `known` does, by the number
    lower * len(links) + higher; how often it did is returned as well. `hopeless()` is asked once,
    after `patience` links, and ends the search if it is true.
    """
    count = len(links)
    best = [math.inf] * len(left)
    before = [start] * len(left)
    queue: list[Entry] = []
    used, taken = 0, 0
    so_far, there = 0.0, start
    best[start] = 0.0
    while there != goal:
        some = links[there] if there < count else None
        for to, length in expand(there, queue) if some is None else some:
            then = so_far + length
            if then < best[to] and left[to] < math.inf:
                heappush(queue, (then + left[to], then, there, to))
        if there in to_goal:
            then = so_far + to_goal[there]
            heappush(queue, (then, then, there, goal))
        while True:
            if not queue:
                return None, used
            _, so_far, here, there = heappop(queue)
            if so_far >= best[there]:
                continue
            taken += 1
            if taken == patience and hopeless():
                return None, used
            answer = None
            if here < count and there < count:
                answer = known.get(here * count + there if here < there else there * count + here)
            if answer is None:
                answer = free(here, there)
            else:
                used += 1
            if answer:
                break
        best[there], before[there] = so_far, here
    chain = [goal]
    while chain[-1] != start:
        chain.append(before[chain[-1]])
    return chain[::-1], used
