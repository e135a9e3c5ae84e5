"""Unifiers, and what they make of terms.

A unifier is a dict from names of variables to terms. It is triangular: a value may contain
variables that are bound in turn, and `substitute` follows them to the end. Binding a variable
therefore costs one entry, however large the terms (Baader and Snyder, "Unification theory", 2001).
"""

from __future__ import annotations

from itertools import count
from typing import TypeAlias, overload

from .arithmetic import NAN, OPERATORS, apply_function
from .order import sorted_annots
from .terms import (
    DEFAULT,
    ONLY_SELF,
    AnnotatedVar,
    Arithmetic,
    Cons,
    Function,
    Literal,
    Nil,
    Operation,
    Qualified,
    Quoted,
    RestVar,
    Term,
    TriggerTerm,
    Var,
    is_ground,
    make_list,
    parts,
    placed,
    rebuilt,
)

Unifier: TypeAlias = dict[str, Term]


class Names:
    """Source of fresh variables, which no clause names."""

    def __init__(self) -> None:
        self._numbers = count(1)

    def fresh(self, hint: str = "") -> Var:
        """Return a new variable whose name ends with `hint`."""
        return Var(f"_{next(self._numbers)}{hint.lstrip('_')}", fresh=True)


def walk(term: Term, u: Unifier) -> Term:
    """Return the term to which a variable is bound, or the term itself if it is no variable."""
    while isinstance(term, Var):
        value = u.get(term.name)
        if value is None:
            return term
        term = value
    return term


def substitute(term: Term, u: Unifier) -> Term:
    """Return the term with its variables replaced by their values and its arithmetic done."""
    if term.__class__ is float or term.__class__ is str:
        return term
    if term.__class__ is Var:
        value = u.get(term.name)
        if value is None:
            return term
        if value.__class__ is float:
            return value
        value = walk(value, u)
        # The unifier is triangular: a value with variables has them replaced in turn.
        return value if isinstance(value, Var) or is_ground(value) else substitute(value, u)
    if term.__class__ is Literal:
        return term if term.ground else substitute_literal(term, u)
    if term.__class__ is Arithmetic:
        return _calculate(term, u)
    return _substitute_other(term, u)


def substitute_literal(literal: Literal, u: Unifier) -> Literal:
    """Return the literal with its variables replaced by their values, annotations sorted again."""
    annots = literal.annots
    if not annots or annots is ONLY_SELF:
        return literal.with_args(tuple([value_of(arg, u) for arg in literal.args]))
    annots = _substitute_annots(annots, u)
    return Literal(
        literal.functor,
        tuple([substitute(arg, u) for arg in literal.args]),
        annots,
        literal.negated,
    )


def _substitute_annots(annots: tuple[Term, ...], u: Unifier) -> tuple[Term, ...]:
    """Return annotations with their variables replaced: sorted again, an open tail last."""
    if all(map(is_ground, annots)):
        return annots
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
    return sorted_annots(tuple(values)) + rest


def _calculate(term: Arithmetic, u: Unifier) -> Term:
    left, right = term.operands
    left, right = substitute(left, u), substitute(right, u)
    if left.__class__ is float and right.__class__ is float:
        return OPERATORS[term.symbol](left, right)
    if is_ground(left) and is_ground(right):
        return NAN
    return Arithmetic(term.symbol, left, right)


def _substitute_other(term: Term, u: Unifier) -> Term:
    if isinstance(term, Cons):
        return term if term.ground else _substitute_list(term, u)
    if isinstance(term, Function):
        # `.count` and its like look at the formula itself, whose variables must stay as they are.
        if term.counts and term.calculate is not None:
            return term.calculate(term.operands[0], u)
        args = tuple(substitute(arg, u) for arg in term.operands)
        if not all(map(is_ground, args)):
            return term.with_operands(args)
        return apply_function(term.symbol, args, term.calculate)
    if isinstance(term, Qualified):
        return _substitute_qualified(term, u)
    if isinstance(term, Operation):
        return rebuilt(term, lambda part: substitute(part, u))
    if isinstance(term, AnnotatedVar):
        return _substitute_annotated(term, u)
    if isinstance(term, Var):
        return substitute(Var(term.name), u)
    if isinstance(term, TriggerTerm):
        return rebuilt(term, lambda part: substitute(part, u))
    if isinstance(term, Quoted):
        return term if term.ground else term.changed(lambda part: _inside_quoted(part, u))
    return term


def _inside_quoted(part: object, u: Unifier) -> Term | None:
    """Return the value of a variable, or of arithmetic that has one; None for anything else."""
    if isinstance(part, Var | Arithmetic | Qualified):
        return substitute(part, u)
    return None


def _substitute_qualified(term: Qualified, u: Unifier) -> Term:
    namespace, inner = (substitute(part, u) for part in term.operands)
    if isinstance(inner, Literal) and isinstance(namespace, Literal):
        if namespace == DEFAULT:
            negated = inner.negated or term.negated
            return Literal(inner.functor, inner.args, inner.annots, negated)
        return placed(inner, namespace.functor, True if term.negated else None)
    if isinstance(inner, Literal | Var | Qualified):
        return Qualified(namespace, inner, term.negated)
    return inner


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
    annots = _substitute_annots(term.annots, u)
    value = substitute(Var(term.name), u)
    if isinstance(value, Literal):
        rest = annots[-1:] if annots and isinstance(annots[-1], RestVar) else ()
        own = annots[: len(annots) - len(rest)]
        return Literal(
            value.functor, value.args, (*sorted_annots(value.annots + own), *rest), value.negated
        )
    if isinstance(value, Var):
        return AnnotatedVar(value.name, annots) if annots else value
    return value.annotated(annots) if isinstance(value, Quoted) else value


def value_of(term: Term, u: Unifier) -> Term:
    """Do as `substitute`, faster for what arguments mostly are: variables, and atoms they have."""
    if term.__class__ is Var:
        value = u.get(term.name)
        if value is None:
            return term
        term = value
    if term.__class__ is Literal and term.ground:
        return term
    return substitute(term, u)


@overload
def rename(term: Literal, names: Names, renamed: dict[str, Var]) -> Literal: ...
@overload
def rename(term: Term, names: Names, renamed: dict[str, Var]) -> Term: ...
def rename(term: Term, names: Names, renamed: dict[str, Var]) -> Term:
    """Return the term with a fresh variable for each one that a clause names: standardised apart.

    So two uses of one clause share no variable, as resolution needs (Robinson 1965).
    `renamed` receives the fresh variable of each name, and gives those it already has.
    """

    def inside(part: Term) -> Term:
        if isinstance(part, Var):
            new = part
            if not part.fresh:
                new = renamed.get(part.name) or names.fresh(part.name)
                renamed[part.name] = new
            if isinstance(part, AnnotatedVar):
                return AnnotatedVar(new.name, tuple(map(inside, part.annots)))
            return RestVar(new.name, fresh=True) if isinstance(part, RestVar) else new
        return part if is_ground(part) else rebuilt(part, inside)

    return term if is_ground(term) else inside(term)


def variable_names(term: Term) -> tuple[str, ...]:
    """Return the names of a term's variables, each once."""
    found: dict[str, None] = {}
    pending: list[Term] = [term]
    while pending:
        part = pending.pop()
        if part.__class__ is Var:
            found[part.name] = None
        elif not is_ground(part):
            if isinstance(part, Var):
                found[part.name] = None
            pending.extend(parts(part))
    return tuple(found)
