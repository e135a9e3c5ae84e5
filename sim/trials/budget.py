"""Budget of a trial: the most of everything that one may ask for.

All is worked out from the figures of a trial, before any of it is made. What asks for more is a
slip, and would take hours or all memory.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from floorplan import Fault, Place

from ..core.numbers import times_until
from ..core.scenario import Scenario
from ..core.work import WorkTask
from ..machines.agv.moves import MOST_MOVES, number_of
from ..machines.kinds import moves_of

LONGEST = 31 * 86_400
"""Seconds. Longest duration of a trial: a month."""

MOST_PEOPLE = 5_000
"""People of a trial, those who come in later among them."""

MOST_PERSON_SECONDS = 100_000_000
"""Number of people times the duration (s). It bounds their visits, and what happens to them."""

MOST_TASKS = 100_000
"""Tasks in a trial, counted each time that they come again."""

MOST_JOBS = 100_000
"""Jobs in a trial of a gantry that only waits, again and again."""

MOST_REPORTS = 10_000_000
"""Times at which a rule set notifies people who are all in violation all the time."""


def people_fault(counts: Iterable[int]) -> tuple[int, str] | None:
    """Return which entry makes the people of a trial too many, and the message; None if none does.

    Parameters
    ----------
    counts : iterable of int
        Number of people of each entry.
    """
    total = 0
    for k, count in enumerate(counts):
        total += count
        if total > MOST_PEOPLE:
            return k, _message(total, MOST_PEOPLE, "people")
    return None


def budget_faults(trial: Scenario) -> Iterator[Fault]:
    """Yield what a trial asks for too much of. Nothing of it is made."""
    duration, count = trial.duration, len(trial.people)
    if duration > LONGEST:
        yield f"must be at most {LONGEST:,} s (31 days), not {duration:g} s", ("duration",)
        return
    if found := people_fault([1] * count):
        yield found[1], ("people",)
    seconds = count * duration
    yield from _over(seconds, MOST_PERSON_SECONDS, "seconds of all people", "duration")
    yield from _first_over(_tasks(trial), MOST_TASKS, "tasks")
    moves = ((number_of(given, duration), place) for place, given in moves_of(trial))
    yield from _first_over(moves, MOST_MOVES, "moves of AGVs")
    jobs, pause = trial.gantry.jobs, sum(job.seconds for job in trial.gantry.jobs)
    if trial.gantry.repeat and pause > 0 and all(job.kind == "wait" for job in jobs):
        yield from _over(len(jobs) * duration / pause, MOST_JOBS, "jobs", "gantry", "jobs")
    rules = trial.rules
    for every, *place in (
        (rules.report_every, "report_every"),
        (rules.notice.every, "notice", "every"),
    ):
        if every:
            yield from _over(seconds / every, MOST_REPORTS, "reports to people", "rules", *place)


def _over(number: float, most: int, what: str, *place: str | int) -> Iterator[Fault]:
    if number > most:
        yield _message(number, most, what), place


def _message(number: float, most: int, what: str) -> str:
    return f"{number:,.0f} {what} are more than the {most:,} that a trial may have"


def _first_over(counted: Iterable[tuple[float, Place]], most: int, what: str) -> Iterator[Fault]:
    """Yield the fault of the place whose number makes the sum of all so far too large."""
    total = 0.0
    for number, place in counted:
        total += number
        if total > most:
            yield _message(total, most, what), place
            return


def _tasks(trial: Scenario) -> Iterator[tuple[float, Place]]:
    """Yield how often each task is there, and its place in the trial."""
    for name, held in trial.work.items():
        workers = sum(name in person.work for person in trial.people)
        means = [max(task.duration.mean, 1e-9) for task in held.tasks]
        for k, task in enumerate(held.tasks):
            number, key = _times(task, trial.duration), "every"
            if held.repeat:
                # It is there again when it is done, and a person does one after the other.
                alone = trial.duration / means[k]
                number, key = min(alone, workers * trial.duration / min(means)), "duration"
            yield number, ("work", name, "tasks", k, key)
    for k, person in enumerate(trial.people):
        for key, tasks in (("schedule", person.schedule), ("breaks", person.breaks)):
            for n, task in enumerate(tasks):
                yield _times(task, trial.duration), ("people", k, key, n, "every")


def _times(task: WorkTask, end: float) -> float:
    """Return how often a task is there until `end` (seconds)."""
    times = times_until(end, task.time, task.every)
    return times if task.count is None else min(times, task.count)
