"""Faults of people's work: places and lists that are not there, times that can't be."""

from __future__ import annotations

from collections.abc import Iterator

from floorplan import LARGEST, Fault, suggestion, time_fault

from ..core.scenario import PersonEntry, Scenario
from ..core.work import Instant, WorkTask, as_given


def list_faults(trial: Scenario) -> Iterator[Fault]:
    """Yield what can't be about the lists of `trial`."""
    taken = {name for person in trial.people for name in person.work}
    for name, held in trial.work.items():
        for k, task in enumerate(held.tasks):
            for message, key in _task_faults(task, trial):
                yield message, (name, "tasks", k, key)
        if not held.tasks:
            yield "has no tasks", (name,)
        if name not in taken:
            yield "nobody takes tasks from this list: name it in the work of a person", (name,)


def person_faults(person: PersonEntry, trial: Scenario) -> Iterator[Fault]:
    """Yield what can't be about the work of a person."""
    for k, name in enumerate(person.work):
        if name not in trial.work:
            hint = suggestion(name, trial.work) if trial.work else "the trial has none"
            yield f"no list of tasks is called {name!r}; {hint}", ("work", k)
    timed: list[tuple[float, float, str, int]] = []
    for key, tasks in (("schedule", person.schedule), ("breaks", person.breaks)):
        for k, task in enumerate(tasks):
            for message, field in _task_faults(task, trial):
                yield message, (key, k, field)
            if task.duration.kind == "fixed" and task.every is None:
                timed.append((task.time, task.time + task.duration.values[0], key, k))
    timed.sort()
    last = (0.0, 0.0, "", 0)
    for one in timed:
        (begin, _, key, number), (_, until, other, before) = one, last
        if begin < until:
            message = f"begins at {begin:g} s, before {other}[{before}] ends at {until:g} s"
            yield message, (key, number)
        if one[1] > until:
            last = one
    end = 0.0
    for k, (begin, until) in enumerate(person.shifts):
        if not 0 <= begin < until <= LARGEST:
            message = f"ends before it begins, or at once: {as_given(begin)} … {as_given(until)}"
            yield message, ("shifts", k)
        elif begin < end:
            message = f"begins at {as_given(begin)}, before the one in front of it ends"
            yield message, ("shifts", k)
        elif begin >= trial.duration:
            yield _too_late(begin, trial), ("shifts", k)
        end = until


def _task_faults(task: WorkTask, trial: Scenario) -> Iterator[tuple[str, str]]:
    """Yield what can't be about a task, with its key."""
    stations = [station.name for station in trial.floorplan.stations]
    if task.at not in stations:
        hint = suggestion(task.at, stations) if stations else "the floor has none"
        yield f"no station is called {task.at!r}; {hint}", "at"
    if fault := time_fault(task.time):
        yield fault, "time"
    elif task.time >= trial.duration:
        yield _too_late(task.time, trial), "time"
    values = task.duration.values
    if not values or not all(0 <= value <= LARGEST for value in values) or max(values) <= 0:
        yield f"must be seconds from 0 to {LARGEST:g}, not {values!r}", "duration"
    if task.every is not None and not 0 < task.every <= LARGEST:
        yield f"must be more than 0 s, not {task.every!r}", "every"


def _too_late(time: float, trial: Scenario) -> str:
    given = f" ({time.given})" if isinstance(time, Instant) else ""
    return f"is at {time:g} s{given} of the trial, which ends at {trial.duration:g} s"
