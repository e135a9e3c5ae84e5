"""Tests of the kind of a term."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ..language.terms import Cons, Literal, Nil, Term, Var, is_ground
from ..reasoning.actions import InternalAction
from ..reasoning.calls import Call


def _kind(test: Callable[[Term], bool]) -> InternalAction:
    def check(call: Call, term: Term) -> bool:
        return test(term)

    return InternalAction(check, 1, 1)


def _is_structure(term: Term) -> bool:
    return isinstance(term, Nil | Cons) or (isinstance(term, Literal) and bool(term.args))


ACTIONS: Mapping[str, InternalAction] = {
    ".string": _kind(lambda term: isinstance(term, str)),
    ".number": _kind(lambda term: isinstance(term, float)),
    ".atom": _kind(lambda term: isinstance(term, Literal) and term.is_atom),
    ".list": _kind(lambda term: isinstance(term, Nil | Cons)),
    ".literal": _kind(lambda term: isinstance(term, Literal)),
    ".structure": _kind(_is_structure),
    ".ground": _kind(is_ground),
    ".var": _kind(lambda term: isinstance(term, Var)),
}
