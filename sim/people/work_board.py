"""The work board of a trial: which tasks are there, and who has taken them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from random import Random

from floorplan import Point

from ..core.body import Body
from ..core.clock import Clock, Turn
from ..core.scenario import Scenario
from ..core.work import WorkList, WorkTask

Call = Callable[[], None]


@dataclass(eq=False)
class Ticket:
    """A task that is there to be done, once: its `id` counts all tickets of the trial.

    `number` is that of the task on its list; those of breaks are negative. `left` are the seconds
    that it still takes at the usual pace. `begun` is the time at which somebody first set to work.
    """

    id: int
    task: WorkTask
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
        ticket = Ticket(self._tickets, task, name, number, at, left, now, is_break)
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
