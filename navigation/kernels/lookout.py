"""Until when a machine may follow a motion, if it is to keep its distance from people by stopping.

Of somebody seen at a place no more is known than their top speed: a circle about it that grows.
People are rows of x, y, top speed (m/s), and what a law that looks ahead asks for from them
(metres; less than 0 where it depends on the machine's speed). Tables of motions are those of
`pieces`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

if not cython.compiled:
    from .braking import Stops
    from .cubics import *
    from .encounter import EncounterBounds
    from .laws import LawEvaluator
    from .numbers import *
    from .odometer import PathLength, radius_of
    from .pieces import rest
    from .uncompiled import TaylorModel
    from .watch import ChangeSearch, TooCloseTest

_PERSON: cython.Py_ssize_t = 4  # numbers of a person's row


class Towards(LawEvaluator):
    """What `law` asks for if somebody walks straight at the machine, on their distance at `since`.

    It is `fixed` metres where that is not less than 0; `margin` metres are kept in addition.
    """

    def __init__(
        self, law: LawEvaluator, speed: float, since: float, fixed: float, margin: float
    ) -> None:
        super().__init__(False)
        self.law = law
        self.speed = speed
        self.since = since
        self.fixed = fixed
        self.margin = margin

    def require(self, encounter: EncounterBounds, begin: float, end: float) -> TaylorModel:
        half: float = (end - begin) / 2
        walked: float = self.speed * (begin + half - self.since)
        # Straight towards the machine the distance shrinks by the top speed, which is the same as a
        # person who stands and a requirement that grows by it.
        if self.fixed >= 0.0:
            return TaylorModel(walked + self.fixed, self.speed, 0.0, 0.0)
        pace: TaylorModel = encounter.machine.speed_over(begin, end)
        around: float = radius_of(pace, half)
        low: float = self.law.distance(self.speed, max(pace.value - around, 0.0))
        high: float = self.law.distance(self.speed, pace.value + around)
        return TaylorModel(
            walked + (low + high) / 2 + self.margin, self.speed, (high - low) / 2, 0.0
        )


class MotionSpan:
    """A part of a motion, from `begin` to `end` (seconds): its ends, and a bound of its speed."""

    def __init__(self, odometer: PathLength, begin: float, end: float) -> None:
        table: Numbers = odometer.table
        row: PosePieces = poses(table)
        self.table = table
        self.begin = begin
        self.end = end
        pace: TaylorModel = odometer.speed_over(begin, end)
        self.fastest = pace.value + radius_of(pace, (end - begin) / 2)
        first: PosePiece = row[max(pose_at(table, begin), 0)]
        u: float = held(first.begin, first.end, begin)
        self.x = value(first.x, u)
        self.y = value(first.y, u)
        last: PosePiece = row[max(pose_at(table, end), 0)]
        u = held(last.begin, last.end, end)
        self.last_x = value(last.x, u)
        self.last_y = value(last.y, u)
        self.last_speed = 0.0
        if row[0].begin <= end < end_of(table):
            self.last_speed = speed(last.x, last.y, u)


class Lookout:
    """The test for a machine to which `law` applies; `margin` metres are kept in addition.

    Laws that look ahead are sure of `rounding` metres; instants are found to `resolution` seconds.
    """

    def __init__(
        self, law: LawEvaluator, margin: float, rounding: float, resolution: float
    ) -> None:
        self.law = law
        self.margin = margin
        self.rounding = rounding
        self.resolution = resolution

    def safe_until(
        self, motion: Numbers, stops: Stops, people: list[float], now: float, least: float
    ) -> tuple[float, int]:
        """Return an instant until which `motion` may be followed, and the row of who ends it.

        It is found by doubling the time, from `least` seconds on; `now` if not even those are safe.
        The row is -1 if nobody ends it before the end of the motion.
        """
        finish: float = end_of(motion)
        k: cython.Py_ssize_t
        if not people or now >= finish:
            return finish, -1
        # Mostly everybody is far away, and one bound for the whole motion says so.
        odometer: PathLength = PathLength(motion)
        whole: MotionSpan = MotionSpan(odometer, now, finish)
        near: cython.bint = False
        for k in range(len(people) // _PERSON):
            near = near or self.in_reach(people, k, whole, now)
        if not near:
            return finish, -1
        until: float = now
        ahead: float = least
        while until < finish:
            then: float = min(now + ahead, finish)
            on: MotionSpan = MotionSpan(odometer, until, then)
            # Safe until `then` and safe through the stop from there: one may decide anew at that
            # time. Doubling asks for as many stops as the logarithm of the time, and finds at least
            # half of it.
            stop: Numbers = stops.table(motion, then)
            stopping: MotionSpan = MotionSpan(PathLength(stop), then, end_of(stop))
            for k in range(len(people) // _PERSON):
                if self.hinders(people, k, on, now) or self.hinders(people, k, stopping, now):
                    return until, k
            until = then
            ahead = 2 * ahead
        return finish, -1

    def lacking(
        self, motion: Numbers, stops: Stops, people: list[float], now: float, least: float
    ) -> float:
        """Return the metres that the first of `people` is too close, whatever comes.

        That is after `least` seconds of the motion, or at the end of the stop from there.
        """
        then: float = min(now + least, end_of(motion))
        on: MotionSpan = MotionSpan(PathLength(motion), now, then)
        stop: Numbers = stops.table(motion, then)
        stopping: MotionSpan = MotionSpan(PathLength(stop), then, end_of(stop))
        return -min(self.room(people, 0, on, now), self.room(people, 0, stopping, now))

    def required(self, people: list[float], k: cython.Py_ssize_t, speed: float) -> float:
        """Return the metres to keep from somebody at their top speed, and at the machine's."""
        fixed: float = people[k * _PERSON + 3]
        if fixed >= 0.0:
            return fixed
        return self.law.distance(people[k * _PERSON + 2], speed) + self.margin

    def hinders(
        self, people: list[float], k: cython.Py_ssize_t, on: MotionSpan, since: float
    ) -> cython.bint:
        """Return whether somebody, seen at `since`, may come too close on a part."""
        # Two cheap answers first: too close at the end, or out of reach all the while. Only what
        # lies between is searched for in continuous time.
        if self.room(people, k, on, since) < 0.0:
            return True
        if not self.in_reach(people, k, on, since):
            return False
        o: cython.Py_ssize_t = k * _PERSON
        x: float = people[o]
        y: float = people[o + 1]
        # A motion of no length stands for ever where it is.
        still: Numbers = rest(0.0, 0.0, x, y, 0.0)
        law: Towards = Towards(self.law, people[o + 2], since, people[o + 3], self.margin)
        encounter: EncounterBounds = EncounterBounds(still, on.table, [], 0.0)
        judge: TooCloseTest = TooCloseTest(law, self.rounding)
        watch: ChangeSearch = ChangeSearch(judge, encounter, on.begin, on.end, self.resolution)
        return watch.change() is not None

    def in_reach(
        self, people: list[float], k: cython.Py_ssize_t, on: MotionSpan, since: float
    ) -> cython.bint:
        """Return whether the two may come too close on a part, whatever they do on the way."""
        o: cython.Py_ssize_t = k * _PERSON
        walked: float = people[o + 2] * (on.end - since)
        reach: float = on.fastest * (on.end - on.begin) + walked
        reach += self.required(people, k, on.fastest)
        dx: float = people[o] - on.x
        dy: float = people[o + 1] - on.y
        return norm(dx, dy) < reach

    def room(
        self, people: list[float], k: cython.Py_ssize_t, on: MotionSpan, since: float
    ) -> float:
        """Return the metres left at the end of a part beyond what is asked for there."""
        o: cython.Py_ssize_t = k * _PERSON
        asked: float = self.required(people, k, on.last_speed)
        asked += people[o + 2] * (on.end - since)
        dx: float = people[o] - on.last_x
        dy: float = people[o + 1] - on.last_y
        return norm(dx, dy) - asked


