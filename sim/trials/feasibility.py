"""Feasibility of a trial: budget, doors and obstacles, commands, and work.

The budget is computed from the numbers in a trial before anything is created, because exceeding it
would take hours or all memory.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

from shapely.geometry import Point

from floorplan import UserError
from floorplan.checks import height_fault, polygon_fault
from floorplan.files.fields import LARGEST
from floorplan.files.problems import Fault, Place, suggestion

from ..core.entries import COMMANDS, Command
from ..core.scenario import PersonEntry, Scenario, spot
from ..core.schedule import ClockTime, Interval, WorkTask, as_given, times_until
from ..core.stage import Closures
from ..machines.agv.model import MOST_MOVES, number_of
from ..machines.kinds import kind_of, moves_of
from ..machines.outside import call_fault, method_fault
from ..people.person import Person
from .names import checked_name, machines, people, stations

LONGEST = 31 * 86_400
"""Seconds. Longest duration of a trial, 31 days."""

MOST_PEOPLE = 5_000
"""Maximum number of people, including those who enter later."""

MOST_PERSON_SECONDS = 100_000_000
"""Maximum number of people times the duration (s). It limits the number of events."""

MOST_TASKS = 100_000
"""Maximum number of tasks, counted with each repetition."""

MOST_JOBS = 100_000
"""Maximum number of jobs of a gantry that only waits repeatedly."""

MOST_REPORTS = 10_000_000
"""Maximum number of notifications if all people violate the rules all the time."""


def people_fault(counts: Iterable[int]) -> tuple[int, str] | None:
    """Return the first entry with which there are too many people, and the message, or None.

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
    """Yield the values of a trial that exceed the budget."""
    duration, count = trial.duration, len(trial.people)
    if duration > LONGEST:
        yield f"must be at most {LONGEST:,} s (31 days), not {duration:g} s", ("duration",)
        return
    if fault := people_fault([1] * count):
        yield fault[1], ("people",)
    seconds = count * duration
    yield from _over(seconds, MOST_PERSON_SECONDS, "seconds of all people", "duration")
    yield from _first_over(_tasks(trial), MOST_TASKS, "tasks")
    moves = ((number_of(entries, duration), place) for place, entries in moves_of(trial))
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
    """Yield a fault at the first place at which the sum exceeds a limit."""
    total = 0.0
    for number, place in counted:
        total += number
        if total > most:
            yield _message(total, most, what), place
            return


def _tasks(trial: Scenario) -> Iterator[tuple[float, Place]]:
    """Yield how often each task is offered, and its place in the trial."""
    for name, work_list in trial.work.items():
        workers = sum(name in person.work for person in trial.people)
        means = [max(task.duration.mean, 1e-9) for task in work_list.tasks]
        for k, task in enumerate(work_list.tasks):
            number, key = _times(task, trial.duration), "every"
            if work_list.repeat:
                # It is offered again when it is done, and each person does one task at a time.
                alone = trial.duration / means[k]
                number, key = min(alone, workers * trial.duration / min(means)), "duration"
            yield number, ("work", name, "tasks", k, key)
    for k, person in enumerate(trial.people):
        for key, tasks in (("schedule", person.schedule), ("breaks", person.breaks)):
            for n, task in enumerate(tasks):
                yield _times(task, trial.duration), ("people", k, key, n, "every")


def _times(task: WorkTask, end: float) -> float:
    """Return how often a task is offered until `end` (s)."""
    times = times_until(end, task.time, task.every)
    return times if task.count is None else min(times, task.count)


def door_faults(trial: Scenario) -> Iterator[Fault]:
    """Yield the faults of the times of doors."""
    doors = [door.name for door in trial.floorplan.doors]
    for name, times in trial.doors.items():
        if name not in doors:
            hint = suggestion(name, doors) if doors else "the floor has none"
            yield f"no door is called {name!r}; {hint}", (name,)
        if (times.closed is None) == (times.open is None):
            yield "must have the times at which it is closed, or open", (name,)
        for key, spans in (("closed", times.closed), ("open", times.open)):
            for message, k in _interval_faults(spans or (), trial):
                yield message, (name, key, k)


def obstacle_faults(trial: Scenario) -> Iterator[Fault]:
    """Yield the faults of temporary obstacles."""
    taken = names_taken(trial)
    for timed in trial.obstacles:
        one = timed.obstacle
        if one.name in taken:
            yield f"something else is called {one.name!r} already", (one.name,)
        taken.add(one.name)
        if fault := polygon_fault(one.footprint):
            yield fault, (one.name,)
        if fault := height_fault(one):
            yield fault, (one.name, "z")
        for message, k in _interval_faults(timed.there, trial):
            yield message, (one.name, "there", k)


def names_taken(trial: Scenario) -> set[str]:
    """Return the names that temporary obstacles cannot have."""
    plan = trial.floorplan
    fixed = (plan.obstacles, plan.lanes, plan.doors, plan.zones, plan.gates)
    taken = {"boundary", *trial.machines, *(one.name for kind in fixed for one in kind)}
    return taken | {person.name for person in trial.people}


def _interval_faults(spans: Sequence[Interval], trial: Scenario) -> Iterator[tuple[str, int]]:
    end = 0.0
    for k, (begin, until) in enumerate(spans):
        if not 0 <= begin < until or (until > LARGEST and until != math.inf):
            text = f"{as_given(begin)} … {as_given(until)}"
            yield f"ends before it begins, or at once: {text}", k
        elif begin < end:
            text = f"begins at {as_given(begin)}, before the previous one ends at"
            yield f"{text} {as_given(end)}", k
        elif begin >= trial.duration:
            yield f"begins at {begin:g} s of the trial, which ends at {trial.duration:g} s", k
        end = until


