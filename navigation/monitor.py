"""When two bodies get too close: solved in continuous time, so that nothing is stepped over.

A condition on a person and a machine ("closer than the law requires") is judged on whole
intervals: it holds throughout, it holds nowhere, or it can't be told yet. Undecided intervals
are halved, left half first, until they are shorter than `RESOLUTION`. This is conservative
advancement (B. Mirtich, "Impulse-based Dynamic Simulation of Rigid Body Systems", 1996) on
bounds of speed and acceleration; its work grows with the changes of motion and the close
encounters, not with the time watched.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

from .encounter import Encounter, encounters
from .motion import Motion
from .separation import Law

RESOLUTION = 1e-7
"""Seconds. Instants are found at least this exactly; nothing longer is missed."""

STANDING_SPEED = 0.01
"""m/s. A machine that is no faster counts as standing where a rule asks for one that moves."""


class Condition(Protocol):
    """Something that may hold between a person and a machine."""

    def holds(self, encounter: Encounter, begin: float, end: float) -> bool | None:
        """Whether it holds throughout the interval, nowhere in it, or (None) can't be told.

        At an instant (`begin` equals `end`) it must be told.
        """
        ...


@dataclass(frozen=True)
class TooClose:
    """The distance between the centres is less than `law` requires."""

    law: Law

    def holds(self, encounter: Encounter, begin: float, end: float) -> bool | None:
        """See `Condition`."""
        b = encounter.bounds(begin, end)
        if b.distance_low >= self.law.distance(b.human_high, b.robot_high):
            return False
        if b.distance_high < self.law.distance(b.human_low, b.robot_low):
            return True
        return None


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
    """The two come closer to each other."""

    def holds(self, encounter: Encounter, begin: float, end: float) -> bool | None:
        """See `Condition`."""
        low, high = encounter.closing(begin, end)
        if low >= 0.0:
            return False
        return True if high < 0.0 else None


@dataclass(frozen=True)
class Apart:
    """The distance between the centres is at least `metres`."""

    metres: float

    def holds(self, encounter: Encounter, begin: float, end: float) -> bool | None:
        """See `Condition`."""
        b = encounter.bounds(begin, end)
        if b.distance_high < self.metres:
            return False
        return True if b.distance_low >= self.metres else None


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
    condition: Condition, person: Motion, machine: Motion, begin: float, end: float
) -> Iterator[tuple[float, float]]:
    """The maximal intervals between `begin` and `end` (seconds) in which `condition` holds."""
    since = begin
    for t, holds in _changes(condition, person, machine, begin, end):
        if holds:
            since = t
        else:
            yield since, t


def first_time(
    condition: Condition, person: Motion, machine: Motion, begin: float, end: float
) -> float | None:
    """The first instant between `begin` and `end` (seconds) at which `condition` holds."""
    for t, _ in _changes(condition, person, machine, begin, end):
        return t
    return None


def _changes(
    condition: Condition, person: Motion, machine: Motion, begin: float, end: float
) -> Iterator[tuple[float, bool]]:
    """The instants at which `condition` begins (True) and ceases (False) to hold, in turn."""
    _require_span(begin, end)
    held = False
    for encounter in encounters(person, machine, begin, end):
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
                yield t, held
    if held:
        yield end, False


def first_violation(
    person: Motion, machine: Motion, law: Law, begin: float, end: float
) -> float | None:
    """The first instant in [begin, end] (seconds) at which the two are closer than `law` asks.

    Distances are taken between the centres; at most `RESOLUTION` late. None if there is none.
    """
    return first_time(TooClose(law), person, machine, begin, end)


def violations(
    person: Motion, machine: Motion, law: Law, begin: float, end: float
) -> list[tuple[float, float]]:
    """All intervals (begin, end) in seconds in which the two are closer than `law` asks."""
    return list(when(TooClose(law), person, machine, begin, end))


def minimum_separation(
    person: Motion, machine: Motion, begin: float, end: float
) -> tuple[float, float]:
    """When the two are nearest, and how near: (seconds, metres between the centres).

    The first of several such instants. The distance is exact to 1e-9 m.
    """
    _require_span(begin, end)
    best = (begin, math.inf)
    for encounter in encounters(person, machine, begin, end):
        undecided = [(encounter.begin, encounter.end)]
        while undecided:
            lower, upper = undecided.pop()
            bound, candidate = encounter.nearest(lower, upper)
            if bound >= best[1] - 1e-9:
                continue
            candidate = min(max(candidate, lower), upper)
            for t in (lower, candidate, upper):
                distance = encounter.distance(t)
                if distance < best[1] - 1e-12:
                    best = (t, distance)
            middle = lower + (upper - lower) / 2
            if bound < best[1] - 1e-9 and lower < middle < upper:
                undecided += [(middle, upper), (lower, middle)]
    return best


def _require_span(begin: float, end: float) -> None:
    if not (math.isfinite(begin) and math.isfinite(end) and begin <= end):
        raise ValueError(f"can't watch from {begin} s to {end} s")
