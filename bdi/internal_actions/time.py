"""Internal actions on simulated time: waits, scheduled events, dates."""

from __future__ import annotations

import re
from datetime import datetime, timedelta

from ..actions import ActionError, error_annots
from ..language.body import Act
from ..language.operations import Conjunction, Disjunction, Negation, Relation, TriggerTerm
from ..language.substitution import rename
from ..language.terms import TRUE, Literal, Term, Var, text
from ..language.unification import try_unify, unify
from ..reasoning.beliefs import with_source
from ..reasoning.circumstance import Timer
from ..reasoning.contexts import condition as compiled
from ..reasoning.execution import WAITING, Call
from ..reasoning.failure import fail
from ..reasoning.intentions import Event, Intention
from ..reasoning.plans import compile_body
from ..reasoning.state import MILLISECOND, AgentState
from .registry import STANDARD, a_number, a_trigger, wrong


class ActiveWait:
    """One active `.wait`. The caller of the constructor suspends the intention.

    The event `trigger`, the formula `condition` or the `timeout` (ms) ends the wait. `elapsed` is a
    term to unify with the waiting time (ms). Without it, a timeout is a failure.
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
        self._holds = None if condition is None else compiled(condition)
        self._awaited: Term = TRUE if condition is None else condition
        if trigger is not None:
            self._awaited = trigger.literal
        self._elapsed = elapsed
        self._began = agent.clock
        self._over = False
        intention.wait = self
        if trigger is not None or condition is not None:
            agent.circumstance.waits.append(self)
        self._alarm: Timer | None = None
        if timeout is not None:
            self._alarm = agent.after(timeout, lambda: self._end(timed_out=True))

    def notice(self, event: Event | None) -> None:
        """Check if an event, or another change, ends the wait."""
        if self._over:
            return
        # Counted as queries, because many waits may be checked at many events.
        self._agent.logic.spend(1, self._awaited)
        u = self._means.u
        if event is not None and self._trigger is not None:
            if self._trigger.sort == event.sort and try_unify(
                self._trigger.literal, event.literal, u
            ):
                self._end(timed_out=False)
        elif self._holds is not None:
            solution = self._holds(self._agent.logic, u)
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
        # Delayed, because an event may end the wait within a cycle. Jason resumes the intention at
        # the beginning of the next deliberation, before it handles that event.
        self._agent.tasks.append(lambda: self._resume(timed_out, ended))

    def _resume(self, timed_out: bool, ended: int) -> None:
        circumstance = self._agent.circumstance
        intention = self._intention
        if not circumstance.take_pending(intention, "wait"):
            return
        if not intention.atomic and circumstance.is_running(intention):
            return
        waits_for_something = self._trigger is not None or self._holds is not None
        if timed_out and waits_for_something and self._elapsed is None:
            if intention.is_suspended:
                # The intention fails when it is resumed.
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
        """Leave a suspended intention to `.resume`."""
        reason = Literal(f"suspended-{self._intention.number}")
        self._agent.circumstance.suspend("suspended", self._intention, reason)


#: Date and time of `.date` and `.time` at simulated time 0.
EPOCH = datetime(2023, 1, 1)

_AT = re.compile(r"\s*now\s*(?:\+\s*(\d+)\s*(.*))?", re.ASCII | re.DOTALL)
_UNITS = (("s", "second", 1_000), ("m", "minute", 60_000), ("h", "hour", 3_600_000))
_DAY = ("d", "day", 86_400_000)


def _milliseconds(number: str, unit: str) -> int:
    """Return a time in ms. Unknown units are milliseconds."""
    for short, word, length in (*_UNITS, _DAY):
        if unit == short or unit.startswith(word):
            return int(number) * length
    return int(number)


@STANDARD.add(".wait", least=1, most=3, in_context=False)
def wait(call: Call, what: Term, *more: Term) -> object:
    """`.wait(What, Timeout?, Elapsed?)`: wait for a time, an event or a condition."""
    agent, intention = call.agent, call.intention
    if intention is None:
        raise wrong("wait", "it cannot be used in a context")
    reason: Term
    if isinstance(what, float):
        milliseconds = float(max(0, int(what)))
        ActiveWait(agent, intention, timeout=int(milliseconds))
        reason = Literal("time", (milliseconds,))
    else:
        timeout = int(a_number("wait", more[0], "second")) if more else None
        trigger = a_trigger(what)
        condition = what if trigger is None else None
        if condition is not None:
            if not isinstance(
                what, Literal | Relation | Conjunction | Disjunction | Negation | Var
            ):
                raise wrong("wait", f"'{text(what)}' is nothing to wait for")
            solution = compiled(what)(agent.logic, call.unifier)
            if solution is not None:
                return solution
        ActiveWait(
            agent,
            intention,
            trigger=trigger,
            condition=condition,
            timeout=timeout,
            elapsed=more[1] if len(more) > 1 else None,
        )
        reason = what if trigger is None else trigger.literal
    waiting_for = Literal("wait", (float(intention.number),), (reason,))
    agent.circumstance.suspend("wait", intention, waiting_for)
    return WAITING


@STANDARD.add(".at", least=2, most=2)
def at(call: Call, when: Term, event: Term) -> bool:
    """`.at("now +3 s", {+!g})`: raise an event later."""
    parsed = _AT.fullmatch(when.strip()) if isinstance(when, str) else None
    if parsed is None:
        raise ActionError(
            f"The time parameter ('{text(when)}') of the internal action 'at' "
            "did not parse correctly!"
        )
    trigger = a_trigger(event)
    if trigger is None:
        raise wrong("at", f"'{text(event)}' is not an event")
    agent = call.agent
    milliseconds = _milliseconds(parsed[1] or "0", (parsed[2] or "").strip())
    literal = rename(trigger.literal, agent.names, {})
    if not isinstance(literal, Literal):
        raise wrong("at", f"'{text(event)}' is not an event")

    announced = agent.circumstance.future_events

    def happen() -> None:
        announced.remove(alarm)
        agent.circumstance.post(Event(trigger.sort, literal))

    alarm = agent.after(milliseconds, happen)
    announced.append(alarm)
    return True


def _instant(call: Call) -> datetime:
    return EPOCH + timedelta(microseconds=call.agent.clock // 1_000)


@STANDARD.add(".date", least=3, most=3)
def date(call: Call, year: Term, month: Term, day: Term) -> object:
    """`.date(Y, M, D)`: the date, counted from EPOCH."""
    now = _instant(call)
    return call.unify([year, month, day], [now.year, now.month, now.day])


@STANDARD.add(".time", least=3, most=4)
def time(call: Call, hour: Term, minute: Term, second: Term, *milliseconds: Term) -> object:
    """`.time(H, M, S, Ms?)`: the time of the day, counted from EPOCH."""
    now = _instant(call)
    values = [now.hour, now.minute, now.second, now.microsecond // 1_000]
    terms = [hour, minute, second, *milliseconds]
    return call.unify(terms, values[: len(terms)])


@STANDARD.add(".nano_time", least=1, most=1)
def nano_time(call: Call, now: Term) -> object:
    """`.nano_time(N)`: the time in nanoseconds."""
    return call.unify(now, float(call.agent.clock))


@STANDARD.add(".signal", least=1, most=2)
def signal(call: Call, event: Term, *kind: Term) -> bool:
    """Raise an event without a change of beliefs."""
    trigger = a_trigger(event)
    literal = None if trigger is None else rename(trigger.literal, call.agent.names, {})
    if trigger is None or not isinstance(literal, Literal):
        raise wrong("signal", f"'{text(event)}' is not an event")
    call.agent.circumstance.post(Event(trigger.sort, with_source(literal)))
    return True
