"""Conditions on a person and a machine, decided over whole intervals of time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from .encounter import Encounter
from .kernels import watch as kernel
from .separation import AnyLaw, kernel_of, require_sense

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


@dataclass(frozen=True)
class TooClose:
    """The two are closer than `law` requires. `ValueError` if the law makes no sense."""

    law: AnyLaw

    def __post_init__(self) -> None:
        require_sense(self.law)

    def holds(self, encounter: Encounter, begin: float, end: float) -> bool | None:
        """See `Condition`."""
        return judge_of(self).verdict(encounter, begin, end)


@dataclass(frozen=True)
class Moving:
    """The machine moves faster than `STANDING_SPEED`."""

    def holds(self, encounter: Encounter, begin: float, end: float) -> bool | None:
        """See `Condition`."""
        return judge_of(self).verdict(encounter, begin, end)


@dataclass(frozen=True)
class Approaching:
    """The centres of the two come closer to each other."""

    def holds(self, encounter: Encounter, begin: float, end: float) -> bool | None:
        """See `Condition`."""
        return judge_of(self).verdict(encounter, begin, end)


@dataclass(frozen=True)
class Apart:
    """The distance between the two is at least `metres`."""

    metres: float

    def holds(self, encounter: Encounter, begin: float, end: float) -> bool | None:
        """See `Condition`."""
        return judge_of(self).verdict(encounter, begin, end)


@dataclass(frozen=True)
class Not:
    """The other condition does not hold."""

    condition: Condition

    def holds(self, encounter: Encounter, begin: float, end: float) -> bool | None:
        """See `Condition`."""
        return judge_of(self).verdict(encounter, begin, end)


@dataclass(frozen=True)
class Both:
    """Two conditions hold at once."""

    first: Condition
    second: Condition

    def holds(self, encounter: Encounter, begin: float, end: float) -> bool | None:
        """See `Condition`."""
        return judge_of(self).verdict(encounter, begin, end)


def judge_of(condition: Condition) -> kernel.Judge:
    """Return what decides about `condition` in the monitor."""
    match condition:
        case TooClose(law):
            return kernel.TooClose(kernel_of(law), ROUNDING)
        case Moving():
            return kernel.Faster(STANDING_SPEED)
        case Approaching():
            return kernel.Approaching()
        case Apart(metres):
            return kernel.Apart(metres)
        case Not(other):
            return kernel.Not(judge_of(other))
        case Both(first, second):
            return kernel.Both(judge_of(first), judge_of(second))
    return kernel.OwnJudge(condition)
