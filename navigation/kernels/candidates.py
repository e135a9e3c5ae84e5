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
from .throng import Throng

if not cython.compiled:
    from math import inf, sqrt

    from .discs import distance, met
    from .pacing import bend_speed, stand, walk_table

    INFINITY = inf
else:
    from cython.cimports.libc.math import INFINITY, sqrt
    from cython.cimports.navigation.kernels.discs import distance, met
    from cython.cimports.navigation.kernels.pacing import bend_speed, stand, walk_table

_ROW: cython.Py_ssize_t = 6  # loss, length, top speed, delay, and for an aside: along, side
_R: cython.Py_ssize_t = ROW
_BEFORE: float = 0.35  # metres before and after the place at which an aside is beside its course
_RAMP: float = 1.2  # metres that it takes to come back, for each metre of a shift
_HAIR: float = 1e-6
_CLEAR: float = 2e-3  # metres; who is so much farther off is not met where one sets out
_HARDLY: float = 0.02  # metres; a shift of no more is none
_STANDS: float = 1e-6  # m/s; slower than this is standing

Slowed = Callable[[list[float], float, float], "tuple[list[float], list[float]] | None"]


class Candidates:
    """Walks of one person from `begin` (seconds) on, who has been on the `lead` until then.

    They set out at `speed` with the velocity `vx`, `vy` (m/s). `course` holds x and y of its
    corners in turn (metres); the `lead` is a table without its final standing, `lead_box` its
    bounds, and both are empty for who sets out `now`. Where limits of speed hold, walks are those
    that `slowed(corners, top_speed, delay)` makes: a table and its bounds, or None.
    """

    def __init__(
        self,
        course: list[float],
        begin: float,
        now: float,
        speed: float,
        vx: float,
        vy: float,
        max_speed: float,
        acceleration: float,
        lead: list[float],
        lead_box: list[float],
        slowed: Slowed | None = None,
    ) -> None:
        self.course = course
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
        self.whole = _length(course)
        none: list[float] = []
        self.rows = none
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
        self.rows = []
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
        sides: list[float],
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
        for i in range(len(sides)):
            side: float = sides[i]
            if abs(side) <= _HARDLY or abs(side) > widest:
                continue
            again: cython.bint = False
            for j in range(i):
                again = again or sides[j] == side
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
        rows: list[float] = self.rows
        while True:
            best: float = INFINITY
            row: cython.Py_ssize_t = -1
            k: cython.Py_ssize_t
            for k in range(len(rows) // _ROW):
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
        corners: list[float] = _first(self.corners, self.length)
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
        table: list[float] = self.table
        box: list[float] = self.box
        tables: list[list[float]] = throng.tables
        boxes: list[float] = throng.boxes
        radii: list[float] = throng.radii
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
        self.stood = []
        self.ends = []
        if len(self.lead) > 0:
            return 0
        x: float = self.course[0]
        y: float = self.course[1]
        here: list[float] = []
        stand(here, self.now, INFINITY, x, y)
        i: cython.Py_ssize_t
        for i in range(len(near)):
            other: list[float] = throng.tables[near[i]]
            last: cython.Py_ssize_t = len(other) - _R
            least: float = own + throng.radii[near[i]]
            found: list[float] = self.ends
            away: float
            if other[last] <= self.now:
                found = self.stood
                away = _apart(x, y, other[last + 2], other[last + 6])
            else:
                away = distance(here, other, self.now)
            if away > least + _CLEAR:
                found.append(other[last + 2])
                found.append(other[last + 6])
                found.append(least - _HAIR)
        return 0

    def _draw(self, corners: list[float]) -> bool:
        """Set `table` and `box` to those of the walk along `corners` that is to be looked at."""
        table: list[float] = self.lead[:]
        start: float = self.begin + self.delay
        since: float = self.begin if table else self.now
        # Only who stands can set out later.
        if self.delay != 0.0 and self.speed > _STANDS:
            return False
        if self.slowed is not None:
            slower = self.slowed(corners, self.top_speed, self.delay)
            if slower is None:
                return False
            self.table, self.box = slower
            return True
        if since < start:
            x: float = corners[0]
            y: float = corners[1]
            stand(table, since, start, x, y)
        tops: list[float] = [self.top_speed] * (len(corners) // 2 - 1)
        if not walk_table(
            corners, tops, start, self.speed, self.max_speed, self.acceleration, table
        ):
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
        rows: list[float] = self.rows
        rows.append(loss)
        rows.append(length)
        rows.append(top_speed)
        rows.append(delay)
        rows.append(along)
        rows.append(side)
        return 0

    def _can_turn(self) -> bool:
        """Return whether they may set out on `corners` without slowing down first."""
        if self.speed < _STANDS:
            return True
        corners: list[float] = self.corners
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
        course: list[float] = self.course
        self._shift(along, side)
        corners: list[float] = [course[0], course[1], self.off_x, self.off_y]
        corners.append(self.by_x)
        corners.append(self.by_y)
        if self.leg >= 0:
            corners.append(self.x)
            corners.append(self.y)
            corners += course[2 * self.leg + 2 :]
        self.corners = corners
        return 0

    def _longer(self, along: float, side: float) -> float:
        """Return how much longer such a course is (metres), without setting it up."""
        course: list[float] = self.course
        self._shift(along, side)
        total: float = _apart(course[0], course[1], self.off_x, self.off_y)
        total += _apart(self.off_x, self.off_y, self.by_x, self.by_y)
        if self.leg >= 0:
            total += _apart(self.by_x, self.by_y, self.x, self.y)
            x: float = self.x
            y: float = self.y
            k: cython.Py_ssize_t
            for k in range(2 * self.leg + 2, len(course), 2):
                total += _apart(x, y, course[k], course[k + 1])
                x = course[k]
                y = course[k + 1]
        return total - self.whole

    def _shift(self, along: float, side: float) -> cython.int:
        """Find where a course bends that is `side` metres to the left after `along` metres.

        It is off the course up to `off_x`, `off_y`, beside it up to `by_x`, `by_y`, and back on its
        `leg` at `x`, `y`; where the goal itself is beside the other, it goes there and `leg` is -1.
        """
        course: list[float] = self.course
        count: cython.Py_ssize_t = len(course)
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
        course: list[float] = self.course
        count: cython.Py_ssize_t = len(course)
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


def _runs_into(corners: list[float], stood: list[float]) -> bool:
    """Return whether a polyline comes nearer to any place than is said with it: x, y, metres."""
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    for k in range(0, len(corners) - 2, 2):
        x: float = corners[k]
        y: float = corners[k + 1]
        dx: float = corners[k + 2] - x
        dy: float = corners[k + 3] - y
        square: float = dx * dx + dy * dy
        for i in range(0, len(stood), 3):
            px: float = stood[i] - x
            py: float = stood[i + 1] - y
            least: float = stood[i + 2]
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


def _ends_at(corners: list[float], ends: list[float]) -> bool:
    """Return whether a polyline ends nearer to any place than is said with it: x, y, metres."""
    count: cython.Py_ssize_t = len(corners)
    x: float = corners[count - 2]
    y: float = corners[count - 1]
    i: cython.Py_ssize_t
    for i in range(0, len(ends), 3):
        dx: float = ends[i] - x
        dy: float = ends[i + 1] - y
        least: float = ends[i + 2]
        if dx * dx + dy * dy < least * least:
            return True
    return False


def _apart(ax: float, ay: float, bx: float, by: float) -> float:
    """Return the distance of two places, metres."""
    dx: float = bx - ax
    dy: float = by - ay
    return sqrt(dx * dx + dy * dy)


def _length(corners: list[float]) -> float:
    """Return the length of a polyline, metres."""
    total: float = 0.0
    k: cython.Py_ssize_t
    for k in range(0, len(corners) - 2, 2):
        total += _apart(corners[k], corners[k + 1], corners[k + 2], corners[k + 3])
    return total


def _first(corners: list[float], length: float) -> list[float]:
    """Return the first `length` metres of a polyline, or all of it."""
    kept: list[float] = corners[:2]
    k: cython.Py_ssize_t
    for k in range(0, len(corners) - 2, 2):
        x: float = corners[k]
        y: float = corners[k + 1]
        dx: float = corners[k + 2] - x
        dy: float = corners[k + 3] - y
        leg: float = sqrt(dx * dx + dy * dy)
        if leg >= length:
            if length > 1e-9:
                share: float = length / leg
                kept.append(x + share * dx)
                kept.append(y + share * dy)
            return kept
        kept.append(corners[k + 2])
        kept.append(corners[k + 3])
        length -= leg
    return kept


def bounds(corners: list[float], more: list[float]) -> list[float]:
    """Return least x and y and greatest x and y of corners, and of bounds besides."""
    low_x: float = INFINITY
    low_y: float = INFINITY
    high_x: float = -INFINITY
    high_y: float = -INFINITY
    k: cython.Py_ssize_t
    x: float
    y: float
    for k in range(0, len(corners), 2):
        x = corners[k]
        y = corners[k + 1]
        low_x = min(low_x, x)
        low_y = min(low_y, y)
        high_x = max(high_x, x)
        high_y = max(high_y, y)
    for k in range(0, len(more), 2):
        x = more[k]
        y = more[k + 1]
        low_x = min(low_x, x)
        low_y = min(low_y, y)
        high_x = max(high_x, x)
        high_y = max(high_y, y)
    return [low_x, low_y, high_x, high_y]
