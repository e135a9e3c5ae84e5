"""Intentions that wait: for a time, for an event, for a condition."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .alarms import Alarm
from .failure import error_annots, fail
from .intentions import Event, Intention, Means
from .program import Act, TriggerTerm
from .steps import compile_body
from .terms import TRUE, Literal, Term
from .unify import unify

if TYPE_CHECKING:
    from .agent import Agent

MILLISECOND = 1_000_000


class Wait:
    """One `.wait` under way. Times are nanoseconds of simulated time."""

    def __init__(
        self,
        agent: Agent,
        intention: Intention,
        *,
        trigger: TriggerTerm | None = None,
        condition: Term | None = None,
        timeout: int | None = None,
        elapsed: Term | None = None,
    ) -> None:
        self._agent = agent
        self.intention = intention
        self.means: Means = intention.top
        self._trigger = trigger
        self._condition = condition
        self._awaited: Term = TRUE if condition is None else condition
        if trigger is not None:
            self._awaited = trigger.literal
        self._elapsed = elapsed
        self._began = agent.clock
        self._over = False
        intention.wait = self
        if trigger is not None or condition is not None:
            agent.circumstance.waits.append(self)
        self._alarm: Alarm | None = None
        if timeout is not None:
            self._alarm = agent.alarms.set(agent.clock + timeout * MILLISECOND, self._time_out)

    def notice(self, event: Event | None) -> None:
        """Looks whether an event, or what an event may have changed, is what it waits for."""
        if self._over:
            return
        # Many that wait for much that happens are work like that of a query.
        self._agent.logic.spend(1, self._awaited)
        u = self.means.u
        if event is not None and self._trigger is not None:
            if self._trigger.kind == event.sort:
                attempt = dict(u)
                if unify(self._trigger.literal, event.literal, attempt):
                    u.update(attempt)
                    self._end(timed_out=False)
        elif self._condition is not None:
            solution = self._agent.logic.first(self._condition, u)
            if solution is not None:
                u.update(solution)
                self._end(timed_out=False)

    def cancel(self) -> None:
        """The intention is no more."""
        self._forget()

    def _time_out(self) -> None:
        if not self._over:
            self._end(timed_out=True)

    def _forget(self) -> None:
        self._over = True
        self.intention.wait = None
        if self._alarm is not None:
            self._alarm.cancel()
        waits = self._agent.circumstance.waits
        if self in waits:
            waits.remove(self)

    def _end(self, *, timed_out: bool) -> None:
        self._forget()
        ended = self._agent.clock
        self._agent.at_next_cycle(lambda: self._resume(timed_out, ended))

    def _resume(self, timed_out: bool, ended: int) -> None:
        circumstance = self._agent.circumstance
        intention = self.intention
        if not circumstance.take_pending(intention, "wait"):
            return
        if not intention.atomic and circumstance.is_running(intention):
            return
        waits_for_something = self._trigger is not None or self._condition is not None
        if timed_out and waits_for_something and self._elapsed is None:
            if intention.is_suspended:
                # It fails when it is resumed.
                self.means.step = compile_body((Act(Literal(".fail")),))
                circumstance.suspend("suspended", intention)
            else:
                fail(self._agent, intention, error_annots("wait_timeout", "timeout in .wait"))
            return
        if intention.is_finished:
            return
        if self.means.step is not None:
            self.means.step = self.means.step.next
        if self._elapsed is not None:
            unify(self._elapsed, float((ended - self._began) // MILLISECOND), self.means.u)
        if intention.is_suspended:
            circumstance.suspend("suspended", intention)
        else:
            circumstance.add_running(intention)
