"""Tests of the kind of a term."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from ..language.body import BodyTerm
from ..language.containers import Container
from ..language.program import PlanTerm, RuleTerm
from ..language.substitution import Unifier
from ..language.terms import (
    And,
    Cons,
    Literal,
    Nil,
    Not,
    Operation,
    Or,
    Relation,
    Term,
    TriggerTerm,
    Var,
    is_ground,
)
from ..reasoning.calls import Call
from .registry import STANDARD


def _kind(test: Callable[[Term], bool]) -> Callable[..., bool]:
    return lambda call, term: test(term)


def _is_structure(term: Term) -> bool:
    if isinstance(term, Literal):
        return not term.is_atom
    return isinstance(term, Nil | Cons | TriggerTerm | PlanTerm | RuleTerm | BodyTerm | Operation)


def _is_literal(term: Term) -> bool:
    formulas = And | Or | Not | Relation
    return isinstance(term, Literal | TriggerTerm | PlanTerm | RuleTerm | BodyTerm | formulas)


def _kinds(term: Term) -> list[str]:
    """Return the kinds of a term, the narrowest first."""
    if isinstance(term, Container):
        return [term.kind, "ground"]
    return [name for name, test in _KINDS.items() if test(term)]


@STANDARD.add(".type", least=2, most=2)
def kind_of(call: Call, term: Term, kind: Term) -> Iterator[Unifier]:
    """`.type(T, Kind)`: an answer for each kind that a term is of."""
    return call.each(kind, map(Literal, _kinds(term)))


_KINDS: Mapping[str, Callable[[Term], bool]] = {
    "number": lambda term: isinstance(term, float),
    "atom": lambda term: isinstance(term, Literal) and term.is_atom,
    "literal": _is_literal,
    "string": lambda term: isinstance(term, str),
    "list": lambda term: isinstance(term, Nil | Cons),
    "structure": _is_structure,
    "rule": lambda term: isinstance(term, RuleTerm),
    "plan": lambda term: isinstance(term, BodyTerm),
    # The variables of a rule are its own, and are left as they are.
    "ground": lambda term: is_ground(term) and not isinstance(term, RuleTerm),
    "free": lambda term: isinstance(term, Var),
}
"""The kinds of `.type`, in its order. A body in braces is a plan, a whole plan is a structure."""

for _name in ("number", "atom", "literal", "string", "list", "structure", "ground"):
    STANDARD.add(f".{_name}", least=1, most=1)(_kind(_KINDS[_name]))
STANDARD.add(".var", least=1, most=1)(_kind(_KINDS["free"]))
