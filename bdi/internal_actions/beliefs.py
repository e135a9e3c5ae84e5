"""Actions on beliefs, and queries for all answers of a formula."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from ..language.order import distinct
from ..language.substitution import Unifier, substitute
from ..language.terms import Literal, Term, Var
from ..reasoning.actions import InternalAction
from ..reasoning.calls import Call
from .arguments import a_list, a_literal, wrong


def abolish(call: Call, pattern: Term) -> bool:
    """Remove all beliefs that match, from any source if the pattern names none."""
    if not isinstance(pattern, Literal | Var):
        raise wrong("abolish", "first argument must be a literal or variable.")
    for found in call.agent.beliefs.matching(pattern, call.unifier):
        call.agent.disbelieve(found)
    return True


def perceive(call: Call) -> bool:
    """Do nothing: percepts are believed as soon as they come."""
    return True


def add_at_front(call: Call, belief: Term) -> bool:
    call.agent.believe(a_literal("asserta", belief))
    return True


def belief(call: Call, pattern: Term) -> Iterator[Unifier]:
    """Yield an answer for each belief, and none for what rules derive."""
    if isinstance(pattern, Literal):
        found = call.agent.beliefs.matching(pattern, call.unifier)
        yield from call.each(pattern, found)


def answers(call: Call, term: Term, formula: Term) -> list[Term]:
    """Return a term as it is in each solution of a formula."""
    return [substitute(term, u) for u in call.agent.logic.solutions(formula, call.unifier)]


def findall(call: Call, term: Term, formula: Term, result: Term) -> object:
    return call.unify(result, answers(call, term, formula))


def setof(call: Call, term: Term, formula: Term, result: Term) -> object:
    return call.unify(result, distinct(answers(call, term, formula)))


def count(call: Call, what: Term, *more: Term) -> object:
    """`.count(Formula, N)`, or `.count(Element, List, N)` for the elements that unify."""
    if len(more) == 1:
        number = sum(1 for _ in call.agent.logic.solutions(what, call.unifier))
        return call.unify(more[0], number)
    elements = a_list("count", more[0], "second")
    number = sum(call.unify(what, element) is not None for element in elements)
    return call.unify(more[1], number)


ACTIONS: Mapping[str, InternalAction] = {
    ".abolish": InternalAction(abolish, 1, 1),
    ".perceive": InternalAction(perceive, 0, 0),
    ".asserta": InternalAction(add_at_front, 1, 1),
    ".belief": InternalAction(belief, 1, 1),
    ".findall": InternalAction(findall, 3, 3),
    ".setof": InternalAction(setof, 3, 3),
    ".count": InternalAction(count, 2, 3),
}
