"""Namespaces of the names in a clause.

A name in a namespace is a functor with a prefix, `ns::b`. The beliefs, goals, events and actions of
a file are in its namespace. Arguments and annotations are not, unless they have a prefix: `::b` is
in the namespace of the file, `default::b` in none.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from .body import (
    Achieve,
    Act,
    Body,
    BodyFormula,
    Constraint,
    For,
    ForkJoin,
    If,
    Test,
    Update,
    While,
    transformed,
)
from .operations import Conjunction, Disjunction, Negation, Qualified, Relation, rebuilt
from .program import Belief, Clause, Goal, Plan, Rule
from .terms import DEFAULT, Literal, Term, Var

THIS = "this_ns"
"""Name that refers to the namespace of its file."""

#: Names without a namespace.
_RESERVED = frozenset(
    [
        *("atomic", "breakpoint", "all_unifs", "source", "self", "percept", "true", "false"),
        *("tell", "untell", "achieve", "unachieve", "askOne", "askAll", "askHow", "tellHow"),
        *("untellHow", "kqml_received", "jag_sleeping", "jag_awaking", "jag_shutting_down"),
    ]
)


class Namespace:
    """Namespace of a part of a file.

    `local` maps each name of a local namespace to the unique name that replaces it.
    """

    def __init__(self, name: str = "default", local: Mapping[str, str] | None = None) -> None:
        self.name = name
        self.local = dict(local or {})

    def place(self, clause: Clause) -> Clause:
        """Return a clause with every name in its namespace."""
        resolved = transformed(clause, self._resolve)
        if self.name == "default":
            return resolved  # type: ignore[no-any-return]
        return self._clause(resolved)

    # ---- names with a namespace

    def resolved(self, name: str) -> str:
        """Return the namespace of the name before `::`."""
        name = self.name if name == THIS else name
        return self.local.get(name, name)

    def _resolve(self, part: Any) -> Term | None:
        """Return a literal with its namespace, or None for other parts."""
        if isinstance(part, Qualified):
            namespace, inner = part.operands
            if isinstance(namespace, Literal):
                namespace = Literal(self.resolved(namespace.functor))
            return Qualified(namespace, transformed(inner, self._resolve), part.negated)
        if not isinstance(part, Literal):
            return None
        if part.functor == THIS and part.is_atom:
            return Literal(self.name)
        prefix, separator, bare = part.functor.rpartition("::")
        if not separator:
            return None
        # `default::b` keeps its prefix until all others have theirs.
        return _renamed(
            rebuilt(part, lambda inner: transformed(inner, self._resolve)),
            f"{self.resolved(prefix)}::{bare}" if self._is_module else self._plain(prefix, bare),
        )

    @property
    def _is_module(self) -> bool:
        return self.name != "default"

    def _plain(self, prefix: str, bare: str) -> str:
        namespace = self.resolved(prefix)
        return bare if namespace == "default" else f"{namespace}::{bare}"

    # ---- names without

    def _clause(self, clause: Clause) -> Clause:
        if isinstance(clause, Belief):
            placed: Clause = replace(clause, belief=self._top(clause.belief))
        elif isinstance(clause, Rule):
            placed = replace(clause, head=self._top(clause.head), body=self._top(clause.body))
        elif isinstance(clause, Goal):
            placed = replace(clause, goal=self._top(clause.goal))
        elif isinstance(clause, Plan):
            placed = self._plan(clause)
        else:
            return clause
        return transformed(placed, _without_default)  # type: ignore[no-any-return]

    def _plan(self, plan: Plan) -> Plan:
        label = self._top(plan.label) if plan.name else plan.label
        return replace(
            plan,
            label=label,
            trigger=replace(plan.trigger, literal=self._top(plan.trigger.literal)),
            context=self._top(plan.context),
            until=None if plan.until is None else self._top(plan.until),
            body=self._body(plan.body),
            subplans=tuple(map(self._plan, plan.subplans)),
        )

    def _body(self, body: Body) -> Body:
        return tuple(map(self._step, body))

    def _step(self, step: BodyFormula) -> BodyFormula:
        if isinstance(step, Achieve):
            return replace(step, goal=self._top(step.goal))
        if isinstance(step, Test):
            return replace(step, formula=self._top(step.formula))
        if isinstance(step, Update):
            return replace(step, belief=self._top(step.belief))
        if isinstance(step, Act):
            return replace(step, action=self._top(step.action))
        if isinstance(step, If):
            condition = self._top(step.condition)
            then, otherwise = self._body(step.then), self._body(step.otherwise)
            return replace(step, condition=condition, then=then, otherwise=otherwise)
        if isinstance(step, While):
            return replace(step, condition=self._top(step.condition), body=self._body(step.body))
        if isinstance(step, For):
            return replace(step, generator=self._top(step.generator), body=self._body(step.body))
        if isinstance(step, ForkJoin):
            return replace(step, branches=tuple(map(self._body, step.branches)))
        assert isinstance(step, Constraint)  # the only other kind, whose operands are values
        return step

    def _top(self, formula: Any) -> Any:
        """Return a formula with its queries in this namespace."""
        if isinstance(formula, Conjunction | Disjunction | Negation):
            return rebuilt(formula, self._top)
        if isinstance(formula, Var):
            return Qualified(Literal(self.name), formula)
        if not isinstance(formula, Literal) or isinstance(formula, Relation):
            return formula
        if "::" in formula.functor or formula.functor in _RESERVED or formula.is_internal_action:
            return formula
        return _renamed(formula, f"{self.name}::{formula.functor}")


def _renamed(term: Term, functor: str) -> Term:
    assert isinstance(term, Literal)  # called for literals only
    return Literal(functor, term.args, term.annots, negated=term.negated)


def _without_default(part: Any) -> Term | None:
    """Return a literal without the prefix `default::`, or None for other parts."""
    if isinstance(part, Literal) and part.functor.startswith("default::"):
        bare = rebuilt(part, lambda inner: transformed(inner, _without_default))
        return _renamed(bare, part.functor[len("default::") :])
    return None


NO_NAMESPACE = Namespace(DEFAULT.functor)
