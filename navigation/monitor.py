"""The separation monitor: conditions on two motions, solved for in continuous time.

A condition on a person and a machine ("closer than the law requires") is judged on whole
intervals: it holds throughout, it holds nowhere, or it is undecided. Undecided intervals
are halved, left half first, until they are shorter than `RESOLUTION`. This is conservative
advancement (B. Mirtich, "Impulse-based Dynamic Simulation of Rigid Body Systems", 1996) on
bounds of speed and acceleration; its work grows with the changes of motion and the close
encounters, not with the time watched.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import inf
from typing import Any, Protocol

from floorplan.files.values import require

from .encounter import Box, Encounter, Shapes
from .kernels import lookout as kernel
from .kernels.watch import (
    ApartTest,
    ApproachingTest,
    BothTest,
    ChangeSearch,
    CustomTest,
    IntervalTest,
    MovingTest,
    NotTest,
    OverlappingTest,
    TooCloseTest,
    first_change as first_change_of,
    first_interval as first_interval_of,
    least,
)
from .motion import Motion
from .separation import AnyLaw, Scaled, is_of_motions, is_of_speeds, kernel_of, require_sense

STANDING_SPEED = 0.01
"""m/s. A machine that is no faster counts as standing where a rule asks for one that moves."""

ROUNDING = 1e-11
"""Metres. Laws that look ahead are not sure of less: being short by this is no violation."""


class Condition(Protocol):
    """A condition that may hold between a person and a machine."""

    def holds(self, encounter: Encounter, begin: float, end: float) -> bool | None:
        """Return whether it holds throughout the interval (True), nowhere in it (False), or None.

        At an instant (`begin` equals `end`) it must be decided.
        """
        ...


class _KernelCondition:
    """A condition that the monitor's kernel decides."""

    def holds(self, encounter: Encounter, begin: float, end: float) -> bool | None:
        """See `Condition`."""
        return judge_of(self).verdict(encounter, begin, end)

    def __invert__(self) -> Not:
        """Return the condition that this one does not hold."""
        return Not(self)

    def __and__(self, other: Condition) -> Both:
        """Return the condition that both hold at once."""
        return Both(self, other)

    def __rand__(self, other: Condition) -> Both:
        """Return the condition that both hold at once."""
        return Both(other, self)


@dataclass(frozen=True)
class TooClose(_KernelCondition):
    """The two are closer than `law` requires. `ValueError` if the law makes no sense."""

    law: AnyLaw

    def __post_init__(self) -> None:
        require_sense(self.law)


@dataclass(frozen=True)
class Moving(_KernelCondition):
    """The machine moves, which is faster than `speed` (m/s)."""

    speed: float = STANDING_SPEED


@dataclass(frozen=True)
class Approaching(_KernelCondition):
    """The centres of the two come closer to each other."""


@dataclass(frozen=True)
class Apart(_KernelCondition):
    """The distance between the two is at least `metres`."""

    metres: float


@dataclass(frozen=True)
class Overlapping(_KernelCondition):
    """The boxes of two bodies overlap by more than `depth` metres, along the floor.

    `one` turns with the first body and `other` with the second. They never do if one is above the
    other. `ValueError` for a depth below 0.
    """

    one: Box
    other: Box
    depth: float = 0.0

    def __post_init__(self) -> None:
        if not self.depth >= 0.0:
            raise ValueError(f"boxes can't overlap by more than {self.depth} m")


@dataclass(frozen=True)
class Not(_KernelCondition):
    """The other condition does not hold."""

    condition: Condition


@dataclass(frozen=True)
class Both(_KernelCondition):
    """Two conditions hold at once."""

    first: Condition
    second: Condition


def kept_judge_of(condition: Condition) -> IntervalTest | None:
    """Return what decided about a condition on places and speeds alone; None if it is not known."""
    kept: IntervalTest | None = getattr(condition, _JUDGE, None)
    return kept


