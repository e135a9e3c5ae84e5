"""Simulated time: waiting, events to come, dates."""

from __future__ import annotations

import re
from collections.abc import Mapping
from datetime import datetime, timedelta
from types import MappingProxyType

from ..errors import ProgramError
from ..failure import ActionError
from ..intentions import Event
from ..parser import parse_trigger
from ..program import BodyTerm, TriggerTerm
from ..steps import WAITING, Waiting
from ..terms import And, Literal, Not, Or, Relation, Term, Var, text
from ..unify import rename
from ..waiting import MILLISECOND, Wait
from .call import Call, InternalAction, a_number, wrong

#: What `.date` and `.time` say at simulated time 0.
EPOCH = datetime(2023, 1, 1)

_UNITS = {"": 1, "s": 1_000, "m": 60_000, "h": 3_600_000, "d": 86_400_000}
_AT = re.compile(r"now\s*\+\s*(\d+)\s*(s|seconds?|m|minutes?|h|hours?|d|days?|)\s*", re.ASCII)


def a_trigger(term: Term) -> TriggerTerm | None:
    """The event a term stands for: `{+b}`, or the same in a string."""
    if isinstance(term, TriggerTerm):
        return term
    if isinstance(term, BodyTerm):
        return term.as_trigger
    if isinstance(term, str):
        try:
            return parse_trigger(term)
        except ProgramError as error:
            raise ActionError(str(error), "wrong_arguments") from None
    return None


def wait(call: Call, what: Term, *more: Term) -> object:
    agent, intention = call.agent, call.intention
    if intention is None:
        raise wrong("wait", "it cannot be used in a context")
    reason: Term
    if isinstance(what, float):
        milliseconds = float(max(0, int(what)))
        Wait(agent, intention, timeout=int(milliseconds))
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
        Wait(
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
        agent.circumstance.post(Event(trigger.kind, literal))

    alarm = agent.alarms.set(agent.clock + milliseconds * MILLISECOND, happen)
    announced.append(alarm)
    return True


def _instant(call: Call) -> datetime:
    return EPOCH + timedelta(microseconds=call.agent.clock // 1_000)


def date(call: Call, year: Term, month: Term, day: Term) -> object:
    now = _instant(call)
    return _unify_all(call, (year, month, day), (now.year, now.month, now.day))


def time(call: Call, hour: Term, minute: Term, second: Term, *milliseconds: Term) -> object:
    now = _instant(call)
    values = (now.hour, now.minute, now.second, now.microsecond // 1_000)
    terms = (hour, minute, second, *milliseconds)
    return _unify_all(call, terms, values[: len(terms)])


def _unify_all(call: Call, terms: tuple[Term, ...], values: tuple[int, ...]) -> object:
    return call.unify(list(terms), list(values))


ACTIONS: Mapping[str, InternalAction] = MappingProxyType(
    {
        ".wait": InternalAction(wait, 1, 3, in_context=False),
        ".at": InternalAction(at, 2, 2),
        ".date": InternalAction(date, 3, 3),
        ".time": InternalAction(time, 3, 4),
    }
)

__all__ = ["ACTIONS", "EPOCH", "Waiting", "a_trigger"]
