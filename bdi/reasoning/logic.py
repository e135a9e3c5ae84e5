"""Search for the solutions of formulas: SLD resolution with negation as failure.

The search is depth first, from left to right, as in Prolog. It has an explicit stack, so that only
memory limits the recursion of rules. A state is a unifier and a linked list of goals to prove. A
choice point is a state to return to, or an iterator of states.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator, Mapping
from itertools import combinations
from types import MappingProxyType
from typing import Any, TypeAlias

from ..errors import TooDeepError
from ..language.operations import Conjunction, Disjunction, Negation, Qualified, Relation
from ..language.program import Rule
from ..language.quoted import decomposed
from ..language.substitution import (
    Names,
    Unifier,
    compare,
    rename,
    substitute,
    substitute_literal,
    value_of,
    variable_names,
)
from ..language.terms import (
    TRUE,
    Literal,
    RestVar,
    Term,
    Var,
    is_ground,
    make_list,
    namespace_of,
    placed,
)
from ..language.unification import matched, unified, unify
from .beliefs import BeliefBase

#: Answer of an internal action: whether it holds, a unifier, or one unifier after another.
Answer: TypeAlias = bool | Unifier | Iterator[Unifier] | None
Goals: TypeAlias = "tuple[Any, Goals] | None"
State: TypeAlias = "tuple[Unifier, Goals]"

MAX_CHOICES = 250_000
"""Maximum number of open choice points, to stop endless recursion."""

CYCLES = 20
"""Maximum number of goals at one time, as a multiple of the maximum in a cycle."""

MOST_FAILURES = 10_000
"""Maximum number of goals that may fail at one time. Each takes 0.1 to 0.3 ms."""


class _Commit:
    """Goal after a negated formula. If it is reached, the negation fails."""

    __slots__ = ("height",)

    def __init__(self, height: int) -> None:
        self.height = height


class _Subquery:
    """Query that rules may answer. As a goal, it ends the body of a rule.

    Each rule has a separate unifier, so that its cost does not grow with that of the caller. At the
    end the values of the variables of the query are copied to the unifier of the caller.

    Attributes
    ----------
    args
        Arguments with values and fresh variables.
    variables
        Names of the unbound variables among them.
    renamed
        Fresh variables by the names in the unifier of the caller.
    """

    __slots__ = ("args", "caller", "query", "renamed", "variables")

    def __init__(
        self,
        query: Literal,
        args: tuple[Term, ...],
        variables: tuple[str, ...],
        renamed: dict[str, Var],
        caller: Unifier,
    ) -> None:
        self.query = query
        self.args = args
        self.variables = variables
        self.renamed = renamed
        self.caller = caller

    def put_to(self, rule: Rule) -> Unifier | None:
        """Return the bindings for the body of a rule, or None if the head does not unify."""
        if rule.parameters is not None and not self.query.annots:
            for arg in self.args:
                if arg.__class__ is Literal and "::" in arg.functor:
                    return None
            return dict(zip(rule.parameters, self.args))  # noqa: B905 - equal lengths, and often
        scope: Unifier = {}
        query = self.query if self.query.args is self.args else self.query.with_args(self.args)
        return scope if unify(query, rule.head, scope) else None


class Logic:
    """Evaluator of formulas over a belief base. `call` runs an internal action.

    At most `max_goals` goals are tried in a reasoning cycle, and CYCLES times as many at one time.
    Endless queries are stopped by this count, so that results do not depend on the machine.
    """

    def __init__(
        self,
        beliefs: BeliefBase,
        names: Names,
        call: Callable[[Literal, Unifier], Answer],
        max_goals: int,
    ) -> None:
        self.beliefs = beliefs
        self.clauses = beliefs.clauses
        self.names = names
        self.call = call
        self.failures = 0
        """Number of internal actions that have failed in queries."""
        self.max_goals = max_goals
        self._left_at_this_instant = CYCLES * max_goals
        self.failures_left = MOST_FAILURES
        self._allowed = self.goals_left = max_goals

    def begin_instant(self) -> None:
        """Reset the budgets of the current time."""
        self._left_at_this_instant = CYCLES * self.max_goals
        self.failures_left = MOST_FAILURES

    def begin_cycle(self) -> None:
        """Reset the budget of a cycle, limited by that of the current time."""
        self._left_at_this_instant -= self._allowed - self.goals_left
        self._allowed = self.goals_left = min(self.max_goals, self._left_at_this_instant)

    def spend(self, goals: int, formula: Term) -> None:
        """Count goals tried for `formula`. Raises `TooDeepError` if the budget is exceeded."""
        self.goals_left -= goals
        if self.goals_left < 0:
            self.give_up(formula)

    def give_up(self, formula: Term) -> None:
        """Raise the error for a budget that `formula` has exceeded."""
        tried = self.max_goals if self._allowed == self.max_goals else CYCLES * self.max_goals
        raise TooDeepError(f"more than {tried:,} goals were tried at once, at last {formula}")

    def solutions(self, formula: Term, u: Unifier) -> Iterator[Unifier]:
        """Yield all solutions in order. `u` stays unchanged."""
        choices: list[State | Iterator[State]] = []
        goals: Goals = (formula, None)
        while True:
            if self.goals_left < 0:
                self.give_up(formula)
            state = self._prove(u, goals, choices)
            if state is not None:
                yield state
            while choices:
                choice = choices[-1]
                if isinstance(choice, tuple):
                    choices.pop()
                    u, goals = choice
                    break
                following = next(choice, None)
                if following is not None:
                    # Solutions count, because an internal action may have endless ones.
                    self.goals_left -= 1
                    u, goals = following
                    break
                choices.pop()
            else:
                return

    def collected(self, term: Term, formula: Term, u: Unifier) -> Term:
        """Return the list of the values of `term` in all solutions.

        The list for a query without values is cached until a belief of its key changes. A cached
        list counts as many goals as its computation.
        """
        names = _unbound(term, formula, u)
        index = self.clauses.get(formula.key) if names else None  # type: ignore[union-attr]
        if index is None or index.rules or not index.is_cacheable:
            return make_list([substitute(term, one) for one in self.solutions(formula, u)])
        cached = index.collected.get(names)
        if cached is None or self.goals_left < cached[1]:
            left = self.goals_left
            values = make_list([substitute(term, one) for one in self.solutions(formula, u)])
            cached = index.collect(names, values, left - self.goals_left)
        else:
            self.goals_left -= cached[1]
        return cached[0]

    def _prove(
        self, u: Unifier, goals: Goals, choices: list[State | Iterator[State]]
    ) -> Unifier | None:
        """Prove the goals in order, and append new choice points to `choices`."""
        solution: Unifier | None
        while goals is not None:
            goal, goals = goals
            self.goals_left -= 1
            cls = goal.__class__
            if cls is Literal:
                solution = self._query(goal, u, goals, choices)
                if solution is None:
                    return None
                u = solution
            elif cls is Conjunction:
                # All choice points share the linked list, so backtracking copies nothing.
                left, right = goal.operands
                goals = (left, (right, goals))
            elif cls is _Subquery:
                u = self._return(goal, u)
            elif cls is Relation:
                left, right = goal.operands
                solution = relate(goal.symbol, substitute(left, u), substitute(right, u), u)
                if solution is None:
                    return None
                u = solution
            elif cls is Disjunction:
                left, right = goal.operands
                choices.append((u, (right, goals)))
                goals = (left, goals)
            elif cls is Negation:
                # Negation as failure (K. L. Clark, "Negation as failure", 1978): the choice point
                # continues as if the formula failed. If it holds, `_Commit` removes the choice
                # point and all later ones.
                choices.append((u, goals))
                goals = (goal.operands[0], (_Commit(len(choices) - 1), None))
            elif cls is _Commit:
                del choices[goal.height :]
                return None
            elif isinstance(goal, Var | Qualified):
                value = substitute(goal, u)
                if isinstance(value, Var | Qualified):
                    choices.append(self._any(value, u, goals))
                    return None
                goals = (value, goals)
            else:
                return None
        return u

    def _query(
        self,
        literal: Literal,
        u: Unifier,
        goals: Goals,
        choices: list[State | Iterator[State]],
    ) -> Unifier | None:
        """Return the only solution of a query. Otherwise add a choice point and return None."""
        if "." in literal.functor and literal.is_internal_action:
            answer = self.call(literal, u)
            if answer is True:
                return u
            if answer is None or answer is False:
                return None
            if isinstance(answer, dict):
                return answer
            choices.append((solution, goals) for solution in answer)
            return None
        index = self.clauses.get(literal.key)
        if index is None:
            return u if literal.functor == "true" and literal == TRUE else None
        candidates = index.candidates(literal, u)
        # A single belief needs no choice point, so that a chain of facts needs no memory.
        if len(candidates) == 1 and candidates[0].__class__ is Literal and not literal.annots:
            return matched(literal, candidates[0], u)
        if len(choices) > MAX_CHOICES:
            raise TooDeepError(f"rules call each other without end, at last {literal}")
        choices.append(self._clauses(literal, candidates, u, goals))
        return None

    def _clauses(
        self,
        literal: Literal,
        candidates: tuple[Literal | Rule, ...],
        u: Unifier,
        goals: Goals,
    ) -> Iterator[State]:
        """Yield a state for each belief and rule that answers a query."""
        question: _Subquery | None = None
        for clause in candidates:
            if isinstance(clause, Rule):
                if question is None:
                    question = self._question(literal, u)
                scope = question.put_to(clause)
                if scope is not None:
                    yield scope, (clause.body, (question, goals))
            elif not literal.annots:
                solution = matched(literal, clause, u)
                if solution is not None:
                    yield solution, goals
            else:
                for solution in self._with_annots(literal, clause, u):
                    yield solution, goals

    def _question(self, literal: Literal, u: Unifier) -> _Subquery:
        """Return a query with values or fresh variables in place of its variables."""
        renamed: dict[str, Var] = {}
        args = [value_of(arg, u) for arg in literal.args]
        variables: list[str] = []
        for place, arg in enumerate(args):
            if arg.__class__ is not Var:
                if is_ground(arg):
                    continue
                break
            if not arg.fresh:
                new = renamed.get(arg.name) or self.names.fresh(arg.name)
                renamed[arg.name] = args[place] = arg = new
            variables.append(arg.name)
        else:
            if not literal.annots:
                # In the order of `variable_names`, because it is the order of the bindings.
                names = tuple(dict.fromkeys(reversed(variables)))
                return _Subquery(literal, tuple(args), names, renamed, u)
        query = rename(substitute_literal(literal, u), self.names, renamed)
        assert isinstance(query, Literal)  # because a literal was renamed
        return _Subquery(query, query.args, variable_names(query), renamed, u)

    def _with_annots(self, literal: Literal, belief: Literal, u: Unifier) -> Iterator[Unifier]:
        """Yield a solution for each choice of annotations that unifies with those of the query."""
        if isinstance(literal.annots[-1], RestVar):
            solution = unified(literal, belief, u)
            if solution is not None:
                yield solution
            return
        # Each choice has as many annotations as the query. `unify_annots` uses the first pairing.
        for annots in combinations(belief.annots, len(literal.annots)):
            solution = unified(literal, belief.with_annots(annots), u)
            if solution is not None:
                yield solution

    def _any(self, pattern: Var | Qualified, u: Unifier, goals: Goals) -> Iterator[State]:
        """Yield a state for each belief, and for each rule of the key in any namespace."""
        inner = pattern.operands[1] if isinstance(pattern, Qualified) else pattern
        for clause in self.beliefs.all_clauses():
            if isinstance(clause, Literal):
                solution = unified(pattern, clause, u)
                if solution is not None:
                    yield solution, goals
            elif isinstance(inner, Literal) and clause.head.key[1:] == inner.key[1:]:
                assert isinstance(pattern, Qualified)  # because it contains a literal
                space = namespace_of(clause.head.functor)
                solution = unified(pattern.operands[0], Literal(space), u)
                if solution is not None and placed(inner, space).key == clause.head.key:
                    yield solution, (placed(inner, space), goals)

    def _return(self, question: _Subquery, scope: Unifier) -> Unifier:
        """Return the unifier of the caller, extended by the values of a proved query."""
        if not question.variables:
            return question.caller
        result = {**question.caller, **question.renamed}
        others: dict[str, Var] = {}
        for name in question.variables:
            value = scope.get(name)
            if value is not None:
                value = value_of(value, scope)
                result[name] = value if is_ground(value) else rename(value, self.names, others)
        return result


def _unbound(term: Term, formula: Term, u: Unifier) -> tuple[str, ...]:
    """Return the names of a variable and of the arguments of a query, if all are unbound."""
    if formula.__class__ is not Literal or formula.annots or formula.is_internal_action:
        return ()
    names = []
    for part in (term, *formula.args):
        if part.__class__ is not Var or part.name in u:
            return ()
        names.append(part.name)
    return tuple(names)


COMPARISONS: Mapping[str, Callable[[float, float], bool]] = MappingProxyType(
    {
        "<": operator.lt,
        "<=": lambda one, other: not one > other,
        ">": operator.gt,
        ">=": lambda one, other: not one < other,
        "==": operator.eq,
        "\\==": operator.ne,
    }
)
"""Comparisons of numbers. NaN is neither smaller nor larger than any number."""


def relate(symbol: str, left: Term, right: Term, u: Unifier) -> Unifier | None:
    """Return `u` extended so that a relation holds between two values, or None."""
    if symbol == "=":
        return unified(left, right, u)
    if symbol == "=..":
        sides = decomposed(left, right)
        return None if sides is None else unified(*sides, u)
    holds = COMPARISONS[symbol]
    if left.__class__ is float and right.__class__ is float:
        return u if holds(left, right) else None
    if symbol in ("==", "\\=="):
        return u if (left == right) is (symbol == "==") else None
    return u if holds(compare(left, right), 0) else None
