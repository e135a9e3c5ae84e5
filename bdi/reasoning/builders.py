"""Terms, compiled to Python closures.

What `substitute` finds out about a term each time it meets it is found out here once, when a plan
is loaded: which arguments are constants, and which are plain variables. Forms that are not frequent
are left to it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from ..language.arithmetic import OPERATORS
from ..language.substitution import Unifier, substitute
from ..language.terms import Arithmetic, Literal, Term, Var, is_ground

Build: TypeAlias = "Callable[[Unifier], Term]"


def builder(term: Term) -> Build:
    """Return a function equal to `lambda u: substitute(term, u)`, but faster."""
    if is_ground(term):
        return lambda u: term
    if term.__class__ is Var:
        return _build_variable(term)
    if isinstance(term, Arithmetic):
        return _build_arithmetic(term)
    if isinstance(term, Literal) and all(map(is_ground, term.annots)):
        return _build_literal(term)
    return lambda u: substitute(term, u)


def _build_variable(variable: Var) -> Build:
    name = variable.name

    def build(u: Unifier) -> Term:
        value = u.get(name)
        if value is None:
            return variable
        if value.__class__ is Literal:
            return value if value.ground else substitute(value, u)
        return value if value.__class__ is float else substitute(value, u)

    return build


def _build_arithmetic(term: Arithmetic) -> Build:
    left, right = term.operands
    calculate = OPERATORS[term.symbol]
    left_of = builder(left)
    if right.__class__ is float:

        def build_with_constant(u: Unifier) -> Term:
            left = left_of(u)
            if left.__class__ is float:
                return calculate(left, right)
            return substitute(term, u)

        return build_with_constant
    right_of = builder(right)

    def build(u: Unifier) -> Term:
        left, right = left_of(u), right_of(u)
        if left.__class__ is float and right.__class__ is float:
            return calculate(left, right)
        return substitute(term, u)

    return build


def _build_literal(literal: Literal) -> Build:
    build_args = [builder(arg) for arg in literal.args]
    if len(build_args) == 1:
        (only,) = build_args
        return lambda u: literal.with_args((only(u),))
    if len(build_args) == 2:
        first, second = build_args
        return lambda u: literal.with_args((first(u), second(u)))
    if len(build_args) == 3:
        first, second, third = build_args
        return lambda u: literal.with_args((first(u), second(u), third(u)))
    return lambda u: literal.with_args(tuple([build(u) for build in build_args]))
