"""Work of people: the task board of a trial, and a person's tasks, shifts and breaks."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass, field
from random import Random
from typing import Any

from bdi.reasoning.beliefs import LiveBeliefs
from floorplan import Human, Point

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
    """A task that is there to be done, once: its `id` counts all tickets of the trial.

    `number` is that of the task on its list; those of breaks are negative. `left` are the seconds
    that it still takes at the usual pace. `begun` is the time at which somebody first set to work.
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
        """What puts it in order: breaks, then by priority, then the oldest first."""
        return (not self.is_break, -self.task.priority, self.since)


class WorkBoard:
    """The tickets of a scenario: those of its lists, and those of each person alone.

    At a station there is room for one: while somebody has a task there, no other one is offered.
    Of those who could take a new ticket, the nearest are called first.

    How long each takes is drawn from the seed, by list and number: whoever does it, and whatever
    else happens, it is the same.
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
        self._repeats = {name for name, held in scenario.work.items() if held.repeat}

    def call(self, name: str, body: Body, called: Call) -> None:
        """Call `called`, for who walks as `body`, when there may be more to do on list `name`."""
        self._called.setdefault(name, []).append((body, called))

    def begin(self) -> None:
        """Let tickets appear from now on, each at its time."""
        for name, held in self._scenario.work.items():
            self._release(name, held)
        for person in self._scenario.people:
            own = own_list(person.name)
            self._release(own, WorkList(person.schedule))
            self._release(own, WorkList(person.breaks), breaks=True)

    def _release(self, name: str, held: WorkList, *, breaks: bool = False) -> None:
        for k, task in enumerate(held.tasks):
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
        """Return the tickets on `lists` that `person`, who is `at`, could take.

        The most urgent come first: breaks, then by priority, then the oldest, then the nearest.
        """
        found = [one for name in lists for one in self._open.get(name, ())]
        return sorted(
            (one for one in found if one.task.at not in self._busy and person not in one.refused),
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
        """Take note that the task of a ticket is done: on some lists it is there again."""
        self._leave(ticket.task.at)
        if ticket.list in self._repeats:
            self._put(ticket.list, ticket.number, ticket.task, ticket.is_break)

    def _leave(self, station: str) -> None:
        """Take note that nobody has a task at `station` any more."""
        self._busy.discard(station)
        waiting = [one for held in self._open.values() for one in held if one.task.at == station]
        self._notify(sorted(waiting, key=lambda one: one.urgency)[:1])

    def _notify(self, tickets: list[Ticket]) -> None:
        """Call those who could take one of `tickets`, the nearest to it first."""
        for ticket in tickets:
            known = self._called.get(ticket.list, [])
            for _, called in sorted(known, key=lambda one: math.dist(one[0].at, ticket.at)):
                called()


def own_list(person: str) -> str:
    """Return the name of the list of what is there for a person alone; no list is called so."""
    return f"of {person}"


REACH = 1.5
"""Metres. So near to a station its tasks can be done: somebody else may stand right on it."""

SLOWEST, FASTEST = 0.1, 10.0
"""Least and greatest pace of work."""


class Worker:
    """The work of one person, who walks as `body` and takes tickets from a `board`.

    There are offers for whoever has started and is on shift; one task is taken at a time. What
    comes of it is perceived: `work_offered`, `task_done`, `shift_began`, `shift_ended`.
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
        """Begin to work: the person has started."""
        now = self._started = self._clock.now
        for begin, end in self._shifts:
            if end > now:
                self._clock.call_at(max(begin, now), self._begin_shift, Turn.NOTICE)
                self._clock.call_at(end, self._end_shift, Turn.NOTICE)

    @property
    def on_shift(self) -> bool:
        """Whether tasks are offered to them now."""
        if self._started is None:
            return False
        now = self._clock.now
        return not self._shifts or any(begin <= now < end for begin, end in self._shifts)

    @property
    def offers(self) -> list[Ticket]:
        """The tickets that they could take now, the most urgent first."""
        here = self._body.at
        return self._board.offers(self._lists, self._name, here) if self.on_shift else []

    @property
    def time_working(self) -> float:
        """How long (s) they have worked, without breaks."""
        doing = self.doing
        under_way = self._since is not None and doing is not None and not doing.is_break
        return self._worked + (self._clock.now - (self._since or 0.0) if under_way else 0.0)

    @property
    def throughput(self) -> float | None:
        """Tasks done in an hour on shift, None before there was any time for it."""
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
        """Take on the task that is offered under this number; False if none is, or with a task."""
        for ticket in self.offers if self.doing is None else ():
            if ticket.id == number:
                self._board.take(ticket)
                self.doing = ticket
                self._record(TaskTaken(**self._facts(ticket)))
                return True
        return False

    def begin(self) -> bool:
        """Set to work; False without a task, or out of reach of its station."""
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
        """Leave the task that is under way, if one is; it is still theirs."""
        ticket = self.doing
        if ticket is None or self._since is None:
            return
        self._stop(ticket)
        self._record(TaskPaused(**self._facts(ticket), left=ticket.left))

    def give_back(self) -> bool:
        """Give the task back, for others or for later; False without one."""
        self.pause()
        ticket = self.doing
        if ticket is None:
            return False
        self.doing = None
        self._record(TaskGivenBack(**self._facts(ticket), refused=False))
        self._board.give_back(ticket)
        return True

    def refuse(self, number: float) -> bool:
        """Have a task that is offered under this number not offered again; False if none is."""
        for ticket in self.offers:
            if ticket.id == number:
                ticket.refused.add(self._name)
                self._record(TaskGivenBack(**self._facts(ticket), refused=True))
                return True
        return False

    def work_pace(self, pace: float) -> bool:
        """Work `pace` times as fast as usual from now on; False beyond 0.1 … 10."""
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
        """Stop the work under way, and count it."""
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
