"""A person at work: what they are offered, take on, and do."""

from __future__ import annotations

import math
from typing import Any

import bdi
from floorplan import Human

from ..core.body import Body
from ..core.clock import Alarm, Turn
from ..core.events import (
    ShiftBegan,
    ShiftEnded,
    TaskBegun,
    TaskDone,
    TaskGivenBack,
    TaskPaused,
    TaskTaken,
)
from ..core.scenario import PersonEntry
from ..core.stage import Stage
from .minds import as_term
from .percepts import Senses
from .work_board import Ticket, WorkBoard, own_list

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

    def beliefs(self) -> bdi.LiveBeliefs:
        """Return live beliefs: `offer(Id, Task, Station, Priority, Ms)`, the most urgent first,
        `doing(Id, Task, Station, X, Y)`, `on_shift`, and `works` if there may be work at all."""
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