def nearest_on(
    motion: Numbers,
    people: list[float],
    now: float,
    begin: float,
    end: float,
    step: float,
    horizon: float,
) -> float:
    """Return the least distance of a `motion`, a table, to `people`; infinity without any.

    It is looked for each `step` seconds from `begin` to `end`, and at `end`. Of each of the people
    there are x, y (metres) and their velocity (m/s) at `now`; they keep it for `horizon` seconds.
    """
    least: float = INFINITY
    i: cython.Py_ssize_t = 0
    k: cython.Py_ssize_t
    t: float = begin
    over: cython.bint = False
    while not over:
        if t >= end:
            t = end
            over = True
        # Before the motion begins its first piece is held at its beginning.
        piece: PosePiece = poses(motion)[max(pose_at(motion, t), 0)]
        u: float = held(piece.begin, piece.end, t)
        x: float = value(piece.x, u)
        y: float = value(piece.y, u)
        after: float = min(t - now, horizon)
        for k in range(len(people) // _PERSON):
            p: cython.Py_ssize_t = k * _PERSON
            dx: float = x - (people[p] + after * people[p + 2])
            dy: float = y - (people[p + 1] + after * people[p + 3])
            least = min(least, norm(dx, dy))
        i += 1
        t = begin + i * step
    return least


def most_remote(
    places: list[float],
    people: list[float],
    glances: list[float],
    horizon: float,
    top: float,
    lag: float,
    enough: float,
) -> int:
    """Return the number of the place on whose path `people` stay farthest from a machine.

    `places` has x and y (metres) of each in turn, of the machine's own first; that is the answer,
    too, where nobody comes nearer than `enough` to it. The machine goes straight at its `top`
    speed, `lag` seconds late. Of the people there are x, y (metres) and their velocity (m/s), which
    they keep for `horizon` seconds; it is looked where they are at `glances`, seconds from now.
    """
    best: cython.int = 0
    farthest: float = -1.0
    x: float = places[0]
    y: float = places[1]
    i: cython.int
    g: cython.Py_ssize_t
    k: cython.Py_ssize_t
    for i in range(len(places) // 2):
        along: float = places[2 * i] - x
        across: float = places[2 * i + 1] - y
        length: float = norm(along, across)
        least: float = INFINITY
        for g in range(len(glances)):
            t: float = glances[g]
            share: float = 0.0
            if length > 0.0:
                share = min(1.0, top * max(0.0, t - lag) / length)
            after: float = min(t, horizon)
            for k in range(len(people) // _PERSON):
                p: cython.Py_ssize_t = k * _PERSON
                dx: float = x + share * along - (people[p] + people[p + 2] * after)
                dy: float = y + share * across - (people[p + 1] + people[p + 3] * after)
                least = min(least, norm(dx, dy))
        if i == 0 and least >= enough:
            return 0
        if least > farthest:
            best = i
            farthest = least
    return int(best)
