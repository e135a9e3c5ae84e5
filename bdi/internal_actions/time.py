"""Simulated time: waits, announced events, dates."""

from __future__ import annotations

import re
from collections.abc import Mapping
from datetime import datetime, timedelta

from ..language.substitution import rename
from ..language.terms import And, Literal, Not, Or, Relation, Term, Var, text
from ..reasoning.actions import ActionError, InternalAction
from ..reasoning.calls import WAITING, Call
from ..reasoning.intentions import Event
from ..reasoning.waiting import ActiveWait
from .arguments import a_number, a_trigger, wrong

#: Date and time of `.date` and `.time` at simulated time 0.
EPOCH = datetime(2023, 1, 1)

_UNITS = {"": 1, "s": 1_000, "m": 60_000, "h": 3_600_000, "d": 86_400_000}
_AT = re.compile(r"now\s*\+\s*(\d+)\s*(s|seconds?|m|minutes?|h|hours?|d|days?|)\s*", re.ASCII)


def wait(call: Call, what: Term, *more: Term) -> object:
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


def at(call: Call, when: Term, event: Term) -> bool:
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
    milliseconds = int(parsed[1]) * _UNITS[parsed[2][:1]]
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


def date(call: Call, year: Term, month: Term, day: Term) -> object:
    now = _instant(call)
    return call.unify([year, month, day], [now.year, now.month, now.day])


def time(call: Call, hour: Term, minute: Term, second: Term, *milliseconds: Term) -> object:
    now = _instant(call)
    values = [now.hour, now.minute, now.second, now.microsecond // 1_000]
    terms = [hour, minute, second, *milliseconds]
    return call.unify(terms, values[: len(terms)])


ACTIONS: Mapping[str, InternalAction] = {
    ".wait": InternalAction(wait, 1, 3, in_context=False),
    ".at": InternalAction(at, 2, 2),
    ".date": InternalAction(date, 3, 3),
    ".time": InternalAction(time, 3, 4),
}
