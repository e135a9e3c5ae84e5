"""Search for the solutions of formulas: resolution (SLD) with negation as failure.

It goes depth first and from left to right, as in Prolog. It keeps its own stack, so a rule may call
itself as deeply as memory allows. A state is a unifier and a linked list of the goals still to
prove. A choice point is a state to return to or an iterator of such states.
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
"""Largest number of open choice points; rules that call each other without end only add some."""

CYCLES = 20
"""Number of cycles of one instant that may each try the most goals a cycle may try."""

MOST_FAILURES = 10_000
"""Maximum number of goals that may fail at one instant; each takes 0.1 to 0.3 ms."""


class _Commit:
    """End of a negated formula: it holds, so the negation fails."""

    __slots__ = ("height",)

    def __init__(self, height: int) -> None:
        self.height = height


class _Subquery:
    """A query that rules may answer; as a goal, the end of a rule's body.

    A rule is proved in a unifier of its own, so its cost does not grow with the caller's. At its
    end the values of the query's variables return to the caller. `args` are the query's own
    arguments, `asked` its variables, `renamed` the caller's names for them.
    """

    __slots__ = ("args", "asked", "caller", "query", "renamed")

    def __init__(
        self,
        query: Literal,
        args: tuple[Term, ...],
        asked: tuple[str, ...],
        renamed: dict[str, Var],
        caller: Unifier,
    ) -> None:
        self.query = query
        self.args = args
        self.asked = asked
        self.renamed = renamed
        self.caller = caller

    def put_to(self, rule: Rule) -> Unifier | None:
        """Return the bindings with which the rule's body is to be proved, None if it has none."""
        if rule.parameters is not None and not self.query.annots:
            for arg in self.args:
                if arg.__class__ is Literal and "::" in arg.functor:
                    return None
            return dict(zip(rule.parameters, self.args))  # noqa: B905 - equal lengths, and often
        scope: Unifier = {}
        query = self.query if self.query.args is self.args else self.query.with_args(self.args)
        return scope if unify(query, rule.head, scope) else None


