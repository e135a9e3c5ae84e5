"""A* over the bends of a floor and of the bodies on it. Links are tested when they are expanded.

See P. E. Hart, N. J. Nilsson and B. Raphael, "A formal basis for the heuristic determination of
minimum cost paths", IEEE Transactions on Systems Science and Cybernetics 4 (1968).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .numbers import Place, numbers, numbers_of

if not cython.compiled:
    from .cubics import *
    from .edges import Room
    from .network import Network, fits

_SOME: cython.Py_ssize_t = 256  # initial number of entries
_LONG: cython.Py_ssize_t = 256  # places that a search reaches before it asks for a proof of failure
_BESIDE: float = 1.01  # of a bend's reach; nearer places may see a bend without grazing it


class Heap:
    """Entries of a search, smallest first.

    A binary heap (J. W. J. Williams, "Algorithm 232: Heapsort", Communications of the ACM 7, 1964).
    """

    def __init__(self) -> None:
        self.entries: Numbers = entry_room(_SOME)
        self.count = 0

    def clear(self) -> cython.int:
        """Remove all entries."""
        self.count = 0
        return 0

    def push(self, entry: SearchEntry) -> cython.int:
        """Add an entry."""
        if self.count == entry_count(self.entries):
            entries_grow(self.entries, 2 * self.count)
        self.count += 1
        return self._rise(self.count - 1, entry)

    def pop(self) -> SearchEntry:
        """Remove and return the smallest entry."""
        row: Entries = entries_of(self.entries)
        least: SearchEntry = row[0]
        self.count -= 1
        # Move the smaller children up to the bottom, because the last entry is seldom small.
        last: cython.Py_ssize_t = self.count
        place: cython.Py_ssize_t = 0
        child: cython.Py_ssize_t = 1
        while child < last:
            if child + 1 < last and _precedes(row[child + 1], row[child]):
                child += 1
            row[place] = row[child]
            place = child
            child = 2 * place + 1
        self._rise(place, row[last])
        return least

    def _rise(self, place: cython.Py_ssize_t, entry: SearchEntry) -> cython.int:
        """Insert an entry on the path from `place` up to the top."""
        row: Entries = entries_of(self.entries)
        while place > 0:
            above: cython.Py_ssize_t = (place - 1) // 2
            if not _precedes(entry, row[above]):
                break
            row[place] = row[above]
            place = above
        row[place] = entry
        return 0


def _precedes(entry: SearchEntry, other: SearchEntry) -> bool:
    """Return whether an entry is smaller than another."""
    if entry.bound != other.bound:
        return entry.bound < other.bound
    if entry.so_far != other.so_far:
        return entry.so_far < other.so_far
    if entry.here != other.here:
        return entry.here < other.here
    return entry.there < other.there


class Search:
    """Search for shortest paths between two places, for several queries.

    Places are the bends of the `floor` (columns of `Bend`), those of bodies, the start and the
    goal, numbered in this order. `network` has the links between the floor's bends that are free of
    walls.
    """

    def __init__(self, floor: NDArray[np.float64], network: Network) -> None:
        self.network = network
        self.fixed = floor.shape[1]
        self.start = self.goal = self.fixed
        self.queue = Heap()
        self.bends = numbers_of(floor.T)
        # `sure` is the shortest length of a queued path to a place that is free for certain. Longer
        # ones need not be queued.
        self.best: Numbers = room(0)
        self.sure: Numbers = room(0)
        self.before: Numbers = room(0)

    def path(
        self,
        start: Place,
        goal: Place,
        straight: bool,
        parts: list[NDArray[np.float64]],
        room: Room,
        refused: set[tuple[Place, Place]],
        hopeless: Callable[[Place, Place], bool],
    ) -> list[Place] | None:
        """Return the places of the shortest path from `start` to `goal`, or None.

        `parts` are the bends of bodies. `room` decides about links that are not the floor's.
        `refused` are links that are excluded. The straight line is used only if `straight`. A long
        search calls `hopeless` once, and ends if the result is true.
        """
        self._lay_out(start, goal, parts)
        self.straight = straight
        self.room = room
        self.alone = len(parts) == 0 and len(refused) == 0
        self.refused = set()
        if refused:
            index = {self._place(k): k for k in range(self.goal + 1)}
            self.refused = {(index[a], index[b]) for a, b in refused if {a, b} <= index.keys()}
        queue: Heap = self.queue
        best: Doubles = at(self.best)
        sure: Doubles = at(self.sure)
        before: Doubles = at(self.before)
        there: cython.Py_ssize_t = self.start
        here: cython.Py_ssize_t
        so_far: float = 0.0
        left: cython.Py_ssize_t = _LONG
        best[there] = 0.0
        while there != self.goal:
            left -= 1
            if left == 0 and hopeless(start, goal):
                return None
            self._leave(there, so_far)
            while True:
                if queue.count == 0:
                    return None
                entry: SearchEntry = queue.pop()
                so_far = entry.so_far
                here = entry.here
                there = entry.there
                # The heuristic is consistent, so the first path to a place is the shortest. Later
                # ones are skipped when they are taken from the queue.
                if so_far >= best[there] or so_far > sure[there]:
                    continue
                # Most links are never expanded. Test only those that are: the laziness of R.
                # Bohlin and L. E. Kavraki, "Path planning using lazy PRM", ICRA 2000.
                if (here < self.fixed and there < self.fixed) or self._clear(here, there, True):
                    break
            best[there] = so_far
            before[there] = here
        chain: list[Place] = [self._place(there)]
        while there != self.start:
            there = int(before[there])
            chain.append(self._place(there))
        chain.reverse()
        return chain

    def _place(self, number: cython.Py_ssize_t) -> Place:
        """Return x and y of a place."""
        place: Bend = bends_of(self.bends)[number]
        return (place.x, place.y)

    def _lay_out(self, start: Place, goal: Place, parts: list[NDArray[np.float64]]) -> cython.int:
        """Assign numbers to the places of a query, none of which is reached yet."""
        k: cython.Py_ssize_t
        bend_cut(self.bends, self.fixed)
        for part in parts:
            self.bends.extend(numbers_of(part.T))
        self.start = bend_count(self.bends)
        self.goal = self.start + 1
        self.bends.extend(numbers((*start, 0.0, 0.0, 0.0, 0.0, 0.0)))
        self.bends.extend(numbers((*goal, 0.0, 0.0, 0.0, 0.0, 0.0)))
        self.best = room(self.goal + 1)
        self.sure = room(self.goal + 1)
        self.before = room(self.goal + 1)
        for k in range(self.goal + 1):
            at(self.best)[k] = at(self.sure)[k] = INFINITY
        self.queue.clear()
        return 0

    def _leave(self, here: cython.Py_ssize_t, so_far: float) -> cython.int:
        """Queue all links from a place at the end of a path of length `so_far`."""
        k: cython.Py_ssize_t
        length: float
        first: cython.Py_ssize_t = 0
        if here < self.fixed:
            links: Numbers = self.network.links_of(here)
            for k in range(link_count(links)):
                link: Link = link_rows(links)[k]
                self._push_known(here, int(link.to), so_far, link.length)
            first = self.fixed
        if first < self.start:
            self._fan(here, first, so_far)
        bend: Bend = bends_of(self.bends)[here]
        goal: Bend = bends_of(self.bends)[self.goal]
        dx: float = goal.x - bend.x
        dy: float = goal.y - bend.y
        length = norm(dx, dy)
        if here == self.start:
            if self.straight:
                self._push(here, self.goal, so_far, length)
        # Nearer than where the path touches the arc, the direction from a bend is undefined.
        elif length <= bend.reach * _BESIDE or fits(bend, dx, dy):
            self._push(here, self.goal, so_far, length)
        return 0

    def _fan(self, here: cython.Py_ssize_t, first: cython.Py_ssize_t, so_far: float) -> cython.int:
        """Queue the lines from a place to the bends from `first` on that graze at both ends."""
        bend: Bends = bends_of(self.bends)
        a: Bend = bend[here]
        k: cython.Py_ssize_t
        for k in range(first, self.start):
            b: Bend = bend[k]
            dx: float = b.x - a.x
            dy: float = b.y - a.y
            length: float = norm(dx, dy)
            if here < self.start:
                if length > 0.0 and fits(a, dx, dy) and fits(b, dx, dy):
                    self._push(here, k, so_far, length)
            elif length <= b.reach * _BESIDE or fits(b, dx, dy):
                self._push(here, k, so_far, length)
        return 0

    def _push(
        self, here: cython.Py_ssize_t, to: cython.Py_ssize_t, so_far: float, length: float
    ) -> cython.int:
        """Queue a link, which is tested when it is expanded."""
        then: float = so_far + length
        if then < at(self.best)[to] and then <= at(self.sure)[to]:
            self.queue.push(SearchEntry(then + self._bound(to), then, here, to))
        return 0

    def _push_known(
        self, here: cython.Py_ssize_t, to: cython.Py_ssize_t, so_far: float, length: float
    ) -> cython.int:
        """Queue a link of the floor, unless it is blocked or another path is shorter."""
        then: float = so_far + length
        if then >= at(self.best)[to] or then > at(self.sure)[to]:
            return 0
        if self.alone or self._clear(here, to, False):
            at(self.sure)[to] = then
            self.queue.push(SearchEntry(then + self._bound(to), then, here, to))
        return 0

    def _bound(self, place: cython.Py_ssize_t) -> float:
        """Return a lower bound of the length from a place to the goal."""
        here: Bend = bends_of(self.bends)[place]
        goal: Bend = bends_of(self.bends)[self.goal]
        return norm(goal.x - here.x, goal.y - here.y)

    def _clear(self, here: cython.Py_ssize_t, to: cython.Py_ssize_t, floor: bool) -> bool:
        """Return whether a link is free. The floor counts if `floor` is true."""
        if len(self.refused) > 0 and (here, to) in self.refused:
            return False
        a: Bend = bends_of(self.bends)[here]
        b: Bend = bends_of(self.bends)[to]
        return self.room.clear(a.x, a.y, b.x, b.y, floor)
