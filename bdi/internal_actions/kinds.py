"""Tests of the kind of a term."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from ..language.body import BodyTerm
from ..language.containers import Container
from ..language.program import PlanTerm, RuleTerm
from ..language.substitution import Unifier
from ..language.terms import Cons, Literal, Nil, Operation, Term, TriggerTerm, Var, is_ground
from ..reasoning.calls import Call
from .registry import STANDARD


def _kind(test: Callable[[Term], bool]) -> Callable[..., bool]:
    return lambda call, term: test(term)


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


@STANDARD.add(".type", least=2, most=2)
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

for _name, _test in _TESTS.items():
    STANDARD.add(_name, least=1, most=1)(_kind(_test))
