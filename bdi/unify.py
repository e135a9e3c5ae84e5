"""Unification and substitution.

A unifier is a dict from names of variables to terms. A value may hold
variables that are bound in turn: `substitute` follows them to the end.
"""

from __future__ import annotations

from itertools import count
from typing import TypeAlias

from .arithmetic import NAN, OPERATORS, apply_function
from .order import sorted_annots
from .program import BodyTerm, PlanTerm, TriggerTerm
from .terms import (
    EMPTY,
    And,
    AnnotatedVar,
    Arithmetic,
    Cons,
    Function,
    Literal,
    Nil,
    Not,
    Or,
    Relation,
    RestVar,
    Term,
    Var,
    is_ground,
    make_list,
)

Unifier: TypeAlias = dict[str, Term]


class Names:
    """Makes variables that no clause names."""

    def __init__(self) -> None:
        self._numbers = count(1)

    def fresh(self, hint: str = "") -> Var:
        return Var(f"_{next(self._numbers)}{hint.lstrip('_')}", fresh=True)


def walk(term: Term, u: Unifier) -> Term:
    """What a variable stands for, as far as it is bound; any other term itself."""
    while isinstance(term, Var):
        value = u.get(term.name)
        if value is None:
            return term
        term = value
    return term


def substitute(term: Term, u: Unifier) -> Term:
    """The term with its variables replaced by their values and its arithmetic done."""
    if term.__class__ is float or term.__class__ is str:
        return term
    if term.__class__ is Var:
        value = walk(term, u)
        if isinstance(value, Var) or is_ground(value):
            return value
        return substitute(value, u)
    if term.__class__ is Literal:
        return term if term.ground else substitute_literal(term, u)
    if term.__class__ is Arithmetic:
        return _calculate(term, u)
    return _substitute_other(term, u)


def substitute_literal(literal: Literal, u: Unifier) -> Literal:
    annots = literal.annots
    if annots:
        values: list[Term] = []
        rest: tuple[Term, ...] = ()
        for annot in annots:
            value = substitute(annot, u)
            if isinstance(annot, RestVar) and isinstance(value, Nil | Cons):
                values.extend(value)
            elif isinstance(annot, RestVar) and isinstance(value, Var):
                rest = (RestVar(value.name, value.fresh),)
            else:
                values.append(value)
        annots = sorted_annots(tuple(values)) + rest
    return Literal(
        literal.functor,
        tuple([substitute(arg, u) for arg in literal.args]),
        annots,
        literal.negated,
    )


def _calculate(term: Arithmetic, u: Unifier) -> Term:
    left = substitute(term.left, u)
    if term.right is None:
        if left.__class__ is float:
            return -left if term.operator == "-" else left
        return NAN if is_ground(left) else Arithmetic(term.operator, left)
    right = substitute(term.right, u)
    if left.__class__ is float and right.__class__ is float:
        return OPERATORS[term.operator](left, right)
    if is_ground(left) and is_ground(right):
        return NAN
    return Arithmetic(term.operator, left, right)


def _substitute_other(term: Term, u: Unifier) -> Term:
    if isinstance(term, Cons):
        return term if term.ground else _substitute_list(term, u)
    if isinstance(term, Function):
        args = tuple(substitute(arg, u) for arg in term.args)
        if not all(map(is_ground, args)):
            return Function(term.name, args, term.calculate)
        return apply_function(term.name, args, term.calculate)
    if isinstance(term, Relation):
        return Relation(term.symbol, substitute(term.left, u), substitute(term.right, u))
    if isinstance(term, And | Or):
        return term.__class__(substitute(term.left, u), substitute(term.right, u))
    if isinstance(term, Not):
        return Not(substitute(term.formula, u))
    if isinstance(term, AnnotatedVar):
        return _substitute_annotated(term, u)
    if isinstance(term, Var):
        return substitute(Var(term.name), u)
    if isinstance(term, PlanTerm | BodyTerm | TriggerTerm):
        return term.substituted(lambda part: substitute(part, u))
    return term


def _substitute_list(cell: Cons, u: Unifier) -> Term:
    elements: list[Term] = []
    rest: Term = cell
    while isinstance(rest, Cons):
        if rest.ground:
            break
        elements.append(substitute(rest.head, u))
        rest = walk(rest.tail, u)
    return make_list(elements, rest)


def _substitute_annotated(term: AnnotatedVar, u: Unifier) -> Term:
    annots = tuple(substitute(annot, u) for annot in term.annots)
    value = substitute(Var(term.name), u)
    if isinstance(value, Literal):
        return value.with_annots(sorted_annots(value.annots + annots))
    if isinstance(value, Var):
        return AnnotatedVar(value.name, annots)
    return value


