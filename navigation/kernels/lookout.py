"""Until when a machine may follow a motion, if it is to keep its distance from people by stopping.

Of a person seen at a place no more is known than their top speed: a disc about it that grows. A
motion is safe as long as the machine could stop from it at any time before it is too close, as in
the passive motion safety of inevitable collision states (S. Bouraine, T. Fraichard and H. Salhi,
"Provably safe navigation for mobile robots with limited field-of-views in dynamic environments",
Autonomous Robots 32, 2012). People are rows of numbers as those of `SeenPerson`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .numbers import numbers

if not cython.compiled:
    from math import cos, sin

    from .braking import Stops
    from .cubics import *
    from .encounter import Encounter, Gauge, nearest_surface
    from .laws import LawEvaluator
    from .odometer import radius_of, speed_over
    from .pieces import instant, rest
    from .watch import ChangeSearch, TooClose


class Towards(LawEvaluator):
    """What `law` requires if a person walks straight at the machine, of their distance at `since`.

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

    def require(self, encounter: Encounter, begin: float, end: float) -> TaylorModel:
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

    def __init__(self, table: Numbers, begin: float, end: float) -> None:
        self.table = table
        self.begin = begin
        self.end = end
        pace: TaylorModel = speed_over(table, begin, end)
        self.fastest = pace.value + radius_of(pace, (end - begin) / 2)
        first: PosePiece = instant(table, begin)
        self.x = first.x.p
        self.y = first.y.p
        last: PosePiece = instant(table, end)
        self.last_x = last.x.p
        self.last_y = last.y.p
        self.last_turn = last.rotation.p
        self.last_speed = norm(last.x.v, last.y.v)


