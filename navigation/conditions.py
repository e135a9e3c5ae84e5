"""Conditions on a person and a machine, decided over whole intervals of time."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from .encounter import Encounter
from .kernels import watch as kernel
from .separation import AnyLaw, is_of_speeds, kernel_of, require_sense
from .surfaces import Box

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


class _OfTheKernel:
    """A condition that the monitor's kernel decides."""

    def holds(self, encounter: Encounter, begin: float, end: float) -> bool | None:
        """See `Condition`."""
        return judge_of(self).verdict(encounter, begin, end)


@dataclass(frozen=True)
class TooClose(_OfTheKernel):
    """The two are closer than `law` requires. `ValueError` if the law makes no sense."""

    law: AnyLaw

    def __post_init__(self) -> None:
        require_sense(self.law)


@dataclass(frozen=True)
class Moving(_OfTheKernel):
    """The machine moves, which is faster than `speed` (m/s)."""

    speed: float = STANDING_SPEED


@dataclass(frozen=True)
class Approaching(_OfTheKernel):
    """The centres of the two come closer to each other."""


@dataclass(frozen=True)
class Apart(_OfTheKernel):
    """The distance between the two is at least `metres`."""

    metres: float


@dataclass(frozen=True)
class Overlapping(_OfTheKernel):
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
class Not(_OfTheKernel):
    """The other condition does not hold."""

    condition: Condition


@dataclass(frozen=True)
class Both(_OfTheKernel):
    """Two conditions hold at once."""

    first: Condition
    second: Condition


def kept_judge_of(condition: Condition) -> kernel.Judge | None:
    """Return what decided about a condition on places and speeds alone; None if it is not known."""
    kept: kernel.Judge | None = getattr(condition, _JUDGE, None)
    return kept


def judge_of(condition: Condition) -> kernel.Judge:
    """Return what decides about `condition` in the monitor."""
    known = kept_judge_of(condition)
    if known is not None:
        return known
    make = _JUDGES.get(type(condition))
    if make is None:
        return kernel.OwnJudge(condition)
    judge = make(condition)
    if _keeps_nothing(condition):
        vars(condition)[_JUDGE] = judge
    return judge


_JUDGE = "_judge"
"""Key under which a condition keeps what decides about it."""


def _overlapping(given: Overlapping) -> kernel.Judge:
    one, other = given.one, given.other
    # Boxes above each other overlap by nothing, however near they are along the floor.
    depth = given.depth if one.is_level_with(other) else math.inf
    return kernel.Overlapping(
        one.length / 2, one.width / 2, other.length / 2, other.width / 2, depth
    )


_JUDGES: dict[type, Callable[[Any], kernel.Judge]] = {
    TooClose: lambda given: kernel.TooClose(kernel_of(given.law), ROUNDING),
    Moving: lambda given: kernel.Faster(given.speed),
    Approaching: lambda given: kernel.Approaching(),
    Apart: lambda given: kernel.Apart(given.metres),
    Overlapping: _overlapping,
    Not: lambda given: kernel.Not(judge_of(given.condition)),
    Both: lambda given: kernel.Both(judge_of(given.first), judge_of(given.second)),
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
