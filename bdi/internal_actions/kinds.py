"""Tests of the kind of a term."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from ..language.body import BodyTerm
from ..language.containers import Container
from ..language.program import PlanTerm, RuleTerm
from ..language.substitution import Unifier
from ..language.terms import Cons, Literal, Nil, Operation, Term, TriggerTerm, Var, is_ground
from ..reasoning.actions import InternalAction
from ..reasoning.calls import Call


def _kind(test: Callable[[Term], bool]) -> InternalAction:
    def check(call: Call, term: Term) -> bool:
        return test(term)

    return InternalAction(check, 1, 1)


def _is_structure(term: Term) -> bool:
    if isinstance(term, Literal):
        return not term.is_atom
    return isinstance(term, Nil | Cons | TriggerTerm | PlanTerm | RuleTerm | BodyTerm | Operation)


def _is_literal(term: Term) -> bool:
    return isinstance(term, Literal | TriggerTerm | PlanTerm | RuleTerm | BodyTerm)


def _kinds(term: Term) -> list[str]:
    """Return the kinds of a term, the narrowest first."""
    if isinstance(term, Container):
        return [term.kind, "ground"]
    tests = {name.lstrip("."): action for name, action in _TESTS.items() if name != ".var"}
    found = [name for name, test in tests.items() if test(term)]
    return [*found, "free"] if isinstance(term, Var) else found


def kind_of(call: Call, term: Term, kind: Term) -> Iterator[Unifier]:
    """`.type(T, Kind)`: an answer for each kind that a term is of."""
    return call.each(kind, map(Literal, _kinds(term)))


_TESTS: Mapping[str, Callable[[Term], bool]] = {
    ".string": lambda term: isinstance(term, str),
    ".number": lambda term: isinstance(term, float),
    ".atom": lambda term: isinstance(term, Literal) and term.is_atom,
    ".literal": _is_literal,
    ".list": lambda term: isinstance(term, Nil | Cons),
    ".structure": _is_structure,
    ".ground": is_ground,
    ".var": lambda term: isinstance(term, Var),
}

ACTIONS: Mapping[str, InternalAction] = {
    **{name: _kind(test) for name, test in _TESTS.items()},
    ".type": InternalAction(kind_of, 2, 2),
}
