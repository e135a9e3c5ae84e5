"""Committed motions of discs on a floor, where they head, and motions that some change together."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .discs import DiscMotions, Swath
from .numbers import numbers

if not cython.compiled:
    from .cubics import *
    from .discs import within_bounds

_SLOW: float = 0.05  # m/s; the direction of whoever is slower is not that of their velocity
_THERE: float = 1e-6  # metres; nearer than this is there


class CommittedMotions(DiscMotions):
    """Motions to which discs are committed.

    Of each that is `bound` for somewhere, `onward` has the next corner of its route, which is
    infinite where there is none (metres).
    """

    def __init__(self, gap: float) -> None:
        super().__init__(gap)
        self.bound = bytearray()
        self.onward: Numbers = room(0)
        self.widest = 0.0
        """The greatest radius, metres."""

    def add(self, swath: Swath, radius: float, counted: float = INFINITY) -> None:
        """Add a disc that is bound for nowhere."""
        DiscMotions.add(self, swath, radius, counted)
        self.widest = max(self.widest, radius)
        self.bound.append(0)
        self.onward.extend((INFINITY, INFINITY))

    def send(self, k: cython.Py_ssize_t, bound: bool, x: float, y: float) -> None:
        """Let the k-th be bound for somewhere or not, by x, y first."""
        self.bound[k] = bound
        positions_of(self.onward)[k] = Position(x, y)

    def near(
        self, box: Numbers, around: float, but: cython.Py_ssize_t = -1
    ) -> list[cython.Py_ssize_t]:
        """Return who, `but` one, may come so near to bounds with their bodies (metres): indices.

        As wide as the widest there is: bounds are those of centres.
        """
        return within_bounds(self.boxes, box, around + self.widest + 2 * self.gap, but)

    def rests(self, k: cython.Py_ssize_t) -> float:
        """Return from when on the k-th stands for good, seconds."""
        return self.end(k).begin

    def end(self, k: cython.Py_ssize_t) -> PlanarPiece:
        """Return the final rest of the k-th."""
        table: Numbers = self.tables[k]
        return planar(table)[planar_count(table) - 1]

    def place(self, k: cython.Py_ssize_t, t: float) -> Position:
        """Return the place of the k-th at `t` (seconds)."""
        table: Numbers = self.tables[k]
        row: cython.Py_ssize_t = planar_from(table, 0, t)
        piece: PlanarPiece = planar(table)[row]
        u: float = max(t - piece.begin, 0.0)
        # Who has come to rest is where their walk ended, to the last bit.
        if piece.end == INFINITY and row > 0:
            piece = planar(table)[row - 1]
            u = piece.end - piece.begin
        return Position(value(piece.x, u), value(piece.y, u))

    def heading(self, k: cython.Py_ssize_t, t: float) -> Position:
        """Return the unit vector of where the k-th walks at `t` (seconds), or would walk on.

        0, 0 for who rests.
        """
        table: Numbers = self.tables[k]
        piece: PlanarPiece = planar(table)[planar_from(table, 0, t)]
        if piece.begin <= t:
            vx: float = slope(piece.x, t - piece.begin)
            vy: float = slope(piece.y, t - piece.begin)
            speed: float = norm(vx, vy)
            if speed > _SLOW:
                return Position(vx / speed, vy / speed)
        onward: Position = positions_of(self.onward)[k]
        if not self.bound[k] or onward.x == INFINITY:
            return Position(0.0, 0.0)
        here: Position = self.place(k, t)
        dx: float = onward.x - here.x
        dy: float = onward.y - here.y
        away: float = norm(dx, dy)
        if away < _THERE:
            return Position(0.0, 0.0)
        return Position(dx / away, dy / away)

    def cosine(self, k: cython.Py_ssize_t, t: float, c: float, s: float) -> float:
        """Return the cosine between c, s and where the k-th walks, or would; 0 for who rests."""
        way: Position = self.heading(k, t)
        return way.x * c + way.y * s

    def between(self, i: cython.Py_ssize_t, k: cython.Py_ssize_t, t: float) -> float:
        """Return the cosine between where the i-th and the k-th walk at `t`, or would walk on.

        0 if either rests.
        """
        way: Position = self.heading(i, t)
        return self.cosine(k, t, way.x, way.y)

    def standing(self, me: int, box: Numbers, around: float, now: float) -> Numbers:
        """Return who stands for good `now` (seconds), so near to bounds, but the `me`-th.

        Rows of circles, which the `me`-th has to stay out of (metres).
        """
        there: list[cython.Py_ssize_t] = self._resting(me, box, around, now)
        found: Numbers = circle_room(len(there))
        radii: Doubles = at(self.radii)
        i: cython.Py_ssize_t
        for i in range(len(there)):
            end: PlanarPiece = self.end(there[i])
            radius: float = radii[me] + radii[there[i]] + self.gap
            circles_of(found)[i] = Circle(end.x.p, end.y.p, radius)
        return found

    def _resting(
        self, me: cython.Py_ssize_t, box: Numbers, around: float, now: float
    ) -> list[cython.Py_ssize_t]:
        found: list[cython.Py_ssize_t] = []
        i: cython.Py_ssize_t
        near: list[cython.Py_ssize_t] = self.near(box, around, me)
        for i in range(len(near)):
            k: cython.Py_ssize_t = near[i]
            if self.rests(k) <= now:
                found.append(k)
        return found

    def encloses(self, me: int, other: int, x: float, y: float, around: float, now: float) -> bool:
        """Return whether the `other` is one of those who stand around x, y (metres) `now`.

        From there a ring grows from neighbour to neighbour through gaps that are too narrow for the
        `me`-th, as far as `around`.
        """
        place: Numbers = numbers((x, y, x, y))
        left: list[cython.Py_ssize_t] = self._resting(me, place, around, now)
        ring: Numbers = circle_room(len(left) + 1)  # of those who are to be left
        circle: Circles = circles_of(ring)
        radii: Doubles = at(self.radii)
        width: float = 2 * (radii[me] + self.gap)
        circle[0] = Circle(x, y, -radii[me])
        last: cython.Py_ssize_t = 0
        i: cython.Py_ssize_t
        while last >= 0:
            here: Circle = circle[last]
            last -= 1
            for i in range(len(left) - 1, -1, -1):
                k: cython.Py_ssize_t = left[i]
                end: PlanarPiece = self.end(k)
                dx: float = end.x.p - here.x
                dy: float = end.y.p - here.y
                if norm(dx, dy) < here.radius + radii[k] + width:
                    if k == other:
                        return True
                    last += 1
                    circle[last] = Circle(here.x + dx, here.y + dy, radii[k])
                    left[i] = left[len(left) - 1]
                    left.pop()
        return False


class Movers(DiscMotions):
    """Those on a `floor` who move from `now` on (seconds) other than they are committed to.

    In the order in which they were added, with their `indices` on the floor.
    """

    def __init__(self, floor: CommittedMotions, now: float) -> None:
        super().__init__(floor.gap)
        self.floor = floor
        self.now = now
        self.indices: list[int] = []
        self.among = bytearray(len(floor.radii))

    def move(self, k: cython.Py_ssize_t, swath: Swath) -> None:
        """Let the k-th on the floor move so."""
        self.add(swath, at(self.floor.radii)[k])
        self.indices.append(k)
        self.among[k] = 1

    def keep(self, count: cython.Py_ssize_t) -> None:
        """Keep the first so many; the others are not to move after all."""
        i: cython.Py_ssize_t
        for i in range(count, len(self.radii)):
            self.among[self.indices[i]] = 0
        del self.indices[count:]
        self.shorten(count)

    def own(self, k: cython.Py_ssize_t) -> float:
        """Return how far the k-th on the floor keeps from the bodies of others (metres)."""
        own: float = at(self.floor.radii)[k] + self.gap
        return own

    def meet(self, k: cython.Py_ssize_t, swath: Swath) -> bool:
        """Return whether the k-th, who goes like this, would come too close to another of them."""
        i: cython.Py_ssize_t
        for i in range(len(self.radii)):
            if self.indices[i] != k and self.meets(i, swath, self.own(k)):
                return True
        return False

    def meets(self, i: cython.Py_ssize_t, swath: Swath, own: float) -> bool:
        """Return whether one who keeps `own` metres meets the i-th of them."""
        return self.met(i, swath, own, self.now, INFINITY) < INFINITY

    def first_hit(self, i: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Return whom the i-th of them would meet first of all others but these; -1 for nobody."""
        return self.first_other(self.indices[i], self.swath_of(i))

    def first_other(self, k: cython.Py_ssize_t, swath: Swath) -> cython.Py_ssize_t:
        """Return whom the k-th, who goes like this, would meet first of all others but these.

        -1 for nobody.
        """
        before: cython.int = self.among[k]
        self.among[k] = 1
        found: cython.Py_ssize_t = self.floor.first_but(self.among, swath, self.own(k), self.now)
        self.among[k] = before
        return found
