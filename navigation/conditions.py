"""Conditions on a person and a machine, decided over whole intervals of time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from .encounter import Encounter
from .odometer import Enclosure
from .separation import AnyLaw, is_of_speeds, require_sense, requirement

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
        law = self.law
        if not is_of_speeds(law):
            return _short_of(requirement(law, encounter, begin, end), encounter, begin, end)
        b = encounter.bounds(begin, end)
        most = law.distance(b.human_high, b.robot_high)
        # The second limit is below the first, so that rounding can't leave a tie undecided.
        if b.distance_low + encounter.rounding >= most:
            return False
        least = law.distance(b.human_low, b.robot_low)
        if b.distance_high + encounter.rounding / 2 < least:
            return True
        if not least <= most:
            raise ValueError(
                f"{law} requires {least} m at speeds of {b.human_low:g} and {b.robot_low:g} m/s,"
                f" but {most} m at {b.human_high:g} and {b.robot_high:g} m/s;"
                " a law must not ask for less when speeds grow"
            )
        return None


def _short_of(required: Enclosure, encounter: Encounter, begin: float, end: float) -> bool | None:
    """Return whether the distance is less than `required`."""
    low, high = margin_bounds(required, encounter, begin, end)[:2]
    if low >= -ROUNDING:
        return False
    if high < -ROUNDING / 2:
        return True
    if not low <= high:
        raise ValueError(f"a law requires {required} from t = {begin} s to {end} s")
    return None


def margin_bounds(
    required: Enclosure, encounter: Encounter, begin: float, end: float
) -> tuple[float, float, float]:
    """Return bounds on distance − required over an interval, and an instant near the least."""
    if begin == end:
        margin = encounter.distance(begin) - required.value
        return margin, margin, begin
    low, high, candidate = encounter.apart(begin, end, required.slope, required.curve)
    slack = required.slack
    return low - required.value - slack, high - required.value + slack, candidate


@dataclass(frozen=True)
class Moving:
    """The machine moves faster than `STANDING_SPEED`."""

    def holds(self, encounter: Encounter, begin: float, end: float) -> bool | None:
        """See `Condition`."""
        b = encounter.bounds(begin, end)
        if b.robot_high <= STANDING_SPEED:
            return False
        return True if b.robot_low > STANDING_SPEED else None


@dataclass(frozen=True)
class Approaching:
    """The centres of the two come closer to each other."""

    def holds(self, encounter: Encounter, begin: float, end: float) -> bool | None:
        """See `Condition`."""
        low, high = encounter.closing(begin, end)
        if low >= 0.0:
            return False
        return True if high < 0.0 else None


@dataclass(frozen=True)
class Apart:
    """The distance between the two is at least `metres`."""

    metres: float

    def holds(self, encounter: Encounter, begin: float, end: float) -> bool | None:
        """See `Condition`."""
        b = encounter.bounds(begin, end)
        if b.distance_high + encounter.rounding / 2 < self.metres:
            return False
        return True if b.distance_low + encounter.rounding >= self.metres else None


@dataclass(frozen=True)
class Not:
    """The other condition does not hold."""

    condition: Condition

    def holds(self, encounter: Encounter, begin: float, end: float) -> bool | None:
        """See `Condition`."""
        verdict = self.condition.holds(encounter, begin, end)
        return None if verdict is None else not verdict


@dataclass(frozen=True)
class Both:
    """Two conditions hold at once."""

    first: Condition
    second: Condition

    def holds(self, encounter: Encounter, begin: float, end: float) -> bool | None:
        """See `Condition`."""
        one = self.first.holds(encounter, begin, end)
        if one is False:
            return False
        other = self.second.holds(encounter, begin, end)
        if other is False:
            return False
        return True if one and other else None
