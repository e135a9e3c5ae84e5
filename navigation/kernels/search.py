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

if not cython.compiled:
    from math import inf, sqrt

    from .edges import Room
    from .heap import Heap

    INFINITY = inf
else:
    from cython.cimports.libc.math import INFINITY, sqrt
    from cython.cimports.navigation.kernels.edges import Room
    from cython.cimports.navigation.kernels.heap import Heap

Link = tuple[int, float]
"""The number of a place, and the distance to it (metres)."""

_SLACK: float = 1e-9  # of a metre and of a line's length; so far a line may enter a corner
_AT_ONCE: cython.Py_ssize_t = 100_000  # pairs of bends
_BESIDE: float = 1.01  # of a bend's reach; nearer places may see a bend that they do not graze


class Turns:
    """Bends around corners: where they are, and how a path goes round there.

    `columns` are seven numbers for each: x and y (metres), x and y of the directions before and
    after it, and how far from it the path touches the arc (metres).
    """

    def __init__(self, columns: NDArray[np.float64]) -> None:
        self.columns = np.ascontiguousarray(columns)
        self.x: list[float] = columns[0].tolist()
        self.y: list[float] = columns[1].tolist()
        self.count = len(self.x)


class Search:
    """A search for the shortest path from one place to another: x and y of both in `ends`.

    Places are the bends of the `floor`, those of bodies in `parts`, the start and the goal, with
    numbers in that order. `links` are those between the floor's bends, or None where only `expand`
    can say, given a bend and the queue; the floor leaves room on them. All others are asked of
    `room`; those in `refused` count for none, and the straight line only if it is `straight`. The
    `queue` may have served another search before.
    """

    def __init__(
        self,
        floor: Turns,
        links: list[list[Link] | None],
        expand: Callable[[int, Heap], list[Link]],
        parts: list[Turns],
        ends: list[float],
        straight: bool,
        room: Room,
        refused: set[tuple[int, int]],
        queue: Heap,
    ) -> None:
        self.floor = floor
        self.links = links
        self.expand = expand
        self.parts = parts
        self.start_x = ends[0]
        self.start_y = ends[1]
        self.goal_x = ends[2]
        self.goal_y = ends[3]
        self.straight = straight
        self.room = room
        self.refused = refused
        self.alone = False
        self.fixed = floor.count
        self.start = floor.count + sum([part.count for part in parts])
        self.goal = self.start + 1
        self.left: list[float] = [-1.0] * (self.goal + 1)
        self.best: list[float] = [INFINITY] * (self.goal + 1)
        # The shortest length by which each place is known to be reached, though not yet taken from
        # the queue. Nothing longer need be queued for it.
        self.sure: list[float] = [INFINITY] * (self.goal + 1)
        self.queue = queue
        queue.clear()
        self.lines: dict[tuple[int, int, int], list[list[Link]]] = {}
        self.x = self.y = 0.0
        self.at = 0
        self.turns = floor

    def path(self, patience: int, hopeless: Callable[[], bool]) -> list[int] | None:
        """Return the numbers of the places of the shortest path, or None.

        `hopeless()` is asked once, after `patience` links, and ends the search if it is true.
        """
        before: list[int] = [self.start] * (self.goal + 1)
        queue: Heap = self.queue
        there: cython.Py_ssize_t = self.start
        here: cython.Py_ssize_t
        so_far: float = 0.0
        taken: cython.Py_ssize_t = 0
        self.best[self.start] = 0.0
        self.alone = len(self.parts) == 0 and len(self.refused) == 0
        while there != self.goal:
            self._leave(there, so_far)
            while True:
                if queue.count == 0:
                    return None
                queue.pop()
                so_far = queue.so_far
                here = queue.here
                there = queue.there
                # Straight distance never falls by more than a link is long, so the first to reach a
                # place is the shortest, and later ones to it are left where they lie in the queue.
                if so_far >= self.best[there] or so_far > self.sure[there]:
                    continue
                taken += 1
                if taken == patience and hopeless():
                    return None
                # Most links are never taken: only one that is, is looked at (the laziness of R.
                # Bohlin and L. E. Kavraki, "Path planning using lazy PRM", ICRA 2000).
                if (here < self.fixed and there < self.fixed) or self._clear(here, there, True):
                    break
            self.best[there] = so_far
            before[there] = here
        chain: list[int] = [self.goal]
        while there != self.start:
            there = before[there]
            chain.append(there)
        chain.reverse()
        return chain

    def place(self, number: int) -> tuple[float, float]:
        """Return x and y (metres) of a place."""
        self._go(number)
        return (self.x, self.y)

    def _go(self, place: cython.Py_ssize_t) -> cython.int:
        """Find where a place is, and which of which `turns` unless it is the start or the goal."""
        part: Turns
        if place < self.fixed:
            self.turns = self.floor
            self.at = place
            self.x = self.floor.x[place]
            self.y = self.floor.y[place]
            return 0
        if place == self.start:
            self.x = self.start_x
            self.y = self.start_y
            return 0
        if place == self.goal:
            self.x = self.goal_x
            self.y = self.goal_y
            return 0
        place -= self.fixed
        for part in self.parts:
            if place < part.count:
                self.turns = part
                break
            place -= part.count
        self.at = place
        self.x = self.turns.x[place]
        self.y = self.turns.y[place]
        return 0

    def _leave(self, here: cython.Py_ssize_t, so_far: float) -> cython.int:
        """Queue all that a path of length `so_far` may go on to from a place."""
        some: list[Any]
        to: cython.Py_ssize_t
        length: float
        part: Turns
        self._go(here)
        x: float = self.x
        y: float = self.y
        turns: Turns = self.turns
        at: cython.Py_ssize_t = self.at if here < self.start else -1
        if here < self.fixed:
            some = self.links[here]
            if some is None:
                some = self.expand(here, self.queue)
            for to, length in some:
                self._push_known(here, to, so_far, length)
        else:
            self._fan(here, x, y, turns, at, self.floor, 0, so_far)
        first: cython.Py_ssize_t = self.fixed
        for part in self.parts:
            self._fan(here, x, y, turns, at, part, first, so_far)
            first += part.count
        dx: float = self.goal_x - x
        dy: float = self.goal_y - y
        length = sqrt(dx * dx + dy * dy)
        if here == self.start:
            if self.straight:
                self._push(here, self.goal, so_far, length)
        # Nearer than where the path touches the arc, the direction from a bend says nothing yet.
        elif length <= turns.columns[6, at] * _BESIDE or _grazes(
            turns.columns[2, at],
            turns.columns[3, at],
            turns.columns[4, at],
            turns.columns[5, at],
            dx,
            dy,
        ):
            self._push(here, self.goal, so_far, length)
        return 0

    def _fan(
        self,
        here: cython.Py_ssize_t,
        x: float,
        y: float,
        turns: Turns,
        at: cython.Py_ssize_t,
        onto: Turns,
        first: cython.Py_ssize_t,
        so_far: float,
    ) -> cython.int:
        """Queue the lines to the bends `onto`, numbered from `first` on, that graze both ends.

        They leave the start, where `at` is -1, or bend `at` of `turns`.
        """
        k: cython.Py_ssize_t
        length: float
        # In Python all bends at once in numpy are faster; in C one at a time, without arrays.
        if not cython.compiled:
            for k, length in self._lines(x, y, turns, at, onto):
                self._push(here, first + k, so_far, length)
            return 0
        own: cython.Py_ssize_t = max(at, 0)
        before_x: float = turns.columns[2, own]
        before_y: float = turns.columns[3, own]
        after_x: float = turns.columns[4, own]
        after_y: float = turns.columns[5, own]
        for k in range(onto.count):
            dx: float = onto.columns[0, k] - x
            dy: float = onto.columns[1, k] - y
            if at >= 0 and not _grazes(before_x, before_y, after_x, after_y, dx, dy):
                continue
            length = sqrt(dx * dx + dy * dy)
            goes_on: bool = _grazes(
                onto.columns[2, k],
                onto.columns[3, k],
                onto.columns[4, k],
                onto.columns[5, k],
                dx,
                dy,
            )
            if at < 0 and length <= onto.columns[6, k] * _BESIDE:
                goes_on = True
            if goes_on and (at < 0 or length > 0.0):
                self._push(here, first + k, so_far, length)
        return 0

    def _lines(self, x: float, y: float, turns: Turns, at: int, onto: Turns) -> list[Link]:
        """Return the same lines, where this is not compiled: those of all bends at once."""
        # All pairs in one go, if these are not too many to keep.
        few = turns.count * onto.count <= _AT_ONCE
        key = (id(turns) if at >= 0 else 0, id(onto), -1 if few else at)
        if key not in self.lines:
            here = np.asarray(turns.columns)
            if at < 0:
                here = np.array([[x], [y], *[[0.0]] * 5])
            elif not few:
                here = here[:, at : at + 1]
            self.lines[key] = _all_lines(here, np.asarray(onto.columns), at < 0)
        return self.lines[key][at if few and at >= 0 else 0]

    def _push(
        self, here: cython.Py_ssize_t, to: cython.Py_ssize_t, so_far: float, length: float
    ) -> cython.int:
        """Queue a link; whether it is clear is asked when it is taken."""
        then: float = so_far + length
        if then < self.best[to] and then <= self.sure[to]:
            self.queue.push(then + self._bound(to), then, here, to)
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
            self.queue.push(then + self._bound(to), then, here, to)
        return 0

    def _bound(self, place: cython.Py_ssize_t) -> float:
        """Return a lower bound of the length from a place to the goal."""
        bound: float = self.left[place]
        if bound < 0.0:
            self._go(place)
            dx: float = self.goal_x - self.x
            dy: float = self.goal_y - self.y
            bound = sqrt(dx * dx + dy * dy)
            self.left[place] = bound
        return bound

    def _clear(self, here: cython.Py_ssize_t, to: cython.Py_ssize_t, floor: bool) -> bool:
        """Return whether there is room on a link; the floor counts if `floor` is true."""
        if len(self.refused) > 0 and (here, to) in self.refused:
            return False
        self._go(here)
        x: float = self.x
        y: float = self.y
        self._go(to)
        return self.room.clear(x, y, self.x, self.y, floor)


