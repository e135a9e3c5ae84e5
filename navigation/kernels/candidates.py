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
    from .numbers import Doubles, Numbers, at, cut, room
    from .pacing import bend_speed, walk_table

    INFINITY = inf
else:
    from cython.cimports.libc.math import INFINITY, sqrt
    from cython.cimports.navigation.kernels.discs import distance, met, stand
    from cython.cimports.navigation.kernels.numbers import Doubles, Numbers, at, cut, room
    from cython.cimports.navigation.kernels.pacing import bend_speed, walk_table

_ROW: cython.Py_ssize_t = 6  # loss, length, top speed, delay, and for an aside: along, side
_R: cython.Py_ssize_t = ROW
_BEFORE: float = 0.35  # metres before and after the place at which an aside is beside its course
_RAMP: float = 1.2  # metres that it takes to come back, for each metre of a shift
_HAIR: float = 1e-6
_CLEAR: float = 2e-3  # metres; who is so much farther off is not met where one sets out
_MANY: cython.Py_ssize_t = 16  # walks that there is room for at first
_HARDLY: float = 0.02  # metres; a shift of no more is none
_STANDS: float = 1e-6  # m/s; slower than this is standing

Slowed = Callable[["Numbers", float, float], "tuple[Numbers, Numbers] | None"]


