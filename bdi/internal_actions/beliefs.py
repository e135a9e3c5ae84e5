"""Actions on beliefs and percepts."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from ..terms import Literal, Term, Var
from .call import Call, InternalAction, a_literal, wrong


def abolish(call: Call, pattern: Term) -> bool:
    """Removes all beliefs that match, whatever their source when the pattern names none."""
    if not isinstance(pattern, Literal | Var):
        raise wrong("abolish", "first argument must be a literal or variable.")
    for found in call.agent.beliefs.matching(pattern, call.unifier):
        call.agent.disbelieve(found)
    return True


def perceive(call: Call) -> bool:
    """Percepts are believed as soon as they come; there is nothing to hurry."""
    return True


def add_at_front(call: Call, belief: Term) -> bool:
    call.agent.believe(a_literal("asserta", belief))
    return True


ACTIONS: Mapping[str, InternalAction] = MappingProxyType(
    {
        ".abolish": InternalAction(abolish, 1, 1),
        ".perceive": InternalAction(perceive, 0, 0),
        ".asserta": InternalAction(add_at_front, 1, 1),
    }
)
