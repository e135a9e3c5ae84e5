"""Choice among candidate motions of one person, by the committed motions of the others.

A candidate is free if it has no conflict with any committed motion. Candidates have a loss in
metres, and are constructed in this order until one is free. This is a search among sampled
trajectories with the earliest exit (T. M. Howard, C. J. Green, A. Kelly and D. Ferguson, "State
space sampling of feasible motions for high-performance mobile robot navigation in complex
environments", Journal of Field Robotics 25, 2008).
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

if not cython.compiled:
    from math import ceil

    from .cubics import *
    from .discs import distance_travelled

_STANDS: float = 1e-6  # m/s; slower people count as standing
_HAIR: float = 1e-3  # metres beyond the minimum distance at which people pass without a conflict
_HARDLY: float = 0.02  # metres; smaller lateral shifts are ignored
_LATER: float = 1.0  # seconds, more than any rounding of times
_BEYOND: float = 0.5  # metres by which walks beside a course are longer than the foresight


class TrajectoryChoice:
    """Choice of a person (`walker`) among candidate `walks` and the `motions` of all people.

    `narrow` has the narrow places for a person who is inside of one, `narrow_outside` for others.
    `legs` tests segments for walls.
    """

    def __init__(
        self,
        walks: Candidates,
        motions: CommittedMotions,
        walker: Passer,
        narrow: Cells,
        narrow_outside: Cells,
        legs: Legs,
        parameters: ChoiceParameters,
    ) -> None:
        self.parameters = parameters
        self.walks = walks
        self.state = walks.state
        self.motions = motions
        self.walker = walker
        self.own = walker.radius + motions.gap
        self.following = CarFollowing(motions, walker, parameters)
        self.legs = legs
        start: Position = positions_of(walks.course.corners)[0]
        self.inside = narrow_outside.has(start.x, start.y)
        self.narrow = narrow if self.inside else narrow_outside
        self.checked = bytearray(int(parameters.farthest / parameters.stride) + 3)
        self.reach = walker.top_speed * walker.foresight
        self.stop = self.stop_beyond(self.reach)
        self.seen = room(4)
        nobody: list[cython.Py_ssize_t] = []
        self.near = nobody
        # People near without one, for walks past this one together with a shift of theirs.
        self.all_near = nobody
        self.without = nobody
        self.excluded = -1
        self.hit = Meeting(-1, INFINITY)
        self.ahead = Leader(-1, 0.0, 0.0)
        self.wished = Swath(self.seen, self.seen)

    def wish(self) -> Swath | None:
        """Return the walk that the person prefers without others, or None if it is impossible.

        It ends after `stop` metres, which is the `reach` of the foresight, extended to the end of a
        narrow place.
        """
        wished: Swath | None = self.walks.draw_along(self.stop, self.walker.top_speed, 0.0)
        if wished is not None:
            self.wished = wished
        return wished

    # Narrow places

    def stop_beyond(self, length: float) -> float:
        """Return the first length along the course from `length` on (m) at which a stop is allowed.

        People stop in a narrow place only at their goal.
        """
        whole: float = self.walks.course.length
        while length < min(whole, self.parameters.farthest):
            if not self.is_narrow(length):
                return length
            length += self.parameters.stride
        return whole

    def stop_before(self, length: float) -> float:
        """Return the last length along the course up to `length` (m) at which a stop is allowed."""
        while length > 0.0 and self.is_narrow(length):
            length -= self.parameters.stride
        return max(length, 0.0)

    def is_narrow(self, length: float) -> bool:
        """Return whether the course is in a narrow place after `length` metres."""
        # Lengths are rounded to a grid, so that each place is queried once for all walks.
        stride: float = self.parameters.stride
        k: cython.Py_ssize_t = int(ceil(length / stride))
        if k * stride > min(self.walks.course.length, self.parameters.farthest) + stride:
            return False
        if self.checked[k] == 0:
            here: CoursePlace = self.walks.course.come_to(k * stride)
            self.checked[k] = 2 if self.narrow.has(here.x, here.y) else 1
        narrow: bool = self.checked[k] == 2
        return narrow

    # The others

    def look(self) -> tuple[int, float]:
        """Find the people who may come near the preferred walk, and the first conflict.

        Return the index of the first person in conflict, or -1, and the time of the conflict (s).
        """
        self._see(self.parameters.looks_around)
        self.hit = self._first_met(self.own, INFINITY)
        return self.hit.person, self.hit.t

    def _see(self, around: float) -> cython.int:
        """Set `near` to the people who may come within `around` metres of the preferred walk.

        `seen` are the bounds of the search.
        """
        b: BoundingBox = boxes_of(self.wished.box)[0]
        self.seen = row_of_box(
            BoundingBox(b.low_x - around, b.low_y - around, b.high_x + around, b.high_y + around)
        )
        self.near = self.motions.near(
            self.seen, self.walker.radius + self.walker.comfort, self.walker.index
        )
        return 0

    def _first_met(self, own: float, until: float) -> Meeting:
        """Return the first conflict before `until` at a distance of `own` metres from bodies."""
        return self.motions.first_meeting(self.near, self.wished, own, self.state.now, until)

    # The choice

    def first_free(self) -> Swath | None:
        """Return the free walk with the least loss, or None.

        Candidates shift aside, slow down, stop earlier or start later. The preferred walk is the
        result if no other person is near it.
        """
        # A larger distance is reached earlier than that of the conflict.
        near: Meeting = self._first_met(self.own + self.walker.comfort, self.hit.t + _LATER)
        walks: Candidates = self.walks
        self.ahead = self.following.leader(self.near, self.state.begin, walks.course.come_to(0.0))
        if near.person < 0 and self.ahead.person < 0:
            return self.wished
        walks.clear()
        hit: Meeting = self.hit
        if near.person < 0 or hit.person < 0:
            return self._keep_distance(near)
        motions: CommittedMotions = self.motions
        # A person in the same direction leaves the place of the conflict, so slowing down suffices.
        # A person who stands or comes the other way must be passed.
        same: float = motions.between(self.walker.index, hit.person, self.state.now)
        follows: cython.bint = same > self.parameters.alike
        if not follows:
            self.ahead = Leader(-1, 0.0, 0.0)
        at_rest: cython.bint = hit.t >= motions.rests(hit.person)
        self._propose_slower_later_shorter(hit.t, at_rest, follows)
        opposed: cython.bint = not follows and motions.bound[hit.person] != 0 and not self.inside
        self._propose_past(near, opposed)
        if near.person != hit.person:
            self._propose_past(hit, opposed)
        walk: Swath | None = self._next_free()
        # Wide detours cost most. Only standing people try them, and not behind a walking person.
        if walk is None and self.state.speed < _STANDS and not follows:
            self._see(self.parameters.widest)
            walks.clear()
            along: float = self._level_with(hit).along
            length: float = self.reach + _BEYOND
            self._add_asides(self.parameters.detours, length, self.walker.top_speed, along)
            walk = self._next_free()
        return walk

    def _keep_distance(self, near: Meeting) -> Swath | None:
        """Return the preferred walk, or one with more distance from others, without a conflict."""
        walks: Candidates = self.walks
        ahead: Leader = self.ahead
        brush: float = 0.0 if near.person < 0 else self.parameters.brush
        if ahead.person < 0:
            walks.add(brush, self.stop, self.walker.top_speed, 0.0)
        else:
            # Share of the top speed that following costs.
            loses: float = 1.0 - max(ahead.speed, ahead.walks_on) / self.walker.top_speed
            walks.add(brush + max(loses, 0.0) * self.reach, self.stop, ahead.speed, 0.0)
            self._propose_past(Meeting(ahead.person, self.state.begin), False)
        if near.person >= 0:
            self._propose_past(near, False)
        walk: Swath | None = self._next_free()
        return self.wished if walk is None or (ahead.person < 0 and walks.row == 0) else walk

    def _propose_slower_later_shorter(
        self, hit_at: float, at_rest: bool, follows: bool
    ) -> cython.int:
        """Add walks along the course that are slower, later, or end before the conflict.

        The conflict is at `hit_at` (s). With `at_rest`, the other person is at rest then. With
        `follows`, both walk in the same direction.
        """
        walks: Candidates = self.walks
        parameters: ChoiceParameters = self.parameters
        speed: float = self.state.speed
        stands: cython.bint = speed < _STANDS
        is_behind: cython.bint = self.ahead.person >= 0
        fastest: float = self.walker.top_speed
        top: float = self.ahead.speed if is_behind else fastest
        whole: float = min(self.reach, walks.course.length)
        i: cython.Py_ssize_t
        if not at_rest:  # a standing person is also in the way later
            for i in range(len(parameters.paces)):
                pace: float = at(parameters.paces)[i]
                walks.add((1 - pace * top / fastest) * whole, self.stop, pace * top, 0.0)
            if stands:
                for i in range(len(parameters.delays)):
                    delay: float = at(parameters.delays)[i]
                    walks.add(delay * top, self.stop, top, delay)
        # In a single file, people come as near as their time gap allows and then slow down. A stop
        # behind a person who is about to walk on costs less than it seems.
        phantom: cython.bint = follows and (at_rest or (is_behind and self.is_narrow(0.0)))
        share: float = parameters.phantom if phantom else 1.0
        # v² / (2 a) is the shortest stop, enlarged against rounding.
        braking: float = speed * speed / (2 * self.state.acceleration) * 1.001
        ahead: float = distance_travelled(self.wished.table, self.state.begin, hit_at)
        checked: cython.bint = False
        goes_in: cython.bint = False
        length: float
        for i in range(len(parameters.parts)):
            length = at(parameters.parts)[i] * ahead
            if self.is_narrow(length):
                if not checked:
                    checked = True
                    goes_in = self._may_go_in(length, follows)
                if not goes_in:
                    length = self.stop_before(length)
            if length >= (parameters.shortest if stands else braking):
                walks.add(share * max(whole - length, 0.0), length, top, 0.0)
        if not stands:
            walks.add(share * max(whole - braking, 0.0), braking, top, 0.0)
            if is_behind and self.ahead.speed + parameters.faster < fastest:
                self._propose_files()
        return 0

    def _may_go_in(self, length: float, follows: bool) -> bool:
        """Return whether a stop in a narrow place after `length` metres of the course is allowed.

        The person must be inside already, or follow a person who leaves in the same direction, and
        no person may come the other way. Otherwise files from both ends would meet inside.
        """
        return (self.is_narrow(0.0) or follows) and not self._is_opposed(length)

    def _is_opposed(self, length: float) -> bool:
        """Return whether a person in a narrow place `length` metres ahead comes the other way."""
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
                and abs(left_of(there, other.x, other.y)) < self.parameters.closes_up
                and motions.cosine(k, t, there.c, there.s) < 0.0
            ):
                end: Position = motions.place(k, motions.rests(k))
                if self.narrow.has(other.x, other.y) or self.narrow.has(end.x, end.y):
                    return True
        return False

    def _propose_files(self) -> cython.int:
        """Add walks to a place beside the leader's file where the person can walk faster.

        A crowd thus uses the whole width, except where others need it for the other direction.
        """
        if self.inside:
            return 0
        parameters: ChoiceParameters = self.parameters
        here: CoursePlace = self.walks.course.come_to(0.0)
        i: cython.Py_ssize_t
        for i in range(2 * len(parameters.files)):
            usual: float = self.walker.usual if i % 2 == 0 else -self.walker.usual
            side: float = at(parameters.files)[i // 2] * usual
            x: float = here.x - side * here.s
            y: float = here.y + side * here.c
            beside: CoursePlace = CoursePlace(x, y, here.c, here.s, 0)
            speed: float = self.following.speed_at(self.near, self.state.begin, beside)
            along: float = parameters.beside_after * speed * self.walker.foresight
            if speed >= self.ahead.speed + parameters.faster and along < self.walks.course.length:
                self._add_aside(side, along, speed, along)
        return 0

    def _propose_past(self, other: Meeting, opposed: bool) -> cython.int:
        """Add the walks that pass the person of a conflict, on either side, closely and wider.

        With `opposed`, walks that end beside the other are added too, because the full reach is
        seldom free behind the first of many people.
        """
        level: FrenetPlace = self._level_with(other)
        # At the comfort distance, then at the minimum distance, to either side.
        needed: float = self.walker.radius + at(self.motions.radii)[other.person] + self.motions.gap
        wide: float = needed + self.walker.comfort
        sides: Numbers = room(4 + len(self.parameters.widths))
        side: Doubles = at(sides)
        side[0] = level.left - wide
        side[1] = level.left + wide
        side[2] = level.left - needed - _HAIR
        side[3] = level.left + needed + _HAIR
        put(side, 4, at(self.parameters.widths), 0, len(self.parameters.widths))
        top: float = self.walker.top_speed
        self._add_asides(sides, self.reach + _BEYOND, top, level.along)
        if opposed:
            cut(sides, 2)
            self._add_asides(sides, level.along + self.parameters.past, top, level.along)
        return 0

    def _add_asides(
        self, sides: Numbers, length: float, top_speed: float, along: float
    ) -> cython.int:
        """Add the walk on each of several `sides` once."""
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
        """Add the walk that is `side` metres to the left, unless the shift is tiny or too wide.

        The unusual side has an additional loss.
        """
        if _HARDLY < abs(side) <= self.parameters.widest:
            extra: float = self.parameters.other_side if side * self.walker.usual < 0.0 else 0.0
            self.walks.add_aside(extra, length, top_speed, along, side)
        return 0

    def _level_with(self, other: Meeting) -> FrenetPlace:
        """Return the place on the course level with the person of a conflict at that time."""
        before: float = distance_travelled(self.wished.table, self.state.begin, other.t)
        here: CoursePlace = self.walks.course.come_to(before)
        there: Position = self.motions.place(other.person, other.t)
        along: float = before + max(ahead_of(here, there.x, there.y), 0.0)
        return FrenetPlace(along, left_of(here, there.x, there.y))

    def _next_free(self) -> Swath | None:
        """Return the free walk with the least loss, or None."""
        while True:
            walk: Swath | None = self.walks.next_free(self.near, self.motions, self.own)
            if walk is None or self._has_room():
                return walk

    def aside(self, along: float, side: float, other: cython.Py_ssize_t) -> Swath | None:
        """Return the walk `side` metres to the left after `along` metres of the course.

        None if it has a conflict with a wall or with the people near, without the index `other`.
        """
        walks: Candidates = self.walks
        if self.all_near is not self.near or self.excluded != other:
            self.all_near = self.near
            self.excluded = other
            self.without = self.near.copy()
            if other in self.without:
                self.without.remove(other)
        walks.clear()
        walks.add_aside(0.0, self.reach + _BEYOND, self.walker.top_speed, along, side)
        walk: Swath | None = walks.next_free(self.without, self.motions, self.own)
        return walk if walk is not None and self._has_room() else None

    def _has_room(self) -> bool:
        """Return whether the last walk that was checked is free of walls.

        The check of people comes first because it is faster.
        """
        walks: Candidates = self.walks
        if walks.looked_at.side == 0.0:
            return True
        corner: Positions = positions_of(walks.corners)
        k: cython.Py_ssize_t
        # Only the first three segments leave the course, which is free.
        for k in range(min(walks.corner_count, 4) - 1):
            if not self.legs.free(corner[k].x, corner[k].y, corner[k + 1].x, corner[k + 1].y):
                return False
        return True
