"""Trials that last for another time than their file says."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

from ..core.closures import DoorTimes, Interval
from ..core.scenario import PersonEntry, Scenario

_Made = TypeVar("_Made", bound=Scenario)


def lasting(trial: _Made, seconds: float) -> _Made:
    """Return the trial with this duration; what would begin after its end is left out."""
    if seconds >= trial.duration:
        return replace(trial, duration=seconds, until_submitted=False)
    timed = ((one, _begun(one.there, seconds)) for one in trial.obstacles)
    return replace(
        trial,
        duration=seconds,
        until_submitted=False,
        people=tuple(_of_person(person, seconds) for person in trial.people),
        work={
            name: replace(held, tasks=tuple(task for task in held.tasks if task.time < seconds))
            for name, held in trial.work.items()
        },
        doors={name: _of_door(times, seconds) for name, times in trial.doors.items()},
        obstacles=tuple(replace(one, there=there) for one, there in timed if there),
    )


def _of_person(person: PersonEntry, end: float) -> PersonEntry:
    return replace(
        person,
        schedule=tuple(task for task in person.schedule if task.time < end),
        breaks=tuple(task for task in person.breaks if task.time < end),
        shifts=_begun(person.shifts, end),
    )


def _of_door(times: DoorTimes, end: float) -> DoorTimes:
    closed, opened = (
        None if given is None else _begun(given, end) for given in (times.closed, times.open)
    )
    return DoorTimes(closed, opened)


def _begun(intervals: tuple[Interval, ...], end: float) -> tuple[Interval, ...]:
    return tuple(one for one in intervals if one[0] < end)
