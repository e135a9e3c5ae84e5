"""The separation monitor: approaches are solved for in continuous time, so none is stepped over.

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
from typing import Protocol

from floorplan import require

from .encounter import Encounter, encounters
from .motion import Motion
from .odometer import Enclosure
from .separation import AnyLaw, MotionLaw, Scaled, is_of_speeds, require_sense, requirement
from .surfaces import Shapes

RESOLUTION = 1e-7
"""Seconds. Instants are found at least this exactly; nothing longer is missed."""

STANDING_SPEED = 0.01
"""m/s. A machine that is no faster counts as standing where a rule asks for one that moves."""

ROUNDING = 1e-11
"""Metres. Laws that look ahead are not sure of less: being short by this is no violation."""

EXACT = 1e-9
"""Metres. Least distances and margins are this exact."""

PLAIN = 1e-6
"""Metres. Least margins are this exact with a law that only knows speeds."""


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
    low, high = _margin(required, encounter, begin, end)[:2]
    if low >= -ROUNDING:
        return False
    if high < -ROUNDING / 2:
        return True
    if not low <= high:
        raise ValueError(f"a law requires {required} from t = {begin} s to {end} s")
    return None


def _margin(
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
    since = begin
    for t, holds in _changes(condition, _meetings(person, machine, begin, end, shapes)):
        if holds:
            since = t
        else:
            yield since, t


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
    for t, _ in _changes(condition, _meetings(person, machine, begin, end, shapes)):
        return t
    return None


def _meetings(
    person: Motion, machine: Motion, begin: float, end: float, shapes: Shapes | None
) -> Iterator[Encounter]:
    if not (math.isfinite(begin) and math.isfinite(end) and begin <= end):
        raise ValueError(f"can't watch from {begin} s to {end} s")
    make = Encounter if shapes is None else shapes.encounter
    return encounters(person, machine, begin, end, make)


def _changes(condition: Condition, meetings: Iterator[Encounter]) -> Iterator[tuple[float, bool]]:
    """Yield the instants at which `condition` begins (True) and ceases (False) to hold, in turn."""
    held = False
    for encounter in meetings:
        undecided = [(encounter.begin, encounter.end)]
        while undecided:
            lower, upper = undecided.pop()
            t = lower
            holds = condition.holds(encounter, lower, upper)
            if holds is None:
                middle = lower + (upper - lower) / 2
                if upper - lower > RESOLUTION and lower < middle < upper:
                    undecided += [(middle, upper), (lower, middle)]
                    continue
                holds = condition.holds(encounter, lower, lower) is True
                if not holds and condition.holds(encounter, upper, upper):
                    t, holds = upper, True
            if holds != held:
                held = holds
                yield float(t), held
    if held:
        yield float(encounter.end), False


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
    require(person, Motion)
    require(machine, Motion)
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
    require(person, Motion)
    require(machine, Motion)
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
    require(person, Motion)
    require(machine, Motion)
    return _least(Encounter.apart, _meetings(person, machine, begin, end, shapes), EXACT)


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
    meetings = _meetings(person, machine, begin, end, shapes)

    def bounds(encounter: Encounter, begin: float, end: float) -> tuple[float, float, float]:
        return _margin(requirement(law, encounter, begin, end), encounter, begin, end)

    judged = law
    while isinstance(judged, Scaled):
        judged = judged.law
    return _least(bounds, meetings, EXACT if isinstance(judged, MotionLaw) else PLAIN)


_Bounds = Callable[[Encounter, float, float], tuple[float, float, float]]
"""The least and the most of a figure over an interval, and an instant near the least."""


def _least(bounds: _Bounds, meetings: Iterator[Encounter], tolerance: float) -> tuple[float, float]:
    """Return the first instant at which a figure is least (seconds), and how much it is then."""
    best = (0.0, math.inf)
    for encounter in meetings:
        undecided = [(encounter.begin, encounter.end)]
        while undecided:
            lower, upper = undecided.pop()
            low, high, candidate = bounds(encounter, lower, upper)
            if low >= best[1] - tolerance:
                continue
            if math.isnan(low + high):
                raise ValueError(f"the law asks for no finite distance from {lower} s to {upper} s")
            for t in (lower, candidate, upper):
                figure = bounds(encounter, t, t)[0]
                if figure < best[1] - 1e-12:
                    best = (float(t), float(figure))
            middle = lower + (upper - lower) / 2
            if low < best[1] - tolerance and lower < middle < upper:
                undecided += [(middle, upper), (lower, middle)]
    return best