def judge_of(condition: Condition) -> IntervalTest:
    """Return what decides about `condition` in the monitor."""
    known = kept_judge_of(condition)
    if known is not None:
        return known
    make = _JUDGES.get(type(condition))
    if make is None:
        return CustomTest(condition)
    judge = make(condition)
    if _keeps_nothing(condition):
        vars(condition)[_JUDGE] = judge
    return judge


_JUDGE = "_judge"
"""Key under which a condition keeps what decides about it."""


def _overlapping(given: Overlapping) -> IntervalTest:
    one, other = given.one, given.other
    # Boxes above each other overlap by nothing, however near they are along the floor.
    depth = given.depth if one.is_level_with(other) else math.inf
    return OverlappingTest(one.length / 2, one.width / 2, other.length / 2, other.width / 2, depth)


_JUDGES: dict[type, Callable[[Any], IntervalTest]] = {
    TooClose: lambda given: TooCloseTest(kernel_of(given.law), ROUNDING),
    Moving: lambda given: MovingTest(given.speed),
    Approaching: lambda given: ApproachingTest(),
    Apart: lambda given: ApartTest(given.metres),
    Overlapping: _overlapping,
    Not: lambda given: NotTest(judge_of(given.condition)),
    Both: lambda given: BothTest(judge_of(given.first), judge_of(given.second)),
}


def _keeps_nothing(condition: Condition) -> bool:
    """Return whether a judge of the condition may serve several searches at once.

    Those of laws that look at motions keep figures while they decide.
    """
    match condition:
        case TooClose(law):
            return is_of_speeds(law)
        case Not(other):
            return _keeps_nothing(other)
        case Both(first, second):
            return _keeps_nothing(first) and _keeps_nothing(second)
    return isinstance(condition, Moving | Approaching | Apart | Overlapping)


RESOLUTION = 1e-7
"""Seconds. Instants are found at least this exactly; nothing longer is missed."""

EXACT = 1e-9
"""Metres. Least distances and margins are this exact."""

PLAIN = 1e-6
"""Metres. Least margins are this exact with a law that only knows speeds."""


def when(
    condition: Condition,
    person: Motion,
    machine: Motion,
    begin: float,
    end: float,
    *,
    shapes: Shapes | None = None,
) -> Iterator[tuple[float, float]]:
    """Yield the maximal intervals between `begin` and `end` (seconds) in which `condition` holds.

    It is a condition on the motions of `person` and `machine`. Distances are taken between the
    centres on the floor, or between the surfaces of `shapes`.
    """
    watch = _watch(condition, person, machine, begin, end, shapes)
    while (since := watch.change()) is not None:
        until = watch.change()
        assert until is not None  # what holds at the end ceases to hold there
        yield since, until


def first_time(
    condition: Condition,
    person: Motion,
    machine: Motion,
    begin: float,
    end: float,
    *,
    shapes: Shapes | None = None,
) -> float | None:
    """The first instant between `begin` and `end` (seconds) at which `condition` holds, or None.

    `person`, `machine` and `shapes` are as in `when`.
    """
    judge = kept_judge_of(condition) if shapes is None else None
    if judge is not None and _makes_sense(person, machine, begin, end):
        one, other = person.table, machine.table
        return first_change_of(judge, one, other, float(begin), float(end), RESOLUTION)
    return _watch(condition, person, machine, begin, end, shapes).change()


def first_interval(
    condition: Condition, person: Motion, machine: Motion, begin: float, end: float
) -> tuple[float, float] | None:
    """Return the first of the intervals that `when` yields, None if there is none.

    `condition`, `person`, `machine`, `begin` and `end` are what they are there.
    """
    judge = kept_judge_of(condition)
    if judge is None or not _makes_sense(person, machine, begin, end):
        return next(when(condition, person, machine, begin, end), None)
    one, other = person.table, machine.table
    return first_interval_of(judge, one, other, float(begin), float(end), RESOLUTION)


