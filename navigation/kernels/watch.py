"""Search for the times at which a condition on two motions begins and ceases to hold.

Intervals that a condition leaves undecided are halved: interval bisection (R. E. Moore, "Interval
Analysis", 1966). The least margin is found by branch and bound over the same intervals.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

if not cython.compiled:
    from math import cos, sin

    from .cubics import *
    from .encounter import Encounter
    from .laws import LawEvaluator, evaluator_of

UNDECIDED: cython.int = -1

STANDING_SPEED = 0.01
"""m/s. A machine that is no faster counts as standing where a rule asks for one that moves."""

_ROUNDING: float = 1e-11  # metres; smaller violations of predictive laws are rounding
_SURE: float = 1e-12  # metres; difference of two limits, so that a tie is always decided


class Condition(Protocol):
    """Interface of conditions on the motions of a person and a machine.

    Conditions combine as `~condition` and `condition & other`.
    """

    def holds(self, encounter: Encounter, begin: float, end: float) -> bool | None:
        """Evaluate the condition over an interval.

        Parameters
        ----------
        encounter : Encounter
            Bounds on the two motions.
        begin, end : float
            Interval within the encounter in seconds.

        Returns
        -------
        bool or None
            True if the condition holds throughout, False if it holds nowhere, None if undecided. It
            must be decided if `begin` equals `end`.
        """
        ...


class UprightBox(Protocol):
    """Interface of `navigation.Box`."""

    @property
    def length(self) -> float: ...
    @property
    def width(self) -> float: ...

    def is_level_with(self, other: Any) -> bool:
        """Return whether the heights of both boxes overlap."""
        ...


class KernelCondition:
    """Condition of the kernel. Conditions of one kind with the same values are equal."""

    __match_args__: tuple[str, ...] = ()

    def decide(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        """Return 1 if the condition holds throughout an interval, 0 if nowhere, -1 if undecided."""
        return 0

    def holds(self, encounter: Encounter, begin: float, end: float) -> bool | None:
        """See `Condition`."""
        decided: cython.int = self.decide(encounter, begin, end)
        return None if decided < 0 else decided == 1

    def __invert__(self) -> Not:
        """Return the condition that this one does not hold."""
        return Not(self)

    def __and__(self, other: Condition) -> Both:
        """Return the condition that both hold at once."""
        return Both(self, other)

    def __rand__(self, other: Condition) -> Both:
        """Return the condition that both hold at once."""
        return Both(other, self)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), tuple([getattr(self, name) for name in self.__match_args__])

    def __eq__(self, other: object) -> bool:
        return isinstance(other, KernelCondition) and self.__reduce__() == other.__reduce__()

    def __hash__(self) -> int:
        return hash(self.__reduce__())

    def __repr__(self) -> str:
        values = ", ".join([f"{name}={getattr(self, name)!r}" for name in self.__match_args__])
        return f"{type(self).__name__}({values})"


def in_kernel(condition: Condition) -> KernelCondition:
    """Return a condition as the kernel evaluates it."""
    if getattr(type(condition), "holds", None) is KernelCondition.holds:
        kernel: KernelCondition = condition  # type: ignore[assignment]
        return kernel
    return CustomCondition(condition)


class TooClose(KernelCondition):
    """Condition that the two are closer than a law requires.

    Parameters
    ----------
    law : Law or MotionLaw
        Law.

    Raises
    ------
    ValueError
        If the law has no method for it, or decreases with a speed.
    """

    __match_args__ = ("law",)

    def __init__(self, law: Any) -> None:
        self.law = law
        self.evaluator = evaluator_of(law)

    def decide(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        law: LawEvaluator = self.evaluator
        if not law.of_speeds:
            return self.short_of(encounter, begin, end)
        apart: Closest = encounter.closest(begin, end, 0.0, 0.0)
        human: Range = Range(0.0, 0.0)
        robot: Range = Range(0.0, 0.0)
        if not law.steady:
            human = encounter.person.speeds(begin, end)
            robot = encounter.machine.speeds(begin, end)
        highest: float = law.distance(human.high, robot.high)
        # The second limit is below the first, so that a tie is always decided.
        if apart.low + encounter.slack >= highest:
            return 0
        lowest: float = law.distance(human.low, robot.low)
        if apart.high + encounter.slack / 2 < lowest:
            return 1
        # Written so that NaN, for which all comparisons are false, is an error too.
        if not lowest <= highest:
            raise ValueError(
                f"{law.source} requires {lowest} m at speeds of {human.low:g} and"
                f" {robot.low:g} m/s, but {highest} m at {human.high:g} and {robot.high:g} m/s;"
                " a law must not ask for less when speeds grow"
            )
        return UNDECIDED

    def short_of(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        margin: Closest = margin_over(self.evaluator, encounter, begin, end)
        if margin.low >= -_ROUNDING:
            return 0
        if margin.high < -_ROUNDING / 2:
            return 1
        if not margin.low <= margin.high:
            required: TaylorModel = self.evaluator.require(encounter, begin, end)
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


class Moving(KernelCondition):
    """Condition that the machine moves.

    Parameters
    ----------
    speed : float, optional
        Minimum speed in m/s.
    reach : float, optional
        Distance in metres from the axis to a point that turns with the machine. The machine also
        moves while this point is faster than `speed` by turning. By default turning on the spot
        does not count.
    """

    __match_args__ = ("speed", "reach")

    def __init__(self, speed: float = STANDING_SPEED, reach: float = 0.0) -> None:
        self.speed = speed
        self.reach = reach

    def decide(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        speed: Range = encounter.machine.speeds(begin, end)
        low: float = speed.low
        high: float = speed.high
        if self.reach > 0.0:
            turning: Range = encounter.machine.turning(begin, end)
            low = max(low, turning.low * self.reach)
            high = max(high, turning.high * self.reach)
        if high <= self.speed:
            return 0
        return 1 if low > self.speed else UNDECIDED


class Approaching(KernelCondition):
    """Condition that the centres approach each other."""

    def decide(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        rate: Range = encounter.approach(begin, end)
        if rate.low >= 0.0:
            return 0
        return 1 if rate.high < 0.0 else UNDECIDED


class Apart(KernelCondition):
    """Condition that the two are apart.

    Parameters
    ----------
    metres : float
        Minimum distance in metres.
    """

    __match_args__ = ("metres",)

    def __init__(self, metres: float) -> None:
        self.metres = metres

    def decide(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        apart: Closest = encounter.closest(begin, end, 0.0, 0.0)
        if apart.high + encounter.slack / 2 < self.metres:
            return 0
        return 1 if apart.low + encounter.slack >= self.metres else UNDECIDED


class Overlapping(KernelCondition):
    """Condition that the boxes of two bodies overlap.

    Parameters
    ----------
    one, other : Box
        Boxes that turn with the first and the second body.
    depth : float, optional
        Minimum depth on the floor in metres. Boxes above each other do not overlap.

    Raises
    ------
    ValueError
        If `depth` is negative.

    Notes
    -----
    Rectangles overlap if they overlap by as much along each normal of their sides: the separating
    axes of S. Gottschalk, M. C. Lin and D. Manocha ("OBBTree", 1996).
    """

    __match_args__ = ("one", "other", "depth")

    def __init__(self, one: UprightBox, other: UprightBox, depth: float = 0.0) -> None:
        if not depth >= 0.0:
            raise ValueError(f"boxes can't overlap by more than {depth} m")
        self.one = one
        self.other = other
        self.depth = depth
        self.along = one.length / 2
        self.across = one.width / 2
        self.other_along = other.length / 2
        self.other_across = other.width / 2
        # Boxes at different heights never overlap.
        self.limit = depth if one.is_level_with(other) else INFINITY
        self.reach = norm(self.along, self.across)
        self.other_reach = norm(self.other_along, self.other_across)

    def decide(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        half: float = (end - begin) / 2
        u: float = begin - encounter.begin + half
        # Relative motion about the middle of the interval.
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
        # Bounds of the distance throughout the interval, along the best of the normals.
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
        # For the lower bound the normals are fixed while the corners turn.
        low -= self.reach * swing + self.other_reach * other_swing
        if low >= -self.limit - _SURE:
            return 0
        # For the upper bound the normals turn with the bodies, whose distance is at most `away`.
        if swing > 0.0 or other_swing > 0.0:
            away: float = norm(x.p, y.p) + half * norm(x.v, y.v) + deviation(x, y, half)
            high += (away + self.reach + self.other_reach) * (swing + other_swing)
        return 1 if high < -self.limit - _SURE / 2 else UNDECIDED


def swing_of(turn: Cubic, half: float) -> float:
    """Bound the angle by which a body turns within `half` seconds."""
    return gain(Cubic(0.0, abs(turn.v), abs(turn.a), abs(turn.j)), half)


class Not(KernelCondition):
    """Condition that another condition does not hold."""

    __match_args__ = ("condition",)

    def __init__(self, condition: Condition) -> None:
        self.condition = condition
        self.inner = in_kernel(condition)

    def decide(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        verdict: cython.int = self.inner.decide(encounter, begin, end)
        return verdict if verdict < 0 else 1 - verdict


class Both(KernelCondition):
    """Condition that two conditions hold."""

    __match_args__ = ("first", "second")

    def __init__(self, first: Condition, second: Condition) -> None:
        self.first = first
        self.second = second
        self.one = in_kernel(first)
        self.other = in_kernel(second)

    def decide(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        one: cython.int = self.one.decide(encounter, begin, end)
        if one == 0:
            return 0
        other: cython.int = self.other.decide(encounter, begin, end)
        if other == 0:
            return 0
        return 1 if one == 1 and other == 1 else UNDECIDED


class CustomCondition(KernelCondition):
    """A condition that is written in Python."""

    def __init__(self, condition: Any) -> None:
        self.condition = condition

    def decide(self, encounter: Encounter, begin: float, end: float) -> cython.int:
        verdict = self.condition.holds(encounter, begin, end)
        if verdict is None:
            return UNDECIDED
        return 1 if verdict else 0


class ChangeSearch:
    """Search for the times at which a condition begins and ceases to hold, in order.

    Undecided intervals are halved, left half first, until they are no longer than `resolution`.
    """

    def __init__(
        self,
        condition: KernelCondition,
        encounter: Encounter,
        begin: float,
        end: float,
        resolution: float,
    ) -> None:
        self.condition = condition
        self.encounter = encounter
        self.end = end
        self.resolution = resolution
        self.holding = False
        self.over = False
        encounter.come_to(begin)

    def change(self) -> float | None:
        """Return the next time (s) at which the condition begins or ceases to hold, or None."""
        if self.over:
            return None
        t: float = next_change(
            self.condition, self.encounter, self.end, self.resolution, self.holding
        )
        if t == INFINITY:
            self.over = True
            return self.end if self.holding else None
        self.holding = not self.holding
        return t


def next_change(
    condition: KernelCondition,
    encounter: Encounter,
    end: float,
    resolution: float,
    holding: cython.bint,
) -> float:
    """Return the next time at which a condition changes, or infinity. `holding`: its state now."""
    t: float
    upper: float
    holds: cython.int
    # Left halves come first, and stretches in order, so the first change is the earliest.
    while encounter.next_interval(end):
        t = encounter.lower
        upper = encounter.upper
        holds = condition.decide(encounter, t, upper)
        while holds < 0 and upper - t > resolution and encounter.halve():
            upper = encounter.upper
            holds = condition.decide(encounter, t, upper)
        if holds < 0:
            # Too short to divide, so both ends decide. A condition that holds only between them is
            # ignored: see `RESOLUTION` in `monitor`.
            holds = condition.decide(encounter, t, t)
            if holds != 1:
                holds = 0
                if condition.decide(encounter, upper, upper) == 1:
                    t = upper
                    holds = 1
        if (holds == 1) != holding:
            return t
    return INFINITY


def least(
    law: LawEvaluator | None,
    encounter: Encounter,
    spans: list[tuple[float, float]],
    tolerance: float,
) -> tuple[float, float]:
    """Return the time (s) of the minimum of distance − required in `spans`, and the minimum (m).

    Without a law it is that of the distance. The minimum is exact to `tolerance` metres.
    """
    best: float = INFINITY
    when: float = 0.0
    begin: float
    end: float
    k: cython.Py_ssize_t
    for begin, end in spans:
        encounter.come_to(begin)
        while encounter.next_interval(end):
            # Branch and bound: halve only intervals that may improve the best value.
            while True:
                lower: float = encounter.lower
                upper: float = encounter.upper
                margin: Closest = margin_over(law, encounter, lower, upper)
                if margin.low >= best - tolerance:
                    break
                # Only NaN differs from itself. Comparisons with it would never end the search.
                if (margin.low + margin.high) != (margin.low + margin.high):
                    raise ValueError(
                        f"the law asks for no finite distance from {lower} s to {upper} s"
                    )
                for k in range(3):
                    t: float = lower if k == 0 else margin.t if k == 1 else upper
                    at_once: Closest = margin_over(law, encounter, t, t)
                    # Among minima that differ only by rounding, the first counts.
                    if at_once.low < best - 1e-12:
                        when = t
                        best = at_once.low
                if margin.low >= best - tolerance or not encounter.halve():
                    break
    return float(when), float(best)
