"""Committed motions of discs on a floor, their directions, and joint changes of several motions."""

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

_SLOW: float = 0.05  # m/s; the velocity of slower people gives no direction
_AROUND: float = 4.0  # metres around a motion within which others are looked for at once
_THERE: float = 1e-6  # metres within which a place counts as reached


class CommittedMotions(DiscMotions):
    """Motions to which discs are committed.

    `bound` marks the discs that have a route, and `onward` has the next corner of each route
    (metres), or infinity.
    """

    def __init__(self, gap: float) -> None:
        super().__init__(gap)
        self.bound = bytearray()
        self.onward: Numbers = room(0)
        self.widest = 0.0
        """Maximum radius in metres."""

    def add(self, swath: Swath, radius: float, counted: float = INFINITY) -> None:
        """Add a disc without a route."""
        DiscMotions.add(self, swath, radius, counted)
        self.widest = max(self.widest, radius)
        self.bound.append(0)
        self.onward.extend((INFINITY, INFINITY))

    def send(self, k: cython.Py_ssize_t, bound: bool, x: float, y: float) -> None:
        """Set whether the k-th disc has a route, and its next corner."""
        self.bound[k] = bound
        positions_of(self.onward)[k] = Position(x, y)

    def near(
        self, box: Numbers, around: float, but: cython.Py_ssize_t = -1
    ) -> list[cython.Py_ssize_t]:
        """Return the indices of discs, without `but`, whose bodies may come within `around` metres.

        `box` has bounds of centres, so the largest radius is added.
        """
        return within_bounds(self.boxes, box, around + self.widest + 2 * self.gap, but)

    def rests(self, k: cython.Py_ssize_t) -> float:
        """Return the time (s) from which the k-th disc stays at rest."""
        return self.end(k).begin

    def end(self, k: cython.Py_ssize_t) -> PlanarPiece:
        """Return the final piece of the k-th motion, at rest."""
        table: Numbers = self.tables[k]
        return planar(table)[planar_count(table) - 1]

    def place(self, k: cython.Py_ssize_t, t: float) -> Position:
        """Return the place of the k-th at `t` (seconds)."""
        table: Numbers = self.tables[k]
        row: cython.Py_ssize_t = planar_from(table, 0, t)
        piece: PlanarPiece = planar(table)[row]
        u: float = max(t - piece.begin, 0.0)
        # A disc at rest is where its walk ended, to the last bit.
        if piece.end == INFINITY and row > 0:
            piece = planar(table)[row - 1]
            u = piece.end - piece.begin
        return Position(value(piece.x, u), value(piece.y, u))

    def heading(self, k: cython.Py_ssize_t, t: float) -> Position:
        """Return the unit vector of the motion of the k-th disc at `t` (s), or of its route.

        (0, 0) for a person at rest.
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
        """Return the cosine between (c, s) and the heading of the k-th disc, or 0 at rest."""
        way: Position = self.heading(k, t)
        return way.x * c + way.y * s

    def between(self, i: cython.Py_ssize_t, k: cython.Py_ssize_t, t: float) -> float:
        """Return the cosine between the headings of the i-th and the k-th disc at `t`.

        0 if either is at rest.
        """
        way: Position = self.heading(i, t)
        return self.cosine(k, t, way.x, way.y)

    def standing(self, person: int, box: Numbers, around: float, now: float) -> Numbers:
        """Return circles around the people who stay at rest `now` (s) within `around` metres.

        They are rows of centres and radii (metres), outside of which `person` must stay.
        """
        there: list[cython.Py_ssize_t] = self._resting(person, box, around, now)
        circles: Numbers = circle_room(len(there))
        radii: Doubles = at(self.radii)
        i: cython.Py_ssize_t
        for i in range(len(there)):
            end: PlanarPiece = self.end(there[i])
            radius: float = radii[person] + radii[there[i]] + self.gap
            circles_of(circles)[i] = Circle(end.x.p, end.y.p, radius)
        return circles

    def _resting(
        self, person: cython.Py_ssize_t, box: Numbers, around: float, now: float
    ) -> list[cython.Py_ssize_t]:
        resting: list[cython.Py_ssize_t] = []
        i: cython.Py_ssize_t
        near: list[cython.Py_ssize_t] = self.near(box, around, person)
        for i in range(len(near)):
            k: cython.Py_ssize_t = near[i]
            if self.rests(k) <= now:
                resting.append(k)
        return resting

    def encloses(
        self, person: int, other: int, x: float, y: float, around: float, now: float
    ) -> bool:
        """Return whether `other` belongs to the ring of people who stand around (x, y) `now`.

        The ring grows from neighbour to neighbour through gaps that are too narrow for `person`, up
        to `around` metres.
        """
        place: Numbers = numbers((x, y, x, y))
        left: list[cython.Py_ssize_t] = self._resting(person, place, around, now)
        ring: Numbers = circle_room(len(left) + 1)  # stack of members without examined neighbours
        circle: Circles = circles_of(ring)
        radii: Doubles = at(self.radii)
        width: float = 2 * (radii[person] + self.gap)
        circle[0] = Circle(x, y, -radii[person])
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
    """Drafts of new motions from `now` (s) on, checked against all committed motions of a `floor`.

    `indices` are the numbers of the movers on the floor, in the order of adding.
    """

    def __init__(self, floor: CommittedMotions, now: float) -> None:
        super().__init__(floor.gap)
        self.floor = floor
        self.now = now
        self.indices: list[int] = []
        self.among = bytearray(len(floor.radii))
        nobody: list[cython.Py_ssize_t] = []
        self.near = nobody
        self.seen = BoundingBox(INFINITY, INFINITY, -INFINITY, -INFINITY)

    def move(self, k: cython.Py_ssize_t, swath: Swath) -> None:
        """Add a draft of a motion of the k-th disc on the floor."""
        self.add(swath, at(self.floor.radii)[k])
        self.indices.append(k)
        self.among[k] = 1

    def keep(self, count: cython.Py_ssize_t) -> None:
        """Remove all drafts after the first `count`."""
        i: cython.Py_ssize_t
        for i in range(count, len(self.radii)):
            self.among[self.indices[i]] = 0
        del self.indices[count:]
        self.shorten(count)

    def own(self, k: cython.Py_ssize_t) -> float:
        """Return the distance (m) of the k-th disc on the floor from the bodies of others."""
        own: float = at(self.floor.radii)[k] + self.gap
        return own

    def meet(self, k: cython.Py_ssize_t, swath: Swath) -> bool:
        """Return whether the motion `swath` of the k-th disc has a conflict with another draft."""
        i: cython.Py_ssize_t
        for i in range(len(self.radii)):
            if self.indices[i] != k and self.meets(i, swath, self.own(k)):
                return True
        return False

    def meets(self, i: cython.Py_ssize_t, swath: Swath, own: float) -> bool:
        """Return whether a motion that keeps `own` metres has a conflict with the i-th draft."""
        meets: bool = self.conflicts(i, swath, own, self.now)
        return meets

    def first_hit(self, i: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Return the first disc without a draft that the i-th draft conflicts with, or -1."""
        return self.first_other(self.indices[i], self.swath_of(i))

    def first_other(self, k: cython.Py_ssize_t, swath: Swath) -> cython.Py_ssize_t:
        """Return the first disc without a draft that `swath` of the k-th conflicts with, or -1."""
        b: BoundingBox = boxes_of(swath.box)[0]
        seen: BoundingBox = self.seen
        if (
            b.low_x < seen.low_x
            or b.low_y < seen.low_y
            or b.high_x > seen.high_x
            or b.high_y > seen.high_y
        ):
            self.seen = BoundingBox(
                b.low_x - _AROUND, b.low_y - _AROUND, b.high_x + _AROUND, b.high_y + _AROUND
            )
            self.near = self.floor.near(row_of_box(self.seen), self.floor.widest)
        before: cython.int = self.among[k]
        self.among[k] = 1
        first: cython.Py_ssize_t = self.floor.first_but(
            self.among, self.near, swath, self.own(k), self.now
        )
        self.among[k] = before
        return first
