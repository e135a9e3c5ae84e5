"""Plans and rules as terms, and decomposition of terms by `=..`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from .body import Act, BodyTerm, Constraint, has_variables, transformed
from .operations import Quoted, TriggerTerm
from .program import Plan, Rule, Trigger
from .substitution import sorted_annots, with_more_annots
from .terms import DEFAULT, EMPTY, TRUE, Cons, Literal, Nil, Term, make_list, placed


@dataclass(frozen=True)
class PlanTerm(Quoted):
    """`{ +!g : c <- b }` as an argument."""

    plan: Plan

    @cached_property
    def ground(self) -> bool:
        """Whether it contains no variables."""
        return not has_variables(self.plan)

    def changed(self, change: Callable[[Any], Any]) -> PlanTerm:
        """Return the term with all parts replaced for which `change` returns not None."""
        return PlanTerm(transformed(self.plan, change))

    @property
    def structure(self) -> Literal:
        """Plan as a structure, `plan(Label, Event, Context, Body)`."""
        return Literal("plan", self.plan.parts)

    def __str__(self) -> str:
        has_more = self.plan.body or self.plan.context != TRUE
        return f"{{ {self.plan} }}" if has_more else f"{{ {self.plan} <- true }}"


@dataclass(frozen=True)
class RuleTerm(Quoted):
    """`{ head :- body }` as an argument."""

    rule: Rule

    @cached_property
    def ground(self) -> bool:
        """Whether it contains no variables."""
        return not has_variables(self.rule)

    def changed(self, change: Callable[[Any], Any]) -> RuleTerm:
        """Return the term with all parts replaced for which `change` returns not None."""
        return RuleTerm(transformed(self.rule, change))

    def annotated(self, annots: tuple[Term, ...]) -> RuleTerm:
        """Return the rule with additional annotations of its head."""
        return RuleTerm(replace(self.rule, head=with_more_annots(self.rule.head, *annots)))

    def __str__(self) -> str:
        return f"{{ {self.rule} }}"


def plan_change(operator: str, plan: PlanTerm) -> Literal | None:
    """Return the internal action for `+{ +!g }` or `-{ +!g }`, or None for other operators."""
    if operator == "-":
        return Literal(".remove_plan", (plan,))
    if operator not in ("+", "+<", "+>"):
        return None
    at = Literal("end" if operator == "+>" else "begin")
    return Literal(".add_plan", (plan, Literal("self"), at))


def decomposed(left: Term, right: Term) -> tuple[Term, Term] | None:
    """Return two terms that unify if `left =.. right` holds, or None if it cannot hold.

    The right side is a list, `[default, Functor, Arguments, Annotations]` or the parts of a plan.
    The namespace `default` is optional.
    """
    if isinstance(left, PlanTerm):
        return make_list(left.plan.parts), right
    if isinstance(left, BodyTerm) and left.structure is not None:
        left = left.structure
    if isinstance(left, Literal):
        space, _, functor = left.functor.rpartition("::")
        parts: list[Term] = [
            Literal(space) if space else DEFAULT,
            Literal(functor, negated=left.negated),
            make_list(left.args),
            make_list(left.annots),
        ]
        if isinstance(right, Cons) and len(right) == 3:
            del parts[0]
        return make_list(parts), right
    if isinstance(right, Cons):
        made = put_together(right)
        return None if made is None else (left, made)
    return None


def put_together(parts: Cons) -> Literal | PlanTerm | None:
    """Return the literal that a list like [foo, [1, 2], [annotation]] describes, or None.

    A list like [label, { +!g }, context, { a; b }] describes a plan.
    """
    elements = list(parts)
    if len(elements) == 4 and isinstance(elements[1], TriggerTerm | BodyTerm):
        return _plan_of(elements)
    space = DEFAULT
    if len(elements) == 4:
        first = elements.pop(0)
        space = first if isinstance(first, Literal) else DEFAULT
    functor = elements[0]
    if isinstance(functor, str):
        functor = Literal(functor)
    if not isinstance(functor, Literal) or len(elements) > 3:
        return None
    lists = [*elements[1:], EMPTY, EMPTY][:2]
    if not all(isinstance(part, Nil | Cons) for part in lists):
        return None
    args, annots = (tuple(part) for part in lists)  # type: ignore[arg-type]
    made = Literal(functor.functor, args, sorted_annots(annots), negated=functor.negated)
    return made if space == DEFAULT else placed(made, space.functor)


def _plan_of(elements: list[Term]) -> PlanTerm | None:
    label, event, context, body = elements
    trigger = event.as_trigger if isinstance(event, BodyTerm) else event
    if not isinstance(label, Literal) or not isinstance(trigger, TriggerTerm):
        return None
    if isinstance(context, BodyTerm):
        # The parser reads a context in braces, { c }, as a body of one step.
        step = context.body[0] if len(context.body) == 1 else None
        context = TRUE
        if isinstance(step, Act):
            context = step.action
        elif isinstance(step, Constraint):
            context = step.relation
    steps = body.body if isinstance(body, BodyTerm) else (Act(body),)  # type: ignore[arg-type]
    name = None if label.functor == "nolabel" else label
    sort = trigger.sort
    return PlanTerm(
        Plan(
            label=name,
            trigger=Trigger(sort[0], sort[1:], trigger.literal),
            context=context,
            body=steps,
        )
    )
