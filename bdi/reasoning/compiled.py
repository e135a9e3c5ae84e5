"""Terms, conditions and triggers of plans, compiled to Python closures.

What `substitute`, `Logic.first` and `unify` find out about a term each time they meet it is found
out here once, when a plan is loaded: which arguments are constants, which are plain variables,
which comparison it is. Forms that are not frequent are left to them.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TypeAlias

from ..language.arithmetic import OPERATORS
from ..language.substitution import Unifier, substitute
from ..language.terms import (
    TRUE,
    And,
    Arithmetic,
    Literal,
    Not,
    Qualified,
    Relation,
    Term,
    Var,
    is_ground,
)
from ..language.unification import matched, unify
from .logic import Logic

Build: TypeAlias = "Callable[[Unifier], Term]"
Condition: TypeAlias = "Callable[[Logic, Unifier], Unifier | None]"
Match: TypeAlias = "Callable[[Literal], Unifier | None]"

_COMPARISONS: Mapping[str, Callable[[float, float], bool]] = MappingProxyType(
    {
        "<": operator.lt,
        "<=": operator.le,
        ">": operator.gt,
        ">=": operator.ge,
        "==": operator.eq,
        "\\==": operator.ne,
    }
)


# ---- terms


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


# ---- conditions


def condition(formula: Term) -> Condition:
    """Return a function equal to `lambda logic, u: logic.first(formula, u)`, but faster."""
    if formula == TRUE:
        return lambda logic, u: u
    if isinstance(formula, Relation):
        if formula.symbol in _COMPARISONS:
            return _compare(formula)
        if formula.symbol == "=" and formula.operands[0].__class__ is Var:
            return _assign(formula)
    if isinstance(formula, And):
        left, right = formula.operands
        if isinstance(left, Relation | Not):
            return _both(condition(left), condition(right))
        if _is_plain_query(left):
            return _query(left, right)
    if isinstance(formula, Not):
        inner = condition(formula.operands[0])
        return lambda logic, u: u if inner(logic, u) is None else None
    if _is_plain_query(formula):
        return _query(formula)
    return lambda logic, u: logic.first(formula, u)


def _is_plain_query(formula: Term) -> bool:
    return isinstance(formula, Literal) and not formula.annots and not formula.is_internal_action


def _compare(relation: Relation) -> Condition:
    holds = _COMPARISONS[relation.symbol]
    left_of, right_of = map(builder, relation.operands)

    def check(logic: Logic, u: Unifier) -> Unifier | None:
        left, right = left_of(u), right_of(u)
        if left.__class__ is float and right.__class__ is float:
            return u if holds(left, right) else None
        return logic.first(relation, u)

    return check


def _assign(relation: Relation) -> Condition:
    """Compile `X = …`, which mostly gives a value to a variable that has none."""
    variable, value = relation.operands
    name = variable.name  # type: ignore[union-attr]
    value_of = builder(value)

    def check(logic: Logic, u: Unifier) -> Unifier | None:
        value = value_of(u)
        if name not in u and (value.__class__ is float or value.__class__ is str):
            return {**u, name: value}
        return logic.first(relation, u)

    return check


def _both(one: Condition, other: Condition) -> Condition:
    def check(logic: Logic, u: Unifier) -> Unifier | None:
        solution = one(logic, u)
        return None if solution is None else other(logic, solution)

    return check


def _query(query: Term, following: Term | None = None) -> Condition:
    """Compile a query, and a formula that is to hold as well for the belief that answers it."""
    assert isinstance(query, Literal)  # a plain query is one
    key = query.key
    formula: Term = query if following is None else And(query, following)
    rest = None if following is None else condition(following)
    match = _answer(query)

    def check(logic: Logic, u: Unifier) -> Unifier | None:
        shelf = logic.shelves.get(key)
        if shelf is None:
            return None
        if shelf.rules:
            return logic.first(formula, u)
        for belief in shelf.candidates(query, u):
            solution = match(belief, u)  # type: ignore[arg-type]
            if solution is None:
                continue
            if rest is None:
                return solution
            logic.goals_left -= 1
            if logic.goals_left < 0:
                logic.give_up(formula)
            solution = rest(logic, solution)
            if solution is not None:
                return solution
        return None

    return check


def _answer(query: Literal) -> Callable[[Literal, Unifier], Unifier | None]:
    """Return a function equal to `lambda belief, u: matched(query, belief, u)`, but faster.

    Most queries have up to three arguments, variables of which the first may have a value.
    """
    names = [arg.name for arg in query.args if arg.__class__ is Var]
    if len(set(names)) < len(query.args) or not 1 <= len(names) <= 3:
        return lambda belief, u: matched(query, belief, u)
    first, others = names[0], names[1:]
    if not others:

        def match_one(belief: Literal, u: Unifier) -> Unifier | None:
            if belief.ground and first not in u:
                return {**u, first: belief.args[0]}
            return matched(query, belief, u)

        return match_one
    if len(others) == 1:
        (second,) = others

        def match_two(belief: Literal, u: Unifier) -> Unifier | None:
            if belief.ground and second not in u:
                value, (one, two) = u.get(first), belief.args
                if value is one:
                    return {**u, second: two}
                if value is None:
                    return {**u, first: one, second: two}
            return matched(query, belief, u)

        return match_two
    second, third = others

    def match_three(belief: Literal, u: Unifier) -> Unifier | None:
        if belief.ground and second not in u and third not in u:
            value, (one, two, three) = u.get(first), belief.args
            if value is one:
                return {**u, second: two, third: three}
            if value is None:
                return {**u, first: one, second: two, third: three}
        return matched(query, belief, u)

    return match_three


# ---- triggers


def matcher(pattern: Literal | Var | Qualified) -> Match:
    """Return a function that unifies a trigger with the literal of an event.

    The two are known to have the same functor and arity.
    """
    if pattern.__class__ is not Literal or pattern.annots:
        return lambda literal: _unified(pattern, literal)
    args = pattern.args
    if not args:
        return lambda literal: {}
    names = [arg.name for arg in args if arg.__class__ is Var]
    if len(names) == len(args) == len(set(names)):
        if len(names) == 1:
            name = names[0]
            return lambda literal: {name: literal.args[0]}
        return lambda literal: dict(zip(names, literal.args))  # noqa: B905 - equal lengths
    return lambda literal: matched(pattern, literal, {})


def _unified(pattern: Term, literal: Literal) -> Unifier | None:
    u: Unifier = {}
    return u if unify(pattern, literal, u) else None