class Logic:
    """Answers formulas from a belief base; `call` runs an internal action.

    At most `max_goals` goals are tried in one reasoning cycle, and CYCLES times as many in one
    instant: a count, not a time, stops a query without end, so that results repeat.
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
        """Renew the budgets of an instant."""
        self._left_at_this_instant = CYCLES * self.max_goals
        self.failures_left = MOST_FAILURES

    def begin_cycle(self) -> None:
        """Renew the budget of a cycle, as far as that of the instant allows."""
        self._left_at_this_instant -= self._allowed - self.goals_left
        self._allowed = self.goals_left = min(self.max_goals, self._left_at_this_instant)

    def spend(self, goals: int, formula: Term) -> None:
        """Count goals tried for `formula`. Raises `TooDeepError` if the budget is exceeded."""
        self.goals_left -= goals
        if self.goals_left < 0:
            self.give_up(formula)

    def give_up(self, formula: Term) -> None:
        """Raise the error for a budget that is used up, at last by `formula`."""
        tried = self.max_goals if self._allowed == self.max_goals else CYCLES * self.max_goals
        raise TooDeepError(f"more than {tried:,} goals were tried at once, at last {formula}")

    def solutions(self, formula: Term, u: Unifier) -> Iterator[Unifier]:
        """Yield every solution, in order. `u` is not changed."""
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
                    # Counted as well: an internal action may have answers without end.
                    self.goals_left -= 1
                    u, goals = following
                    break
                choices.pop()
            else:
                return

    def collected(self, term: Term, formula: Term, u: Unifier) -> Term:
        """Return the list of `term` as it is in each of the `solutions`.

        That for a plain query without values is kept until a belief of its kind changes, as
        programs ask for all stations again and again; it counts as many goals as the first time.
        """
        names = _unbound(term, formula, u)
        index = self.clauses.get(formula.key) if names else None  # type: ignore[union-attr]
        if index is None or index.rules or not index.is_cacheable:
            return make_list([substitute(term, one) for one in self.solutions(formula, u)])
        known = index.collected.get(names)
        if known is None or self.goals_left < known[1]:
            left = self.goals_left
            made = make_list([substitute(term, one) for one in self.solutions(formula, u)])
            known = index.collect(names, made, left - self.goals_left)
        else:
            self.goals_left -= known[1]
        return known[0]

    def _prove(
        self, u: Unifier, goals: Goals, choices: list[State | Iterator[State]]
    ) -> Unifier | None:
        """Prove one goal after another, and append to `choices` the choice points this opens."""
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
                # Goals are a linked list, shared by all choice points: to go back to one copies
                # nothing.
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
                # goes on as if the formula failed. If it holds, `_Commit` takes that away, and all
                # that was opened since.
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
        """Return the one answer of a query; else None, with the answers as a choice point."""
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
        # The one belief there may be: no choice point, so that a chain of facts needs no memory.
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
        """Yield a state for each belief and rule that may answer a query."""
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
        """Return a query with its values and fresh variables in place of its variables."""
        renamed: dict[str, Var] = {}
        args = [value_of(arg, u) for arg in literal.args]
        asked: list[str] = []
        for place, arg in enumerate(args):
            if arg.__class__ is not Var:
                if is_ground(arg):
                    continue
                break
            if not arg.fresh:
                new = renamed.get(arg.name) or self.names.fresh(arg.name)
                renamed[arg.name] = args[place] = arg = new
            asked.append(arg.name)
        else:
            if not literal.annots:
                # In the order that `variable_names` has them, as bindings are made in it.
                names = tuple(dict.fromkeys(reversed(asked))) if len(asked) > 1 else tuple(asked)
                return _Subquery(literal, tuple(args), names, renamed, u)
        query = rename(substitute_literal(literal, u), self.names, renamed)
        assert isinstance(query, Literal)  # as what was renamed
        return _Subquery(query, query.args, variable_names(query), renamed, u)

    def _with_annots(self, literal: Literal, belief: Literal, u: Unifier) -> Iterator[Unifier]:
        """Yield a solution for each choice of annotations that unifies with the query's."""
        if isinstance(literal.annots[-1], RestVar):
            solution = unified(literal, belief, u)
            if solution is not None:
                yield solution
            return
        # Every choice of as many as the query has; in each, `unify_annots` takes the first pairing.
        for annots in combinations(belief.annots, len(literal.annots)):
            solution = unified(literal, belief.with_annots(annots), u)
            if solution is not None:
                yield solution

    def _any(self, pattern: Var | Qualified, u: Unifier, goals: Goals) -> Iterator[State]:
        """Yield a state for each belief there is, and for each rule that a namespace may have."""
        inner = pattern.operands[1] if isinstance(pattern, Qualified) else pattern
        for clause in self.beliefs.all_clauses():
            if isinstance(clause, Literal):
                solution = unified(pattern, clause, u)
                if solution is not None:
                    yield solution, goals
            elif isinstance(inner, Literal) and clause.head.key[1:] == inner.key[1:]:
                # The namespace is that of the rule: its body is proved as for a query there.
                assert isinstance(pattern, Qualified)  # only such have a literal inside
                space = namespace_of(clause.head.functor)
                solution = unified(pattern.operands[0], Literal(space), u)
                if solution is not None and placed(inner, space).key == clause.head.key:
                    yield solution, (placed(inner, space), goals)

    def _return(self, question: _Subquery, scope: Unifier) -> Unifier:
        if not question.asked:
            return question.caller
        # Back in the caller: of the rule's own variables, only what the query asked for is kept.
        result = {**question.caller, **question.renamed}
        others: dict[str, Var] = {}
        for name in question.asked:
            value = scope.get(name)
            if value is not None:
                value = value_of(value, scope)
                result[name] = value if is_ground(value) else rename(value, self.names, others)
        return result


def _unbound(term: Term, formula: Term, u: Unifier) -> tuple[str, ...]:
    """Return the names of a variable and of a plain query's arguments, if none has a value."""
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
"""Comparisons of numbers; as in the order of terms, NaN is neither smaller nor larger than any."""


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
