"""Patterns, compiled to Python closures: triggers of plans, and queries that beliefs may answer.

What `unify` and `matched` find out about a pattern each time is found out here once. Forms that are
not frequent are left to them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from ..language.substitution import Unifier
from ..language.terms import Literal, Qualified, Term, Var
from ..language.unification import matched, unify

Match: TypeAlias = "Callable[[Literal], Unifier | None]"


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
    if len(names) < len(args) or len(set(names)) < len(names):
        return lambda literal: matched(pattern, literal, {})
    if len(names) == 1:
        name = names[0]

        def match_one(literal: Literal) -> Unifier | None:
            (one,) = literal.args
            if one.__class__ is Literal and "::" in one.functor:
                return None
            return {name: one}

        return match_one

    def match_all(literal: Literal) -> Unifier | None:
        for arg in literal.args:
            if arg.__class__ is Literal and "::" in arg.functor:
                return None
        return dict(zip(names, literal.args))  # noqa: B905 - equal lengths

    return match_all


def _unified(pattern: Term, literal: Literal) -> Unifier | None:
    u: Unifier = {}
    return u if unify(pattern, literal, u) else None


def belief_matcher(query: Literal) -> Callable[[Literal, Unifier], Unifier | None]:
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
                (one,) = belief.args
                if one.__class__ is Literal and "::" in one.functor:
                    return None
                return {**u, first: one}
            return matched(query, belief, u)

        return match_one
    if len(others) == 1:
        (second,) = others

        def match_two(belief: Literal, u: Unifier) -> Unifier | None:
            if belief.ground and second not in u:
                value, (one, two) = u.get(first), belief.args
                if two.__class__ is Literal and "::" in two.functor:
                    return None
                if value is one:
                    return {**u, second: two}
                if value is None and not (one.__class__ is Literal and "::" in one.functor):
                    return {**u, first: one, second: two}
            return matched(query, belief, u)

        return match_two
    second, third = others

    def match_three(belief: Literal, u: Unifier) -> Unifier | None:
        if belief.ground and second not in u and third not in u:
            value, (one, two, three) = u.get(first), belief.args
            if (two.__class__ is Literal and "::" in two.functor) or (
                three.__class__ is Literal and "::" in three.functor
            ):
                return None
            if value is one:
                return {**u, second: two, third: three}
            if value is None and not (one.__class__ is Literal and "::" in one.functor):
                return {**u, first: one, second: two, third: three}
        return matched(query, belief, u)

    return match_three
