"""Patterns of declarative goals: the plans that `{ begin bdg(g) } … { end }` makes of others.

After Hübner, Bordini and Wooldridge, "Programming declarative goals using plan patterns" (DALT
2006). Each pattern takes the plans between its two directives and returns them with those that make
its goal declarative: achieved when it is believed, tried again when it has failed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import TypeAlias

from ..errors import ProgramError
from .body import BodyFormula, Place, Test, Update
from .program import Belief, Clause, Directive, Plan
from .terms import TRUE, And, Literal, Not, Term, text
from .texts import parse_plan, parse_term, parse_trigger
from .unification import unified

Clauses: TypeAlias = list[Clause]
_Pattern: TypeAlias = Callable[[Directive, Sequence[Clause]], Clauses]


class WrongPatternError(Exception):
    """Pattern that cannot be applied, with what would be right."""


def apply_pattern(directive: Directive, inner: Sequence[Clause]) -> Clauses:
    """Return the clauses of a pattern over those inside it.

    Raises:
        WrongPatternError: its arguments are wrong.
    """
    return PATTERNS[directive.name](directive, inner)


def _goal(directive: Directive, index: int = 0) -> Literal:
    goal = directive.args[index] if index < len(directive.args) else None
    if isinstance(goal, Literal):
        return goal
    raise WrongPatternError(f"argument {index + 1} of {directive.name} is a goal, as go(X)")


def _plan(source: str, place: Place) -> Plan:
    try:
        return replace(parse_plan(source), place=place)
    except ProgramError as error:
        raise WrongPatternError(str(error)) from None


def _achieves(clause: Clause, goal: Literal) -> bool:
    if not isinstance(clause, Plan) or clause.trigger.kind != "!":
        return False
    return unified(clause.trigger.literal, goal, {}) is not None


def _tests(plan: Plan) -> BodyFormula:
    return Test(plan.trigger.literal, plan.place)


def _declarative(directive: Directive, inner: Sequence[Clause]) -> Clauses:
    """dg(g): g is achieved when it is believed, which every plan for it has to bring about."""
    goal, place = _goal(directive), directive.place
    # First in the program, so that a goal that is believed is achieved without any of its plans,
    # and so is one that is pursued already.
    plans: Clauses = [
        _plan(f"+!{goal} : {goal}", place),
        _plan(f"+!{goal} : .intend({goal})", place),
    ]
    for clause in inner:
        if isinstance(clause, Plan) and _achieves(clause, goal):
            clause = replace(clause, body=(*clause.body, _tests(clause)))
        plans.append(clause)
    return [*plans, _plan(f"+{goal} <- .succeed_goal({goal})", place)]


def _backtracking(directive: Directive, inner: Sequence[Clause]) -> Clauses:
    """bdg(g): as dg(g), and g is tried again when it has failed."""
    goal = _goal(directive)
    return [*_declarative(directive, inner), _plan(f"-!{goal} <- !{goal}", directive.place)]


def _exclusive(directive: Directive, inner: Sequence[Clause]) -> Clauses:
    """ebdg(g): as bdg(g), and no plan for g is tried twice."""
    goal, place = _goal(directive), directive.place
    plans: Clauses = [_plan(f"+!{goal} : {goal}", place)]
    number = 0
    for clause in inner:
        if isinstance(clause, Plan) and _achieves(clause, goal):
            number += 1
            # The plan notes that it has been tried before its first step, so its failure can't come
            # before.
            tried = Literal("p__f", (float(number), goal))
            context: Term = Not(tried)
            if clause.context != TRUE:
                context = And(context, clause.context)
            body = (Update("+", tried, clause.place), *clause.body, _tests(clause))
            clause = replace(clause, context=context, body=body)
        plans.append(clause)
    forget = f".abolish(p__f(_,{goal}))"
    return [
        *plans,
        _plan(f"-!{goal} <- !{goal}", place),
        _plan(f"+{goal} <- {forget}; .succeed_goal({goal})", place),
        _plan(f"-{goal} <- {forget}", place),
    ]


def _within(directive: Directive, inner: Sequence[Clause], pattern: str) -> Clauses:
    """Return the clauses of the pattern that an argument names, or else of the usual one."""
    goal = _goal(directive)
    chosen = directive.args[1] if len(directive.args) > 1 else Literal(pattern, (goal,))
    if not isinstance(chosen, Literal) or chosen.functor not in PATTERNS:
        raise WrongPatternError(f"argument 2 of {directive.name} is a pattern, as {pattern}(g)")
    return apply_pattern(replace(directive, name=chosen.functor, args=chosen.args), inner)


def _blind(directive: Directive, inner: Sequence[Clause]) -> Clauses:
    """bc(g, pattern): g is pursued for ever."""
    goal = _goal(directive)
    return [*_within(directive, inner, "bdg"), _plan(f"+!{goal} <- !{goal}", directive.place)]


def _committed(directive: Directive, inner: Sequence[Clause]) -> Clauses:
    blind = replace(directive, name="bc", args=directive.args[:1])
    return _blind(blind, inner)


def _single_minded(directive: Directive, inner: Sequence[Clause]) -> Clauses:
    """smc(g, f): g is pursued until f is believed."""
    goal, failed = _goal(directive), _goal(directive, 1)
    return [
        *_committed(directive, inner),
        _plan(f"+{failed} <- .fail_goal({goal})", directive.place),
    ]


def _relativised(directive: Directive, inner: Sequence[Clause]) -> Clauses:
    """rc(g, m): g is pursued as long as m is believed."""
    goal, motive = _goal(directive), _goal(directive, 1)
    return [
        *_committed(directive, inner),
        _plan(f"-{motive} <- .succeed_goal({goal})", directive.place),
    ]


def _open_minded(directive: Directive, inner: Sequence[Clause]) -> Clauses:
    """omc(g, f, m): g is pursued until f is believed or m is no longer."""
    goal, failed, motive = (_goal(directive, index) for index in range(3))
    return [
        *_committed(directive, inner),
        _plan(f"+{failed} <- .drop_intention({goal})", directive.place),
        _plan(f"-{motive} <- .succeed_goal({goal})", directive.place),
    ]


def _maintained(directive: Directive, inner: Sequence[Clause]) -> Clauses:
    """mg(g, pattern): g is believed at first, and pursued whenever it is no longer."""
    goal = _goal(directive)
    return [
        Belief(goal, directive.place),
        *_within(directive, inner, "bc"),
        _plan(f"-{goal} <- !{goal}", directive.place),
    ]


def _sequenced(directive: Directive, inner: Sequence[Clause]) -> Clauses:
    """sga("t", "c", g): at each event t in which c holds g is adopted, one after another."""
    if len(directive.args) != 3 or not all(isinstance(arg, str) for arg in directive.args[:2]):
        raise WrongPatternError('sga takes an event, a context and a goal: sga("+b", "c", g)')
    goal, place = _goal(directive, 2), directive.place
    try:
        trigger = parse_trigger(str(directive.args[0]))
        context = text(parse_term(str(directive.args[1])))
    except ProgramError as error:
        raise WrongPatternError(str(error)) from None
    event = f"{trigger.sort}{trigger.literal}"
    return [
        _plan(f"{event} : not f__l(_) & {context} <- !f__g({goal})", place),
        _plan(f"{event} : f__l(_) & ({context}) <- +f__l({goal})", place),
        _plan(f"+!f__g({goal}) <- +f__l({goal}); !{goal}; -f__l({goal})", place),
        _plan(f"-!f__g({goal}) <- -f__l({goal})", place),
        _plan(f"-f__l({goal}) : f__l({goal}) <- !f__g({goal})", place),
    ]


PATTERNS: Mapping[str, _Pattern] = MappingProxyType(
    {
        "dg": _declarative,
        "bdg": _backtracking,
        "ebdg": _exclusive,
        "bc": _blind,
        "smc": _single_minded,
        "rc": _relativised,
        "omc": _open_minded,
        "mg": _maintained,
        "sga": _sequenced,
    }
)
"""The patterns by the names of their directives."""
