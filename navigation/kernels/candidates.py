"""Candidate walks of a person among others: along a course, or beside it, from one state on.

Candidates are added in any order with their loss. They are constructed in the order of their loss
until one is free, so most of them never are. This is lazy evaluation as in lazy motion planning (R.
Bohlin and L. E. Kavraki, "Path planning using lazy PRM", ICRA 2000).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .discs import DiscMotions, Swath
from .numbers import Place, flat

if not cython.compiled:
    from .cubics import *
    from .discs import covers, distance
    from .walks import bend_speed, draw_walk

_BEFORE: float = 0.35  # metres before and after a place along which a shifted walk is parallel
_RAMP: float = 1.2  # metres along the course for the return from each metre of a shift
_HAIR: float = 1e-6
_CLEAR: float = 2e-3  # metres; people farther away than this are not in conflict at the start
_MORE: cython.Py_ssize_t = 32  # capacity for walks at first, and each time it grows
_STANDS: float = 1e-6  # m/s; slower people count as standing
_NO_LENGTH: float = 1e-9  # metres

Slowed = Callable[["Numbers", float, float], "Swath | None"]


class Course:
    """Polyline through `corners` (metres), with places along it and paths beside it."""

    def __init__(self, corners: list[Place]) -> None:
        self.corners = flat(corners)
        self.count = len(corners)
        self.legs = course_leg_room(self.count)
        self.length = 0.0
        corner: Positions = positions_of(self.corners)
        leg: CourseLegs = course_legs(self.legs)
        # A course of one corner has no length, but needs a direction.
        last: CourseLeg = CourseLeg(0.0, 1.0, 0.0)
        leg[0] = last
        k: cython.Py_ssize_t
        for k in range(self.count - 1):
            dx: float = corner[k + 1].x - corner[k].x
            dy: float = corner[k + 1].y - corner[k].y
            length: float = norm(dx, dy)
            # Segments without a length have the direction of the previous one.
            if length > _NO_LENGTH:
                last = CourseLeg(length, dx / length, dy / length)
            last = CourseLeg(length, last.c, last.s)
            leg[k] = last
            self.length += length

    def after(self, length: float) -> tuple[float, float, float, float]:
        """Return the place after `length` metres of the course, and its direction just before."""
        here: CoursePlace = self.come_to(length)
        return here.x, here.y, here.c, here.s

    def come_to(self, length: float) -> CoursePlace:
        """Return the place after `length` metres of the course, and its direction just before."""
        # A corner has two directions. The one just before it is that of the arrival.
        before: CoursePlace = self.seek(max(length - _HAIR, 0.0))
        here: CoursePlace = self.seek(length)
        return CoursePlace(here.x, here.y, before.c, before.s, here.leg)

    def seek(self, length: float) -> CoursePlace:
        """Return the place after `length` metres of the course, with the segment and its direction.

        At the end of the course, the index of the segment is one past the last.
        """
        corner: Positions = positions_of(self.corners)
        leg: CourseLegs = course_legs(self.legs)
        last: cython.Py_ssize_t = self.count - 1
        k: cython.Py_ssize_t = 0
        while k < last and leg[k].length <= length:
            length -= leg[k].length
            k += 1
        x: float = corner[k].x
        y: float = corner[k].y
        on: CourseLeg = leg[k - 1 if k == last and k > 0 else k]
        if k < last:
            share: float = max(length, 0.0) / on.length
            x += share * (corner[k + 1].x - x)
            y += share * (corner[k + 1].y - y)
        return CoursePlace(x, y, on.c, on.s, k)

    def beside(self, along: float, side: float) -> Bypass:
        """Return the corners of a path that is `side` metres to the left after `along` metres."""
        here: CoursePlace = self.come_to(along)
        # Perpendicular to the course, with (-s, c) to the left.
        x: float = here.x - side * here.s
        y: float = here.y + side * here.c
        early: float = min(_BEFORE, along)
        off_x: float = x - early * here.c
        off_y: float = y - early * here.s
        if along + _BEFORE >= self.length:
            goal: Position = positions_of(self.corners)[self.count - 1]
            return Bypass(off_x, off_y, goal.x, goal.y, goal.x, goal.y, -1)
        # A wider shift returns to the course later, so that the turns are no sharper.
        back: CoursePlace = self.seek(min(along + _BEFORE + _RAMP * abs(side), self.length))
        by_x: float = x + _BEFORE * here.c
        by_y: float = y + _BEFORE * here.s
        return Bypass(off_x, off_y, by_x, by_y, back.x, back.y, back.leg)

    def longer(self, along: float, side: float) -> float:
        """Return the additional length (m) of such a path."""
        corner: Positions = positions_of(self.corners)
        way: Bypass = self.beside(along, side)
        total: float = norm(way.off_x - corner[0].x, way.off_y - corner[0].y)
        total += norm(way.by_x - way.off_x, way.by_y - way.off_y)
        if way.leg >= 0:
            total += norm(way.x - way.by_x, way.y - way.by_y)
            # The rest of the segment to which it returns, and all later ones.
            k: cython.Py_ssize_t = way.leg + 1
            if k < self.count:
                total += norm(corner[k].x - way.x, corner[k].y - way.y)
            for k in range(way.leg + 1, self.count - 1):
                total += course_legs(self.legs)[k].length
        return total - self.length

    def corners_beside(self, along: float, side: float, corners: Numbers) -> cython.Py_ssize_t:
        """Set `corners` to those of such a path, and return their number."""
        course: Positions = positions_of(self.corners)
        corner: Positions = positions_of(corners)
        way: Bypass = self.beside(along, side)
        corner[0] = course[0]
        corner[1] = Position(way.off_x, way.off_y)
        corner[2] = Position(way.by_x, way.by_y)
        if way.leg < 0:
            return 3
        corner[3] = Position(way.x, way.y)
        count: cython.Py_ssize_t = 4
        k: cython.Py_ssize_t
        for k in range(way.leg + 1, self.count):
            corner[count] = course[k]
            count += 1
        return count


class Departure:
    """State from which walks start at `begin` (s) with `speed` (m/s).

    The person arrives on the straight `leg` (x, y in metres), and is limited to `max_speed` (m/s)
    and `acceleration` (m/s²). Walks start `now`, or after a `lead` that precedes them.
    """

    def __init__(
        self,
        begin: float,
        now: float,
        speed: float,
        leg: tuple[float, float],
        max_speed: float,
        acceleration: float,
        lead: Swath | None = None,
    ) -> None:
        self.begin = begin
        self.now = now
        self.speed = speed
        self.leg_x, self.leg_y = leg
        self.max_speed = max_speed
        self.acceleration = acceleration
        self.lead = room(0) if lead is None else lead.walk
        self.box = room(0) if lead is None else lead.box
        self.follows = len(self.lead) > 0

    def can_turn(self, dx: float, dy: float) -> bool:
        """Return whether a walk can start in the direction d without slowing down first."""
        if self.speed < _STANDS:
            return True
        length: float = norm(dx, dy)
        before: float = norm(self.leg_x, self.leg_y)
        if length == 0.0 or before == 0.0:
            return True
        cosine: float = (dx * self.leg_x + dy * self.leg_y) / (length * before)
        shorter: float = length if length < before else before
        return self.speed <= bend_speed(cosine, shorter, self.acceleration)


class Candidates:
    """Walks of one person along a `course`, or beside it, from a state on.

    `slowed(corners, top_speed, delay)`, if there is one, constructs the walks within speed limits,
    from x and y of each corner. `taken` is the walk that was constructed last.
    """

    def __init__(self, course: Course, state: Departure, slowed: Slowed | None = None) -> None:
        self.course = course
        self.state = state
        self.slowed = slowed
        self.walks = room(0)
        self.count = 0
        self.row = self.blocker = -1
        self.looked_at = CandidateWalk(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        none: Numbers = room(0)
        self.stood = none
        self.ends = none
        nobody: list[cython.Py_ssize_t] = []
        self.near = nobody
        # The buffers of candidates are reused.
        self.tops = room(1)
        self.corners = position_room(course.count + 4)
        self.corner_count = 0
        self.path = position_room(course.count + 4)
        self.sketch = Swath(room(0), room(4))
        self.taken = self.sketch

    def clear(self) -> None:
        """Remove all walks."""
        self.count = 0
        self.row = -1
        self.blocker = -1

    def add(self, loss: float, length: float, top_speed: float, delay: float) -> None:
        """Add the walk along the first `length` metres of the course with a loss of `loss` metres.

        Its top speed is `top_speed` (m/s), and it starts `delay` seconds later.
        """
        self._add(CandidateWalk(loss, length, top_speed, delay, 0.0, 0.0))

    def add_aside(
        self, loss: float, length: float, top_speed: float, along: float, side: float
    ) -> None:
        """Add the walk that is `side` metres to the left after `along` metres.

        Its loss is its additional length plus `loss` metres.
        """
        loss += self.course.longer(along, side)
        self._add(CandidateWalk(loss, length, top_speed, 0.0, along, side))

    def _add(self, walk: CandidateWalk) -> cython.int:
        if self.count == candidate_count(self.walks):
            candidates_grow(self.walks, self.count + _MORE)
        candidates_of(self.walks)[self.count] = walk
        self.count += 1
        return 0

    def draw_along(self, length: float, top_speed: float, delay: float) -> Swath | None:
        """Return the walk along the first `length` metres of the course, or None if impossible.

        Its top speed is `top_speed` (m/s). A standing person starts `delay` seconds later.
        """
        self.looked_at = CandidateWalk(0.0, length, top_speed, delay, 0.0, 0.0)
        self._come_to()
        pieces: cython.Py_ssize_t = self._draw(self._cut())
        return None if pieces == 0 else self._take(pieces)

    def next_free(
        self, near: list[cython.Py_ssize_t], others: DiscMotions, own: float
    ) -> Swath | None:
        """Return the next walk without a conflict with the people `near`, or None.

        `own` is the distance (m) to keep from the bodies of `others`.
        """
        while self._next():
            pieces: cython.Py_ssize_t = self._free(near, others, own)
            if pieces > 0:
                return self._take(pieces)
        return None

    def _next(self) -> bool:
        """Select the walk with the least loss among those not checked, or return False.

        Walks that begin with too sharp a turn are skipped.
        """
        walk: CandidateWalks = candidates_of(self.walks)
        corner: Positions = positions_of(self.corners)
        while True:
            best: float = INFINITY
            k: cython.Py_ssize_t
            self.row = -1
            # By loss, then in the order of adding. A heap would cost more than it saves, because
            # few walks are checked.
            for k in range(self.count):
                if walk[k].loss < best:
                    best = walk[k].loss
                    self.row = k
            if self.row < 0:
                return False
            w: CandidateWalk = walk[self.row]
            walk[self.row] = CandidateWalk(
                INFINITY, w.length, w.top_speed, w.delay, w.along, w.side
            )
            self.looked_at = w
            self._come_to()
            if w.side == 0.0 or self.state.can_turn(
                corner[1].x - corner[0].x, corner[1].y - corner[0].y
            ):
                return True

    def _come_to(self) -> cython.int:
        """Set `corners` to those of the selected walk."""
        w: CandidateWalk = self.looked_at
        if w.side == 0.0:
            self.corner_count = self.course.count
            positions_put(self.corners, self.course.corners)
        else:
            self.corner_count = self.course.corners_beside(w.along, w.side, self.corners)
        return 0

    def _free(
        self, near: list[cython.Py_ssize_t], others: DiscMotions, own: float
    ) -> cython.Py_ssize_t:
        """Construct the selected walk. Return the number of its pieces, or 0 after a conflict."""
        count: cython.Py_ssize_t = self._cut()
        self._look_at(near, others, own)
        # A walk through a person who stands, or to the final place of another, has a conflict at
        # any speed, so it needs no table.
        last: Position = positions_of(self.path)[count - 1]
        if _runs_into(self.path, count, self.stood) or covers(self.ends, last.x, last.y):
            return 0
        pieces: cython.Py_ssize_t = self._draw(count)
        if pieces == 0:
            return 0
        now: float = self.state.now
        # Try the previous obstacle first, because successive candidates often meet the same person.
        k: cython.Py_ssize_t = self.blocker
        if k >= 0 and others.conflicts(k, self.sketch, own, now):
            return 0
        i: cython.Py_ssize_t
        for i in range(len(near)):
            k = near[i]
            if others.conflicts(k, self.sketch, own, now):
                self.blocker = k
                return 0
        return pieces

    def _look_at(
        self, near: list[cython.Py_ssize_t], others: DiscMotions, own: float
    ) -> cython.int:
        """Set `stood` to circles around the standing people, and `ends` around final places.

        Only people who are farther away than the minimum distance at the start are included. A walk
        through their circles always has a conflict with them.
        """
        if near is self.near:
            return 0
        self.near = near
        self.blocker = -1
        self.stood = circle_room(0 if self.state.follows else len(near))
        self.ends = circle_room(circle_count(self.stood))
        if self.state.follows:
            return 0
        standing: cython.Py_ssize_t = 0
        ending: cython.Py_ssize_t = 0
        start: Position = positions_of(self.course.corners)[0]
        here: Numbers = planar_room(1)
        planar(here)[0] = rest_piece(self.state.now, start.x, start.y)
        i: cython.Py_ssize_t
        for i in range(len(near)):
            other: Numbers = others.tables[near[i]]
            end: PlanarPiece = planar(other)[planar_count(other) - 1]
            least: float = own + at(others.radii)[near[i]]
            spot: Circle = Circle(end.x.p, end.y.p, least - _HAIR)
            if end.begin <= self.state.now:
                if norm(spot.x - start.x, spot.y - start.y) > least + _CLEAR:
                    circles_of(self.stood)[standing] = spot
                    standing += 1
            elif (
                at(others.counted)[near[i]] == INFINITY
                and distance(here, other, self.state.now) > least + _CLEAR
            ):
                circles_of(self.ends)[ending] = spot
                ending += 1
        circle_cut(self.stood, standing)
        circle_cut(self.ends, ending)
        return 0

    def _cut(self) -> cython.Py_ssize_t:
        """Set `path` to the first `length` metres of the corners. Return the number of places."""
        corner: Positions = positions_of(self.corners)
        place: Positions = positions_of(self.path)
        length: float = self.looked_at.length
        place[0] = corner[0]
        k: cython.Py_ssize_t
        for k in range(1, self.corner_count):
            before: Position = corner[k - 1]
            dx: float = corner[k].x - before.x
            dy: float = corner[k].y - before.y
            leg: float = norm(dx, dy)
            if leg >= length:
                if length <= _NO_LENGTH:
                    return k
                share: float = length / leg
                place[k] = Position(before.x + share * dx, before.y + share * dy)
                return k + 1
            place[k] = corner[k]
            length -= leg
        return self.corner_count

    def _draw(self, count: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Construct the walk along the first `count` places of `path`. Return its pieces, or 0."""
        state: Departure = self.state
        w: CandidateWalk = self.looked_at
        # Only a standing person can start later.
        if w.delay != 0.0 and state.speed > _STANDS:
            return 0
        if self.slowed is not None:
            slower = self.slowed(first_positions(self.path, count), w.top_speed, w.delay)
            if slower is None:
                return 0
            self.sketch = slower
            return planar_count(self.sketch.table)
        at(self.tops)[0] = w.top_speed
        box: BoundingBox = box_around(self.path, count)
        if box_count(state.box) > 0:
            box = united(box, boxes_of(state.box)[0])
        boxes_of(self.sketch.box)[0] = box
        begin: float = state.begin + w.delay
        pace: SpeedLimits = SpeedLimits(begin, state.speed, state.max_speed, state.acceleration)
        since: float = state.begin if state.follows else state.now
        table: Numbers = self.sketch.table
        return draw_walk(self.path, count, self.tops, pace, since, state.lead, table)

    def _take(self, pieces: cython.Py_ssize_t) -> Swath:
        """Return a copy of the sketch with its first `pieces` pieces."""
        table: Numbers = first_pieces(self.sketch.table, pieces)
        self.taken = Swath(table, row_of_box(boxes_of(self.sketch.box)[0]))
        return self.taken


def _runs_into(path: Numbers, count: cython.Py_ssize_t, stood: Numbers) -> bool:
    """Return whether the polyline of the first `count` places enters any circle."""
    place: Positions = positions_of(path)
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    for k in range(count - 1):
        dx: float = place[k + 1].x - place[k].x
        dy: float = place[k + 1].y - place[k].y
        square: float = dx * dx + dy * dy
        for i in range(circle_count(stood)):
            circle: Circle = circles_of(stood)[i]
            px: float = circle.x - place[k].x
            py: float = circle.y - place[k].y
            least: float = circle.radius
            along: float = px * dx + py * dy  # times the length of the segment
            if 0.0 < along < square:
                across: float = px * dy - py * dx
                if across * across < least * least * square:
                    return True
                continue
            if along > 0.0:
                px -= dx
                py -= dy
            if px * px + py * py < least * least:
                return True
    return False