def _makes_sense(person: Motion, machine: Motion, begin: float, end: float) -> bool:
    """Return whether these are motions, and a span; what is wrong is said by `_encounter`."""
    return person.__class__ is Motion is machine.__class__ and -inf < begin <= end < inf


def _watch(
    condition: Condition,
    person: Motion,
    machine: Motion,
    begin: float,
    end: float,
    shapes: Shapes | None,
) -> ChangeSearch:
    encounter = _encounter(person, machine, begin, end, shapes)
    return ChangeSearch(judge_of(condition), encounter, float(begin), float(end), RESOLUTION)


def _encounter(
    person: Motion, machine: Motion, begin: float, end: float, shapes: Shapes | None
) -> Encounter:
    require(person, Motion)
    require(machine, Motion)
    if not -inf < begin <= end < inf:
        raise ValueError(f"can't watch from {begin} s to {end} s")
    return Encounter(person, machine, () if shapes is None else shapes.gauges)


def first_violation(
    person: Motion,
    machine: Motion,
    law: AnyLaw,
    begin: float,
    end: float,
    *,
    shapes: Shapes | None = None,
) -> float | None:
    """The first instant in [begin, end] (seconds) at which the two are closer than `law` asks.

    The two are the motions of `person` and `machine`. Distances are taken between the centres on
    the floor, or between the surfaces of `shapes`. At most `RESOLUTION` late.
    None if there is none.
    """
    return first_time(TooClose(law), person, machine, begin, end, shapes=shapes)


def violations(
    person: Motion,
    machine: Motion,
    law: AnyLaw,
    begin: float,
    end: float,
    *,
    shapes: Shapes | None = None,
) -> list[tuple[float, float]]:
    """Return all intervals (begin, end) in seconds in which the two are closer than `law` asks.

    `person`, `machine`, `law` and `shapes` are as in `first_violation`; the intervals are cut at
    `begin` and `end`.
    """
    return list(when(TooClose(law), person, machine, begin, end, shapes=shapes))


def minimum_separation(
    person: Motion,
    machine: Motion,
    begin: float,
    end: float,
    *,
    shapes: Shapes | None = None,
) -> tuple[float, float]:
    """Return when `person` and `machine` are nearest from `begin` to `end`: (seconds, metres).

    Between the centres on the floor, or between the surfaces of `shapes`. The first of several
    such instants. The distance is exact to 1e-9 m.
    """
    encounter = _encounter(person, machine, begin, end, shapes)
    return least(None, encounter, float(begin), float(end), EXACT)


def minimum_margin(
    person: Motion,
    machine: Motion,
    law: AnyLaw,
    begin: float,
    end: float,
    *,
    shapes: Shapes | None = None,
) -> tuple[float, float]:
    """Return when distance − required distance is least, and that margin: (seconds, metres).

    Looked for from `begin` to `end`; `person`, `machine`, `law` and `shapes` are as in
    `first_violation`. Negative where the two are closer than `law` asks. Where the requirement
    jumps with a speed, both sides of the jump count. The first of several such instants. Exact to
    1e-9 m for every law that is a `MotionLaw`, to 1e-6 m for those that only know speeds.
    """
    require_sense(law)
    encounter = _encounter(person, machine, begin, end, shapes)
    judged = law
    # A scaled law is as exact as the one inside.
    while isinstance(judged, Scaled):
        judged = judged.law
    tolerance = EXACT if is_of_motions(judged) else PLAIN
    return least(kernel_of(law), encounter, float(begin), float(end), tolerance)


class StoppingHorizon(kernel.Lookout):
    """The test for a machine to which `law` applies; `margin` metres are kept in addition."""

    def __init__(self, law: AnyLaw, margin: float) -> None:
        super().__init__(kernel_of(law), margin, ROUNDING, RESOLUTION)
