"""Search for the instants at which a condition on two motions begins and ceases to hold.

Intervals that a condition leaves undecided are halved.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

if not cython.compiled:
    from math import cos, sin, sqrt

    from .encounter import EncounterBounds
    from .follower import Follower
    from .gauge import Gauge
    from .laws import LawEvaluator
    from .numbers import Numbers
    from .odometer import TaylorModel
else:
    from cython.cimports.libc.math import cos, sin, sqrt
    from cython.cimports.navigation.kernels.encounter import EncounterBounds
    from cython.cimports.navigation.kernels.follower import Follower
    from cython.cimports.navigation.kernels.gauge import Gauge
    from cython.cimports.navigation.kernels.laws import LawEvaluator
    from cython.cimports.navigation.kernels.numbers import Numbers
    from cython.cimports.navigation.kernels.odometer import TaylorModel

_INFINITE: float = float("inf")

_NO_GAUGES: list[Gauge] = []

UNDECIDED: cython.int = -1

_SURE: float = 1e-12  # metres; so that rounding can't leave a tie undecided


class IntervalTest:
    """A condition on an encounter, decided over an interval: 1 holds, 0 does not, -1 undecided."""

    def holds(self, encounter: EncounterBounds, begin: float, end: float) -> cython.int:
        return 0

    def verdict(self, encounter: EncounterBounds, begin: float, end: float) -> bool | None:
        """Return whether it holds throughout (True), nowhere (False), or None."""
        decided: cython.int = self.holds(encounter, begin, end)
        return None if decided < 0 else decided == 1


class TooCloseTest(IntervalTest):
    """The distance is less than `law` requires; laws that look ahead are sure of `rounding`."""

    def __init__(self, law: LawEvaluator, rounding: float) -> None:
        self.law = law
        self.rounding = rounding

    def holds(self, encounter: EncounterBounds, begin: float, end: float) -> cython.int:
        law: LawEvaluator = self.law
        if not law.of_speeds:
            return self.short_of(encounter, begin, end)
        person: Follower = encounter.person
        machine: Follower = encounter.machine
        if law.steady:
            encounter.apart_over(begin, end, 0.0, 0.0)
            person.low = person.high = machine.low = machine.high = 0.0
        else:
            encounter.look(begin, end)
        near: float = encounter.near
        far: float = encounter.far
        most: float = law.distance(person.high, machine.high)
        # The second limit is below the first, so that rounding can't leave a tie undecided.
        if near + encounter.slack >= most:
            return 0
        least: float = law.distance(person.low, machine.low)
        if far + encounter.slack / 2 < least:
            return 1
        # Written so that NaN, which compares with nothing, is refused as well.
        if not least <= most:
            raise ValueError(
                f"{law.source} requires {least} m at speeds of {person.low:g} and"
                f" {machine.low:g} m/s, but {most} m at {person.high:g} and {machine.high:g} m/s;"
                " a law must not ask for less when speeds grow"
            )
        return UNDECIDED

    def short_of(self, encounter: EncounterBounds, begin: float, end: float) -> cython.int:
        margin_bounds(self.law, encounter, begin, end)
        if encounter.near >= -self.rounding:
            return 0
        if encounter.far < -self.rounding / 2:
            return 1
        if not encounter.near <= encounter.far:
            raise ValueError(f"a law requires {self.law.out.value} m from t = {begin} s to {end} s")
        return UNDECIDED


def margin_bounds(
    law: LawEvaluator, encounter: EncounterBounds, begin: float, end: float
) -> cython.int:
    """Bound distance − required: `near`, `far` of the encounter; `offset` is near the least."""
    law.require(encounter, begin, end)
    out: TaylorModel = law.out
    if begin == end:
        encounter.measure(begin - encounter.since, 0.0, 0.0, 0.0)
        encounter.near -= out.value
        encounter.far = encounter.near
        encounter.offset = begin
        return 0
    encounter.apart_over(begin, end, out.slope, out.curve)
    encounter.near = encounter.near - out.value - out.slack
    encounter.far = encounter.far - out.value + out.slack
    return 0


class MovingTest(IntervalTest):
    """The machine moves faster than `limit` m/s."""

    def __init__(self, limit: float) -> None:
        self.limit = limit

    def holds(self, encounter: EncounterBounds, begin: float, end: float) -> cython.int:
        half: float = (end - begin) / 2
        machine: Follower = encounter.machine
        machine.pace(begin - encounter.since + half, half)
        if machine.high <= self.limit:
            return 0
        return 1 if machine.low > self.limit else UNDECIDED


class ApproachingTest(IntervalTest):
    """The places of the two come closer to each other."""

    def holds(self, encounter: EncounterBounds, begin: float, end: float) -> cython.int:
        encounter.close_in(begin, end)
        if encounter.near >= 0.0:
            return 0
        return 1 if encounter.far < 0.0 else UNDECIDED


class ApartTest(IntervalTest):
    """The distance is at least `metres`."""

    def __init__(self, metres: float) -> None:
        self.metres = metres

    def holds(self, encounter: EncounterBounds, begin: float, end: float) -> cython.int:
        encounter.apart_over(begin, end, 0.0, 0.0)
        if encounter.far + encounter.slack / 2 < self.metres:
            return 0
        return 1 if encounter.near + encounter.slack >= self.metres else UNDECIDED


class OverlappingTest(IntervalTest):
    """Two rectangles that turn with the bodies overlap by more than `depth` metres.

    So they do if they overlap by as much along each normal of their sides: the separating axes of
    S. Gottschalk, M. C. Lin and D. Manocha ("OBBTree", 1996). `along` and `across` are half the
    length along its heading and half the width of the one that is in the person's place,
    `other_along` and `other_across` those of the other, all in metres.
    """

    def __init__(
        self,
        along: float,
        across: float,
        other_along: float,
        other_across: float,
        depth: float,
    ) -> None:
        self.along = along
        self.across = across
        self.other_along = other_along
        self.other_across = other_across
        self.depth = depth
        self.reach = sqrt(along * along + across * across)
        self.other_reach = sqrt(other_along * other_along + other_across * other_across)

    def holds(self, encounter: EncounterBounds, begin: float, end: float) -> cython.int:
        one: Follower = encounter.person
        other: Follower = encounter.machine
        half: float = (end - begin) / 2
        u: float = begin - encounter.since + half
        x2: float = encounter.x2
        x3: float = encounter.x3
        y2: float = encounter.y2
        y3: float = encounter.y3
        # About the middle, the other's place from the one, and its velocity; the terms of second
        # and third order are the accelerations (halved) and the jerks (a sixth).
        x: float = encounter.x0 + u * (encounter.x1 + u * (x2 + u * x3))
        y: float = encounter.y0 + u * (encounter.y1 + u * (y2 + u * y3))
        vx: float = encounter.x1 + u * (2 * x2 + u * 3 * x3)
        vy: float = encounter.y1 + u * (2 * y2 + u * 3 * y3)
        ax: float = x2 + 3 * x3 * u
        ay: float = y2 + 3 * y3 * u
        swing: float = turned(one, u, half)
        other_swing: float = turned(other, u, half)
        turn: float = one.r0 + u * (one.r1 + u * (one.r2 + u * one.r3))
        other_turn: float = other.r0 + u * (other.r1 + u * (other.r2 + u * other.r3))
        c: float = cos(turn)
        s: float = sin(turn)
        other_c: float = cos(other_turn)
        other_s: float = sin(other_turn)
        # How far apart they are at least throughout, and at most, along the best of the normals.
        low: float = -_INFINITE
        high: float = -_INFINITE
        normal: cython.Py_ssize_t
        for normal in range(4):
            nx: float = c if normal < 2 else other_c
            ny: float = s if normal < 2 else other_s
            if normal % 2:
                nx, ny = -ny, nx
            apart: float = abs(nx * x + ny * y)
            apart -= self.along * abs(nx * c + ny * s) + self.across * abs(ny * c - nx * s)
            apart -= self.other_along * abs(nx * other_c + ny * other_s)
            apart -= self.other_across * abs(ny * other_c - nx * other_s)
            moved: float = half * (
                abs(nx * vx + ny * vy)
                + half * (abs(nx * ax + ny * ay) + half * abs(nx * x3 + ny * y3))
            )
            low = max(low, apart - moved)
            high = max(high, apart + moved)
        # The normals of the least stay where they are while the corners turn.
        low -= self.reach * swing + self.other_reach * other_swing
        if low >= -self.depth - _SURE:
            return 0
        # Those of the most turn with the bodies, which are no farther from each other than this.
        if swing > 0.0 or other_swing > 0.0:
            away: float = sqrt(x * x + y * y) + half * sqrt(vx * vx + vy * vy)
            away += half * half * (sqrt(ax * ax + ay * ay) + half * sqrt(x3 * x3 + y3 * y3))
            high += (away + self.reach + self.other_reach) * (swing + other_swing)
        return 1 if high < -self.depth - _SURE / 2 else UNDECIDED


def turned(body: Follower, u: float, half: float) -> float:
    """Bound the angle by which a body turns within `half` seconds of `u`, from that at `u`."""
    rate: float = abs(body.r1 + u * (2 * body.r2 + u * 3 * body.r3))
    return half * (rate + half * (abs(body.r2 + 3 * body.r3 * u) + half * abs(body.r3)))


class NotTest(IntervalTest):
    """Another condition does not hold."""

    def __init__(self, other: IntervalTest) -> None:
        self.other = other

    def holds(self, encounter: EncounterBounds, begin: float, end: float) -> cython.int:
        verdict: cython.int = self.other.holds(encounter, begin, end)
        return verdict if verdict < 0 else 1 - verdict


class BothTest(IntervalTest):
    """Two conditions hold at once."""

    def __init__(self, first: IntervalTest, second: IntervalTest) -> None:
        self.first = first
        self.second = second

    def holds(self, encounter: EncounterBounds, begin: float, end: float) -> cython.int:
        one: cython.int = self.first.holds(encounter, begin, end)
        if one == 0:
            return 0
        other: cython.int = self.second.holds(encounter, begin, end)
        if other == 0:
            return 0
        return 1 if one == 1 and other == 1 else UNDECIDED


class CustomTest(IntervalTest):
    """A condition that is written in Python."""

    def __init__(self, condition: Any) -> None:
        self.condition = condition

    def holds(self, encounter: EncounterBounds, begin: float, end: float) -> cython.int:
        verdict = self.condition.holds(encounter, begin, end)
        if verdict is None:
            return UNDECIDED
        return 1 if verdict else 0


class ChangeSearch:
    """Finds the instants at which a condition begins and ceases to hold, one after another.

    Undecided intervals are halved, left half first, until they are no longer than `resolution`.
    """

    def __init__(
        self,
        judge: IntervalTest,
        encounter: EncounterBounds,
        begin: float,
        end: float,
        resolution: float,
    ) -> None:
        self.judge = judge
        self.encounter = encounter
        self.end = end
        self.resolution = resolution
        self.held = False
        self.over = False
        encounter.start(begin)

    def change(self) -> float | None:
        """Return the next instant at which the condition begins or ceases to hold, seconds."""
        if self.over:
            return None
        t: float = next_change(self.judge, self.encounter, self.end, self.resolution, self.held)
        if t == _INFINITE:
            self.over = True
            return self.end if self.held else None
        self.held = not self.held
        return t


def next_change(
    judge: IntervalTest,
    encounter: EncounterBounds,
    end: float,
    resolution: float,
    held: cython.bint,
) -> float:
    """Return the next instant at which a condition that was `held` or not changes; or infinity."""
    t: float
    upper: float
    holds: cython.int
    # Left halves come first, and stretches in turn, so what is found first is the earliest.
    while encounter.next_interval(end):
        t = encounter.lower
        upper = encounter.upper
        holds = judge.holds(encounter, t, upper)
        while holds < 0 and upper - t > resolution and encounter.halve():
            upper = encounter.upper
            holds = judge.holds(encounter, t, upper)
        if holds < 0:
            # Too short to cut: its two ends stand for it. What holds at neither, and for less
            # than the resolution, is let pass; `RESOLUTION` in `monitor` says so.
            holds = judge.holds(encounter, t, t)
            if holds != 1:
                holds = 0
                if judge.holds(encounter, upper, upper) == 1:
                    t = upper
                    holds = 1
        if (holds == 1) != held:
            return t
    return _INFINITE


def first_change(
    judge: IntervalTest,
    person: Numbers,
    machine: Numbers,
    begin: float,
    end: float,
    resolution: float,
) -> float | None:
    """Return the first instant at which a condition on places and speeds holds, or None."""
    encounter: EncounterBounds = EncounterBounds(person, machine, _NO_GAUGES, 0.0)
    encounter.start(begin)
    t: float = next_change(judge, encounter, end, resolution, False)
    return None if t == _INFINITE else t


def first_interval(
    judge: IntervalTest,
    person: Numbers,
    machine: Numbers,
    begin: float,
    end: float,
    resolution: float,
) -> tuple[float, float] | None:
    """Return the first interval in which a condition on places and speeds holds, or None."""
    encounter: EncounterBounds = EncounterBounds(person, machine, _NO_GAUGES, 0.0)
    watch: ChangeSearch = ChangeSearch(judge, encounter, begin, end, resolution)
    since = watch.change()
    if since is None:
        return None
    until = watch.change()
    assert until is not None  # what holds at the end ceases to hold there
    return since, until


def least(
    law: LawEvaluator | None, encounter: EncounterBounds, begin: float, end: float, tolerance: float
) -> tuple[float, float]:
    """Return the first instant at which distance − required is least (seconds), and how much.

    Without a law nothing is required. Exact to `tolerance` metres.
    """
    best: float = _INFINITE
    when: float = 0.0
    low: float
    high: float
    candidate: float
    k: cython.Py_ssize_t
    encounter.start(begin)
    while encounter.next_interval(end):
        # Branch and bound: what can't be better than the best so far by the tolerance is not
        # halved.
        while True:
            lower: float = encounter.lower
            upper: float = encounter.upper
            margin_over(law, encounter, lower, upper)
            low = encounter.near
            high = encounter.far
            candidate = encounter.offset
            if low >= best - tolerance:
                break
            # Only NaN differs from itself, and no comparison with it would ever end the search.
            if (low + high) != (low + high):
                raise ValueError(f"the law asks for no finite distance from {lower} s to {upper} s")
            for k in range(3):
                t: float = lower if k == 0 else candidate if k == 1 else upper
                margin_over(law, encounter, t, t)
                # The first of several that are equal but for rounding is kept.
                if encounter.near < best - 1e-12:
                    when = t
                    best = encounter.near
            if low >= best - tolerance or not encounter.halve():
                break
    return float(when), float(best)


def margin_over(
    law: LawEvaluator | None, encounter: EncounterBounds, begin: float, end: float
) -> cython.int:
    """See `margin_bounds`; without a law, bound the distance."""
    if law is None:
        return encounter.apart_over(begin, end, 0.0, 0.0)
    return margin_bounds(law, encounter, begin, end)
