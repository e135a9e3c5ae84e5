"""States of machines in traffic, and the graph of machines that wait for each other."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Generic, TypeVar

from floorplan.files.dataclass import dataclass

from ...core.entries import Pose
from .areas import Part

T = TypeVar("T")


@dataclass(frozen=True)
class Driving:
    """State of a machine on its path to its goal, or at rest there."""


@dataclass(frozen=True)
class GivingWay:
    """State of a machine on its path to the passing place `aside`."""

    aside: Pose


@dataclass
class WaitingForMachines(Generic[T]):
    """State of a machine that is held until the area ahead is free.

    `ahead` is the next part of its motion, and `before` is the state to which it returns.
    """

    ahead: Part
    blockers: list[T]
    """Machines that claim a part of the area."""
    since: float
    """Begin of the wait, seconds."""
    before: Driving | GivingWay
    looks: int = 0
    """Number of searches for another path."""


def circle_of(machine: T, waits_for: Mapping[T, Sequence[T]]) -> tuple[T, ...]:
    """Return a shortest cycle through a machine in the wait-for graph, or an empty one.

    Each machine of the cycle waits for the next one, and the last for the first.
    """
    paths: list[tuple[T, ...]] = [(machine,)]
    visited = {machine}
    for path in paths:
        for other in waits_for.get(path[-1], ()):
            if other is machine:
                return path
            if other not in visited:
                visited.add(other)
                paths.append((*path, other))
    return ()


def leads_to(machine: T, circle: Collection[T], waits_for: Mapping[T, Sequence[T]]) -> bool:
    """Return whether a machine waits for a machine of a cycle, directly or through others."""
    reached = [machine]
    for other in reached:
        if other in circle:
            return True
        reached += [blocker for blocker in waits_for.get(other, ()) if blocker not in reached]
    return False
