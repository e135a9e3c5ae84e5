"""Choice among candidate motions of one person, by the committed motions of the others.

A candidate is free if it has no conflict with any of them. Candidates are proposed with their loss
in metres and drawn up in this order, until one is free.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .candidates import Candidates
from .edges import Legs
from .grid import Cells
from .throng import Throng

if not cython.compiled:
    from math import ceil, inf

    from .discs import first_met, gone
    from .following import followed, speed_behind
    from .numbers import Doubles, Numbers, at, numbers, room

    INFINITY = inf
else:
    from cython.cimports.libc.math import INFINITY, ceil
    from cython.cimports.navigation.kernels.discs import first_met, gone
    from cython.cimports.navigation.kernels.following import followed, speed_behind
    from cython.cimports.navigation.kernels.numbers import Doubles, Numbers, at, numbers, room

_STANDS: float = 1e-6  # m/s; slower than this is standing
_HAIR: float = 1e-3  # metres; nobody is met by who passes them so much farther off


class ChoiceParameters:
    """Parameters of the choice, from an object with these attributes and lists of numbers."""

    def __init__(self, given: Any) -> None:
        self.stride: float = given.stride
        self.farthest: float = given.farthest
        self.looks_around: float = given.looks_around
        self.detours = numbers(given.detours)
        self.widths = numbers(given.widths)
        self.widest: float = given.widest
        self.paces = numbers(given.paces)
        self.delays = numbers(given.delays)
        self.parts = numbers(given.parts)
        self.shortest: float = given.shortest
        self.phantom: float = given.phantom
        self.files = numbers(given.files)
        self.faster: float = given.faster
        self.beside_after: float = given.beside_after
        self.past: float = given.past
        self.other_side: float = given.other_side
        self.brush: float = given.brush
        self.alike: float = given.alike
        self.closes_in: float = given.closes_in
        self.sees: float = given.sees
        self.least_speed: float = given.least_speed
        self.same_way: float = given.same_way
        self.closes_up: float = given.closes_up


class TrajectoryChoice:
    """Choice of person `me` of a throng among candidate `walks`.

    At up to `top_speed` (m/s). `radius` and `comfort`, the distance that they keep where there is
    room, are in metres, `time_gap` and `foresight` in seconds (see `Manners`); `usual` is the side
    on which they pass, 1 for the left, -1 for the right. `narrow` says where it is narrow for who
    is there already, `narrow_outside` for who is not, `legs` where there are no walls.
    """

    def __init__(
        self,
        walks: Candidates,
        throng: Throng,
        me: int,
        top_speed: float,
        radius: float,
        comfort: float,
        time_gap: float,
        foresight: float,
        usual: float,
        narrow: Cells,
        narrow_outside: Cells,
        legs: Legs,
        given: ChoiceParameters,
    ) -> None:
        self.given = given
        self.walks = walks
        self.throng = throng
        self.me = me
        self.top_speed = top_speed
        self.radius = radius
        self.own = radius + throng.gap
        self.comfort = comfort
        self.time_gap = time_gap
        self.foresight = foresight
        self.usual = usual
        self.narrow = narrow
        self.narrow_outside = narrow_outside
        self.legs = legs
        course: Doubles = at(walks.course)
        self.inside = narrow_outside.has(course[0], course[1])
        self.known = bytearray(int(self.given.farthest / self.given.stride) + 3)
        self.reach = top_speed * foresight
        self.stop = self.stop_beyond(self.reach)
        none: Numbers = room(0)
        nobody: list[cython.Py_ssize_t] = []
        self.table = none
        self.box = none
        self.seen = none
        self.near = nobody
        self.wishes = False
        self.hit = self.ahead = -1
        self.met_at = self.hit_at = INFINITY
        self.when = room(1)
        self.ahead_speed = self.ahead_walks_on = self.beside = 0.0

    def wish(self) -> bool:
        """Draw up the walk that they would take if nobody were there; False if they can't.

        It stops after `stop` metres: as far as they look ahead, their `reach`, and on to the end of
        a narrow place.
        """
        walks: Candidates = self.walks
        if not walks.draw_along(self.stop, self.top_speed, 0.0):
            return False
        self.table = walks.table
        self.box = walks.box
        return True

    # Narrow places

    def stop_beyond(self, length: float) -> float:
        """Return the first length along the course, from `length` metres on, for a stop.

        Nobody stops in a narrow place of their own will, but at their goal.
        """
        whole: float = self.walks.whole
        while length < min(whole, self.given.farthest):
            if not self.is_narrow(length):
                return length
            length += self.given.stride
        return whole

    def stop_before(self, length: float) -> float:
        """Return the last length along the course, up to `length` metres, for a stop."""
        while length > 0.0 and self.is_narrow(length):
            length -= self.given.stride
        return max(length, 0.0)

    def is_narrow(self, length: float) -> bool:
        """Return whether the course is in a narrow place after `length` metres."""
        # On a grid of lengths, so that the same place is asked for once and not once for each walk.
        k: cython.Py_ssize_t = int(ceil(length / self.given.stride))
        if k * self.given.stride > min(self.walks.whole, self.given.farthest) + self.given.stride:
            return False
        if self.known[k] == 0:
            self.walks.come_to(k * self.given.stride)
            self.known[k] = 2 if self._is_narrow_at(self.walks.x, self.walks.y) else 1
        found: bool = self.known[k] == 2
        return found

    def _is_narrow_at(self, x: float, y: float) -> bool:
        """Return whether a place is narrow for them, who may be inside already."""
        return self.narrow.has(x, y) if self.inside else self.narrow_outside.has(x, y)

    # The others

    def look(self) -> cython.Py_ssize_t:
        """See those who may come near the walk that they wish for, or beside it.

        Return whom they would meet first, `hit`, at `hit_at` (seconds); -1 for nobody.
        """
        self._see(self.given.looks_around)
        self.hit = self._first_met(self.own)
        self.hit_at = self.met_at
        return self.hit

    def _see(self, around: float) -> cython.int:
        """See those who may come into bounds so far around that walk (metres).

        They are `near` then, and the bounds are those `seen`.
        """
        box: Doubles = at(self.box)
        self.seen = room(4)
        seen: Doubles = at(self.seen)
        seen[0] = box[0] - around
        seen[1] = box[1] - around
        seen[2] = box[2] + around
        seen[3] = box[3] + around
        self.near = self.throng.near(self.seen, self.radius + self.comfort, self.me)
        return 0

    def _first_met(self, own: float) -> cython.Py_ssize_t:
        """Return whom they would meet first who keep so far from others; -1 for nobody.

        When, is `met_at`.
        """
        throng: Throng = self.throng
        who: cython.Py_ssize_t = first_met(
            self.table,
            self.box,
            self.near,
            throng.tables,
            throng.boxes,
            throng.radii,
            own,
            self.walks.now,
            self.when,
        )
        self.met_at = at(self.when)[0]
        return who

    # Following

    def _follow(self) -> cython.int:
        """Set `ahead` to whom they follow, who walks on; -1 if nobody keeps them below their speed.

        In `closes_in` seconds they have come to the distance of their time gap, times their speed,
        beyond the bodies; who is beside the path of the one ahead keeps less. Who stands, or goes
        another way, is not followed, and nobody keeps a gap into which somebody who comes the other
        way would step: that jams aisles.
        """
        self.ahead = -1
        if self.time_gap <= 0.0:
            return 0
        throng: Throng = self.throng
        walks: Candidates = self.walks
        t: float = walks.begin
        walks.come_to(0.0)
        x: float = walks.x
        y: float = walks.y
        c: float = walks.c
        s: float = walks.s
        slow: list[cython.Py_ssize_t] = []
        i: cython.Py_ssize_t
        k: cython.Py_ssize_t
        found: cython.Py_ssize_t = self._followed(x, y, c, s, slow)
        best: float = self.top_speed
        if found >= 0:
            best = self._speed_behind(found, x, y, c, s)
            if best == INFINITY:
                found = -1
                best = self.top_speed
        walks_on: float = self.ahead_walks_on
        # A person who has just started may be followed too, along their route.
        for i in range(len(slow)):
            k = slow[i]
            if throng.rests(k) > t and throng.cosine(k, t, c, s) > self.given.same_way:
                speed: float = self._speed_behind(k, x, y, c, s)
                if speed < best:
                    found = k
                    best = speed
                    walks_on = self.ahead_walks_on
        if found < 0:
            return 0
        for i in range(len(slow)):
            k = slow[i]
            throng.find(k, t)
            away: float = abs((throng.y - y) * c - (throng.x - x) * s)
            if away < self.given.closes_up and throng.cosine(k, t, c, s) < -self.given.same_way:
                return 0
        self.ahead = found
        self.ahead_speed = max(best, self.given.least_speed)
        self.ahead_walks_on = walks_on
        return 0

    def _followed(
        self, x: float, y: float, c: float, s: float, slow: list[cython.Py_ssize_t]
    ) -> cython.Py_ssize_t:
        """Return who keeps them below their top speed most who walk from x, y in direction c, s.

        -1 for nobody; `slow` receives those ahead who hardly move.
        """
        throng: Throng = self.throng
        return followed(
            self.near,
            throng.tables,
            throng.radii,
            self.walks.begin,
            self.given.sees,
            x,
            y,
            c,
            s,
            self.radius,
            self.time_gap,
            self.given.closes_in,
            self.top_speed,
            self.given.same_way,
            self.given.closes_up,
            slow,
        )

    def _speed_behind(self, k: cython.Py_ssize_t, x: float, y: float, c: float, s: float) -> float:
        """Return how fast they walk behind the k-th (m/s); infinite for who is not in the way.

        From x, y in direction c, s. How fast the other walks on is `ahead_walks_on`.
        """
        throng: Throng = self.throng
        t: float = self.walks.begin
        throng.find(k, t)
        ox: float = throng.x
        oy: float = throng.y
        away: float = abs((oy - y) * c - (ox - x) * s)
        touch: float = self.radius + at(throng.radii)[k]
        if away >= touch:
            return INFINITY
        along: float = (ox - x) * c + (oy - y) * s
        throng.find(k, t + self.given.sees)
        self.ahead_walks_on = ((throng.x - ox) * c + (throng.y - oy) * s) / self.given.sees
        most: float = speed_behind(
            along, away, touch, self.ahead_walks_on, self.time_gap, self.given.closes_in
        )
        return most

    def _speed_beside(self, side: float) -> float:
        """Return how fast (m/s) they would come on `side` metres to the left, behind others."""
        walks: Candidates = self.walks
        walks.come_to(0.0)
        c: float = walks.c
        s: float = walks.s
        x: float = walks.x - side * s
        y: float = walks.y + side * c
        slow: list[cython.Py_ssize_t] = []
        k: cython.Py_ssize_t = self._followed(x, y, c, s, slow)
        speed: float = INFINITY if k < 0 else self._speed_behind(k, x, y, c, s)
        return self.top_speed if speed == INFINITY else max(speed, self.given.least_speed)

    # The choice

    def first_free(self) -> bool:
        """Choose among the walks that there are: the free one that loses least.

        Aside, slower, shorter, or later. Return whether there is one: it was the last to be looked
        at, or is their wish, as `wishes` says.
        """
        walks: Candidates = self.walks
        self.wishes = False
        near: cython.Py_ssize_t = self._first_met(self.own + self.comfort)
        near_at: float = self.met_at
        self._follow()
        if near < 0 and self.ahead < 0:
            self.wishes = True
            return True
        walks.clear()
        hit: cython.Py_ssize_t = self.hit
        hit_at: float = self.hit_at
        if near < 0 or hit < 0:
            return self._keep_distance(near, near_at)
        throng: Throng = self.throng
        at_rest: cython.bint = hit_at >= throng.rests(hit)
        # Who walks the same way leaves the place where they would be met: slowing down is enough.
        # Past who comes the other way, or stands, one has to get.
        follows: cython.bint = throng.between(self.me, hit, walks.now) > self.given.alike
        if not follows:
            self.ahead = -1
        self._propose_slower_later_shorter(hit_at, at_rest, follows)
        opposed: cython.bint = not follows and throng.bound[hit] != 0 and not self.inside
        self._propose_past(near, near_at, opposed)
        if near != hit:
            self._propose_past(hit, hit_at, opposed)
        if self._next_free():
            return True
        # Only who stands, and before nobody who walks on, tries wide detours: they cost the most.
        if walks.speed < _STANDS and not follows:
            self._see(self.given.widest)
            walks.clear()
            self._propose_detours(hit, hit_at)
            return self._next_free()
        return False

    def _keep_distance(self, near: cython.Py_ssize_t, near_at: float) -> bool:
        """Choose where nobody is in the way: the wish, or a walk farther from others than it is."""
        walks: Candidates = self.walks
        brush: float = 0.0 if near < 0 else self.given.brush
        if self.ahead < 0:
            walks.add(brush, self.stop, self.top_speed, 0.0)
        else:
            # The share of their top speed that following costs them.
            loses: float = 1.0 - max(self.ahead_speed, self.ahead_walks_on) / self.top_speed
            walks.add(brush + max(loses, 0.0) * self.reach, self.stop, self.ahead_speed, 0.0)
            self._propose_past(self.ahead, walks.begin, False)
        if near >= 0:
            self._propose_past(near, near_at, False)
        self.wishes = not self._next_free() or (self.ahead < 0 and walks.row == 0)
        return True

    def _propose_slower_later_shorter(
        self, hit_at: float, at_rest: bool, follows: bool
    ) -> cython.int:
        """Add walks along the course that are slower, later, or end before the conflict.

        That is at `hit_at` (seconds), `at_rest` if the other stands by then; who `follows` goes the
        same way as they do.
        """
        walks: Candidates = self.walks
        stands: cython.bint = walks.speed < _STANDS
        top: float = self.top_speed if self.ahead < 0 else self.ahead_speed
        whole: float = min(self.reach, walks.whole)
        i: cython.Py_ssize_t
        if not at_rest:  # else it would be as much in the way later on
            for i in range(len(self.given.paces)):
                pace: float = at(self.given.paces)[i]
                walks.add((1 - pace * top / self.top_speed) * whole, self.stop, pace * top, 0.0)
            if stands:
                for i in range(len(self.given.delays)):
                    delay: float = at(self.given.delays)[i]
                    walks.add(delay * top, self.stop, top, delay)
        # In a single file all come as near as their time gap lets them, and then slow down: a stop
        # behind somebody who is about to walk on loses less than it seems.
        phantom: cython.bint = follows and (at_rest or (self.ahead >= 0 and self.is_narrow(0.0)))
        share: float = self.given.phantom if phantom else 1.0
        # v² / (2 a), the shortest stop there is, and a little more against rounding.
        braking: float = walks.speed * walks.speed / (2 * walks.acceleration) * 1.001
        ahead: float = gone(self.table, walks.begin, hit_at)
        asked: cython.bint = False
        goes_in: cython.bint = False
        length: float
        for i in range(len(self.given.parts)):
            length = at(self.given.parts)[i] * ahead
            if self.is_narrow(length):
                if not asked:
                    asked = True
                    goes_in = self._may_go_in(length, follows)
                if not goes_in:
                    length = self.stop_before(length)
            if length >= (self.given.shortest if stands else braking):
                walks.add(share * max(whole - length, 0.0), length, top, 0.0)
        if not stands:
            walks.add(share * max(whole - braking, 0.0), braking, top, 0.0)
            if self.ahead >= 0 and self.ahead_speed + self.given.faster < self.top_speed:
                self._propose_files()
        return 0

    def _may_go_in(self, length: float, follows: bool) -> bool:
        """Return whether they may stop in a narrow place, after `length` metres of their course.

        Only against nobody who comes, else two files would go in from either end behind those who
        come out, and meet inside: who is in it already, or follows somebody who leaves it the same
        way.
        """
        return (self.is_narrow(0.0) or follows) and not self._is_opposed(length)

    def _is_opposed(self, length: float) -> bool:
        """Return whether somebody in a narrow place ahead comes, `length` metres on."""
        walks: Candidates = self.walks
        throng: Throng = self.throng
        t: float = walks.begin
        walks.come_to(length)
        c: float = walks.c
        s: float = walks.s
        course: Doubles = at(walks.course)
        i: cython.Py_ssize_t
        for i in range(len(self.near)):
            k: cython.Py_ssize_t = self.near[i]
            throng.find(k, t)
            x: float = throng.x
            y: float = throng.y
            if (
                (x - course[0]) * c + (y - course[1]) * s > 0.0
                and abs((y - walks.y) * c - (x - walks.x) * s) < self.given.closes_up
                and throng.cosine(k, t, c, s) < 0.0
            ):
                if self._is_narrow_at(x, y):
                    return True
                throng.find(k, throng.rests(k))
                if self._is_narrow_at(throng.x, throng.y):
                    return True
        return False

    def _propose_files(self) -> cython.int:
        """Add walks to a place beside the file of who follows, where they come on faster.

        So a crowd takes up all the width that there is, but where others need it to come the other
        way.
        """
        if self.inside:
            return 0
        walks: Candidates = self.walks
        sides: Numbers = room(1)
        i: cython.Py_ssize_t
        for i in range(2 * len(self.given.files)):
            side: float = at(self.given.files)[i // 2] * (self.usual if i % 2 == 0 else -self.usual)
            speed: float = self._speed_beside(side)
            along: float = self.given.beside_after * speed * self.foresight
            if speed >= self.ahead_speed + self.given.faster and along < walks.whole:
                at(sides)[0] = side
                walks.add_asides(
                    sides, self.given.widest, self.usual, self.given.other_side, along, speed, along
                )
        return 0

    def _propose_past(
        self,
        k: cython.Py_ssize_t,
        t: float,
        opposed: bool,
    ) -> cython.int:
        """Add the walks that pass the k-th on either side, who is met at `t` (seconds).

        Just past the other, and a little wider. Who is `opposed` may also stop beside the other:
        past the first of many there seldom is room for all that they look ahead.
        """
        walks: Candidates = self.walks
        throng: Throng = self.throng
        along: float = self._come_beside(k, t)
        beside: float = self.beside
        # Just past them at the comfort distance, then at the least one; to either side.
        needed: float = self.radius + at(throng.radii)[k] + throng.gap
        wide: float = needed + self.comfort
        sides: Numbers = numbers(
            (
                beside - wide,
                beside + wide,
                beside - needed - _HAIR,
                beside + needed + _HAIR,
                *self.given.widths,
            )
        )
        length: float = self.reach + 0.5
        top: float = self.top_speed
        usual: float = self.usual
        walks.add_asides(sides, self.given.widest, usual, self.given.other_side, length, top, along)
        if opposed:
            length = along + self.given.past
            sides = numbers((beside - wide, beside + wide))
            walks.add_asides(
                sides, self.given.widest, usual, self.given.other_side, length, top, along
            )
        return 0

    def _propose_detours(self, k: cython.Py_ssize_t, t: float) -> cython.int:
        """Add wide walks round the k-th, who is met at `t` (seconds)."""
        along: float = self._come_beside(k, t)
        length: float = self.reach + 0.5
        self.walks.add_asides(
            self.given.detours,
            self.given.widest,
            self.usual,
            self.given.other_side,
            length,
            self.top_speed,
            along,
        )
        return 0

    def _come_beside(self, k: cython.Py_ssize_t, t: float) -> float:
        """Return after how many metres they are level with the k-th, who is met at `t` (seconds).

        How far the other is to the left of the course then (metres), is `beside`.
        """
        walks: Candidates = self.walks
        throng: Throng = self.throng
        before: float = gone(self.table, walks.begin, t)
        walks.come_to(before)
        throng.find(k, t)
        dx: float = throng.x - walks.x
        dy: float = throng.y - walks.y
        self.beside = dy * walks.c - dx * walks.s
        along: float = before + max(dx * walks.c + dy * walks.s, 0.0)
        return along

    def _next_free(self) -> bool:
        """Come to the walk that loses least of those that are free; return whether there is one."""
        while self.walks.next_free(self.near, self.throng, self.own):
            if self._has_room():
                return True
        return False

    def aside(self, along: float, side: float, near: list[cython.Py_ssize_t]) -> bool:
        """Draw up a walk `side` metres to the left after `along` metres of the course.

        Return whether it is free, of walls and of those `near`.
        """
        walks: Candidates = self.walks
        walks.clear()
        walks.add_aside(along, side, self.reach + 0.5, self.top_speed)
        return walks.next_free(near, self.throng, self.own) and self._has_room()

    def _has_room(self) -> bool:
        """Return whether there are no walls in the way of the walk that was looked at last.

        To be asked after others were looked at: that is quicker.
        """
        if self.walks.side == 0.0:
            return True
        c: Doubles = at(self.walks.corners)
        k: cython.Py_ssize_t
        # The shift is in the first three legs; all that comes after is the course, which is free.
        for k in range(0, min(self.walks.many, 8) - 2, 2):
            if not self.legs.free(c[k], c[k + 1], c[k + 2], c[k + 3]):
                return False
        return True
