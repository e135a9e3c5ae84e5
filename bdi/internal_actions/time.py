"""Simulated time: waits, announced events, dates."""

from __future__ import annotations

import re
from datetime import datetime, timedelta

from ..language.substitution import rename
from ..language.terms import And, Literal, Not, Or, Relation, Term, Var, text
from ..reasoning.actions import ActionError
from ..reasoning.beliefs import with_source
from ..reasoning.calls import WAITING, Call
from ..reasoning.intentions import Event
from ..reasoning.waiting import ActiveWait
from .arguments import a_number, a_trigger, wrong
from .registry import STANDARD

#: Date and time of `.date` and `.time` at simulated time 0.
EPOCH = datetime(2023, 1, 1)

_AT = re.compile(r"\s*now\s*(?:\+\s*(\d+)\s*(.*))?", re.ASCII | re.DOTALL)
_UNITS = (("s", "second", 1_000), ("m", "minute", 60_000), ("h", "hour", 3_600_000))
_DAY = ("d", "day", 86_400_000)


def _milliseconds(number: str, unit: str) -> int:
    """Return a time; one without a unit, or with another than these, is in milliseconds."""
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
            if not isinstance(what, Literal | Relation | And | Or | Not | Var):
                raise wrong("wait", f"'{text(what)}' is nothing to wait for")
            solution = agent.logic.first(what, call.unifier)
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
        raise wrong("at", f"'{text(event)}' is no event")
    agent = call.agent
    milliseconds = _milliseconds(parsed[1] or "0", (parsed[2] or "").strip())
    literal = rename(trigger.literal, agent.names, {})
    if not isinstance(literal, Literal):
        raise wrong("at", f"'{text(event)}' is no event")

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
    """Raise an event as it is given: nothing is believed by it."""
    trigger = a_trigger(event)
    literal = None if trigger is None else rename(trigger.literal, call.agent.names, {})
    if trigger is None or not isinstance(literal, Literal):
        raise wrong("signal", f"'{text(event)}' is no event")
    call.agent.circumstance.post(Event(trigger.sort, with_source(literal)))
    return True
