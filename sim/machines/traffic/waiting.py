"""Who waits for whom, and circles of machines that wait for each other."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from ...core.entries import Pose

T = TypeVar("T")


@dataclass
class WaitForMachines(Generic[T]):
    """The poses for which a machine waits, who keeps it from them, and since when (s)."""

    ahead: Sequence[Sequence[Pose]]
    blockers: list[T]
    since: float
    looks: int = 0
    """Number of times that it has looked for another path."""


def circle_of(one: T, waits_for: Mapping[T, Sequence[T]]) -> tuple[T, ...]:
    """Return a shortest circle of machines that wait for each other with `one`, or none.

    Each of them waits for the next one, and the last for the first.
    """
    paths: list[tuple[T, ...]] = [(one,)]
    seen = {one}
    for path in paths:
        for other in waits_for.get(path[-1], ()):
            if other is one:
                return path
            if other not in seen:
                seen.add(other)
                paths.append((*path, other))
    return ()


def leads_to(one: T, circle: Collection[T], waits_for: Mapping[T, Sequence[T]]) -> bool:
    """Return whether one machine waits for one of a circle, directly or by others."""
    found = [one]
    for other in found:
        if other in circle:
            return True
        found += [next_one for next_one in waits_for.get(other, ()) if next_one not in found]
    return False