class Lookout:
    """The test for a machine to which `law` applies; `margin` metres are kept in addition.

    Instants are found to `resolution` seconds. Distances are those of places, or between the
    surfaces of `gauges`.
    """

    def __init__(
        self,
        law: LawEvaluator,
        margin: float,
        resolution: float,
        gauges: list[Gauge],
    ) -> None:
        self.gauges = gauges
        # No surface is farther from its body's place than this, both together.
        self.around = 0.0
        gauge: Gauge
        for gauge in gauges:
            self.around = max(self.around, gauge.reach + gauge.rounding + gauge.radius)
        self.law = law
        self.margin = margin
        self.resolution = resolution

    def safe_until(
        self, motion: Numbers, stops: Stops, people: list[float], now: float, least: float
    ) -> tuple[float, int]:
        """Return an instant until which `motion` may be followed, and the row of who ends it.

        It is found by doubling the time, from `least` seconds on; `now` if not even those are safe.
        The row is -1 if no person ends it before the end of the motion.
        """
        finish: float = end_of(motion)
        row: Numbers = numbers(people)
        person: SeenPeople = seen_people(row)
        count: cython.Py_ssize_t = person_count(row)
        k: cython.Py_ssize_t
        if not people or now >= finish:
            return finish, -1
        # Mostly everybody is far away, and one bound for the whole motion says so.
        whole: MotionSpan = MotionSpan(motion, now, finish)
        near: cython.bint = False
        for k in range(count):
            near = near or self.in_reach(person[k], whole, now)
        if not near:
            return finish, -1
        until: float = now
        ahead: float = least
        while until < finish:
            then: float = min(now + ahead, finish)
            on: MotionSpan = MotionSpan(motion, until, then)
            # Safe until `then` and safe through the stop from there: one may decide anew at that
            # time. Doubling asks for as many stops as the logarithm of the time, and finds at least
            # half of it.
            stop: Numbers = stops.table(motion, then)
            stopping: MotionSpan = MotionSpan(stop, then, end_of(stop))
            for k in range(count):
                if self.hinders(person[k], on, now) or self.hinders(person[k], stopping, now):
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
        on: MotionSpan = MotionSpan(motion, now, then)
        stop: Numbers = stops.table(motion, then)
        stopping: MotionSpan = MotionSpan(stop, then, end_of(stop))
        row: Numbers = numbers(people)
        first: SeenPerson = seen_people(row)[0]
        return -min(self.spare(first, on, now), self.spare(first, stopping, now))

    def required(self, person: SeenPerson, speed: float) -> float:
        """Return the metres to keep from a person at their top speed, and at the machine's."""
        if person.fixed >= 0.0:
            return person.fixed
        return self.law.distance(person.top_speed, speed) + self.margin

    def hinders(self, person: SeenPerson, on: MotionSpan, since: float) -> cython.bint:
        """Return whether a person, seen at `since`, may come too close on a part."""
        # Two cheap answers first: too close at the end, or out of reach all the while. Only what
        # lies between is searched for in continuous time.
        if self.spare(person, on, since) < 0.0:
            return True
        if not self.in_reach(person, on, since):
            return False
        # A motion of no length rests where it is.
        there: Numbers = rest(0.0, 0.0, person.x, person.y, 0.0)
        still: MotionSpan = MotionSpan(there, since, since)
        law: Towards = Towards(self.law, person.top_speed, since, person.fixed, self.margin)
        encounter: Encounter = Encounter(still, on, self.gauges)
        near: TooClose = TooClose(law)
        watch: ChangeSearch = ChangeSearch(near, encounter, on.begin, on.end, self.resolution)
        return watch.change() is not None

    def in_reach(self, person: SeenPerson, on: MotionSpan, since: float) -> cython.bint:
        """Return whether the two may come too close on a part, whatever they do on the way."""
        walked: float = person.top_speed * (on.end - since)
        reach: float = on.fastest * (on.end - on.begin) + walked
        reach += self.required(person, on.fastest) + self.around
        return norm(person.x - on.x, person.y - on.y) < reach

    def spare(self, person: SeenPerson, on: MotionSpan, since: float) -> float:
        """Return the metres left at the end of a part beyond the required distance there."""
        required: float = self.required(person, on.last_speed)
        required += person.top_speed * (on.end - since)
        dx: float = person.x - on.last_x
        dy: float = person.y - on.last_y
        if self.gauges:
            c: float = cos(on.last_turn)
            s: float = sin(on.last_turn)
            return nearest_surface(self.gauges, c * dx + s * dy, c * dy - s * dx) - required
        return norm(dx, dy) - required


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
    row: Numbers = numbers(people)
    least: float = INFINITY
    i: cython.Py_ssize_t = 0
    k: cython.Py_ssize_t
    t: float = begin
    over: cython.bint = False
    while not over:
        if t >= end:
            t = end
            over = True
        here: PosePiece = instant(motion, t)
        after: float = min(t - now, horizon)
        for k in range(person_count(row)):
            person: MovingPerson = moving_people(row)[k]
            dx: float = here.x.p - (person.x + after * person.vx)
            dy: float = here.y.p - (person.y + after * person.vy)
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
    row: Numbers = numbers(people)
    place_row: Numbers = numbers(places)
    place: Positions = positions_of(place_row)
    best: cython.int = 0
    farthest: float = -1.0
    x: float = place[0].x
    y: float = place[0].y
    i: cython.int
    g: cython.Py_ssize_t
    k: cython.Py_ssize_t
    for i in range(position_count(place_row)):
        along: float = place[i].x - x
        across: float = place[i].y - y
        length: float = norm(along, across)
        least: float = INFINITY
        for g in range(len(glances)):
            t: float = glances[g]
            share: float = 0.0
            if length > 0.0:
                share = min(1.0, top * max(0.0, t - lag) / length)
            after: float = min(t, horizon)
            for k in range(person_count(row)):
                person: MovingPerson = moving_people(row)[k]
                dx: float = x + share * along - (person.x + person.vx * after)
                dy: float = y + share * across - (person.y + person.vy * after)
                least = min(least, norm(dx, dy))
        if i == 0 and least >= enough:
            return 0
        if least > farthest:
            best = i
            farthest = least
    return int(best)
