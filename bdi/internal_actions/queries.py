"""Actions that ask for all answers of a formula."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType

from ..order import standard_order
from ..terms import Literal, Term, make_list
from ..unify import Unifier, substitute
from .call import Call, InternalAction, a_list


def _answers(call: Call, term: Term, formula: Term) -> list[Term]:
    return [substitute(term, u) for u in call.agent.logic.solutions(formula, call.unifier)]


def findall(call: Call, term: Term, formula: Term, result: Term) -> object:
    return call.unify(result, make_list(_answers(call, term, formula)))


def setof(call: Call, term: Term, formula: Term, result: Term) -> object:
    return call.unify(result, make_list(distinct(_answers(call, term, formula))))


def distinct(terms: list[Term]) -> list[Term]:
    """Terms in standard order, each once."""
    ordered: list[Term] = []
    for term in sorted(terms, key=standard_order):
        if not ordered or standard_order(ordered[-1]) != standard_order(term):
            ordered.append(term)
    return ordered


def count(call: Call, what: Term, *more: Term) -> object:
    """`.count(Formula, N)`, or of the elements of a list that are equal: `.count(E, List, N)`."""
    if len(more) == 1:
        number = sum(1 for _ in call.agent.logic.solutions(what, call.unifier))
        return call.unify(more[0], number)
    elements = a_list("count", more[0], "second")
    number = sum(call.unify(what, element) is not None for element in elements)
    return call.unify(more[1], number)


def belief(call: Call, pattern: Term) -> Iterator[Unifier]:
    """The beliefs themselves, not what rules make of them."""
    if isinstance(pattern, Literal):
        for found in call.agent.beliefs.matching(pattern, call.unifier):
            solution = call.unify(pattern, found)
            if solution is not None:
                yield solution


ACTIONS: Mapping[str, InternalAction] = MappingProxyType(
    {
        ".findall": InternalAction(findall, 3, 3),
        ".setof": InternalAction(setof, 3, 3),
        ".count": InternalAction(count, 2, 3),
        ".belief": InternalAction(belief, 1, 1),
    }
)
