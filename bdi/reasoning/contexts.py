"""Contexts compiled to functions, which find the first solution of a formula or all of them.

They do without the stack of `Logic.solutions`, and leave to it what needs one: recursive rules,
queries with annotations, and formulas that are variables.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TypeAlias

from ..language.operations import Conjunction, Disjunction, Negation, Relation
from ..language.program import Rule, made_once
from ..language.substitution import Unifier, builder, rename, value_of
from ..language.terms import TRUE, Literal, Term, Var, is_ground, is_placed
from ..language.unification import belief_matcher, matched, unified, unify
from .beliefs import CachedAnswers, ClauseIndex, Question, Values
from .logic import COMPARISONS, Logic, relate

Condition: TypeAlias = Callable[[Logic, Unifier], Unifier | None]


Answers: TypeAlias = Callable[[Logic, Unifier], Iterable[Unifier]]
"""All solutions, in order: a tuple if it is known that there is at most one."""


MOST_KEPT = 64
"""Largest number of questions of which the answers by rules are kept."""


def condition(formula: Term) -> Condition:
    """Return a function that finds the first solution of a formula in a unifier, or None.

    It leaves the unifier unchanged.
    """
    if formula == TRUE:
        return lambda logic, u: u
    if isinstance(formula, Relation):
        is_assignment = formula.symbol == "=" and formula.operands[0].__class__ is Var
        return _assign(formula) if is_assignment else _relation(formula)
    if isinstance(formula, Conjunction):
        left, right = formula.operands
        if isinstance(left, Relation | Negation):
            return _both(condition(left), condition(right))
        if _is_plain_query(left):
            return _query(left, right)
    if isinstance(formula, Disjunction):
        return _either(*map(condition, formula.operands))
    if isinstance(formula, Negation):
        inner = condition(formula.operands[0])
        return lambda logic, u: u if inner(logic, u) is None else None
    if _is_plain_query(formula):
        return _query(formula)
    return lambda logic, u: next(logic.solutions(formula, u), None)


def _is_plain_query(formula: Term) -> bool:
    return isinstance(formula, Literal) and not formula.annots and not formula.is_internal_action


def _relation(relation: Relation) -> Condition:
    symbol = relation.symbol
    left_of, right_of = map(builder, relation.operands)
    holds = COMPARISONS.get(symbol)
    if holds is None:
        return lambda logic, u: relate(symbol, left_of(u), right_of(u), u)

    def check(logic: Logic, u: Unifier) -> Unifier | None:
        left, right = left_of(u), right_of(u)
        if left.__class__ is float and right.__class__ is float:
            return u if holds(left, right) else None
        return relate(symbol, left, right, u)

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
        return unified(variable, value, u)

    return check


def _both(one: Condition, other: Condition) -> Condition:
    def check(logic: Logic, u: Unifier) -> Unifier | None:
        solution = one(logic, u)
        return None if solution is None else other(logic, solution)

    return check


def _either(one: Condition, other: Condition) -> Condition:
    def check(logic: Logic, u: Unifier) -> Unifier | None:
        solution = one(logic, u)
        return other(logic, u) if solution is None else solution

    return check


def _query(query: Term, following: Term | None = None) -> Condition:
    """Compile a query, and a formula that is to hold as well for the belief that answers it."""
    assert isinstance(query, Literal)  # a plain query is one
    key = query.key
    formula: Term = query if following is None else Conjunction(query, following)
    rest = None if following is None else condition(following)
    match = belief_matcher(query)
    by_rules = _asked(query)

    def check(logic: Logic, u: Unifier) -> Unifier | None:
        index = logic.clauses.get(key)
        if index is None:
            return None
        solution: Unifier | None
        # Rules may come and go while the agent runs, so each query looks what there is.
        if index.rules:
            for solution in by_rules(logic, u):
                if rest is None:
                    return solution
                solution = rest(logic, solution)
                if solution is not None:
                    return solution
            return None
        for belief in index.candidates(query, u):
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


def answers(formula: Term) -> Answers:
    """Return a function equal to `lambda logic, u: logic.solutions(formula, u)`, but faster."""
    if isinstance(formula, Conjunction):
        return _join(*map(answers, formula.operands))
    if isinstance(formula, Relation | Negation) or formula == TRUE:
        return _once(condition(formula))
    if _is_plain_query(formula):
        return _asked(formula)
    if isinstance(formula, Literal) and formula.is_internal_action:
        return _called(formula)
    return lambda logic, u: logic.solutions(formula, u)


def _once(holds: Condition) -> Answers:
    def found(logic: Logic, u: Unifier) -> Iterable[Unifier]:
        solution = holds(logic, u)
        return () if solution is None else (solution,)

    return found


def _join(one: Answers, other: Answers) -> Answers:
    def both(logic: Logic, u: Unifier) -> Iterable[Unifier]:
        found = one(logic, u)
        if found.__class__ is not tuple:
            return (solution for first in found for solution in other(logic, first))
        return other(logic, found[0]) if found else found

    return both


def _called(action: Literal) -> Answers:
    """Compile the call of an internal action."""

    def counted(logic: Logic, found: Iterator[Unifier]) -> Iterator[Unifier]:
        for solution in found:
            logic.spend(1, action)  # there may be answers without end
            yield solution

    def found(logic: Logic, u: Unifier) -> Iterable[Unifier]:
        answer = logic.call(action, u)
        if answer is None or answer is False:
            return ()
        if answer is True:
            return (u,)
        return (answer,) if isinstance(answer, dict) else counted(logic, answer)

    return found


def _asked(query: Term) -> Answers:
    """Compile a query that beliefs and rules may answer."""
    assert isinstance(query, Literal)  # a plain query is one
    key = query.key
    match = belief_matcher(query)
    build_args = [builder(arg) for arg in query.args]

    def believed(clauses: tuple[Literal | Rule, ...], u: Unifier) -> Iterator[Unifier]:
        for belief in clauses:
            solution = match(belief, u)  # type: ignore[arg-type]
            if solution is not None:
                yield solution

    def found(logic: Logic, u: Unifier) -> Iterable[Unifier]:
        index = logic.clauses.get(key)
        if index is None:
            return ()
        if not index.rules:
            clauses = index.candidates(query, u)
            if len(clauses) != 1:
                return believed(clauses, u)
            solution = match(clauses[0], u)  # type: ignore[arg-type]
            return () if solution is None else (solution,)
        question: list[Term | None] = []
        names: list[str] = []
        for build in build_args:
            arg = build(u)
            if arg.__class__ is Var:
                names.append(arg.name)
                question.append(None)
            elif is_ground(arg):
                question.append(arg)
            else:
                return logic.solutions(query, u)
        if len(set(names)) < len(names) or not logic.beliefs.has_plain_rules(key):
            return logic.solutions(query, u)
        values = _kept(logic, query, tuple(question), u, index)
        return ({**u, **dict(zip(names, one))} for one in values)  # noqa: B905 - equal lengths

    return found


def _kept(
    logic: Logic, query: Literal, question: Question, u: Unifier, index: ClauseIndex
) -> Iterable[Values]:
    """Return the answers to a question, as far as possible those known."""
    kept = index.answers
    if kept is None:
        return _proved(logic, query, question, u)
    known = kept.get(question)
    if known is None or not known.is_cacheable:
        if len(kept) >= MOST_KEPT:
            kept.clear()
        source = _proved(logic, query, question, u)
        known = kept[question] = CachedAnswers(source, lambda: logic.failures)
    return known


def _proved(logic: Logic, query: Literal, question: Question, u: Unifier) -> Iterator[Values]:
    """Yield the values of the variables among a query's arguments for each of its answers.

    A rule is proved in a unifier of its own, in which the variables of its head have the values of
    the query's arguments. Those that the query asks for get theirs as the body is proved.
    """
    for clause in logic.clauses[query.key].candidates(query, u):
        logic.spend(1, query)
        if isinstance(clause, Literal):
            solution = matched(query, clause, u)
            if solution is not None:
                asked = [arg for arg, one in zip(query.args, question, strict=True) if one is None]
                yield _values(logic, asked, solution)
            continue
        scope: Unifier = {}
        asked = []
        for inside, value in zip(clause.head.args, question, strict=True):
            if value is None:
                if is_placed(inside):
                    break
                asked.append(inside)
            elif inside.__class__ is Var and not is_placed(value):
                scope[inside.name] = value
            elif not unify(inside, value, scope):
                break
        else:
            for found in _answers_of(clause)(logic, scope):
                yield _values(logic, asked, found)


def _values(logic: Logic, variables: list[Term], u: Unifier) -> Values:
    """Return what variables have become, with fresh ones in place of any that are left."""
    others: dict[str, Var] = {}
    found = [value_of(variable, u) for variable in variables]
    return tuple([v if is_ground(v) else rename(v, logic.names, others) for v in found])


@made_once
def _answers_of(rule: Rule) -> Answers:
    """Return the body of a rule compiled."""
    return answers(rule.body)