class Candidates:
    """Walks of one person from `begin` (seconds) on, who has been on the `lead` until then.

    They set out at `speed` with the velocity `vx`, `vy` (m/s). `course` are its corners (metres);
    the `lead` is a table without its final standing, `lead_box` its bounds, and both are empty for
    who sets out `now`. Where limits of speed hold, walks are those that `slowed(corners, top_speed,
    delay)` makes: a table and its bounds, or None; the corners are x and y of each in turn.
    """

    def __init__(
        self,
        course: list[Place],
        begin: float,
        now: float,
        speed: float,
        vx: float,
        vy: float,
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
        self.vx = vx
        self.vy = vy
        self.max_speed = max_speed
        self.acceleration = acceleration
        self.lead = lead
        self.lead_box = lead_box
        self.slowed = slowed
        self.whole = _length(self.course)
        none: Numbers = room(0)
        self.rows = room(_ROW * _MANY)
        self.count = 0
        self.tops = room(1)
        self.stood = none
        self.ends = none
        nobody: list[cython.Py_ssize_t] = []
        self.near = nobody
        self.row = -1
        self.loss = -INFINITY
        self.blocker = -1
        self.length = self.top_speed = self.delay = self.side = 0.0
        self.corners = none
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
        self.loss = -INFINITY

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

    def next_course(self) -> bool:
        """Come to the walk that loses least of those not looked at; False if there is none.

        `corners`, `length`, `top_speed`, `delay` and `side` are its own then. Those that one can't
        turn to are left out.
        """
        rows: Doubles = at(self.rows)
        while True:
            best: float = INFINITY
            row: cython.Py_ssize_t = -1
            k: cython.Py_ssize_t
            for k in range(self.count):
                loss: float = rows[k * _ROW]
                # The next in order of loss, and of being added: a heap would cost more than it
                # saves, as few are ever looked at.
                if loss < best and (loss > self.loss or (loss == self.loss and k > self.row)):
                    best = loss
                    row = k
            if row < 0:
                return False
            self.row = row
            self.loss = best
            self.length = rows[row * _ROW + 1]
            self.top_speed = rows[row * _ROW + 2]
            self.delay = rows[row * _ROW + 3]
            self.side = rows[row * _ROW + 5]
            if self.side == 0.0:
                self.corners = self.course
                return True
            self._aside(rows[row * _ROW + 4], self.side)
            if self._can_turn():
                return True

    def draw_along(self, length: float, top_speed: float, delay: float) -> bool:
        """Draw up the walk along the first `length` metres of the course; False if it can't be.

        At up to `top_speed` (m/s), and `delay` seconds later, who stands.
        """
        self.corners = self.course
        self.length = length
        self.top_speed = top_speed
        self.delay = delay
        self.side = 0.0
        return self._draw(_first(self.corners, self.length))

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

    def is_free_aside(
        self,
        length: float,
        top_speed: float,
        along: float,
        side: float,
        near: list[cython.Py_ssize_t],
        throng: Throng,
        own: float,
    ) -> bool:
        """Come to a walk that is `side` metres to the left `along` metres on.

        Of its `length` metres at most, at up to `top_speed` (m/s). Return whether it meets nobody
        `near`, as in `next_free`.
        """
        self._aside(along, side)
        self.length = length
        self.top_speed = top_speed
        self.delay = 0.0
        self.side = side
        return self._can_turn() and self._is_free(near, throng, own)

    def _is_free(self, near: list[cython.Py_ssize_t], throng: Throng, own: float) -> bool:
        """Draw up the walk that is looked at; return whether it meets nobody `near`."""
        corners: Numbers = _first(self.corners, self.length)
        self._look_at(near, throng, own)
        # No table is drawn up for what can't be free, whenever they walk there: through somebody
        # who stands, or to where somebody will stand in the end.
        if (
            _runs_into(corners, self.stood)
            or _ends_at(corners, self.ends)
            or not self._draw(corners)
        ):
            return False
        now: float = self.now
        table: Numbers = self.table
        box: Numbers = self.box
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
        return True

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

    def _draw(self, corners: Numbers) -> bool:
        """Set `table` and `box` to those of the walk along `corners` that is to be looked at."""
        # Only who stands can set out later.
        if self.delay != 0.0 and self.speed > _STANDS:
            return False
        if self.slowed is not None:
            slower = self.slowed(corners, self.top_speed, self.delay)
            if slower is None:
                return False
            self.table, self.box = slower
            return True
        at(self.tops)[0] = self.top_speed
        table: Numbers = walk_table(
            corners,
            self.tops,
            self.begin if len(self.lead) > 0 else self.now,
            self.begin + self.delay,
            self.speed,
            self.max_speed,
            self.acceleration,
            self.lead,
        )
        if len(table) == 0:
            return False
        self.table = table
        self.box = bounds(corners, self.lead_box)
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
        o: cython.Py_ssize_t = _ROW * self.count
        if o == len(self.rows):
            self.rows.extend(self.rows)
        row: Doubles = at(self.rows)
        row[o] = loss
        row[o + 1] = length
        row[o + 2] = top_speed
        row[o + 3] = delay
        row[o + 4] = along
        row[o + 5] = side
        self.count += 1
        return 0

    def _can_turn(self) -> bool:
        """Return whether they may set out on `corners` without slowing down first."""
        if self.speed < _STANDS:
            return True
        corners: Doubles = at(self.corners)
        dx: float = corners[2] - corners[0]
        dy: float = corners[3] - corners[1]
        length: float = sqrt(dx * dx + dy * dy)
        speed: float = sqrt(self.vx * self.vx + self.vy * self.vy)
        if length == 0.0 or speed == 0.0:
            return True
        cosine: float = (dx * self.vx + dy * self.vy) / (length * speed)
        # As `can_go_on` has it, where the leg before is what the present velocity makes in a
        # second.
        shorter: float = length if length < speed else speed
        return self.speed <= bend_speed(cosine, shorter, self.acceleration)

    def _aside(self, along: float, side: float) -> cython.int:
        """Set `corners` to a course that is `side` metres to the left after `along` metres."""
        self._shift(along, side)
        # Where the course goes on after it.
        on: cython.Py_ssize_t = len(self.course)
        if self.leg >= 0:
            on = 2 * self.leg + 2
        back: cython.Py_ssize_t = 8 if self.leg >= 0 else 6
        self.corners = room(back + len(self.course) - on)
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
        k: cython.Py_ssize_t
        for k in range(on, len(self.course)):
            corner[back + k - on] = course[k]
        return 0

    def _longer(self, along: float, side: float) -> float:
        """Return how much longer such a course is (metres), without setting it up."""
        course: Doubles = at(self.course)
        self._shift(along, side)
        total: float = _apart(course[0], course[1], self.off_x, self.off_y)
        total += _apart(self.off_x, self.off_y, self.by_x, self.by_y)
        if self.leg >= 0:
            total += _apart(self.by_x, self.by_y, self.x, self.y)
            x: float = self.x
            y: float = self.y
            k: cython.Py_ssize_t
            for k in range(2 * self.leg + 2, len(self.course), 2):
                total += _apart(x, y, course[k], course[k + 1])
                x = course[k]
                y = course[k + 1]
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
        count: cython.Py_ssize_t = len(self.course)
        self.c = 1.0
        self.s = 0.0
        k: cython.Py_ssize_t
        for k in range(0, count - 2, 2):
            x: float = course[k]
            y: float = course[k + 1]
            dx: float = course[k + 2] - x
            dy: float = course[k + 3] - y
            leg: float = sqrt(dx * dx + dy * dy)
            if leg > 1e-9:
                self.c = dx / leg
                self.s = dy / leg
            if leg > length:
                share: float = max(length, 0.0) / leg
                self.x = x + share * dx
                self.y = y + share * dy
                self.leg = k // 2
                return 0
            length -= leg
        self.x = course[count - 2]
        self.y = course[count - 1]
        self.leg = count // 2 - 1
        return 0


def _runs_into(corners: Numbers, stood: Numbers) -> bool:
    """Return whether a polyline comes nearer to any place than is said with it: x, y, metres."""
    corner: Doubles = at(corners)
    disc: Doubles = at(stood)
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    for k in range(0, len(corners) - 2, 2):
        x: float = corner[k]
        y: float = corner[k + 1]
        dx: float = corner[k + 2] - x
        dy: float = corner[k + 3] - y
        square: float = dx * dx + dy * dy
        for i in range(0, len(stood), 3):
            px: float = disc[i] - x
            py: float = disc[i + 1] - y
            least: float = disc[i + 2]
            share: float = px * dx + py * dy
            if share > 0.0:
                # The nearest point of the leg; `share` is along it, times its length squared until
                # here.
                share = share / square if share < square else 1.0
                px -= share * dx
                py -= share * dy
            if px * px + py * py < least * least:
                return True
    return False


def _ends_at(corners: Numbers, ends: Numbers) -> bool:
    """Return whether a polyline ends nearer to any place than is said with it: x, y, metres."""
    corner: Doubles = at(corners)
    disc: Doubles = at(ends)
    count: cython.Py_ssize_t = len(corners)
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


def _length(corners: Numbers) -> float:
    """Return the length of a polyline, metres."""
    corner: Doubles = at(corners)
    total: float = 0.0
    k: cython.Py_ssize_t
    for k in range(0, len(corners) - 2, 2):
        total += _apart(corner[k], corner[k + 1], corner[k + 2], corner[k + 3])
    return total


def _first(corners: Numbers, length: float) -> Numbers:
    """Return the first `length` metres of a polyline, or all of it."""
    corner: Doubles = at(corners)
    kept: Numbers = room(len(corners))
    place: Doubles = at(kept)
    place[0] = corner[0]
    place[1] = corner[1]
    k: cython.Py_ssize_t
    for k in range(2, len(corners), 2):
        x: float = corner[k - 2]
        y: float = corner[k - 1]
        dx: float = corner[k] - x
        dy: float = corner[k + 1] - y
        leg: float = sqrt(dx * dx + dy * dy)
        if leg >= length:
            if length <= 1e-9:
                cut(kept, k)
                return kept
            share: float = length / leg
            place[k] = x + share * dx
            place[k + 1] = y + share * dy
            cut(kept, k + 2)
            return kept
        place[k] = corner[k]
        place[k + 1] = corner[k + 1]
        length -= leg
    return kept


def bounds(corners: Numbers, more: Numbers) -> Numbers:
    """Return least x and y and greatest x and y of `corners`, and of bounds besides."""
    found: Numbers = room(4)
    box: Doubles = at(found)
    box[0] = box[1] = INFINITY
    box[2] = box[3] = -INFINITY
    _widen(box, corners)
    _widen(box, more)
    return found


def _widen(box: Doubles, corners: Numbers) -> cython.int:
    """Widen bounds to those of corners."""
    corner: Doubles = at(corners)
    k: cython.Py_ssize_t
    for k in range(0, len(corners), 2):
        box[0] = min(box[0], corner[k])
        box[1] = min(box[1], corner[k + 1])
        box[2] = max(box[2], corner[k])
        box[3] = max(box[3], corner[k + 1])
    return 0
