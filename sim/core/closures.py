"""Places that change in the course of a trial: doors, and obstacles that come and go."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from floorplan import Door, Floorplan, Obstacle

Interval = tuple[float, float]
"""From when to when, seconds; the end may be infinite."""


@dataclass(frozen=True)
class DoorTimes:
    """When a door is closed, or when it is open; it is the other one in between."""

    closed: tuple[Interval, ...] | None = None
    open: tuple[Interval, ...] | None = None

    @property
    def intervals(self) -> tuple[Interval, ...]:
        """The times that are given, whichever they are."""
        return (self.closed or ()) + (self.open or ())

    def is_open(self, t: float) -> bool:
        """Return whether the door is open at `t` (seconds)."""
        return (self.open is None) != _within(self.intervals, t)


@dataclass(frozen=True)
class TimedObstacle:
    """An obstacle that stands on the floor within the intervals of `there`."""

    obstacle: Obstacle
    there: tuple[Interval, ...]


@dataclass(frozen=True)
class Closures:
    """The obstacles of a trial that are not always there: closed doors, and what comes and goes."""

    plan: Floorplan
    doors: dict[str, DoorTimes]
    timed: tuple[TimedObstacle, ...]

    def at(self, t: float) -> dict[str, Obstacle]:
        """Return the obstacles that are there at `t` (seconds), by name."""
        shut = (door.closed for door in self.plan.doors if not self._is_open(door, t))
        there = (one.obstacle for one in self.timed if _within(one.there, t))
        return {one.name: one for one in (*shut, *there)}

    def changes(self, end: float) -> list[float]:
        """Return the instants from 0 to `end` (seconds) at which something may change."""
        given = [times.intervals for times in self.doors.values()]
        given += [one.there for one in self.timed]
        return sorted({t for t in _edges(given) if 0 < t < end})

    def _is_open(self, door: Door, t: float) -> bool:
        times = self.doors.get(door.name)
        return door.is_open if times is None else times.is_open(t)


def _within(intervals: Iterable[Interval], t: float) -> bool:
    return any(begin <= t < end for begin, end in intervals)


def _edges(given: Iterable[tuple[Interval, ...]]) -> Iterator[float]:
    return (t for intervals in given for interval in intervals for t in interval)
