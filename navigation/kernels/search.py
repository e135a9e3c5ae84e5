"""A* over the bends of a floor and of the bodies on it, whose links are asked for when taken.

See P. E. Hart, N. J. Nilsson and B. Raphael, "A formal basis for the heuristic determination of
minimum cost paths", IEEE Transactions on Systems Science and Cybernetics 4 (1968).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .numbers import Place

if not cython.compiled:
    from math import sqrt

    from .edges import Room
    from .heap import Heap
    from .network import Network, grazes
    from .numbers import *
    from .uncompiled import Entry

Link = tuple[int, float]
"""The number of a place, and the distance to it (metres)."""

_SPARE: cython.Py_ssize_t = 256  # places beside those of the floor for which there is room at first
_SLACK: float = 1e-9  # of a metre and of a line's length; so far a line may enter a corner
_LONG: cython.Py_ssize_t = 256  # places that a search reaches before it asks if it is hopeless
_AT_ONCE: cython.Py_ssize_t = 100_000  # pairs of bends
_BESIDE: float = 1.01  # of a bend's reach; nearer places may see a bend that they do not graze


class Search:
    """A search for the shortest path from one place to another, then from others to others.

    Places are the bends of the `floor`, those of bodies, the start and the goal, with numbers in
    that order. Bends are columns of seven numbers: x and y (metres), x and y of the directions
    before and after it, and how far from it the path touches the arc (metres). `network` has the
    links between the floor's bends, on which the floor leaves room.
    """

    def __init__(self, floor: NDArray[np.float64], network: Network) -> None:
        self.network = network
        self.fixed = floor.shape[1]
        self.queue = Heap()
        self.bends = floor
        # What is known of each place; lists are the fastest where this is not compiled. `sure` is
        # the shortest length by which a place is known to be reached, though not yet taken from the
        # queue. Nothing longer need be queued for it.
        if cython.compiled:
            self._widen(self.fixed + _SPARE)
        else:
            self.x: Any = floor[0].tolist()
            self.y: Any = floor[1].tolist()
            self.best: Any = []
            self.sure: Any = []
            self.before: Any = []
            self.lines: dict[int, list[list[Link]]] = {}

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
        """Return the places of the shortest path, or None.

        It leads from `start` to `goal`; `parts` are the bends of bodies. Links that are not the
        floor's are asked of `room`; those `refused` count for none, and the straight line only if
        it is `straight`. A long search asks once whether it is `hopeless`, and ends if so.
        """
        self._lay_out(start, goal, parts)
        self.straight = straight
        self.room = room
        self.alone = len(parts) == 0 and len(refused) == 0
        self.refused = set()
        if refused:
            number = {self._place(k): k for k in range(self.goal + 1)}
            self.refused = {(number[a], number[b]) for a, b in refused if {a, b} <= number.keys()}
        queue: Heap = self.queue
        there: cython.Py_ssize_t = self.start
        here: cython.Py_ssize_t
        so_far: float = 0.0
        left: cython.Py_ssize_t = _LONG
        self.best[there] = 0.0
        while there != self.goal:
            left -= 1
            if left == 0 and hopeless(start, goal):
                return None
            self._leave(there, so_far)
            while True:
                if queue.count == 0:
                    return None
                entry: Entry = queue.pop()
                so_far = entry.so_far
                here = entry.here
                there = entry.there
                # Straight distance never falls by more than a link is long, so the first to reach a
                # place is the shortest, and later ones to it are left where they lie in the queue.
                if so_far >= self.best[there] or so_far > self.sure[there]:
                    continue
                # Most links are never taken: only one that is, is looked at (the laziness of R.
                # Bohlin and L. E. Kavraki, "Path planning using lazy PRM", ICRA 2000).
                if (here < self.fixed and there < self.fixed) or self._clear(here, there, True):
                    break
            self.best[there] = so_far
            self.before[there] = here
        chain: list[Place] = [self._place(there)]
        while there != self.start:
            there = self.before[there]
            chain.append(self._place(there))
        chain.reverse()
        return chain

    def _place(self, number: cython.Py_ssize_t) -> Place:
        """Return x and y of a place."""
        x: float = self.x[number]
        y: float = self.y[number]
        return (x, y)

    def _lay_out(self, start: Place, goal: Place, parts: list[NDArray[np.float64]]) -> cython.int:
        """Number the places of a question. None is reached yet."""
        first: cython.Py_ssize_t = self.fixed
        k: cython.Py_ssize_t
        self.start = first + sum([part.shape[1] for part in parts])
        self.goal = self.start + 1
        self.queue.clear()
        if not cython.compiled:
            if parts:
                self.bends = np.hstack([self.bends[:, :first], *parts])
            self.turns = self.bends
            bends = self.bends[:, first : self.start].tolist()
            self.x[first:] = [*bends[0], start[0], goal[0]]
            self.y[first:] = [*bends[1], start[1], goal[1]]
            self.best = [INFINITY] * len(self.x)
            self.sure = [INFINITY] * len(self.x)
            self.before = [0] * len(self.x)
            self.lines = {}
            return 0
        if self.goal >= self.bends.shape[1]:
            self._widen(self.goal + _SPARE)
        for part in parts:
            self.bends[:, first : first + part.shape[1]] = part
            first += part.shape[1]
        self.x[self.start], self.y[self.start] = start
        self.x[self.goal], self.y[self.goal] = goal
        for k in range(self.goal + 1):
            self.best[k] = INFINITY
            self.sure[k] = INFINITY
        return 0

    def _widen(self, places: cython.Py_ssize_t) -> cython.int:
        """Make room for so many places, where this is compiled; those of the floor are kept."""
        bends = np.zeros((7, places))
        bends[:, : self.fixed] = self.bends[:, : self.fixed]
        self.bends = self.turns = bends
        self.x = bends[0]
        self.y = bends[1]
        self.best = np.empty(places)
        self.sure = np.empty(places)
        self.before = np.empty(places, dtype=np.intp)
        return 0

    def _leave(self, here: cython.Py_ssize_t, so_far: float) -> cython.int:
        """Queue all that a path of length `so_far` may go on to from a place."""
        k: cython.Py_ssize_t
        length: float
        first: cython.Py_ssize_t = 0
        if here < self.fixed:
            links: Numbers = self.network.links_of(here)
            link: Doubles = at(links)
            for k in range(0, len(links), 2):
                self._push_known(here, int(link[k]), so_far, link[k + 1])
            first = self.fixed
        if first < self.start:
            self._fan(here, first, so_far)
        dx: float = self.x[self.goal] - self.x[here]
        dy: float = self.y[self.goal] - self.y[here]
        length = sqrt(dx * dx + dy * dy)
        if here == self.start:
            if self.straight:
                self._push(here, self.goal, so_far, length)
        # Nearer than where the path touches the arc, the direction from a bend says nothing yet.
        elif length <= self.turns[6, here] * _BESIDE or self._grazes(here, dx, dy):
            self._push(here, self.goal, so_far, length)
        return 0

    def _fan(self, here: cython.Py_ssize_t, first: cython.Py_ssize_t, so_far: float) -> cython.int:
        """Queue the lines from a place to the bends from `first` on that graze at both ends."""
        k: cython.Py_ssize_t
        length: float
        # In Python all bends at once in numpy are faster; in C one at a time, without arrays.
        if not cython.compiled:
            for k, length in self._lines(here, first):
                self._push(here, first + k, so_far, length)
            return 0
        bend: cython.bint = here < self.start
        for k in range(first, self.start):
            dx: float = self.x[k] - self.x[here]
            dy: float = self.y[k] - self.y[here]
            if bend and not self._grazes(here, dx, dy):
                continue
            length = sqrt(dx * dx + dy * dy)
            if bend:
                if length > 0.0 and self._grazes(k, dx, dy):
                    self._push(here, k, so_far, length)
            elif length <= self.turns[6, k] * _BESIDE or self._grazes(k, dx, dy):
                self._push(here, k, so_far, length)
        return 0

    def _lines(self, here: cython.Py_ssize_t, first: cython.Py_ssize_t) -> list[Link]:
        """Return the same lines, where this is not compiled: those of all bends at once."""
        onto = self.bends[:, first : self.start]
        if here == self.start:
            return _all_lines(np.array([[self.x[here]], [self.y[here]]]), onto)[0]
        # All pairs in one go, if these are not too many to keep.
        low: cython.Py_ssize_t = 0 if here < self.fixed else self.fixed
        high: cython.Py_ssize_t = self.fixed if here < self.fixed else self.start
        if (high - low) * (self.start - first) > _AT_ONCE:
            low = here
            high = here + 1
        if low not in self.lines:
            self.lines[low] = _all_lines(self.bends[:, low:high], onto)
        return self.lines[low][here - low]

    def _push(
        self, here: cython.Py_ssize_t, to: cython.Py_ssize_t, so_far: float, length: float
    ) -> cython.int:
        """Queue a link; whether it is clear is asked when it is taken."""
        then: float = so_far + length
        if then < self.best[to] and then <= self.sure[to]:
            self.queue.push(Entry(then + self._bound(to), then, here, to))
        return 0

    def _push_known(
        self, here: cython.Py_ssize_t, to: cython.Py_ssize_t, so_far: float, length: float
    ) -> cython.int:
        """Queue a link of the floor, unless it is blocked or others are shorter."""
        then: float = so_far + length
        if then >= self.best[to] or then > self.sure[to]:
            return 0
        if self.alone or self._clear(here, to, False):
            self.sure[to] = then
            self.queue.push(Entry(then + self._bound(to), then, here, to))
        return 0

    def _bound(self, place: cython.Py_ssize_t) -> float:
        """Return a lower bound of the length from a place to the goal."""
        dx: float = self.x[self.goal] - self.x[place]
        dy: float = self.y[self.goal] - self.y[place]
        return sqrt(dx * dx + dy * dy)

    def _clear(self, here: cython.Py_ssize_t, to: cython.Py_ssize_t, floor: bool) -> bool:
        """Return whether there is room on a link; the floor counts if `floor` is true."""
        if len(self.refused) > 0 and (here, to) in self.refused:
            return False
        return self.room.clear(self.x[here], self.y[here], self.x[to], self.y[to], floor)

    def _grazes(self, bend: cython.Py_ssize_t, dx: float, dy: float) -> bool:
        """Return whether a line along d only grazes the corner at a bend."""
        return grazes(
            self.turns[2, bend],
            self.turns[3, bend],
            self.turns[4, bend],
            self.turns[5, bend],
            dx,
            dy,
        )


def _all_lines(ones: NDArray[np.float64], others: NDArray[np.float64]) -> list[list[Link]]:
    """Return the lines from each of some bends, or from the start, to some others."""
    here, there = ones[:, :, None], others[:, None, :]
    dx, dy = there[0] - here[0], there[1] - here[1]
    length = np.sqrt(dx * dx + dy * dy)
    slack = _SLACK * (1.0 + np.abs(dx) + np.abs(dy))
    leaving = len(ones) == 2
    seen = []
    for way in (there,) if leaving else (here, there):
        entering, going = way[2] * dy - way[3] * dx, way[4] * dy - way[5] * dx
        low, high = np.minimum(entering, going), np.maximum(entering, going)
        seen.append((low <= slack) & (high >= -slack))
    if leaving:
        passable = seen[0] | (length <= there[6] * _BESIDE)
    else:
        passable = seen[0] & seen[1] & (length > 0.0)
    lines: list[list[Link]] = [[] for _ in range(ones.shape[1])]
    one, other = np.nonzero(passable)
    far = length[one, other]
    for i, k, metres in zip(one.tolist(), other.tolist(), far.tolist(), strict=True):
        lines[i].append((k, metres))
    return lines
