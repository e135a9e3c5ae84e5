"""The standard order of terms: numbers, strings, lists, then literals and variables."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cmp_to_key
from typing import TypeAlias

from .terms import Arithmetic, Cons, Function, Literal, Nil, Relation, Term, Var, text


def compare(one: Term, other: Term) -> int:
    """Return a negative number, 0 or a positive one as `one` sorts before, with or after `other`.

    Numbers come first, by value; then strings, lists and literals. Strings compare by their text,
    quotes included; lists element by element and then by length; literals by functor, strong
    negation (negated last), arguments, arity and annotations. An unbound variable is greater than
    anything bound.
    """
    if isinstance(one, Var):
        return _sign(one.name, other.name) if isinstance(other, Var) else 1
    if isinstance(other, Var):
        return -1
    if isinstance(one, float):
        return _sign(one, other) if isinstance(other, float) else -1
    if isinstance(other, float):
        return 1
    if isinstance(one, str) or isinstance(other, str):
        if isinstance(one, str) and isinstance(other, str):
            return _sign(text(one), text(other))
        return -1 if isinstance(one, str) else 1
    if isinstance(one, Nil | Cons):
        if not isinstance(other, Nil | Cons):
            return -1
        return _compare_each(tuple(one), tuple(other))
    if isinstance(other, Nil | Cons):
        return 1
    return _compare_structures(one, other)


def _sign(one: float | str, other: float | str) -> int:
    return (one > other) - (one < other)  # type: ignore[operator]


def _compare_structures(one: Term, other: Term) -> int:
    # What has no parts of its own, as a plan, sorts by how it is written.
    mine, theirs = _parts(one), _parts(other)
    if mine is None or theirs is None:
        return _sign(text(one), text(other))
    return (
        _sign(mine[0], theirs[0])
        or _sign(mine[1], theirs[1])
        or _compare_each(mine[2], theirs[2])
        or _compare_each(mine[3], theirs[3])
    )


_Parts: TypeAlias = tuple[str, bool, tuple[Term, ...], tuple[Term, ...]]


def _parts(term: Term) -> _Parts | None:
    """Return functor, negation, arguments and annotations of a structure; None if it has none."""
    if isinstance(term, Literal):
        return term.functor, term.negated, term.args, term.annots
    if isinstance(term, Relation):
        return f" {term.symbol} ", False, term.operands, ()
    if isinstance(term, Function | Arithmetic):
        return term.symbol, False, term.operands, ()
    return None


def _compare_each(ones: tuple[Term, ...], others: tuple[Term, ...]) -> int:
    """Compare sequences element by element, and then by length."""
    for one, other in zip(ones, others, strict=False):
        order = compare(one, other)
        if order:
            return order
    return _sign(len(ones), len(others))


standard_order = cmp_to_key(compare)


def distinct(terms: Iterable[Term]) -> list[Term]:
    """Return the terms in standard order, each once."""
    result: list[Term] = []
    for term in sorted(terms, key=standard_order):
        if not result or compare(result[-1], term) != 0:
            result.append(term)
    return result


def with_more_annots(literal: Literal, *annots: Term) -> Literal:
    """Return a literal with these annotations beside its own."""
    return literal.with_annots(sorted_annots((*literal.annots, *annots)))


def sorted_annots(annots: tuple[Term, ...]) -> tuple[Term, ...]:
    """Return annotations in standard order and each once; a variable for their tail stays last."""
    return annots if len(annots) < 2 else tuple(distinct(annots))
