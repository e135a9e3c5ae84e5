"""The separation monitor: approaches are solved for in continuous time, so none is stepped over.

A condition on a person and a machine ("closer than the law requires") is judged on whole
intervals: it holds throughout, it holds nowhere, or it is undecided. Undecided intervals
are halved, left half first, until they are shorter than `RESOLUTION`. This is conservative
advancement (B. Mirtich, "Impulse-based Dynamic Simulation of Rigid Body Systems", 1996) on
bounds of speed and acceleration; its work grows with the changes of motion and the close
encounters, not with the time watched.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import inf

from floorplan import require

from .conditions import Condition, TooClose, judge_of, kept_judge_of
from .encounter import Encounter
from .kernels import watch as kernel
from .motion import Motion
from .separation import AnyLaw, Scaled, is_of_motions, kernel_of, require_sense
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
        return kernel.first_change(judge, one, other, float(begin), float(end), RESOLUTION)
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
    return kernel.first_interval(judge, one, other, float(begin), float(end), RESOLUTION)


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
) -> kernel.Watch:
    encounter = _encounter(person, machine, begin, end, shapes)
    return kernel.Watch(judge_of(condition), encounter, float(begin), float(end), RESOLUTION)


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
    return kernel.least(None, encounter, float(begin), float(end), EXACT)


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
    return kernel.least(kernel_of(law), encounter, float(begin), float(end), tolerance)