def closed_place_faults(trial: Scenario) -> Iterator[Fault]:
    """Yield the people who start in closed doors or temporary obstacles."""
    plan = trial.floorplan
    height = plan.human.height
    there = Closures(plan, trial.doors, trial.obstacles).at(0.0).values()
    for k, person in enumerate(trial.people):
        place = person.place_on(plan)
        if place is None or person.recorded is not None:
            continue
        at = Point(place)
        radius = person.radius or plan.human.radius
        for one in there:
            if one.overlaps(0.0, height) and one.footprint.distance(at) < radius:
                yield f"{place} is in {one.name}, which is there then", ("people", k, "at")


def command_faults(trial: Scenario) -> Iterator[Fault]:
    """Yield the faults of the commands of a trial."""
    placed: set[str] = set()
    before = 0.0
    for k, command in enumerate(trial.commands):
        if command.time is None:
            yield "give a time", (k, "time")
        elif command.time < before:
            yield f"comes before the previous command, at {before:g} s", (k, "time")
        before = max(before, command.time or 0.0)
        if sum(getattr(command, name) is not None for name in (*COMMANDS, "call")) != 1:
            yield f"must be one of {', '.join(COMMANDS)}; or a call", (k,)
        for message, key in _faults(command, trial, placed):
            yield message, (k, key)
        if command.block is not None:
            placed.add(command.block.name)
        placed.discard(command.clear or "")


def _faults(command: Command, trial: Scenario, placed: set[str]) -> Iterator[tuple[str, str]]:
    """Yield the faults of a command with their keys. `placed` are the names of added obstacles."""
    names_by_key = {
        **dict.fromkeys(("send", "person"), people(trial)),
        **dict.fromkeys(("hold", "release", "machine"), machines(trial)),
    }
    for key, names in names_by_key.items():
        if (name := getattr(command, key)) is not None:
            try:
                checked_name(name, "person" if key in ("send", "person") else "machine", names)
            except UserError as why:
                yield str(why), key
    if (command.send is None) != (command.to is None):
        yield "a person is sent to a place: [x, y], or the name of a station or a door", "to"
    elif any(one.name == command.send and one.recorded is not None for one in trial.people):
        yield f"{command.send} walks as measured and cannot be sent", "send"
    elif command.to is not None:
        yield from ((message, "to") for message in _place_faults(command, trial))
    if (one := command.block) is not None:
        if one.name in names_taken(trial) | placed or any(
            one.name == timed.obstacle.name for timed in trial.obstacles
        ):
            yield f"something else is called {one.name!r} already", "block"
        if fault := polygon_fault(one.footprint):
            yield fault, "block"
        if one.footprint.interiors:
            yield "must have no holes", "block"
        if fault := height_fault(one):
            yield fault, "z"
    if (command.call is None) != (command.machine is None and command.person is None):
        yield "a call has a machine, and a machine a call", "machine"
    elif command.call is not None and command.person is not None:
        if fault := method_fault(Person, "a person", command.call, command.arguments or {}):
            yield fault, "call"
    elif command.call is not None and command.machine in machines(trial):
        kind = kind_of(command.machine, trial)
        if fault := call_fault(kind, command.call, command.arguments or {}):
            yield fault, "call"
    if command.clear is not None and command.clear not in placed:
        hint = suggestion(command.clear, placed) if placed else "there is nothing then"
        yield f"nothing that is called {command.clear!r} was put down by then; {hint}", "clear"


def _place_faults(command: Command, trial: Scenario) -> Iterator[str]:
    assert command.to is not None
    at = spot(trial.floorplan, command.to)
    if at is None:
        doors = [door.name for door in trial.floorplan.doors]
        hint = suggestion(str(command.to), [*stations(trial), *doors])
        yield f"no station or door is called {command.to!r}; {hint}"
    elif not all(map(math.isfinite, at)) or max(map(abs, at)) > LARGEST:
        yield f"must be a place, not {command.to!r}"


def list_faults(trial: Scenario) -> Iterator[Fault]:
    """Yield the faults of the work lists."""
    taken = {name for person in trial.people for name in person.work}
    for name, work_list in trial.work.items():
        for k, task in enumerate(work_list.tasks):
            for message, key in _task_faults(task, trial):
                yield message, (name, "tasks", k, key)
        if not work_list.tasks:
            yield "has no tasks", (name,)
        if name not in taken:
            yield "no person takes tasks from this list; add it to the work of a person", (name,)


def person_faults(person: PersonEntry, trial: Scenario) -> Iterator[Fault]:
    """Yield the faults of the work of a person."""
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
            message = f"begins at {as_given(begin)}, before the previous one ends"
            yield message, ("shifts", k)
        elif begin >= trial.duration:
            yield _too_late(begin, trial), ("shifts", k)
        end = until


def _task_faults(task: WorkTask, trial: Scenario) -> Iterator[tuple[str, str]]:
    """Yield the faults of a task with their keys."""
    stations = [station.name for station in trial.floorplan.stations]
    if task.at not in stations:
        hint = suggestion(task.at, stations) if stations else "the floor has none"
        yield f"no station is called {task.at!r}; {hint}", "at"
    if task.time >= trial.duration:
        yield _too_late(task.time, trial), "time"


def _too_late(time: float, trial: Scenario) -> str:
    clock = f" ({time.given})" if isinstance(time, ClockTime) else ""
    return f"is at {time:g} s{clock} of the trial, which ends at {trial.duration:g} s"
