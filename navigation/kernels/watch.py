"""Search for the times at which a condition on two motions begins and ceases to hold.

Intervals that a condition leaves undecided are halved: interval bisection (R. E. Moore, "Interval
Analysis", 1966). The least margin is found by branch and bound over the same intervals.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

if not cython.compiled:
    from math import cos, sin

    from .cubics import *
    from .encounter import Encounter
    from .laws import LawEvaluator

UNDECIDED: cython.int = -1

_SURE: float = 1e-12  # metres; so that rounding can't leave a tie undecided


class IntervalTest:
    """A condition on an encounter, decided over an interval: 1 holds, 0 does not, -1 undecided."""

    def holds(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        return 0

    def verdict(self, encounter: Encounter, begin: float, end: float) -> bool | None:
        """Return whether it holds throughout (True), nowhere (False), or None."""
        decided: cython.int = self.holds(encounter, begin, end)
        return None if decided < 0 else decided == 1


class TooCloseTest(IntervalTest):
    """The distance is less than `law` requires; laws that look ahead are sure of `rounding`."""

    def __init__(self, law: LawEvaluator, rounding: float) -> None:
        self.law = law
        self.rounding = rounding

    def holds(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        law: LawEvaluator = self.law
        if not law.of_speeds:
            return self.short_of(encounter, begin, end)
        apart: Closest = encounter.closest(begin, end, 0.0, 0.0)
        human: Range = Range(0.0, 0.0)
        robot: Range = Range(0.0, 0.0)
        if not law.steady:
            human = encounter.person.speeds(begin, end)
            robot = encounter.machine.speeds(begin, end)
        most: float = law.distance(human.high, robot.high)
        # The second limit is below the first, so that rounding can't leave a tie undecided.
        if apart.low + encounter.slack >= most:
            return 0
        least: float = law.distance(human.low, robot.low)
        if apart.high + encounter.slack / 2 < least:
            return 1
        # Written so that NaN, which compares with nothing, is refused as well.
        if not least <= most:
            raise ValueError(
                f"{law.source} requires {least} m at speeds of {human.low:g} and"
                f" {robot.low:g} m/s, but {most} m at {human.high:g} and {robot.high:g} m/s;"
                " a law must not ask for less when speeds grow"
            )
        return UNDECIDED

    def short_of(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        margin: Closest = margin_over(self.law, encounter, begin, end)
        if margin.low >= -self.rounding:
            return 0
        if margin.high < -self.rounding / 2:
            return 1
        if not margin.low <= margin.high:
            required: TaylorModel = self.law.require(encounter, begin, end)
            raise ValueError(f"a law requires {required.value} m from t = {begin} s to {end} s")
        return UNDECIDED


def margin_over(
    law: LawEvaluator | None, encounter: Encounter, begin: float, end: float
) -> Closest:
    """Bound distance − required, or the distance without a law."""
    if law is None:
        return encounter.closest(begin, end, 0.0, 0.0)
    required: TaylorModel = law.require(encounter, begin, end)
    apart: Closest
    if begin == end:
        apart = encounter.closest(begin, begin, 0.0, 0.0)
        return Closest(apart.low - required.value, apart.low - required.value, begin)
    apart = encounter.closest(begin, end, required.slope, required.curve)
    return Closest(
        apart.low - required.value - required.slack,
        apart.high - required.value + required.slack,
        apart.t,
    )


class MovingTest(IntervalTest):
    """The machine moves faster than `limit` m/s: its axis, or what turns `reach` metres from it."""

    def __init__(self, limit: float, reach: float) -> None:
        self.limit = limit
        self.reach = reach

    def holds(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        speed: Range = encounter.machine.speeds(begin, end)
        low: float = speed.low
        high: float = speed.high
        if self.reach > 0.0:
            turning: Range = encounter.machine.turning(begin, end)
            low = max(low, turning.low * self.reach)
            high = max(high, turning.high * self.reach)
        if high <= self.limit:
            return 0
        return 1 if low > self.limit else UNDECIDED


class ApproachingTest(IntervalTest):
    """The places of the two come closer to each other."""

    def holds(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        rate: Range = encounter.approach(begin, end)
        if rate.low >= 0.0:
            return 0
        return 1 if rate.high < 0.0 else UNDECIDED


class ApartTest(IntervalTest):
    """The distance is at least `metres`."""

    def __init__(self, metres: float) -> None:
        self.metres = metres

    def holds(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        apart: Closest = encounter.closest(begin, end, 0.0, 0.0)
        if apart.high + encounter.slack / 2 < self.metres:
            return 0
        return 1 if apart.low + encounter.slack >= self.metres else UNDECIDED


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
        self.reach = norm(along, across)
        self.other_reach = norm(other_along, other_across)

    def holds(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        half: float = (end - begin) / 2
        u: float = begin - encounter.begin + half
        # About the middle, the other's place from the one, its velocity, half its acceleration and
        # a sixth of its jerk.
        x: Cubic = shift(encounter.x, u)
        y: Cubic = shift(encounter.y, u)
        turn: Cubic = shift(encounter.person.rotation, u)
        other_turn: Cubic = shift(encounter.machine.rotation, u)
        swing: float = swing_of(turn, half)
        other_swing: float = swing_of(other_turn, half)
        c: float = cos(turn.p)
        s: float = sin(turn.p)
        other_c: float = cos(other_turn.p)
        other_s: float = sin(other_turn.p)
        # How far apart they are at least throughout, and at most, along the best of the normals.
        low: float = -INFINITY
        high: float = -INFINITY
        normal: cython.Py_ssize_t
        for normal in range(4):
            nx: float = c if normal < 2 else other_c
            ny: float = s if normal < 2 else other_s
            if normal % 2:
                nx, ny = -ny, nx
            apart: float = abs(nx * x.p + ny * y.p)
            apart -= self.along * abs(nx * c + ny * s) + self.across * abs(ny * c - nx * s)
            apart -= self.other_along * abs(nx * other_c + ny * other_s)
            apart -= self.other_across * abs(ny * other_c - nx * other_s)
            moved: float = half * (
                abs(nx * x.v + ny * y.v)
                + half * (abs(nx * x.a + ny * y.a) + half * abs(nx * x.j + ny * y.j))
            )
            low = max(low, apart - moved)
            high = max(high, apart + moved)
        # The normals of the least stay where they are while the corners turn.
        low -= self.reach * swing + self.other_reach * other_swing
        if low >= -self.depth - _SURE:
            return 0
        # Those of the most turn with the bodies, which are no farther from each other than this.
        if swing > 0.0 or other_swing > 0.0:
            away: float = norm(x.p, y.p) + half * norm(x.v, y.v) + deviation(x, y, half)
            high += (away + self.reach + self.other_reach) * (swing + other_swing)
        return 1 if high < -self.depth - _SURE / 2 else UNDECIDED


def swing_of(turn: Cubic, half: float) -> float:
    """Bound the angle by which a body turns within `half` seconds, from that at 0."""
    return gain(Cubic(0.0, abs(turn.v), abs(turn.a), abs(turn.j)), half)


class NotTest(IntervalTest):
    """Another condition does not hold."""

    def __init__(self, other: IntervalTest) -> None:
        self.other = other

    def holds(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        verdict: cython.int = self.other.holds(encounter, begin, end)
        return verdict if verdict < 0 else 1 - verdict


class BothTest(IntervalTest):
    """Two conditions hold at once."""

    def __init__(self, first: IntervalTest, second: IntervalTest) -> None:
        self.first = first
        self.second = second

    def holds(self, encounter: Encounter, begin: float, end: float) -> cython.int:
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

    def holds(self, encounter: Encounter, begin: float, end: float) -> cython.int:
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
        encounter: Encounter,
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
        encounter.come_to(begin)

    def change(self) -> float | None:
        """Return the next instant at which the condition begins or ceases to hold, seconds."""
        if self.over:
            return None
        t: float = next_change(self.judge, self.encounter, self.end, self.resolution, self.held)
        if t == INFINITY:
            self.over = True
            return self.end if self.held else None
        self.held = not self.held
        return t


def next_change(
    judge: IntervalTest,
    encounter: Encounter,
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
    return INFINITY


def least(
    law: LawEvaluator | None, encounter: Encounter, begin: float, end: float, tolerance: float
) -> tuple[float, float]:
    """Return the first instant at which distance − required is least (seconds), and how much.

    Without a law nothing is required. Exact to `tolerance` metres.
    """
    best: float = INFINITY
    when: float = 0.0
    k: cython.Py_ssize_t
    encounter.come_to(begin)
    while encounter.next_interval(end):
        # Branch and bound: what can't be better than the best so far by the tolerance is not
        # halved.
        while True:
            lower: float = encounter.lower
            upper: float = encounter.upper
            margin: Closest = margin_over(law, encounter, lower, upper)
            if margin.low >= best - tolerance:
                break
            # Only NaN differs from itself, and no comparison with it would ever end the search.
            if (margin.low + margin.high) != (margin.low + margin.high):
                raise ValueError(f"the law asks for no finite distance from {lower} s to {upper} s")
            for k in range(3):
                t: float = lower if k == 0 else margin.t if k == 1 else upper
                at_once: Closest = margin_over(law, encounter, t, t)
                # The first of several that are equal but for rounding is kept.
                if at_once.low < best - 1e-12:
                    when = t
                    best = at_once.low
            if margin.low >= best - tolerance or not encounter.halve():
                break
    return float(when), float(best)
