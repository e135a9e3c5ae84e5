"""Walks that somebody may take among others: along a course, or beside it, from one state on.

They are given in any order by what they lose, and drawn up from the least on until one is free, so
that most of them never are. For the tables see `discs`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .discs import ROW
from .numbers import Place, flat
from .throng import Throng

if not cython.compiled:
    from math import inf, sqrt

    from .discs import distance, met, stand
    from .numbers import Doubles, Numbers, at, cut, grow, part, put, room
    from .pacing import bend_speed, draw

    INFINITY = inf
else:
    from cython.cimports.libc.math import INFINITY, sqrt
    from cython.cimports.navigation.kernels.discs import distance, met, stand
    from cython.cimports.navigation.kernels.numbers import (
        Doubles,
        Numbers,
        at,
        cut,
        grow,
        part,
        put,
        room,
    )
    from cython.cimports.navigation.kernels.pacing import bend_speed, draw

_ROW: cython.Py_ssize_t = 5  # length, top speed, delay, and for an aside: along, side
_LEG: cython.Py_ssize_t = 3  # length, direction
_R: cython.Py_ssize_t = ROW
_BEFORE: float = 0.35  # metres before and after the place at which an aside is beside its course
_RAMP: float = 1.2  # metres that it takes to come back, for each metre of a shift
_HAIR: float = 1e-6
_CLEAR: float = 2e-3  # metres; who is so much farther off is not met where one sets out
_MORE: cython.Py_ssize_t = 32  # walks that there is room for at first, and more each time
_HARDLY: float = 0.02  # metres; a shift of no more is none
_STANDS: float = 1e-6  # m/s; slower than this is standing

Slowed = Callable[["Numbers", float, float], "tuple[Numbers, Numbers] | None"]


class Candidates:
    """Walks of one person from `begin` (seconds) on, who has been on the `lead` until then.

    They set out at `speed` (m/s), and come on the straight leg `leg_x`, `leg_y` (metres). `course`
    are its corners (metres); the `lead` is a table without its final standing, `lead_box` its
    bounds, and both are empty for who sets out `now`. Where limits of speed hold, walks are those
    that `slowed(corners, top_speed, delay)` makes: a table and its bounds, or None; the corners are
    x and y of each in turn.
    """

    def __init__(
        self,
        course: list[Place],
        begin: float,
        now: float,
        speed: float,
        leg_x: float,
        leg_y: float,
        max_speed: float,
        acceleration: float,
        lead: Numbers,
        lead_box: Numbers,
        slowed: Slowed | None = None,
    ) -> None:
        self.course = flat(course)
        self.begin = begin
        self.now = now
        self.speed = speed
        self.leg_x = leg_x
        self.leg_y = leg_y
        self.max_speed = max_speed
        self.acceleration = acceleration
        self.lead = lead
        self.lead_box = lead_box
        self.slowed = slowed
        self.legs = room(_LEG * len(course))
        self.whole = self._measure()
        self.losses = room(0)
        self.rows = room(0)
        self.count = 0
        self.tops = room(1)
        none: Numbers = room(0)
        self.stood = none
        self.ends = none
        nobody: list[cython.Py_ssize_t] = []
        self.near = nobody
        self.row = -1
        self.blocker = -1
        self.length = self.top_speed = self.delay = self.side = 0.0
        self.corners = none
        self.many = 0
        # What is looked at is drawn up in the same room again and again.
        self.aside = room(len(self.course) + 8)
        self.path = room(len(self.course) + 8)
        self.sketch = room(0)
        self.bounds = room(4)
        self.table = none
        self.box = none
        self.x = self.y = self.off_x = self.off_y = self.by_x = self.by_y = 0.0
        self.c = 1.0
        self.s = 0.0
        self.leg = 0

    def clear(self) -> None:
        """Forget all that were added."""
        self.count = 0
        self.row = -1
        self.blocker = -1

    def add(self, loss: float, length: float, top_speed: float, delay: float) -> None:
        """Add the walk along the first `length` metres of the course, which loses `loss` metres.

        At up to `top_speed` (m/s), `delay` seconds later.
        """
        self._add(loss, length, top_speed, delay, 0.0, 0.0)

    def add_asides(
        self,
        sides: Numbers,
        widest: float,
        usual: float,
        extra: float,
        length: float,
        top_speed: float,
        along: float,
    ) -> None:
        """Add the asides of several `sides`, each once, but for the widest and for hardly any.

        Those on the other side than the `usual` (1 or -1) lose `extra` metres besides.
        """
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        shift: Doubles = at(sides)
        for i in range(len(sides)):
            side: float = shift[i]
            if abs(side) <= _HARDLY or abs(side) > widest:
                continue
            again: cython.bint = False
            for j in range(i):
                again = again or shift[j] == side
            if not again:
                loss: float = self._longer(along, side)
                if side * usual < 0.0:
                    loss += extra
                self._add(loss, length, top_speed, 0.0, along, side)

    def add_aside(self, along: float, side: float, length: float, top_speed: float) -> None:
        """Add the walk that is `side` metres to the left `along` metres on."""
        self._add(0.0, length, top_speed, 0.0, along, side)

    def next_course(self) -> bool:
        """Come to the walk that loses least of those not looked at; False if there is none.

        `corners`, `length`, `top_speed`, `delay` and `side` are its own then. Those that one can't
        turn to are left out.
        """
        rows: Doubles = at(self.rows)
        losses: Doubles = at(self.losses)
        while True:
            best: float = INFINITY
            row: cython.Py_ssize_t = -1
            k: cython.Py_ssize_t
            # The next in order of loss, and of being added: a heap would cost more than it saves,
            # as few are ever looked at.
            for k in range(self.count):
                if losses[k] < best:
                    best = losses[k]
                    row = k
            if row < 0:
                return False
            losses[row] = INFINITY
            self.row = row
            o: cython.Py_ssize_t = row * _ROW
            self.length = rows[o]
            self.top_speed = rows[o + 1]
            self.delay = rows[o + 2]
            self.side = rows[o + 4]
            if self.side == 0.0:
                self._go_along()
                return True
            self._go_aside(rows[o + 3], self.side)
            if self._can_turn():
                return True

    def draw_along(self, length: float, top_speed: float, delay: float) -> bool:
        """Draw up the walk along the first `length` metres of the course; False if it can't be.

        At up to `top_speed` (m/s), and `delay` seconds later, who stands.
        """
        self.length = length
        self.top_speed = top_speed
        self.delay = delay
        self.side = 0.0
        self._go_along()
        return self._take(self._draw(self._cut()))

    def at(self, length: float) -> tuple[float, float, float, float]:
        """Return the place after `length` metres of the course, and its direction just before."""
        self.come_to(length)
        return self.x, self.y, self.c, self.s

    def come_to(self, length: float) -> cython.int:
        """Set x, y, c and s to what `at` returns."""
        # At a corner there are two directions: a hair before it, it is that in which one comes.
        self._seek(max(length - _HAIR, 0.0))
        c: float = self.c
        s: float = self.s
        self._seek(length)
        self.c = c
        self.s = s
        return 0

    def next_free(self, near: list[cython.Py_ssize_t], throng: Throng, own: float) -> bool:
        """Come to the next walk that meets nobody of a throng who is `near`, as `first_met` has it.

        `own` is how far they keep from the bodies of others (metres). False if there is none. Its
        `corners`, `table` and `box` are there then.
        """
        while self.next_course():
            if self._is_free(near, throng, own):
                return True
        return False

    def _is_free(self, near: list[cython.Py_ssize_t], throng: Throng, own: float) -> bool:
        """Draw up the walk that is looked at; return whether it meets nobody `near`."""
        count: cython.Py_ssize_t = self._cut()
        self._look_at(near, throng, own)
        # No table is drawn up for what can't be free, whenever they walk there: through somebody
        # who stands, or to where somebody will stand in the end.
        if _runs_into(self.path, count, self.stood) or _ends_at(self.path, count, self.ends):
            return False
        end: cython.Py_ssize_t = self._draw(count)
        if end == 0:
            return False
        now: float = self.now
        table: Numbers = self.sketch
        box: Numbers = self.bounds
        tables: list[Numbers] = throng.tables
        boxes: Numbers = throng.boxes
        radii: Numbers = throng.radii
        # Whoever was in the way of the last one is likely to be in the way of this one.
        k: cython.Py_ssize_t = self.blocker
        if k >= 0 and met(table, box, tables, boxes, radii, own, now, INFINITY, k) < INFINITY:
            return False
        i: cython.Py_ssize_t
        for i in range(len(near)):
            k = near[i]
            if met(table, box, tables, boxes, radii, own, now, INFINITY, k) < INFINITY:
                self.blocker = k
                return False
        return self._take(end)

    def _look_at(self, near: list[cython.Py_ssize_t], throng: Throng, own: float) -> cython.int:
        """Set `stood` to who of those `near` stands for good, and `ends` to where others will.

        Of each x, y, and how near to come is to meet them. Those alone who are farther off than
        that where one sets out: then every walk through there, or to there, meets them, whenever it
        is.
        """
        if near is self.near:  # looked at already
            return 0
        self.near = near
        self.blocker = -1
        if len(self.lead) > 0:
            self.stood = self.ends = room(0)
            return 0
        here: Numbers = room(_R)
        course: Doubles = at(self.course)
        stand(at(here), 0, self.now, INFINITY, course[0], course[1])
        self.stood = room(3 * len(near))
        self.ends = room(3 * len(near))
        standing: cython.Py_ssize_t = 0
        ending: cython.Py_ssize_t = 0
        radii: Doubles = at(throng.radii)
        i: cython.Py_ssize_t
        for i in range(len(near)):
            other: Numbers = throng.tables[near[i]]
            last: Doubles = at(other)
            o: cython.Py_ssize_t = len(other) - _R
            least: float = own + radii[near[i]]
            if last[o] <= self.now:
                away: float = _apart(course[0], course[1], last[o + 2], last[o + 6])
                if away > least + _CLEAR:
                    standing = _note(at(self.stood), standing, last[o + 2], last[o + 6], least)
            elif distance(here, other, self.now) > least + _CLEAR:
                ending = _note(at(self.ends), ending, last[o + 2], last[o + 6], least)
        cut(self.stood, standing)
        cut(self.ends, ending)
        return 0

    def _cut(self) -> cython.Py_ssize_t:
        """Set `path` to the first `length` metres of the corners; return how many numbers it is."""
        corner: Doubles = at(self.corners)
        place: Doubles = at(self.path)
        length: float = self.length
        place[0] = corner[0]
        place[1] = corner[1]
        k: cython.Py_ssize_t
        for k in range(2, self.many, 2):
            x: float = corner[k - 2]
            y: float = corner[k - 1]
            dx: float = corner[k] - x
            dy: float = corner[k + 1] - y
            leg: float = sqrt(dx * dx + dy * dy)
            if leg >= length:
                if length <= 1e-9:
                    return k
                share: float = length / leg
                place[k] = x + share * dx
                place[k + 1] = y + share * dy
                return k + 2
            place[k] = corner[k]
            place[k + 1] = corner[k + 1]
            length -= leg
        return self.many

    def _draw(self, count: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Sketch the walk along the first so many numbers of `path`; return its length, or 0."""
        # Only who stands can set out later.
        if self.delay != 0.0 and self.speed > _STANDS:
            return 0
        if self.slowed is not None:
            slower = self.slowed(part(self.path, 0, count), self.top_speed, self.delay)
            if slower is None:
                return 0
            self.sketch, self.bounds = slower
            return len(self.sketch)
        at(self.tops)[0] = self.top_speed
        bound(self.path, count, self.lead_box, self.bounds)
        return draw(
            self.path,
            count,
            self.tops,
            self.begin if len(self.lead) > 0 else self.now,
            self.begin + self.delay,
            self.speed,
            self.max_speed,
            self.acceleration,
            self.lead,
            self.sketch,
        )

    def _take(self, end: cython.Py_ssize_t) -> bool:
        """Set `table` and `box` to those of a sketch of this length; False if there is none."""
        if end == 0:
            return False
        self.table = part(self.sketch, 0, end)
        self.box = part(self.bounds, 0, 4)
        return True

    def _add(
        self,
        loss: float,
        length: float,
        top_speed: float,
        delay: float,
        along: float,
        side: float,
    ) -> cython.int:
        k: cython.Py_ssize_t = self.count
        if k == len(self.losses):
            grow(self.losses, k + _MORE)
            grow(self.rows, _ROW * (k + _MORE))
        at(self.losses)[k] = loss
        row: Doubles = at(self.rows)
        o: cython.Py_ssize_t = _ROW * k
        row[o] = length
        row[o + 1] = top_speed
        row[o + 2] = delay
        row[o + 3] = along
        row[o + 4] = side
        self.count = k + 1
        return 0

    def _can_turn(self) -> bool:
        """Return whether they may set out on `corners` without slowing down first."""
        if self.speed < _STANDS:
            return True
        corners: Doubles = at(self.corners)
        dx: float = corners[2] - corners[0]
        dy: float = corners[3] - corners[1]
        length: float = sqrt(dx * dx + dy * dy)
        before: float = sqrt(self.leg_x * self.leg_x + self.leg_y * self.leg_y)
        if length == 0.0 or before == 0.0:
            return True
        cosine: float = (dx * self.leg_x + dy * self.leg_y) / (length * before)
        shorter: float = length if length < before else before
        return self.speed <= bend_speed(cosine, shorter, self.acceleration)

    def _go_along(self) -> cython.int:
        """Set `corners` to the course."""
        self.corners = self.course
        self.many = len(self.course)
        return 0

    def _go_aside(self, along: float, side: float) -> cython.int:
        """Set `corners` to a course that is `side` metres to the left after `along` metres."""
        self._shift(along, side)
        # Where the course goes on after it.
        on: cython.Py_ssize_t = len(self.course)
        if self.leg >= 0:
            on = 2 * self.leg + 2
        back: cython.Py_ssize_t = 8 if self.leg >= 0 else 6
        self.corners = self.aside
        self.many = back + len(self.course) - on
        corner: Doubles = at(self.corners)
        course: Doubles = at(self.course)
        corner[0] = course[0]
        corner[1] = course[1]
        corner[2] = self.off_x
        corner[3] = self.off_y
        corner[4] = self.by_x
        corner[5] = self.by_y
        if self.leg >= 0:
            corner[6] = self.x
            corner[7] = self.y
        put(corner, back, course, on, len(self.course) - on)
        return 0

    def _longer(self, along: float, side: float) -> float:
        """Return how much longer such a course is (metres), without setting it up."""
        course: Doubles = at(self.course)
        self._shift(along, side)
        total: float = _apart(course[0], course[1], self.off_x, self.off_y)
        total += _apart(self.off_x, self.off_y, self.by_x, self.by_y)
        if self.leg >= 0:
            total += _apart(self.by_x, self.by_y, self.x, self.y)
            # The rest of the leg that it comes back to, and all after that.
            k: cython.Py_ssize_t = 2 * self.leg + 2
            if k < len(self.course):
                total += _apart(self.x, self.y, course[k], course[k + 1])
            leg: Doubles = at(self.legs)
            for k in range(self.leg + 1, len(self.course) // 2 - 1):
                total += leg[k * _LEG]
        return total - self.whole

    def _shift(self, along: float, side: float) -> cython.int:
        """Find where a course bends that is `side` metres to the left after `along` metres.

        It is off the course up to `off_x`, `off_y`, beside it up to `by_x`, `by_y`, and back on its
        `leg` at `x`, `y`; where the goal itself is beside the other, it goes there and `leg` is -1.
        """
        course: Doubles = at(self.course)
        count: cython.Py_ssize_t = len(self.course)
        self.come_to(along)
        c: float = self.c
        s: float = self.s
        # Off the course at a right angle, (-s, c) being to the left.
        x: float = self.x - side * s
        y: float = self.y + side * c
        early: float = min(_BEFORE, along)
        self.off_x = x - early * c
        self.off_y = y - early * s
        if along + _BEFORE >= self.whole:
            self.by_x = course[count - 2]
            self.by_y = course[count - 1]
            self.leg = -1
            return 0
        self.by_x = x + _BEFORE * c
        self.by_y = y + _BEFORE * s
        # Back on the course farther on the wider the shift is, so that the turns are no sharper.
        self._seek(min(along + _BEFORE + _RAMP * abs(side), self.whole))
        return 0

    def _seek(self, length: float) -> cython.int:
        """Come to the place after `length` metres of the course: `x`, `y`, and the leg it is on.

        Also the direction of that leg. At its end, the leg is one that is not there.
        """
        course: Doubles = at(self.course)
        leg: Doubles = at(self.legs)
        last: cython.Py_ssize_t = len(self.course) // 2 - 1
        k: cython.Py_ssize_t = 0
        while k < last and leg[k * _LEG] <= length:
            length -= leg[k * _LEG]
            k += 1
        self.leg = k
        self.x = course[2 * k]
        self.y = course[2 * k + 1]
        if k < last:
            share: float = max(length, 0.0) / leg[k * _LEG]
            self.x += share * (course[2 * k + 2] - self.x)
            self.y += share * (course[2 * k + 3] - self.y)
        elif k > 0:
            k -= 1
        self.c = leg[k * _LEG + 1]
        self.s = leg[k * _LEG + 2]
        return 0

    def _measure(self) -> float:
        """Note the legs of the course; return its length, metres."""
        course: Doubles = at(self.course)
        count: cython.Py_ssize_t = len(self.course) // 2
        leg: Doubles = at(self.legs)
        total: float = 0.0
        c: float = 1.0
        s: float = 0.0
        k: cython.Py_ssize_t
        # A course of one corner leads nowhere, but has a direction.
        leg[1] = c
        leg[2] = s
        for k in range(count - 1):
            dx: float = course[2 * k + 2] - course[2 * k]
            dy: float = course[2 * k + 3] - course[2 * k + 1]
            length: float = sqrt(dx * dx + dy * dy)
            # Legs that are none have the direction of those before.
            if length > 1e-9:
                c = dx / length
                s = dy / length
            leg[k * _LEG] = length
            leg[k * _LEG + 1] = c
            leg[k * _LEG + 2] = s
            total += length
        return total


def _runs_into(corners: Numbers, count: cython.Py_ssize_t, stood: Numbers) -> bool:
    """Return whether a polyline comes nearer to any place than is said with it: x, y, metres."""
    corner: Doubles = at(corners)
    disc: Doubles = at(stood)
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    for k in range(0, count - 2, 2):
        x: float = corner[k]
        y: float = corner[k + 1]
        dx: float = corner[k + 2] - x
        dy: float = corner[k + 3] - y
        square: float = dx * dx + dy * dy
        for i in range(0, len(stood), 3):
            px: float = disc[i] - x
            py: float = disc[i + 1] - y
            least: float = disc[i + 2]
            along: float = px * dx + py * dy  # the leg, times its length
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


def _ends_at(corners: Numbers, count: cython.Py_ssize_t, ends: Numbers) -> bool:
    """Return whether a polyline ends nearer to any place than is said with it: x, y, metres."""
    corner: Doubles = at(corners)
    disc: Doubles = at(ends)
    x: float = corner[count - 2]
    y: float = corner[count - 1]
    i: cython.Py_ssize_t
    for i in range(0, len(ends), 3):
        dx: float = disc[i] - x
        dy: float = disc[i + 1] - y
        least: float = disc[i + 2]
        if dx * dx + dy * dy < least * least:
            return True
    return False


def _note(
    disc: Doubles, o: cython.Py_ssize_t, x: float, y: float, least: float
) -> cython.Py_ssize_t:
    """Set a place at `o`, and how near to come is too near; return where the next one is."""
    disc[o] = x
    disc[o + 1] = y
    disc[o + 2] = least - _HAIR
    return o + 3


def _apart(ax: float, ay: float, bx: float, by: float) -> float:
    """Return the distance of two places, metres."""
    dx: float = bx - ax
    dy: float = by - ay
    return sqrt(dx * dx + dy * dy)


def bound(corners: Numbers, count: cython.Py_ssize_t, more: Numbers, box: Numbers) -> cython.int:
    """Set `box` to the bounds of so many numbers of `corners`, and of bounds besides.

    Least x and y, greatest x and y.
    """
    low: Doubles = at(box)
    low[0] = low[1] = INFINITY
    low[2] = low[3] = -INFINITY
    _widen(low, at(corners), count)
    _widen(low, at(more), len(more))
    return 0


def _widen(box: Doubles, corner: Doubles, count: cython.Py_ssize_t) -> cython.int:
    """Widen bounds to those of corners."""
    k: cython.Py_ssize_t
    for k in range(0, count, 2):
        box[0] = min(box[0], corner[k])
        box[1] = min(box[1], corner[k + 1])
        box[2] = max(box[2], corner[k])
        box[3] = max(box[3], corner[k + 1])
    return 0
