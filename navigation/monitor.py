"""Separation monitor: conditions on two motions, solved for in continuous time.

A condition on a person and a machine ("closer than the law requires") is evaluated on intervals. It
holds throughout, it holds nowhere, or it is undecided. Undecided intervals are halved, left half
first, until they are shorter than `RESOLUTION`. This is conservative advancement (B. Mirtich,
"Impulse-based Dynamic Simulation of Rigid Body Systems", 1996) on bounds of speed and acceleration.
Its cost grows with the changes of motion and the close encounters, not with the duration.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import inf

from floorplan.files.values import require

from .encounter import Shapes
from .kernels import lookout as kernel
from .kernels.encounter import Encounter
from .kernels.laws import evaluator_of
from .kernels.watch import ChangeSearch, Condition, TooClose, in_kernel, least
from .motion import Motion
from .separation import AnyLaw, Scaled, is_of_motions

RESOLUTION = 1e-7
"""Maximum error of times in seconds. No longer interval is missed."""

EXACT = 1e-9
"""Maximum error of minimum distances and margins in metres."""

PLAIN = 1e-6
"""Maximum error of minimum margins for a law of speeds alone, in metres."""


def when(
    condition: Condition,
    person: Motion,
    machine: Motion,
    begin: float,
    end: float,
    *,
    shapes: Shapes | None = None,
) -> Iterator[tuple[float, float]]:
    """Yield the maximal intervals in which a condition holds.

    Parameters
    ----------
    condition : Condition
        Condition on the two motions.
    person, machine : Motion
        Motions of the two bodies.
    begin, end : float
        Time span in seconds.
    shapes : Shapes, optional
        Solids between whose surfaces distances are measured. By default distances are between
        centres on the floor.

    Yields
    ------
    tuple of float
        Begin and end of an interval in seconds, within the time span.

    Raises
    ------
    TypeError
        If `person` or `machine` is no `Motion`.
    ValueError
        If the time span is invalid.
    """
    _check(person, machine, begin, end)
    watch = search(condition, person, machine, begin, end, shapes)
    while (since := watch.change()) is not None:
        until = watch.change()
        assert until is not None  # a condition that holds at the end ceases to hold there
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
    """Return the first time at which a condition holds.

    Parameters
    ----------
    condition, person, machine, begin, end, shapes
        See `when`.

    Returns
    -------
    float or None
        Time in seconds, at most 1e-7 s late.

    Raises
    ------
    TypeError, ValueError
        See `when`.
    """
    _check(person, machine, begin, end)
    return search(condition, person, machine, begin, end, shapes).change()


def search(
    condition: Condition,
    person: Motion,
    machine: Motion,
    begin: float,
    end: float,
    shapes: Shapes | None,
) -> ChangeSearch:
    """Return the search for changes of a condition, without checks: see `when`."""
    encounter = Encounter(person, machine, () if shapes is None else shapes.gauges)
    return ChangeSearch(in_kernel(condition), encounter, float(begin), float(end), RESOLUTION)


def _check(person: Motion, machine: Motion, begin: float, end: float) -> None:
    require(person, Motion)
    require(machine, Motion)
    if not -inf < begin <= end < inf:
        raise ValueError(f"can't watch from {begin} s to {end} s")


def first_violation(
    person: Motion,
    machine: Motion,
    law: AnyLaw,
    begin: float,
    end: float,
    *,
    shapes: Shapes | None = None,
) -> float | None:
    """Return the first time at which two motions are closer than a law requires.

    Parameters
    ----------
    person, machine : Motion
        Motions of the two bodies.
    law : Law or MotionLaw
        Law.
    begin, end : float
        Time span in seconds.
    shapes : Shapes, optional
        See `when`.

    Returns
    -------
    float or None
        Time in seconds, at most 1e-7 s late.

    Raises
    ------
    TypeError
        If `person` or `machine` is no `Motion`.
    ValueError
        If the time span or the law is invalid.

    Examples
    --------
    >>> from navigation import SeparationLaw, first_violation, gantry_move, walk
    >>> person = walk([(0.0, 0.0), (10.0, 0.0)])
    >>> gantry = gantry_move((12.0, 0.0, 0.0), (8.0, 0.0, 0.0))
    >>> law = SeparationLaw(t1=1.0, t2=1.5, stopping=0.0, intrusion=1.0)
    >>> round(first_violation(person, gantry, law, 0.0, 60.0), 3)
    4.538
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
    """Return all intervals in which two motions are closer than a law requires.

    Parameters
    ----------
    person, machine, law, begin, end, shapes
        See `first_violation`.

    Returns
    -------
    list of tuple of float
        Begin and end of each interval in seconds, within the time span.

    Raises
    ------
    TypeError, ValueError
        See `first_violation`.
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
    """Return when two motions are closest.

    Parameters
    ----------
    person, machine, begin, end, shapes
        See `first_violation`.

    Returns
    -------
    tuple of float
        Time in seconds, the first of several, and distance in metres. The distance is exact to
        1e-9 m.

    Raises
    ------
    TypeError, ValueError
        See `first_violation`.
    """
    return least_over(None, person, machine, [(begin, end)], shapes)


def minimum_margin(
    person: Motion,
    machine: Motion,
    law: AnyLaw,
    begin: float,
    end: float,
    *,
    shapes: Shapes | None = None,
) -> tuple[float, float]:
    """Return when distance minus required distance is minimal.

    Parameters
    ----------
    person, machine, law, begin, end, shapes
        See `first_violation`.

    Returns
    -------
    tuple of float
        Time in seconds, the first of several, and margin in metres. The margin is negative during a
        violation. If the requirement jumps with a speed, both sides of the jump count. The margin
        is exact to 1e-9 m for a `MotionLaw`, and to 1e-6 m for other laws.

    Raises
    ------
    TypeError, ValueError
        See `first_violation`.
    """
    return least_over(law, person, machine, [(begin, end)], shapes)


def least_over(
    law: AnyLaw | None,
    person: Motion,
    machine: Motion,
    spans: Sequence[tuple[float, float]],
    shapes: Shapes | None,
) -> tuple[float, float]:
    """Return `minimum_margin` over several time spans, or `minimum_separation` without a law."""
    for begin, end in spans:
        _check(person, machine, begin, end)
    encounter = Encounter(person, machine, () if shapes is None else shapes.gauges)
    times = [(float(begin), float(end)) for begin, end in spans]
    if law is None:
        return least(None, encounter, times, EXACT)
    inner = law
    # A scaled law is as exact as its inner law.
    while isinstance(inner, Scaled):
        inner = inner.law
    return least(evaluator_of(law), encounter, times, EXACT if is_of_motions(inner) else PLAIN)


class StoppingHorizon(kernel.Lookout):
    """Stopping test for a machine with a `law` and an additional `margin` in metres.

    Distances are between centres on the floor, or between the surfaces of `shapes`.
    """

    def __init__(self, law: AnyLaw, margin: float, shapes: Shapes | None = None) -> None:
        gauges = [] if shapes is None else [*shapes.gauges]
        super().__init__(evaluator_of(law), margin, RESOLUTION, gauges)
