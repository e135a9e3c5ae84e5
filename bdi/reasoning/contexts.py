"""Formulas compiled to functions that find their first solution, or all solutions.

`Logic.solutions` evaluates what the functions cannot: recursive rules, which need its stack,
queries with annotations, and formulas given by variables.
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
"""First solution of a formula, or None. The given unifier stays unchanged."""

Answers: TypeAlias = Callable[[Logic, Unifier], Iterable[Unifier]]
"""All solutions of a formula in order, as a tuple if there is at most one."""

MAX_QUESTIONS = 64
"""Maximum number of questions whose answers by rules are cached per functor."""


def condition(formula: Term) -> Condition:
    """Return a function that finds the first solution of a formula."""
    if formula == TRUE:
        return lambda logic, u: u
    if isinstance(formula, Relation):
        is_assignment = formula.symbol == "=" and formula.operands[0].__class__ is Var
        return _assign(formula) if is_assignment else _relation(formula)
    if isinstance(formula, Conjunction):
        left, right = formula.operands
        if isinstance(left, Relation | Negation):
            return _both(condition(left), condition(right))
        return _first_of_both(answers(left), condition(right), formula)
    if isinstance(formula, Disjunction):
        return _either(*map(condition, formula.operands))
    if isinstance(formula, Negation):
        inner = condition(formula.operands[0])
        return lambda logic, u: u if inner(logic, u) is None else None
    return _first(answers(formula))


def answers(formula: Term) -> Answers:
    """Return a function that finds all solutions of a formula, as `Logic.solutions`."""
    if isinstance(formula, Conjunction):
        return _join(*map(answers, formula.operands))
    if isinstance(formula, Relation | Negation) or formula == TRUE:
        return _at_most_one(condition(formula))
    if isinstance(formula, Literal) and formula.is_internal_action:
        return _call(formula)
    if isinstance(formula, Literal) and not formula.annots:
        return _query(formula)
    return lambda logic, u: logic.solutions(formula, u)


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
    """Compile `X = …`, which usually binds an unbound variable."""
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


def _first(solutions: Answers) -> Condition:
    def check(logic: Logic, u: Unifier) -> Unifier | None:
        for solution in solutions(logic, u):
            return solution
        return None

    return check


def _first_of_both(left: Answers, right: Condition, formula: Term) -> Condition:
    def check(logic: Logic, u: Unifier) -> Unifier | None:
        for first in left(logic, u):
            logic.goals_left -= 1
            if logic.goals_left < 0:
                logic.give_up(formula)
            solution = right(logic, first)
            if solution is not None:
                return solution
        return None

    return check


def _at_most_one(holds: Condition) -> Answers:
    def solve(logic: Logic, u: Unifier) -> Iterable[Unifier]:
        solution = holds(logic, u)
        return () if solution is None else (solution,)

    return solve


def _join(one: Answers, other: Answers) -> Answers:
    def solve(logic: Logic, u: Unifier) -> Iterable[Unifier]:
        solutions = one(logic, u)
        if solutions.__class__ is not tuple:
            return (solution for first in solutions for solution in other(logic, first))
        return other(logic, solutions[0]) if solutions else solutions

    return solve


def _call(action: Literal) -> Answers:
    """Compile the call of an internal action."""

    def counted(logic: Logic, solutions: Iterator[Unifier]) -> Iterator[Unifier]:
        for solution in solutions:
            logic.spend(1, action)  # because the action may have endless solutions
            yield solution

    def solve(logic: Logic, u: Unifier) -> Iterable[Unifier]:
        answer = logic.call(action, u)
        if answer is None or answer is False:
            return ()
        if answer is True:
            return (u,)
        return (answer,) if isinstance(answer, dict) else counted(logic, answer)

    return solve


def _query(query: Literal) -> Answers:
    """Compile a query without annotations."""
    key = query.key
    match = belief_matcher(query)
    build_args = [builder(arg) for arg in query.args]

    def believed(clauses: tuple[Literal | Rule, ...], u: Unifier) -> Iterator[Unifier]:
        for belief in clauses:
            solution = match(belief, u)  # type: ignore[arg-type]
            if solution is not None:
                yield solution

    def solve(logic: Logic, u: Unifier) -> Iterable[Unifier]:
        index = logic.clauses.get(key)
        if index is None:
            return ()
        if not index.rules:
            clauses = index.candidates(query, u)
            if len(clauses) != 1:
                return believed(clauses, u) if clauses else ()
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
        # Rules may be added and removed at run time, so each query checks what rules there are.
        is_plain = index.answers is not None or logic.beliefs.has_plain_rules(key)
        if not is_plain or len(set(names)) < len(names):
            return logic.solutions(query, u)
        rows = _cached(logic, query, tuple(question), u, index)
        return ({**u, **dict(zip(names, values))} for values in rows)  # noqa: B905 - equal lengths

    return solve


def _cached(
    logic: Logic, query: Literal, question: Question, u: Unifier, index: ClauseIndex
) -> Iterable[Values]:
    """Return the answers to a question, cached if the rules allow it."""
    cache = index.answers
    if cache is None:
        return _proved(logic, query, question, u)
    cached = cache.get(question)
    if cached is None or not cached.is_cacheable:
        if len(cache) >= MAX_QUESTIONS:
            cache.clear()
        source = _proved(logic, query, question, u)
        cached = cache[question] = CachedAnswers(source, logic)
    return cached


def _proved(logic: Logic, query: Literal, question: Question, u: Unifier) -> Iterator[Values]:
    """Yield the values of the variables among a query's arguments for each of its answers.

    The unifier of a rule starts with the query's values for the variables of the head. The proof
    of the body binds the variables of the head that the query leaves open.
    """
    for clause in logic.clauses[query.key].candidates(query, u):
        logic.spend(1, query)
        if isinstance(clause, Literal):
            solution = matched(query, clause, u)
            if solution is not None:
                open_args = [
                    arg for arg, value in zip(query.args, question, strict=True) if value is None
                ]
                yield _values(logic, open_args, solution)
            continue
        scope: Unifier = {}
        open_args = []
        for parameter, value in zip(clause.head.args, question):  # noqa: B905 - equal lengths
            if value is None:
                if is_placed(parameter):
                    break
                open_args.append(parameter)
            elif parameter.__class__ is Var and not is_placed(value):
                scope[parameter.name] = value
            elif not unify(parameter, value, scope):
                break
        else:
            for solution in _answers_of(clause)(logic, scope):
                yield _values(logic, open_args, solution)


def _values(logic: Logic, terms: list[Term], u: Unifier) -> Values:
    """Return the values of terms, with fresh variables in place of unbound ones."""
    values = tuple([value_of(term, u) for term in terms])
    if all(map(is_ground, values)):
        return values
    renamed: dict[str, Var] = {}
    return tuple([v if is_ground(v) else rename(v, logic.names, renamed) for v in values])


@made_once
def _answers_of(rule: Rule) -> Answers:
    """Return the compiled body of a rule."""
    return answers(rule.body)
