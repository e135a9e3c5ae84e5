"""Unification of terms: Robinson's algorithm (1965) over triangular unifiers, without occurs check.

As in Prolog and in Jason a variable may be bound to a term that contains it; substitution then
nests too deeply and stops the agent. Two things are AgentSpeak's own: annotations unify as subsets,
and arithmetic is evaluated before it is compared.
"""

from __future__ import annotations

from .substitution import Unifier, substitute, walk
from .terms import (
    AnnotatedVar,
    Arithmetic,
    Cons,
    Function,
    Literal,
    Operation,
    RestVar,
    Term,
    TriggerTerm,
    Var,
    make_list,
)


def unify(one: Term, other: Term, u: Unifier) -> bool:
    """Return True if the terms can be made equal, and bind in `u` the variables that this takes.

    The annotations of the first must be among those of the second. If the terms cannot be made
    equal, `u` keeps the bindings made until then.
    """
    while one.__class__ is Var:
        value = u.get(one.name)
        if value is None:
            break
        one = value
    while other.__class__ is Var:
        value = u.get(other.name)
        if value is None:
            break
        other = value
    if one is other:
        return True
    if one.__class__ is Var:
        return _bind(one, other, u)
    if other.__class__ is Var:
        return _bind(other, one, u)
    if one.__class__ is Literal and other.__class__ is Literal:
        return unify_literals(one, other, u)
    if one.__class__ is float or one.__class__ is str:
        if other.__class__ is Arithmetic or other.__class__ is Function:
            other = substitute(other, u)
        return one == other or (isinstance(other, Var) and unify(other, one, u))
    return _unify_others(one, other, u)


def try_unify(one: Term, other: Term, u: Unifier) -> bool:
    """Do as `unify`, but leave `u` unchanged if the terms cannot be made equal."""
    attempt = dict(u)
    if not unify(one, other, attempt):
        return False
    u.update(attempt)
    return True


def _bind(var: Var, value: Term, u: Unifier) -> bool:
    if value.__class__ is Arithmetic or value.__class__ is Function:
        value = substitute(value, u)
    if value.__class__ is Var and value.name == var.name:
        return True
    if value.__class__ is Var and not value.fresh and var.fresh:
        u[value.name] = var
    else:
        u[var.name] = value
    return True


def unify_literals(one: Literal, other: Literal, u: Unifier) -> bool:
    if (
        one.functor != other.functor
        or len(one.args) != len(other.args)
        or one.negated != other.negated
    ):
        return False
    for mine, theirs in zip(one.args, other.args):  # noqa: B905 - equal lengths, and often
        if not unify(mine, theirs, u):
            return False
    return not one.annots or unify_annots(one.annots, other.annots, u)


def unify_annots(mine: tuple[Term, ...], theirs: tuple[Term, ...], u: Unifier) -> bool:
    """Unify each of `mine` with another one of `theirs`, or a tail of `mine` with what is left."""
    remaining = [annot for annot in theirs if not isinstance(annot, RestVar)]
    for annot in mine:
        if isinstance(annot, RestVar):
            return unify(Var(annot.name), make_list(remaining), u)
        for position, candidate in enumerate(remaining):
            if try_unify(annot, candidate, u):
                del remaining[position]
                break
        else:
            return False
    return True


def _unify_others(one: Term, other: Term, u: Unifier) -> bool:
    if isinstance(one, Cons) and isinstance(other, Cons):
        return _unify_lists(one, other, u)
    for term in (one, other):
        if isinstance(term, Arithmetic | Function):
            one, other = substitute(one, u), substitute(other, u)
            if isinstance(one, Arithmetic | Function) or isinstance(other, Arithmetic | Function):
                return one == other
            return unify(one, other, u)
    if isinstance(one, AnnotatedVar):
        return _unify_annotated(one, other, u)
    if isinstance(other, AnnotatedVar):
        return _unify_annotated(other, one, u)
    if isinstance(one, Var) or isinstance(other, Var):
        return unify(_plain(one), _plain(other), u)
    if isinstance(one, Operation) and isinstance(other, Operation):
        pairs = zip(one.operands, other.operands)  # noqa: B905 - equal with equal symbols
        return one.symbol == other.symbol and all(unify(*pair, u) for pair in pairs)
    if isinstance(one, TriggerTerm) and isinstance(other, TriggerTerm):
        return one.sort == other.sort and unify(one.literal, other.literal, u)
    return one == other


def _plain(term: Term) -> Term:
    return Var(term.name) if isinstance(term, Var) else term


def _unify_lists(one: Cons, other: Cons, u: Unifier) -> bool:
    mine: Term = one
    theirs: Term = other
    while isinstance(mine, Cons) and isinstance(theirs, Cons):
        if mine is theirs:
            return True
        if not unify(mine.head, theirs.head, u):
            return False
        mine, theirs = walk(mine.tail, u), walk(theirs.tail, u)
    return unify(mine, theirs, u)


def _unify_annotated(pattern: AnnotatedVar, value: Term, u: Unifier) -> bool:
    if isinstance(value, AnnotatedVar):
        return unify(Var(pattern.name), Var(value.name), u)
    if not isinstance(value, Literal):
        return False
    bound = walk(Var(pattern.name), u)
    if isinstance(bound, Literal):
        return unify_annots(pattern.annots, value.annots, u) and unify(bound, value, u)
    if not unify_annots(pattern.annots, value.annots, u):
        return False
    u[pattern.name] = value.without_annots()
    return True


def unified(one: Term, other: Term, u: Unifier) -> Unifier | None:
    """Return `u` extended so that the terms are equal, or None. `u` itself is not changed."""
    result = dict(u)
    return result if unify(one, other, result) else None


def matched(pattern: Literal, belief: Literal, u: Unifier) -> Unifier | None:
    """Return `unified` of a query without annotations and a belief of its functor and arity.

    Most of a program's time is spent here, so the frequent arguments, numbers, strings and atoms,
    are compared in place, and `u` is copied only when there is something to bind.
    """
    result = u
    for mine, theirs in zip(pattern.args, belief.args):  # noqa: B905 - equal lengths, and often
        if mine.__class__ is Var:
            value = result.get(mine.name)
            if value is None:
                kind = theirs.__class__
                if kind is Var or kind is Arithmetic or kind is Function:
                    return unified(pattern, belief, u)
                if result is u:
                    result = dict(u)
                result[mine.name] = theirs
                continue
            mine = value
        if mine is theirs:
            continue
        if (mine.__class__ is float or mine.__class__ is str) and (
            theirs.__class__ is float or theirs.__class__ is str
        ):
            if mine != theirs:
                return None
            continue
        if mine.__class__ is Literal and theirs.__class__ is Literal:
            if mine.key != theirs.key:
                return None
            if not mine.args and not mine.annots:
                continue
        if result is u:
            result = dict(u)
        if not unify(mine, theirs, result):
            return None
    return result