def unify(one: Term, other: Term, u: Unifier) -> bool:
    """Whether the terms can be made equal; binds what that takes in `u`, also when they cannot.

    The annotations of the first have to be among those of the second.
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
    """Whether each of `mine` is one of `theirs`, each of these taken once."""
    remaining = [annot for annot in theirs if not isinstance(annot, RestVar)]
    for annot in mine:
        if isinstance(annot, RestVar):
            return unify(Var(annot.name), make_list(remaining), u)
        for position, candidate in enumerate(remaining):
            attempt = dict(u)
            if unify(annot, candidate, attempt):
                u.update(attempt)
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
            mine, theirs = substitute(one, u), substitute(other, u)
            return mine == theirs if mine is one and theirs is other else _again(mine, theirs, u)
    if isinstance(one, AnnotatedVar):
        return _unify_annotated(one, other, u)
    if isinstance(other, AnnotatedVar):
        return _unify_annotated(other, one, u)
    if isinstance(one, Var) or isinstance(other, Var):
        return unify(_plain(one), _plain(other), u)
    if isinstance(one, Relation | And | Or) and isinstance(other, Relation | And | Or):
        return (
            one.symbol == other.symbol
            and unify(one.left, other.left, u)
            and unify(one.right, other.right, u)
        )
    if isinstance(one, Not) and isinstance(other, Not):
        return unify(one.formula, other.formula, u)
    if isinstance(one, TriggerTerm) and isinstance(other, TriggerTerm):
        return one.kind == other.kind and unify(one.literal, other.literal, u)
    return one == other


def _again(one: Term, other: Term, u: Unifier) -> bool:
    if isinstance(one, Arithmetic | Function) or isinstance(other, Arithmetic | Function):
        return one == other
    return unify(one, other, u)


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
    """A unifier that makes the terms equal and agrees with `u`, which stays as it is; or None."""
    result = dict(u)
    return result if unify(one, other, result) else None


def matched(pattern: Literal, belief: Literal, u: Unifier) -> Unifier | None:
    """`unified` for a query without annotations and a belief of its functor and arity."""
    result = u
    for mine, theirs in zip(pattern.args, belief.args):  # noqa: B905 - equal lengths, and often
        if mine.__class__ is Var:
            value = result.get(mine.name)
            if value is None:
                if theirs.__class__ is Var or theirs.__class__ is Arithmetic:
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


def rename(term: Term, names: Names, renamed: dict[str, Var]) -> Term:
    """The term with a fresh variable for each one that a clause names; `renamed` says which."""

    def variable(var: Var) -> Var:
        if var.fresh:
            return var
        if var.name not in renamed:
            renamed[var.name] = names.fresh(var.name)
        return renamed[var.name]

    def inside(part: Term) -> Term:
        return rename(part, names, renamed)

    if is_ground(term):
        return term
    if isinstance(term, AnnotatedVar):
        return AnnotatedVar(variable(term).name, tuple(map(inside, term.annots)))
    if isinstance(term, RestVar):
        return RestVar(variable(term).name, fresh=True)
    if isinstance(term, Var):
        return variable(term)
    if isinstance(term, Literal):
        return Literal(
            term.functor,
            tuple(map(inside, term.args)),
            tuple(map(inside, term.annots)),
            term.negated,
        )
    if isinstance(term, Cons):
        elements = [inside(element) for element in term]
        rest = term.open_tail
        return make_list(elements, EMPTY if rest is None else variable(rest))
    if isinstance(term, Arithmetic):
        right = None if term.right is None else inside(term.right)
        return Arithmetic(term.operator, inside(term.left), right)
    if isinstance(term, Function):
        return Function(term.name, tuple(map(inside, term.args)), term.calculate)
    if isinstance(term, Relation):
        return Relation(term.symbol, inside(term.left), inside(term.right))
    if isinstance(term, And | Or):
        return term.__class__(inside(term.left), inside(term.right))
    if isinstance(term, Not):
        return Not(inside(term.formula))
    return term


def variable_names(term: Term) -> tuple[str, ...]:
    """The names of a term's variables, each once."""
    found: dict[str, None] = {}
    pending: list[Term] = [term]
    while pending:
        part = pending.pop()
        if is_ground(part):
            continue
        if isinstance(part, Var):
            found[part.name] = None
            if isinstance(part, AnnotatedVar):
                pending.extend(part.annots)
        elif isinstance(part, Literal):
            pending.extend((*part.args, *part.annots))
        elif isinstance(part, Cons):
            pending.extend(part)
            if part.open_tail is not None:
                pending.append(part.open_tail)
        elif isinstance(part, Arithmetic):
            pending.extend((part.left,) if part.right is None else (part.left, part.right))
        elif isinstance(part, Function):
            pending.extend(part.args)
        elif isinstance(part, Relation | And | Or):
            pending.extend((part.left, part.right))
        elif isinstance(part, Not):
            pending.append(part.formula)
    return tuple(found)
