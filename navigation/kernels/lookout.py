"""Time until which a machine may follow a motion, if it avoids people by stopping.

Only the top speed of a person is known, so a growing disc contains the person. A motion is safe as
long as the machine could stop from it at any time before it is too close. This is the passive
motion safety of inevitable collision states (S. Bouraine, T. Fraichard and H. Salhi, "Provably safe
navigation for mobile robots with limited field-of-views in dynamic environments", Autonomous Robots
32, 2012). People are rows of `SeenPerson`.
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
    """Requirement of `law` if a person walks straight at the machine, from the distance at `since`.

    A `fixed` distance (m) of at least 0 replaces that of the law, and `margin` metres are added.
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
        # The distance to a person who walks straight at the machine shrinks by the top speed. A
        # standing person and a requirement that grows at this rate are equivalent.
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
    """Part of a motion from `begin` to `end` (s), with its ends and a bound of its speed."""

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
    """Stopping test for a machine with a `law`, which keeps `margin` metres in addition.

    Times are exact to `resolution` seconds. Distances are between centres, or between the surfaces
    of `gauges`.
    """

    def __init__(
        self,
        law: LawEvaluator,
        margin: float,
        resolution: float,
        gauges: list[Gauge],
    ) -> None:
        self.gauges = gauges
        # Upper bound of the distance of both surfaces from their axes together.
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
        """Return the time until which `motion` is safe, and the row of the person who limits it.

        The search doubles the duration, beginning with `least` seconds. The result is `now` if that
        is not safe, and the row is -1 if no person limits the motion.
        """
        finish: float = end_of(motion)
        row: Numbers = numbers(people)
        person: SeenPeople = seen_people(row)
        count: cython.Py_ssize_t = person_count(row)
        k: cython.Py_ssize_t
        if not people or now >= finish:
            return finish, -1
        # Mostly all people are far away, which one bound for the whole motion proves.
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
            # The motion is safe until `then`, and the stop from there too, so the machine may
            # replan at that time. Doubling needs a logarithmic number of stops, and the result is
            # at least half of the safe duration.
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
        """Return the distance (m) by which the first of `people` is too close.

        It is evaluated after `least` seconds of the motion and at the end of the stop from there.
        """
        then: float = min(now + least, end_of(motion))
        on: MotionSpan = MotionSpan(motion, now, then)
        stop: Numbers = stops.table(motion, then)
        stopping: MotionSpan = MotionSpan(stop, then, end_of(stop))
        row: Numbers = numbers(people)
        first: SeenPerson = seen_people(row)[0]
        return -min(self.spare(first, on, now), self.spare(first, stopping, now))

    def required(self, person: SeenPerson, speed: float) -> float:
        """Return the required distance (m) at a person's top speed and the machine's `speed`."""
        if person.fixed >= 0.0:
            return person.fixed
        return self.law.distance(person.top_speed, speed) + self.margin

    def hinders(self, person: SeenPerson, on: MotionSpan, since: float) -> cython.bint:
        """Return whether a person, seen at `since`, may come too close during a part."""
        # First two cheap tests: too close at the end, or out of reach. Only otherwise a search in
        # continuous time decides.
        if self.spare(person, on, since) < 0.0:
            return True
        if not self.in_reach(person, on, since):
            return False
        # A motion without a length is at rest.
        there: Numbers = rest(0.0, 0.0, person.x, person.y, 0.0)
        still: MotionSpan = MotionSpan(there, since, since)
        law: Towards = Towards(self.law, person.top_speed, since, person.fixed, self.margin)
        encounter: Encounter = Encounter(still, on, self.gauges)
        near: TooClose = TooClose(law)
        watch: ChangeSearch = ChangeSearch(near, encounter, on.begin, on.end, self.resolution)
        return watch.change() is not None

    def in_reach(self, person: SeenPerson, on: MotionSpan, since: float) -> cython.bint:
        """Return whether the two may come too close during a part on any path of the person."""
        walked: float = person.top_speed * (on.end - since)
        reach: float = on.fastest * (on.end - on.begin) + walked
        reach += self.required(person, on.fastest) + self.around
        return norm(person.x - on.x, person.y - on.y) < reach

    def spare(self, person: SeenPerson, on: MotionSpan, since: float) -> float:
        """Return the distance (m) at the end of a part less the required distance there."""
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
    """Return the minimum distance of a `motion` (table) from `people`, infinity without people.

    It is sampled every `step` seconds from `begin` to `end`, and at `end`. People are rows of x, y
    (m) and velocity (m/s) at `now`, which they keep for `horizon` seconds.
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
    """Return the index of the place on whose path `people` stay farthest from a machine.

    `places` has x and y (m) of each, beginning with the machine's own place. The result is 0 if
    no person comes nearer than `enough` to that place. The machine drives straight at `top` speed
    after `lag` seconds. People are rows of x, y (m) and velocity (m/s), which they keep for
    `horizon` seconds. Distances are sampled at `glances` (seconds from now).
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
