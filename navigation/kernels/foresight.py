"""Choice among candidate motions of one person, by the committed motions of the others.

A candidate is free if it has no conflict with any of them. Candidates are proposed with their loss
in metres and drawn up in this order, until one is free: a search among sampled trajectories with
the earliest exit (T. M. Howard, C. J. Green, A. Kelly and D. Ferguson, "State space sampling of
feasible motions for high-performance mobile robot navigation in complex environments", Journal of
Field Robotics 25, 2008).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .candidates import Candidates
from .committed import CommittedMotions
from .discs import Swath
from .edges import Legs
from .following import CarFollowing, ChoiceParameters, Passer
from .grid import Cells
from .numbers import numbers

if not cython.compiled:
    from math import ceil

    from .cubics import *
    from .discs import distance_travelled

_STANDS: float = 1e-6  # m/s; slower than this is standing
_HAIR: float = 1e-3  # metres; nobody is met by who passes them so much farther off
_HARDLY: float = 0.02  # metres; a shift of no more is none
_BEYOND: float = 0.5  # metres; how much farther than the foresight walks beside a course lead


class TrajectoryChoice:
    """Choice of a person among others on a floor, with committed `motions`, between `walks`.

    `narrow` says where it is narrow for who is there already, `narrow_outside` for who is not,
    `legs` where there are no walls.
    """

    def __init__(
        self,
        walks: Candidates,
        motions: CommittedMotions,
        who: Passer,
        narrow: Cells,
        narrow_outside: Cells,
        legs: Legs,
        given: ChoiceParameters,
    ) -> None:
        self.given = given
        self.walks = walks
        self.state = walks.state
        self.motions = motions
        self.who = who
        self.own = who.radius + motions.gap
        self.following = CarFollowing(motions, who, given)
        self.legs = legs
        start: Position = positions_of(walks.course.corners)[0]
        self.inside = narrow_outside.has(start.x, start.y)
        self.narrow = narrow if self.inside else narrow_outside
        self.known = bytearray(int(given.farthest / given.stride) + 3)
        self.reach = who.top_speed * who.foresight
        self.stop = self.stop_beyond(self.reach)
        self.seen = room(4)
        nobody: list[cython.Py_ssize_t] = []
        self.near = nobody
        self.hit = Meeting(-1, INFINITY)
        self.ahead = Leader(-1, 0.0, 0.0)
        self.wished = Swath(self.seen, self.seen)

    def wish(self) -> Swath | None:
        """Draw up the walk that they would take if nobody were there; None if they can't.

        It stops after `stop` metres: as far as they look ahead, their `reach`, and on to the end of
        a narrow place.
        """
        wished: Swath | None = self.walks.draw_along(self.stop, self.who.top_speed, 0.0)
        if wished is not None:
            self.wished = wished
        return wished

    # Narrow places

    def stop_beyond(self, length: float) -> float:
        """Return the first length along the course, from `length` metres on, for a stop.

        Nobody stops in a narrow place of their own will, but at their goal.
        """
        whole: float = self.walks.course.length
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
        stride: float = self.given.stride
        k: cython.Py_ssize_t = int(ceil(length / stride))
        if k * stride > min(self.walks.course.length, self.given.farthest) + stride:
            return False
        if self.known[k] == 0:
            here: CoursePlace = self.walks.course.come_to(k * stride)
            self.known[k] = 2 if self.narrow.has(here.x, here.y) else 1
        found: bool = self.known[k] == 2
        return found

    # The others

    def look(self) -> tuple[int, float]:
        """See those who may come near the walk that they wish for, or beside it.

        Return whom they would meet first, -1 for nobody, and when (seconds).
        """
        self._see(self.given.looks_around)
        self.hit = self._first_met(self.own)
        return self.hit.who, self.hit.t

    def _see(self, around: float) -> cython.int:
        """See those who may come into bounds so far around that walk (metres).

        They are `near` then, and the bounds are those `seen`.
        """
        b: BoundingBox = boxes_of(self.wished.box)[0]
        self.seen = row_of_box(
            BoundingBox(b.low_x - around, b.low_y - around, b.high_x + around, b.high_y + around)
        )
        self.near = self.motions.near(self.seen, self.who.radius + self.who.comfort, self.who.me)
        return 0

    def _first_met(self, own: float) -> Meeting:
        """Return whom they would meet first who keep so far from others."""
        return self.motions.first_meeting(self.near, self.wished, own, self.state.now)

    # The choice

    def first_free(self) -> Swath | None:
        """Return the free walk that loses least: aside, slower, shorter, or later.

        That is the one they wish for if nobody is near it; None if there is none.
        """
        near: Meeting = self._first_met(self.own + self.who.comfort)
        walks: Candidates = self.walks
        self.ahead = self.following.leader(self.near, self.state.begin, walks.course.come_to(0.0))
        if near.who < 0 and self.ahead.who < 0:
            return self.wished
        walks.clear()
        hit: Meeting = self.hit
        if near.who < 0 or hit.who < 0:
            return self._keep_distance(near)
        motions: CommittedMotions = self.motions
        # Who walks the same way leaves the place where they would be met: slowing down is enough.
        # Past who comes the other way, or stands, one has to get.
        same: float = motions.between(self.who.me, hit.who, self.state.now)
        follows: cython.bint = same > self.given.alike
        if not follows:
            self.ahead = Leader(-1, 0.0, 0.0)
        at_rest: cython.bint = hit.t >= motions.rests(hit.who)
        self._propose_slower_later_shorter(hit.t, at_rest, follows)
        opposed: cython.bint = not follows and motions.bound[hit.who] != 0 and not self.inside
        self._propose_past(near, opposed)
        if near.who != hit.who:
            self._propose_past(hit, opposed)
        found: Swath | None = self._next_free()
        # Only who stands, and before nobody who walks on, tries wide detours: they cost the most.
        if found is None and self.state.speed < _STANDS and not follows:
            self._see(self.given.widest)
            walks.clear()
            along: float = self._level_with(hit).along
            length: float = self.reach + _BEYOND
            self._add_asides(self.given.detours, length, self.who.top_speed, along)
            found = self._next_free()
        return found

    def _keep_distance(self, near: Meeting) -> Swath | None:
        """Choose where nobody is in the way: the wish, or a walk farther from others than it is."""
        walks: Candidates = self.walks
        ahead: Leader = self.ahead
        brush: float = 0.0 if near.who < 0 else self.given.brush
        if ahead.who < 0:
            walks.add(brush, self.stop, self.who.top_speed, 0.0)
        else:
            # The share of their top speed that following costs them.
            loses: float = 1.0 - max(ahead.speed, ahead.walks_on) / self.who.top_speed
            walks.add(brush + max(loses, 0.0) * self.reach, self.stop, ahead.speed, 0.0)
            self._propose_past(Meeting(ahead.who, self.state.begin), False)
        if near.who >= 0:
            self._propose_past(near, False)
        found: Swath | None = self._next_free()
        return self.wished if found is None or (ahead.who < 0 and walks.row == 0) else found

    def _propose_slower_later_shorter(
        self, hit_at: float, at_rest: bool, follows: bool
    ) -> cython.int:
        """Add walks along the course that are slower, later, or end before the conflict.

        That is at `hit_at` (seconds), `at_rest` if the other stands by then; who `follows` goes the
        same way as they do.
        """
        walks: Candidates = self.walks
        given: ChoiceParameters = self.given
        speed: float = self.state.speed
        stands: cython.bint = speed < _STANDS
        is_behind: cython.bint = self.ahead.who >= 0
        fastest: float = self.who.top_speed
        top: float = self.ahead.speed if is_behind else fastest
        whole: float = min(self.reach, walks.course.length)
        i: cython.Py_ssize_t
        if not at_rest:  # else it would be as much in the way later on
            for i in range(len(given.paces)):
                pace: float = at(given.paces)[i]
                walks.add((1 - pace * top / fastest) * whole, self.stop, pace * top, 0.0)
            if stands:
                for i in range(len(given.delays)):
                    delay: float = at(given.delays)[i]
                    walks.add(delay * top, self.stop, top, delay)
        # In a single file all come as near as their time gap lets them, and then slow down: a stop
        # behind somebody who is about to walk on loses less than it seems.
        phantom: cython.bint = follows and (at_rest or (is_behind and self.is_narrow(0.0)))
        share: float = given.phantom if phantom else 1.0
        # v² / (2 a), the shortest stop there is, and a little more against rounding.
        braking: float = speed * speed / (2 * self.state.acceleration) * 1.001
        ahead: float = distance_travelled(self.wished.table, self.state.begin, hit_at)
        asked: cython.bint = False
        goes_in: cython.bint = False
        length: float
        for i in range(len(given.parts)):
            length = at(given.parts)[i] * ahead
            if self.is_narrow(length):
                if not asked:
                    asked = True
                    goes_in = self._may_go_in(length, follows)
                if not goes_in:
                    length = self.stop_before(length)
            if length >= (given.shortest if stands else braking):
                walks.add(share * max(whole - length, 0.0), length, top, 0.0)
        if not stands:
            walks.add(share * max(whole - braking, 0.0), braking, top, 0.0)
            if is_behind and self.ahead.speed + given.faster < fastest:
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
        motions: CommittedMotions = self.motions
        t: float = self.state.begin
        there: CoursePlace = self.walks.course.come_to(length)
        start: Position = positions_of(self.walks.course.corners)[0]
        here: CoursePlace = CoursePlace(start.x, start.y, there.c, there.s, 0)
        i: cython.Py_ssize_t
        for i in range(len(self.near)):
            k: cython.Py_ssize_t = self.near[i]
            other: Position = motions.place(k, t)
            if (
                ahead_of(here, other.x, other.y) > 0.0
                and abs(left_of(there, other.x, other.y)) < self.given.closes_up
                and motions.cosine(k, t, there.c, there.s) < 0.0
            ):
                end: Position = motions.place(k, motions.rests(k))
                if self.narrow.has(other.x, other.y) or self.narrow.has(end.x, end.y):
                    return True
        return False

    def _propose_files(self) -> cython.int:
        """Add walks to a place beside the file of who follows, where they come on faster.

        So a crowd takes up all the width that there is, but where others need it to come the other
        way.
        """
        if self.inside:
            return 0
        given: ChoiceParameters = self.given
        here: CoursePlace = self.walks.course.come_to(0.0)
        i: cython.Py_ssize_t
        for i in range(2 * len(given.files)):
            usual: float = self.who.usual if i % 2 == 0 else -self.who.usual
            side: float = at(given.files)[i // 2] * usual
            x: float = here.x - side * here.s
            y: float = here.y + side * here.c
            beside: CoursePlace = CoursePlace(x, y, here.c, here.s, 0)
            speed: float = self.following.speed_at(self.near, self.state.begin, beside)
            along: float = given.beside_after * speed * self.who.foresight
            if speed >= self.ahead.speed + given.faster and along < self.walks.course.length:
                self._add_aside(side, along, speed, along)
        return 0

    def _propose_past(self, other: Meeting, opposed: bool) -> cython.int:
        """Add the walks that pass another, who is met then, on either side.

        Just past the other, and a little wider. Who is `opposed` may also stop beside the other:
        past the first of many there seldom is room for all that they look ahead.
        """
        level: FrenetPlace = self._level_with(other)
        # Just past them at the comfort distance, then at the least one; to either side.
        needed: float = self.who.radius + at(self.motions.radii)[other.who] + self.motions.gap
        wide: float = needed + self.who.comfort
        sides: Numbers = numbers(
            (
                level.left - wide,
                level.left + wide,
                level.left - needed - _HAIR,
                level.left + needed + _HAIR,
                *self.given.widths,
            )
        )
        top: float = self.who.top_speed
        self._add_asides(sides, self.reach + _BEYOND, top, level.along)
        if opposed:
            cut(sides, 2)
            self._add_asides(sides, level.along + self.given.past, top, level.along)
        return 0

    def _add_asides(
        self, sides: Numbers, length: float, top_speed: float, along: float
    ) -> cython.int:
        """Add the walks on several `sides`, each once."""
        side: Doubles = at(sides)
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        for i in range(len(sides)):
            again: cython.bint = False
            for j in range(i):
                again = again or side[j] == side[i]
            if not again:
                self._add_aside(side[i], length, top_speed, along)
        return 0

    def _add_aside(self, side: float, length: float, top_speed: float, along: float) -> cython.int:
        """Add the walk that is `side` metres to the left, but for the widest and for hardly any.

        On the other side than the usual one it loses more.
        """
        if _HARDLY < abs(side) <= self.given.widest:
            extra: float = self.given.other_side if side * self.who.usual < 0.0 else 0.0
            self.walks.add_aside(extra, length, top_speed, along, side)
        return 0

    def _level_with(self, other: Meeting) -> FrenetPlace:
        """Return where on the course they are level with another, who is met then."""
        before: float = distance_travelled(self.wished.table, self.state.begin, other.t)
        here: CoursePlace = self.walks.course.come_to(before)
        there: Position = self.motions.place(other.who, other.t)
        along: float = before + max(ahead_of(here, there.x, there.y), 0.0)
        return FrenetPlace(along, left_of(here, there.x, there.y))

    def _next_free(self) -> Swath | None:
        """Return the walk that loses least of those that are free, or None."""
        while True:
            found: Swath | None = self.walks.next_free(self.near, self.motions, self.own)
            if found is None or self._has_room():
                return found

    def aside(self, along: float, side: float, near: list[cython.Py_ssize_t]) -> Swath | None:
        """Draw up a walk `side` metres to the left after `along` metres of the course.

        None if it is not free, of walls and of those `near`.
        """
        walks: Candidates = self.walks
        walks.clear()
        walks.add_aside(0.0, self.reach + _BEYOND, self.who.top_speed, along, side)
        found: Swath | None = walks.next_free(near, self.motions, self.own)
        return found if found is not None and self._has_room() else None

    def _has_room(self) -> bool:
        """Return whether there are no walls in the way of the walk that was looked at last.

        To be asked after others were looked at: that is quicker.
        """
        walks: Candidates = self.walks
        if walks.looked_at.side == 0.0:
            return True
        corner: Positions = positions_of(walks.corners)
        k: cython.Py_ssize_t
        # The shift is in the first three legs; all that comes after is the course, which is free.
        for k in range(min(walks.many, 4) - 1):
            if not self.legs.free(corner[k].x, corner[k].y, corner[k + 1].x, corner[k + 1].y):
                return False
        return True