def _all_lines(
    ones: NDArray[np.float64], others: NDArray[np.float64], leaving: bool
) -> list[list[Link]]:
    """Return the lines from each of some bends, or places if `leaving`, to some others."""
    here, there = ones[:, :, None], others[:, None, :]
    dx, dy = there[0] - here[0], there[1] - here[1]
    length = np.sqrt(dx * dx + dy * dy)
    slack = _SLACK * (1.0 + np.abs(dx) + np.abs(dy))
    seen = []
    for way in (here, there):
        entering, going = way[2] * dy - way[3] * dx, way[4] * dy - way[5] * dx
        low, high = np.minimum(entering, going), np.maximum(entering, going)
        seen.append((low <= slack) & (high >= -slack))
    if leaving:
        passable = seen[1] | (length <= there[6] * _BESIDE)
    else:
        passable = seen[0] & seen[1] & (length > 0.0)
    lines: list[list[Link]] = [[] for _ in range(ones.shape[1])]
    one, other = np.nonzero(passable)
    far = length[one, other]
    for i, k, metres in zip(one.tolist(), other.tolist(), far.tolist(), strict=True):
        lines[i].append((k, metres))
    return lines


def _grazes(
    before_x: float, before_y: float, after_x: float, after_y: float, dx: float, dy: float
) -> bool:
    """Return whether a line along d only grazes the corner at a bend with these directions.

    A shortest path bends only where it grazes; all others would enter the grown corner.
    """
    slack: float = _SLACK * (1.0 + abs(dx) + abs(dy))
    entering: float = before_x * dy - before_y * dx
    leaving: float = after_x * dy - after_y * dx
    return (entering <= slack and leaving >= -slack) or (entering >= -slack and leaving <= slack)
