"""Motions of discs: what each sweeps, and continuous collision detection between them.

The first conflict is the first time at which two centres come too close. The test of an interval
bounds the distance from the tangent at its middle, and undecided intervals are halved (interval
subdivision as in S. Redon, A. Kheddar and S. Coquillart, "Fast continuous collision detection
between rigid bodies", Computer Graphics Forum 21, 2002). Motions are tables of `PlanarPiece`. The
last piece is the final rest, and never ends.

Pairs are pruned by the bounds of their centres (sweep and prune, J. D. Cohen et al., "I-COLLIDE",
1995) and by conservative advancement: two discs that are far apart stay apart for as many times as
their speeds permit (B. Mirtich, "Impulse-based dynamic simulation of rigid body systems", 1996).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .numbers import numbers
from .results import NearestDiscs

if not cython.compiled:
    from math import sqrt

    from .cubics import *

_RESOLUTION: float = 1e-4  # seconds; shorter undecided intervals count as a conflict
_JUST_NOW: float = 1e-3  # seconds; a conflict this soon counts as present from the begin
_ROUNDING: float = 1e-6  # of the number of times at which a pair cannot meet
_FAR: float = 2e-3  # metres; more than the tolerance of `met` for an initial conflict
_TOUCH: float = 1e-9  # metres; smaller differences of distance are rounding


class Swath:
    """Floor that the centre of a disc sweeps from a time on, by the `table` of its motion.

    `box` has its bounds: minimum x and y, maximum x and y (metres).
    """

    def __init__(self, table: Numbers, box: Numbers) -> None:
        self.table = table
        self.box = box

    @property
    def rests(self) -> float:
        """Time at which the final rest begins (seconds)."""
        return planar(self.table)[planar_count(self.table) - 1].begin

    @property
    def place(self) -> tuple[float, float]:
        """Final place (metres)."""
        last: PlanarPiece = planar(self.table)[planar_count(self.table) - 1]
        return (last.x.p, last.y.p)

    @property
    def walk(self) -> Numbers:
        """Table without the final rest."""
        return first_pieces(self.table, planar_count(self.table) - 1)

    def gone(self, since: float, t: float) -> float:
        """Return the length (m) of a walk along straight segments from `since` to `t` (s)."""
        return distance_travelled(self.table, since, t)


def swept(pieces: Numbers, begin: float, since: float, x: float, y: float) -> Swath:
    """Return the swath from `begin` (s) on of a motion that rests at (x, y) from `since` on.

    `pieces` is its table with rotations.
    """
    count: cython.Py_ssize_t = 0
    table: Numbers = planar_room(pose_count(pieces) + 1)
    row: PlanarPieces = planar(table)
    piece: PosePieces = poses(pieces)
    extent: BoundingBox = BoundingBox(x, y, x, y)
    k: cython.Py_ssize_t
    for k in range(pose_count(pieces)):
        p: PosePiece = piece[k]
        if p.end > begin and p.end > p.begin:
            row[count] = PlanarPiece(p.begin, p.end, p.x, p.y)
            count += 1
            across: Range = range_of(p.x, p.end - p.begin)
            up: Range = range_of(p.y, p.end - p.begin)
            extent = united(extent, BoundingBox(across.low, up.low, across.high, up.high))
    row[count] = rest_piece(since, x, y)
    planar_cut(table, count + 1)
    return Swath(table, row_of_box(extent))


class DiscMotions:
    """Motions of discs by index: `tables`, their bounds `boxes`, and `radii` (metres).

    Two discs keep `gap` metres between them. A disc is in the way of another until its value of
    `counted` (s) after the other has come to rest.
    """

    def __init__(self, gap: float) -> None:
        self.gap = gap
        self.tables: list[Numbers] = []
        self.boxes: Numbers = room(0)
        self.radii: Numbers = room(0)
        self.counted: Numbers = room(0)

    def add(self, swath: Swath, radius: float, counted: float = INFINITY) -> None:
        """Add a disc."""
        self.tables.append(swath.table)
        self.boxes.extend(swath.box)
        self.radii.append(radius)
        self.counted.append(counted)

    def change(self, k: cython.Py_ssize_t, swath: Swath) -> None:
        """Replace the motion of the k-th disc."""
        self.tables[k] = swath.table
        boxes_of(self.boxes)[k] = boxes_of(swath.box)[0]

    def shorten(self, count: cython.Py_ssize_t) -> None:
        """Remove all discs after the first `count`."""
        del self.tables[count:]
        del self.radii[count:]
        del self.counted[count:]
        box_cut(self.boxes, count)

    def swath_of(self, k: cython.Py_ssize_t) -> Swath:
        """Return the swath of the k-th disc."""
        return Swath(self.tables[k], row_of_box(boxes_of(self.boxes)[k]))

    def met(
        self, k: cython.Py_ssize_t, ahead: Swath, own: float, begin: float, until: float
    ) -> float:
        """Return the first time from `begin` to `until` of a conflict with the k-th disc.

        The motion `ahead` keeps `own` metres from the bodies of others. Discs that are too close
        already have a conflict when they come closer still. The result is infinity without one.
        """
        least: float = own + at(self.radii)[k]
        if not are_within(boxes_of(ahead.box)[0], boxes_of(self.boxes)[k], least):
            return INFINITY
        other: Numbers = self.tables[k]
        if at(self.counted)[k] < INFINITY:
            until = min(until, rests_from(ahead.table) + at(self.counted)[k])
        t: float = first_conflict(ahead.table, other, least, begin, until)
        if t <= begin + _JUST_NOW:
            # The discs are too close already, so a conflict is a distance below the present one.
            apart: float = distance(ahead.table, other, begin)
            if apart < least + _JUST_NOW:
                t = first_conflict(ahead.table, other, min(least, apart - 1e-9), begin, until)
        # A piece that begins before `until` may last longer.
        return t if t < until else INFINITY

    def conflicts(self, k: cython.Py_ssize_t, ahead: Swath, own: float, begin: float) -> bool:
        """Return whether there is a conflict with the k-th disc from `begin` on: see `met`."""
        least: float = own + at(self.radii)[k]
        if not are_within(boxes_of(ahead.box)[0], boxes_of(self.boxes)[k], least):
            return False
        other: Numbers = self.tables[k]
        # The time does not matter, unless the discs are too close already.
        if at(self.counted)[k] == INFINITY and distance(ahead.table, other, begin) >= least + _FAR:
            return conflict_from(ahead.table, other, least, begin, INFINITY, 0, 0, False) < INFINITY
        return self.met(k, ahead, own, begin, INFINITY) < INFINITY

    def first_meeting(
        self, near: list[cython.Py_ssize_t], ahead: Swath, own: float, begin: float, until: float
    ) -> Meeting:
        """Return the first conflict before `until` with the discs `near`: see `met`."""
        first: Meeting = Meeting(-1, until)
        i: cython.Py_ssize_t
        for i in range(len(near)):
            t: float = self.met(near[i], ahead, own, begin, first.t)
            if t < first.t:
                first = Meeting(near[i], t)
        return first

    def first_met(
        self, near: list[cython.Py_ssize_t], ahead: Swath, own: float, begin: float
    ) -> tuple[int, float]:
        """Return the index of the first of the discs `near` in conflict, or -1, and the time."""
        first: Meeting = self.first_meeting(near, ahead, own, begin, INFINITY)
        return first.person, first.t

    def free(self, near: list[cython.Py_ssize_t], ahead: Swath, own: float, begin: float) -> bool:
        """Return whether there is no conflict with the discs `near`: see `met`."""
        i: cython.Py_ssize_t = 0
        while i < len(near) and not self.conflicts(near[i], ahead, own, begin):
            i += 1
        is_free: bool = i == len(near)
        return is_free

    def first_but(
        self,
        apart: bytearray,
        near: list[cython.Py_ssize_t],
        ahead: Swath,
        own: float,
        begin: float,
    ) -> cython.Py_ssize_t:
        """Return the first of the discs `near` in conflict that is not `apart`, or -1: see `met`.

        `apart` has a byte for each disc.
        """
        first: Meeting = Meeting(-1, INFINITY)
        box: BoundingBox = boxes_of(ahead.box)[0]
        boxes: Boxes = boxes_of(self.boxes)
        radius: Doubles = at(self.radii)
        i: cython.Py_ssize_t
        for i in range(len(near)):
            k: cython.Py_ssize_t = near[i]
            if are_within(box, boxes[k], own + radius[k]) and not apart[k]:
                t: float = self.met(k, ahead, own, begin, first.t)
                if t < first.t:
                    first = Meeting(k, t)
        return first.person


class DiscWindow:
    """Centres of discs at the times of a window. Times are numbered through all windows.

    `tables` are the motions of the centres, `radii` in metres. Between consecutive times a disc
    moves at most its value of `steps` (metres), except in its `jumps`: the sorted indices of the
    times after which its place changes without a motion.
    """

    def __init__(
        self,
        tables: list[Numbers],
        radii: list[float],
        steps: list[float],
        jumps: list[list[float]],
    ) -> None:
        none: Numbers = room(0)
        self.tables = tables
        self.radii = numbers(radii)
        self.steps = numbers(steps)
        self.jumps = [numbers(each) for each in jumps]
        self.rows = [0] * len(tables)
        self.first = 0
        self.times = none
        self.xs = none
        self.ys = none
        self.boxes: Numbers = room(4 * len(tables))

    def see(self, first: cython.Py_ssize_t, times: list[float]) -> None:
        """Advance to a window with `times` (seconds), of which the first has the index `first`.

        Windows follow each other, or start again at 0.
        """
        if first == 0:
            self.rows = [0] * len(self.tables)
        width: cython.Py_ssize_t = len(times)
        self.first = first
        self.times = numbers(times)
        self.xs = room(width * len(self.tables))
        self.ys = room(width * len(self.tables))
        t: Doubles = at(self.times)
        x: Doubles = at(self.xs)
        y: Doubles = at(self.ys)
        i: cython.Py_ssize_t
        k: cython.Py_ssize_t
        for i in range(len(self.tables)):
            table: Numbers = self.tables[i]
            row: cython.Py_ssize_t = self.rows[i]
            box: BoundingBox = BoundingBox(INFINITY, INFINITY, -INFINITY, -INFINITY)
            for k in range(width):
                row = planar_from(table, row, t[k])
                piece: PlanarPiece = planar(table)[row]
                u: float = max(t[k] - piece.begin, 0.0)
                n: cython.Py_ssize_t = i * width + k
                x[n] = value(piece.x, u)
                y[n] = value(piece.y, u)
                box = united(box, BoundingBox(x[n], y[n], x[n], y[n]))
            boxes_of(self.boxes)[i] = box
            self.rows[i] = row

    def centre(self, i: cython.Py_ssize_t, k: cython.Py_ssize_t) -> tuple[float, float]:
        """Return the centre of the i-th disc at the k-th time."""
        n: cython.Py_ssize_t = i * len(self.times) + k - self.first
        return self.xs[n], self.ys[n]

    def nearest(self, best: float) -> NearestDiscs:
        """Return the nearest two discs at any time of the window.

        The first of several minima counts. The distance is `best` if no pair is nearer.
        """
        end: cython.Py_ssize_t = self.first + len(self.times)
        when: cython.Py_ssize_t = self.first
        one: cython.Py_ssize_t = 0
        two: cython.Py_ssize_t = 1
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        for i in range(len(self.tables)):
            for j in range(i + 1, len(self.tables)):
                if self._between(i, j) > best:
                    continue
                k: cython.Py_ssize_t = self.first
                while k < end:
                    gap: float = self._gap(i, j, k)
                    if gap < best or (gap == best and k < when):
                        best = gap
                        when = k
                        one = i
                        two = j
                    k += self._passed(i, j, k, gap - best, end)
        return NearestDiscs(one, two, when, best)

    def nearer_between(self, best: float) -> list[tuple[int, int, int]]:
        """Return pairs of discs that come nearer than `best` metres, and the time before that."""
        last: cython.Py_ssize_t = self.first + len(self.times) - 1
        near: list[tuple[int, int, int]] = []
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        for i in range(len(self.tables)):
            for j in range(i + 1, len(self.tables)):
                step: float = at(self.steps)[i] + at(self.steps)[j]
                # Between two times, each disc is within a step of one of its two places.
                if self._between(i, j) - 2 * step > best:
                    continue
                k: cython.Py_ssize_t = self.first
                while k < last:
                    gap: float = self._gap(i, j, k)
                    passed: cython.Py_ssize_t = self._passed(i, j, k, gap - best, last)
                    # With distances p and q at both times, and an approach by at most v between
                    # them, a pair is never nearer than (p + q - v) / 2. Jumps have no bound.
                    if passed == 1 and (
                        (gap + self._gap(i, j, k + 1) - step) / 2 < best
                        or self._next_jump(i, k, last) == k
                        or self._next_jump(j, k, last) == k
                    ):
                        begin: float = at(self.times)[k - self.first]
                        end: float = at(self.times)[k - self.first + 1]
                        least: float = at(self.radii)[i] + at(self.radii)[j] + best - _TOUCH
                        one: Numbers = self.tables[i]
                        two: Numbers = self.tables[j]
                        row: cython.Py_ssize_t = max(planar_at(one, begin), 0)
                        other: cython.Py_ssize_t = max(planar_at(two, begin), 0)
                        if conflict_from(one, two, least, begin, end, row, other, True) <= end:
                            near.append((i, j, k))
                    k += passed
        return near

    def _between(self, i: cython.Py_ssize_t, j: cython.Py_ssize_t) -> float:
        """Return the distance between two discs by the bounds of their centres, metres."""
        a: BoundingBox = boxes_of(self.boxes)[i]
        b: BoundingBox = boxes_of(self.boxes)[j]
        dx: float = max(a.low_x - b.high_x, max(b.low_x - a.high_x, 0.0))
        dy: float = max(a.low_y - b.high_y, max(b.low_y - a.high_y, 0.0))
        least: float = at(self.radii)[i] + at(self.radii)[j]
        return norm(dx, dy) - least

    def _gap(self, i: cython.Py_ssize_t, j: cython.Py_ssize_t, k: cython.Py_ssize_t) -> float:
        """Return the distance between two discs at the k-th time, metres."""
        o: cython.Py_ssize_t = i * len(self.times) + k - self.first
        p: cython.Py_ssize_t = j * len(self.times) + k - self.first
        apart: float = norm(at(self.xs)[o] - at(self.xs)[p], at(self.ys)[o] - at(self.ys)[p])
        least: float = at(self.radii)[i] + at(self.radii)[j]
        return apart - least

    def _passed(
        self,
        i: cython.Py_ssize_t,
        j: cython.Py_ssize_t,
        k: cython.Py_ssize_t,
        spare: float,
        end: cython.Py_ssize_t,
    ) -> cython.Py_ssize_t:
        """Return the number of times, at least 1, until a pair may be nearer by `spare` metres."""
        step: float = at(self.steps)[i] + at(self.steps)[j]
        if spare < 2 * step:
            return 1
        passed: cython.Py_ssize_t = end
        if spare < step * end:
            passed = int(spare / step - _ROUNDING)
        # Up to the next jump of either disc, and only one time across it.
        jump: cython.Py_ssize_t = min(self._next_jump(i, k, end), self._next_jump(j, k, end))
        return max(min(passed, jump - k), 1)

    def _next_jump(
        self, i: cython.Py_ssize_t, k: cython.Py_ssize_t, end: cython.Py_ssize_t
    ) -> cython.Py_ssize_t:
        """Return the first jump of a disc from the k-th time on, or `end`."""
        jumps: Numbers = self.jumps[i]
        jump: Doubles = at(jumps)
        n: cython.Py_ssize_t
        for n in range(len(jumps)):
            if jump[n] >= k:
                return int(jump[n])
        return end


def within_bounds(
    boxes: Numbers, box: Numbers, margin: float, but: cython.Py_ssize_t = -1
) -> list[cython.Py_ssize_t]:
    """Return the indices of the `boxes` without `but` that overlap `box` with a margin (m)."""
    a: BoundingBox = boxes_of(box)[0]
    a = BoundingBox(a.low_x - margin, a.low_y - margin, a.high_x + margin, a.high_y + margin)
    overlapping: list[cython.Py_ssize_t] = []
    other: Boxes = boxes_of(boxes)
    k: cython.Py_ssize_t
    for k in range(box_count(boxes)):
        if k != but and are_within(a, other[k], 0.0):
            overlapping.append(k)  # noqa: PERF401
    return overlapping


def covers(circles: Numbers, x: float, y: float) -> bool:
    """Return whether a place is in one of `circles`."""
    k: cython.Py_ssize_t
    for k in range(circle_count(circles)):
        circle: Circle = circles_of(circles)[k]
        if norm(circle.x - x, circle.y - y) < circle.radius:
            return True
    return False


def rests_from(table: Numbers) -> float:
    """Return the time at which the final rest begins (seconds)."""
    k: cython.Py_ssize_t = 0
    while planar(table)[k].end < INFINITY:
        k += 1
    return planar(table)[k].begin


def distance_travelled(table: Numbers, since: float, t: float) -> float:
    """Return the length (m) of a walk along straight segments from `since` to `t` (s)."""
    total: float = 0.0
    row: PlanarPieces = planar(table)
    k: cython.Py_ssize_t
    for k in range(planar_count(table) - 1):
        p: PlanarPiece = row[k]
        if since <= p.begin < t:
            u: float = (p.end if p.end < t else t) - p.begin
            # On a straight segment a walk never turns back, so that the chord is the path.
            total += norm(gain(p.x, u), gain(p.y, u))
    return total


def distance(one: Numbers, other: Numbers, t: float) -> float:
    """Return the distance (m) of two centres at `t` (s)."""
    a: Position = position_at(one, t)
    b: Position = position_at(other, t)
    return norm(a.x - b.x, a.y - b.y)


def first_conflict(one: Numbers, other: Numbers, least: float, begin: float, until: float) -> float:
    """Return the first time from `begin` to `until` (s) at which two are nearer than `least` (m).

    It is infinite without a conflict. Both tables reach back to `begin`. No conflict is missed.
    False ones are possible only if the distance stays within rounding of `least`.
    """
    return conflict_from(one, other, least, begin, until, 0, 0, True)


def conflict_from(
    one: Numbers,
    other: Numbers,
    least: float,
    begin: float,
    until: float,
    i: cython.Py_ssize_t,
    j: cython.Py_ssize_t,
    exact: bool,
) -> float:
    """Return the first conflict of tables whose pieces before i and j are over.

    If not `exact`, the time of another conflict may be returned.
    """
    ones: PlanarPieces = planar(one)
    others: PlanarPieces = planar(other)
    i = planar_from(one, i, begin)
    j = planar_from(other, j, begin)
    t: float = begin
    while t < until:
        a: PlanarPiece = ones[i]
        b: PlanarPiece = others[j]
        u: float = max(t - a.begin, 0.0)
        w: float = max(t - b.begin, 0.0)
        x: Cubic = minus(shift(a.x, u), shift(b.x, w))
        y: Cubic = minus(shift(a.y, u), shift(b.y, w))
        end: float = a.end if a.end < b.end else b.end
        if end == INFINITY:
            return t if x.p * x.p + y.p * y.p < least * least else INFINITY
        duration: float = end - t
        # The bounds along the axes are cheapest and decide most intervals.
        if not _is_apart(x, duration, least) and not _is_apart(y, duration, least):
            entry: float = _first_within(x, y, duration, least, exact)
            if entry >= 0.0:
                return t + entry
        t = end
        if a.end <= t:
            i += 1
        if b.end <= t:
            j += 1
    return INFINITY


def _is_apart(c: Cubic, duration: float, least: float) -> bool:
    """Return whether the Bernstein bounds of a coordinate keep it `least` from 0."""
    if -least < c.p < least:
        return False
    extent: Range = range_of(c, duration)
    return extent.low >= least or extent.high <= -least


def _first_within(x: Cubic, y: Cubic, duration: float, least: float, exact: bool) -> float:
    """Return the first u in [0, `duration`] at which (x, y) is within `least` of the origin, or -1.

    If not `exact`, any such u may be returned.

    Subdivision: the distance along the tangent at the middle of an interval is convex, and the
    point stays within `deviation` of the tangent. Undecided intervals are halved. The current one
    is the k-th of its `width`. The shortest count as a conflict unless the two move apart, because
    no interval decides about a person who leaves from exactly the minimum distance.
    """
    straight: cython.bint = is_straight(x, y)
    width: float = duration
    k: cython.Py_ssize_t = 0
    while True:
        half: float = width / 2
        since: float = k * width
        dx: Cubic = shift(x, since + half)
        dy: Cubic = shift(y, since + half)
        u: float = nearest_on_line(dx, dy, half)
        near: float = norm(dx.p + dx.v * u, dy.p + dy.v * u)
        if not straight:
            near -= deviation(dx, dy, half)
            if near < least and width <= _RESOLUTION:
                near = _least_on_leaving(shift(x, since), shift(y, since), width)
        if near >= least:
            k += 1
            # Continue with the widest interval that begins at this end.
            while k % 2 == 0:
                k //= 2
                width *= 2
            if width >= duration:
                return -1.0
        elif straight:
            return _entry(x, y, duration, least)
        elif width <= _RESOLUTION or (
            not exact and norm(value(dx, u), value(dy, u)) < least - _TOUCH
        ):
            return since
        else:
            k *= 2
            width = half


def _least_on_leaving(x: Cubic, y: Cubic, width: float) -> float:
    """Bound the distance of (x, y) from the origin for `width` seconds, exactly if it increases.

    This is the Bernstein bound of the component along the initial direction.
    """
    away: float = norm(x.p, y.p)
    if away == 0.0:
        return 0.0
    nx: float = x.p / away
    ny: float = y.p / away
    # Distances of the control points from the initial place.
    one: float = width * (nx * x.v + ny * y.v)
    two: float = width * width * (nx * x.a + ny * y.a)
    three: float = width * width * width * (nx * x.j + ny * y.j)
    nearer: float = min(one / 3, min((2 * one + two) / 3, one + two + three))
    return away + min(nearer, 0.0)


def _entry(x: Cubic, y: Cubic, duration: float, least: float) -> float:
    """Return the first u from 0 to `duration` at which a line enters a disc around the origin."""
    # The roots of a u² + 2 b u + c. The first is c / (√(b² − a c) − b), and b < 0 on approach, so
    # that the denominator is a sum of positive terms without cancellation.
    c: float = x.p * x.p + y.p * y.p - least * least
    if c <= 0.0:
        return 0.0
    a: float = x.v * x.v + y.v * y.v
    b: float = x.p * x.v + y.p * y.v
    root: float = sqrt(max(b * b - a * c, 0.0))
    return min(max(c / (root - b), 0.0), duration)
