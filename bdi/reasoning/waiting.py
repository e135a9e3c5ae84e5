"""Waits of intentions: for a time, for an event, for a condition."""

from __future__ import annotations

from ..language.body import Act
from ..language.terms import TRUE, Literal, Term, TriggerTerm
from ..language.unification import try_unify, unify
from .actions import error_annots
from .alarms import Alarm
from .bodies import compile_body
from .failure import fail
from .intentions import Event, Intention
from .state import MILLISECOND, AgentState


class ActiveWait:
    """One `.wait` under way. The constructor leaves the suspension of the intention to the caller.

    Args:
        agent: state of the agent.
        intention: the intention that waits.
        trigger: event that ends the wait, if any.
        condition: formula that ends the wait when it holds, if any.
        timeout: longest time (ms), if any.
        elapsed: term to unify with the time waited (ms); without it a timeout is a failure.
    """

    def __init__(
        self,
        agent: AgentState,
        intention: Intention,
        *,
        trigger: TriggerTerm | None = None,
        condition: Term | None = None,
        timeout: int | None = None,
        elapsed: Term | None = None,
    ) -> None:
        self._agent = agent
        self._intention = intention
        self._means = intention.top
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
            self._alarm = agent.after(timeout, lambda: self._end(timed_out=True))

    def notice(self, event: Event | None) -> None:
        """Check if an event, or a change that something else has made, ends the wait."""
        if self._over:
            return
        # Counted as a query is: many waits may be checked at many events.
        self._agent.logic.spend(1, self._awaited)
        u = self._means.u
        if event is not None and self._trigger is not None:
            if self._trigger.sort == event.sort and try_unify(
                self._trigger.literal, event.literal, u
            ):
                self._end(timed_out=False)
        elif self._condition is not None:
            solution = self._agent.logic.first(self._condition, u)
            if solution is not None:
                u.update(solution)
                self._end(timed_out=False)

    def cancel(self) -> None:
        """End the wait of an intention that has ended."""
        self._over = True
        self._intention.wait = None
        if self._alarm is not None:
            self._alarm.cancel()
        waits = self._agent.circumstance.waits
        if self in waits:
            waits.remove(self)

    def _end(self, *, timed_out: bool) -> None:
        self.cancel()
        ended = self._agent.clock
        # Not at once: an event ends the wait in the middle of a cycle, and Jason puts the intention
        # back at the beginning of the next deliberation, before it takes that event.
        self._agent.tasks.append(lambda: self._resume(timed_out, ended))

    def _resume(self, timed_out: bool, ended: int) -> None:
        circumstance = self._agent.circumstance
        intention = self._intention
        if not circumstance.take_pending(intention, "wait"):
            return
        if not intention.atomic and circumstance.is_running(intention):
            return
        waits_for_something = self._trigger is not None or self._condition is not None
        if timed_out and waits_for_something and self._elapsed is None:
            if intention.is_suspended:
                # The failure comes when it is resumed.
                self._means.step = compile_body((Act(Literal(".fail")),))
                self._suspend()
            else:
                fail(self._agent, intention, error_annots("wait_timeout", "timeout in .wait"))
            return
        if intention.is_finished:
            return
        if self._means.step is not None:
            self._means.step = self._means.step.next
        if self._elapsed is not None:
            unify(self._elapsed, float((ended - self._began) // MILLISECOND), self._means.u)
        if intention.is_suspended:
            self._suspend()
        else:
            circumstance.resume(intention)

    def _suspend(self) -> None:
        """Leave the intention, which `.suspend` has suspended, to `.resume`."""
        reason = Literal(f"suspended-{self._intention.number}")
        self._agent.circumstance.suspend("suspended", self._intention, reason)
