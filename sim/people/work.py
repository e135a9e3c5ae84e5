"""Work of people: the board of tasks of a trial, and the tasks, shifts and breaks of a person."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import KW_ONLY, field
from random import Random
from typing import Any

from bdi.reasoning.beliefs import LiveBeliefs
from floorplan import Human, Point
from floorplan.files.dataclass import dataclass

from ..core.body import Body
from ..core.clock import Alarm, Clock, Turn
from ..core.events import (
    ShiftBegan,
    ShiftEnded,
    TaskBegun,
    TaskDone,
    TaskGivenBack,
    TaskPaused,
    TaskTaken,
)
from ..core.scenario import PersonEntry, Scenario
from ..core.schedule import WorkList, WorkTask
from ..core.stage import Stage
from .minds import as_term
from .perception import Senses

Call = Callable[[], None]


@dataclass(eq=False)
class Ticket:
    """One execution of a task. `id` counts all tickets of the trial.

    `number` is the number of the task on its list, negative for breaks. `left` is the remaining
    time at the usual pace (s), and `begun` the time at which work on it first began (s).
    """

    id: int
    task: WorkTask
    _: KW_ONLY
    list: str
    number: int
    at: Point
    left: float
    since: float
    is_break: bool = False
    begun: float | None = None
    refused: set[str] = field(default_factory=set)

    @property
    def urgency(self) -> tuple[bool, int, float]:
        """Sort key: breaks first, then by priority, then by age."""
        return (not self.is_break, -self.task.priority, self.since)


class WorkBoard:
    """Tickets of a scenario: those of its lists, and those of single people.

    While a person has a task at a station, other tasks there are not offered. The nearest people
    who can take a new ticket are called first.

    Durations are drawn by seed, list and number, so that they depend on nothing else.
    """

    def __init__(self, scenario: Scenario, clock: Clock) -> None:
        self._scenario = scenario
        self._clock = clock
        self._stations = {one.name: one.position for one in scenario.floorplan.stations}
        self._open: dict[str, list[Ticket]] = {}
        self._called: dict[str, list[tuple[Body, Call]]] = {}
        self._busy: set[str] = set()
        self._tickets = 0
        self._drawn: dict[tuple[str, int], int] = {}
        self._repeats = {name for name, tasks in scenario.work.items() if tasks.repeat}

    def call(self, name: str, body: Body, called: Call) -> None:
        """Call `called` for the person with `body` when list `name` may offer a task."""
        self._called.setdefault(name, []).append((body, called))

    def begin(self) -> None:
        """Schedule the appearance of all tickets."""
        for name, tasks in self._scenario.work.items():
            self._release(name, tasks)
        for person in self._scenario.people:
            own = own_list(person.name)
            self._release(own, WorkList(person.schedule))
            self._release(own, WorkList(person.breaks), breaks=True)

    def _release(self, name: str, work: WorkList, *, breaks: bool = False) -> None:
        for k, task in enumerate(work.tasks):
            number = -1 - k if breaks else k
            self._wait_for(task.time, 1, name, number, task, breaks)

    def _wait_for(
        self, t: float, count: int, name: str, number: int, task: WorkTask, breaks: bool
    ) -> None:
        def appear() -> None:
            self._put(name, number, task, breaks)
            if task.every is not None and (task.count is None or count < task.count):
                self._wait_for(t + task.every, count + 1, name, number, task, breaks)

        self._clock.call_at(t, appear, Turn.NOTICE)

    def _put(self, name: str, number: int, task: WorkTask, is_break: bool) -> None:
        self._tickets += 1
        drawn = self._drawn[name, number] = self._drawn.get((name, number), 0) + 1
        random = Random(f"{self._scenario.seed} {name} {number} {drawn}")
        left = task.duration.draw(random)
        at, now = self._stations[task.at], self._clock.now
        ticket = Ticket(
            self._tickets,
            task,
            list=name,
            number=number,
            at=at,
            left=left,
            since=now,
            is_break=is_break,
        )
        self._open.setdefault(name, []).append(ticket)
        self._notify([ticket])

    def offers(self, lists: list[str], person: str, at: Point) -> list[Ticket]:
        """Return the tickets on `lists` that `person` at `at` can take, the most urgent first.

        Equally urgent tickets are sorted by distance.
        """
        tickets = [ticket for name in lists for ticket in self._open.get(name, ())]
        return sorted(
            (one for one in tickets if one.task.at not in self._busy and person not in one.refused),
            key=lambda one: (*one.urgency, math.dist(one.at, at), one.id),
        )

    def take(self, ticket: Ticket) -> None:
        """Take a ticket off the board."""
        self._open[ticket.list].remove(ticket)
        self._busy.add(ticket.task.at)

    def give_back(self, ticket: Ticket) -> None:
        """Put a ticket back on the board."""
        self._open[ticket.list].append(ticket)
        self._leave(ticket.task.at)

    def done(self, ticket: Ticket) -> None:
        """Complete a ticket. On repeated lists a new one appears."""
        self._leave(ticket.task.at)
        if ticket.list in self._repeats:
            self._put(ticket.list, ticket.number, ticket.task, ticket.is_break)

    def _leave(self, station: str) -> None:
        """Release a station, and notify people about its most urgent ticket."""
        self._busy.discard(station)
        waiting = [
            one for tickets in self._open.values() for one in tickets if one.task.at == station
        ]
        self._notify(sorted(waiting, key=lambda one: one.urgency)[:1])

    def _notify(self, tickets: list[Ticket]) -> None:
        """Call the people who can take one of `tickets`, the nearest first."""
        for ticket in tickets:
            callbacks = self._called.get(ticket.list, [])
            for _, called in sorted(callbacks, key=lambda one: math.dist(one[0].at, ticket.at)):
                called()


def own_list(person: str) -> str:
    """Return the name of the list of a single person, which no other list has."""
    return f"of {person}"


REACH = 1.5
"""Maximum distance (m) from a station at which its tasks can be done."""

SLOWEST, FASTEST = 0.1, 10.0
"""Minimum and maximum pace of work."""


class Worker:
    """Work of one person, who takes tickets from a `board`.

    Tasks are offered after the start, during shifts. A person has at most one task. Percepts are
    `work_offered`, `task_done`, `shift_began` and `shift_ended`.
    """

    def __init__(
        self,
        stage: Stage,
        entry: PersonEntry,
        board: WorkBoard,
        *,
        body: Body,
        human: Human,
        senses: Senses,
    ) -> None:
        self.tasks_done = 0
        self.doing: Ticket | None = None
        self._clock = stage.clock
        self._record = stage.record
        self._board = board
        self._name = entry.name
        self._works = entry.works
        self._shifts = entry.shifts
        self._lists = [own_list(entry.name), *entry.work]
        self._body = body
        self._reach = max(REACH, human.goal_tolerance)
        self._senses = senses
        self._pace = 1.0
        self._started: float | None = None
        self._since: float | None = None
        self._worked = 0.0
        self._end = Alarm(stage.clock, self._done, Turn.MOTION_ENDS)
        for name in self._lists:
            board.call(name, body, self._offered)

    def start(self) -> None:
        """Begin to work, and schedule the shifts."""
        now = self._started = self._clock.now
        for begin, end in self._shifts:
            if end > now:
                self._clock.call_at(max(begin, now), self._begin_shift, Turn.NOTICE)
                self._clock.call_at(end, self._end_shift, Turn.NOTICE)

    @property
    def on_shift(self) -> bool:
        """Whether tasks are offered now."""
        if self._started is None:
            return False
        now = self._clock.now
        return not self._shifts or any(begin <= now < end for begin, end in self._shifts)

    @property
    def offers(self) -> list[Ticket]:
        """Tickets that the person can take now, the most urgent first."""
        here = self._body.at
        return self._board.offers(self._lists, self._name, here) if self.on_shift else []

    @property
    def time_working(self) -> float:
        """Time worked without breaks (s)."""
        doing = self.doing
        under_way = self._since is not None and doing is not None and not doing.is_break
        return self._worked + (self._clock.now - (self._since or 0.0) if under_way else 0.0)

    @property
    def throughput(self) -> float | None:
        """Tasks per hour on shift, or None before the first shift."""
        if self._started is None:
            return None
        now = self._clock.now
        shifts = self._shifts or ((self._started, now),)
        there = sum(max(0.0, min(end, now) - max(begin, self._started)) for begin, end in shifts)
        return self.tasks_done / there * 3600.0 if there > 0 else None

    def beliefs(self) -> LiveBeliefs:
        """Return live beliefs about work.

        They are `offer(Id, Task, Station, Priority, Ms)`, the most urgent first, `doing(Id, Task,
        Station, X, Y)`, `on_shift`, and `works` if there may be any work.
        """
        return {
            ("offer", 5): lambda: [
                (
                    float(one.id),
                    one.task.label,
                    as_term(one.task.at),
                    float(one.task.priority),
                    one.left * 1000.0,
                )
                for one in self.offers
            ],
            ("doing", 5): lambda: [
                (float(one.id), one.task.label, as_term(one.task.at), *one.at)
                for one in [self.doing]
                if one is not None
            ],
            ("on_shift", 0): lambda: [()] if self.on_shift else [],
            ("works", 0): lambda: [()] if self._works else [],
        }

    # Actions

    def take(self, number: float) -> bool:
        """Take the offered task with this number. Return False if there is none, or if busy."""
        for ticket in self.offers if self.doing is None else ():
            if ticket.id == number:
                self._board.take(ticket)
                self.doing = ticket
                self._record(TaskTaken(**self._facts(ticket)))
                return True
        return False

    def begin(self) -> bool:
        """Begin work. Return False without a task, or out of reach of its station."""
        ticket = self.doing
        if ticket is None:
            return False
        if math.dist(self._body.at, ticket.at) > self._reach or self._body.state.speed > 0:
            return False
        if self._since is None:
            now = self._since = self._clock.now
            if ticket.begun is None:
                ticket.begun = now
            self._end.set(now + ticket.left / self._pace)
            self._record(TaskBegun(**self._facts(ticket)))
        return True

    def pause(self) -> None:
        """Interrupt the current task without giving it back."""
        ticket = self.doing
        if ticket is None or self._since is None:
            return
        self._stop(ticket)
        self._record(TaskPaused(**self._facts(ticket), left=ticket.left))

    def give_back(self) -> bool:
        """Give the task back to the board. Return False without a task."""
        self.pause()
        ticket = self.doing
        if ticket is None:
            return False
        self.doing = None
        self._record(TaskGivenBack(**self._facts(ticket), refused=False))
        self._board.give_back(ticket)
        return True

    def refuse(self, number: float) -> bool:
        """Reject the offered task with this number for good. Return False if there is none."""
        for ticket in self.offers:
            if ticket.id == number:
                ticket.refused.add(self._name)
                self._record(TaskGivenBack(**self._facts(ticket), refused=True))
                return True
        return False

    def work_pace(self, pace: float) -> bool:
        """Work `pace` times as fast as usual. Return False outside 0.1 to 10."""
        if not SLOWEST <= pace <= FASTEST:
            return False
        ticket = self.doing
        if ticket is not None and self._since is not None:
            self._stop(ticket)
            self._since = self._clock.now
            self._end.set(self._since + ticket.left / pace)
        self._pace = pace
        return True

    def _stop(self, ticket: Ticket) -> None:
        """Interrupt the work, and add up the time."""
        assert self._since is not None
        spent = self._clock.now - self._since
        ticket.left = max(0.0, ticket.left - spent * self._pace)
        if not ticket.is_break:
            self._worked += spent
        self._since = None
        self._end.set(None)

    def _done(self) -> None:
        ticket = self.doing
        assert ticket is not None and ticket.begun is not None
        self._stop(ticket)
        self.doing = None
        self.tasks_done += not ticket.is_break
        waited, took = ticket.begun - ticket.since, self._clock.now - ticket.begun
        self._record(TaskDone(**self._facts(ticket), waited=waited, took=took))
        self._senses.count("task_done")
        self._board.done(ticket)

    def _offered(self) -> None:
        if self.offers:
            self._senses.count("work_offered")

    def _begin_shift(self) -> None:
        self._record(ShiftBegan(person=self._name))
        self._senses.count("shift_began")

    def _end_shift(self) -> None:
        self._record(ShiftEnded(person=self._name))
        self._senses.count("shift_ended")

    def _facts(self, ticket: Ticket) -> dict[str, Any]:
        return {"person": self._name, "task": ticket.task.label, "station": ticket.task.at}
