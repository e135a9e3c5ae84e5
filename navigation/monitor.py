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

from floorplan import require

from .conditions import Condition, TooClose, margin_bounds
from .encounter import Encounter, encounters
from .motion import Motion
from .separation import AnyLaw, Scaled, is_of_motions, require_sense, requirement
from .surfaces import Shapes

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
    require(person, Motion)
    require(machine, Motion)
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
        return margin_bounds(requirement(law, encounter, begin, end), encounter, begin, end)

    judged = law
    while isinstance(judged, Scaled):
        judged = judged.law
    return _least(bounds, meetings, EXACT if is_of_motions(judged) else PLAIN)


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
