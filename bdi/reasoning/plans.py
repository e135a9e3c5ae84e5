"""The plan library: plans compiled to steps, indexed by their trigger."""

from __future__ import annotations

from collections.abc import Iterator
from copy import copy

from ..language.body import (
    Achieve,
    Act,
    Body,
    BodyFormula,
    Constraint,
    Event,
    For,
    If,
    Place,
    Test,
    Update,
    While,
)
from ..language.operations import Qualified
from ..language.program import Key, Plan, Rule, made_once
from ..language.quoted import RuleTerm
from ..language.substitution import Build, builder, sorted_annots
from ..language.terms import FROM_SELF, TRUE, Literal, Term, Var
from ..language.unification import matcher
from .beliefs import has_source, with_source
from .contexts import Condition, condition


class BodyStep:
    """One step of a body.

    Attributes
    ----------
    operation
        Operator of a goal, belief or fork, name of a control structure, or kind of an action.
    term
        Goal, belief, action or condition.
    build, check
        Function for the value of the term, or for its first solution.
    branches
        First steps of the inner bodies.
    next
        Following step, if any.
    """

    __slots__ = ("branches", "build", "check", "formula", "next", "operation", "term")

    def __init__(
        self, operation: str, formula: BodyFormula, following: BodyStep | None, term: Term = TRUE
    ) -> None:
        self.operation = operation
        self.formula = formula
        self.next = following
        self.term = term
        self.branches: tuple[BodyStep | None, ...] = ()
        if isinstance(formula, Achieve | Update | Act):
            self.build: Build = builder(term)
            if isinstance(formula, Achieve | Update) and not isinstance(term, Literal):
                self.build = _with_source(self.build)
        else:
            self.check: Condition = condition(term)

    @property
    def goal(self) -> Event | None:
        """Subgoal for which the step waits, if any."""
        formula = self.formula
        return formula.goal if isinstance(formula, Achieve) and not formula.new_focus else None


def compile_body(body: Body, following: BodyStep | None = None) -> BodyStep | None:
    """Return the first step of a body that continues with `following`."""
    # In reverse order, because each step refers to the next one.
    for formula in reversed(body):
        following = _compile(formula, following)
    return following


def _compile(formula: BodyFormula, following: BodyStep | None) -> BodyStep:
    if isinstance(formula, Achieve):
        operation = "!!" if formula.new_focus else "!"
        return BodyStep(operation, formula, following, _sourced(formula.goal))
    if isinstance(formula, Update):
        return BodyStep(formula.operator, formula, following, _sourced(formula.belief))
    if isinstance(formula, Test):
        return BodyStep("?", formula, following, formula.formula)
    if isinstance(formula, Act):
        return BodyStep(_kind(formula.action), formula, following, formula.action)
    if isinstance(formula, Constraint):
        return BodyStep("constraint", formula, following, formula.relation)
    if isinstance(formula, If):
        step = BodyStep("if", formula, following, formula.condition)
        step.branches = (
            compile_body(formula.then, following),
            compile_body(formula.otherwise, following),
        )
        return step
    if isinstance(formula, While):
        return _compile_loop("while", formula, formula.condition, following)
    if isinstance(formula, For):
        return _compile_loop("for", formula, formula.generator, following)
    step = BodyStep("|&|" if formula.all_of else "|||", formula, following)
    meeting = BodyStep("join", formula, following)
    step.branches = tuple(compile_body(branch, meeting) for branch in formula.branches)
    return step


def _compile_loop(
    name: str, formula: While | For, term: Term, following: BodyStep | None
) -> BodyStep:
    """Return the first step of a loop, whose body leads to a step that repeats it."""
    first = BodyStep(name, formula, following, term)
    again = BodyStep(f"{name} again", formula, following, term)
    # Two steps, because a loop begins in another way than it continues.
    first.branches = again.branches = (compile_body(formula.body, again) or again,)
    return first


def _sourced(term: Term) -> Term:
    """Return a literal or a rule with a source, and other terms unchanged."""
    if isinstance(term, RuleTerm):
        rule = term.rule
        return RuleTerm(Rule(with_source(rule.head), rule.body, rule.place))
    return with_source(term) if isinstance(term, Literal) else term


def _with_source(build: Build) -> Build:
    """Return a function that adds a source to the value of a variable."""
    return lambda u: _sourced(build(u))


def _kind(action: Event) -> str:
    if isinstance(action, Literal):
        return "internal action" if action.is_internal_action else "external action"
    return "variable"


PROTOCOL = "<messages>"
"""Name of the program with the plans for messages."""

SLEEPING = frozenset({"jag_sleeping", "jag_awaking"})
"""Events of an agent that becomes idle, and that becomes active again."""


def _is_file(place: Place) -> bool:
    return bool(place.file) and not place.file.startswith("<") and place.file.endswith(".asl")


class Compiled:
    """Trigger, context and body of a plan as functions and steps, independent of an agent."""

    __slots__ = ("applies", "body", "match", "until")

    def __init__(self, plan: Plan) -> None:
        self.match = matcher(plan.trigger.literal)
        self.applies = None if plan.context == TRUE else condition(plan.context)
        self.until = None if plan.until is None else condition(plan.until)
        self.body: BodyStep | None = compile_body(plan.body)


@made_once
def compiled(plan: Plan) -> Compiled:
    """Return the compiled plan."""
    return Compiled(plan)


class LoadedPlan:
    """Compiled plan in a library. It is immutable, because agents with one program share its plans.

    Attributes
    ----------
    plan
        Plan as written.
    label
        Label with a name and sources.
    inner
        Library of its subplans, if any.
    scope
        Library that contains it, if it is the library of another plan.
    until
        Check of the condition by which its goal is achieved, if any.
    """

    __slots__ = (
        *("applies", "atomic", "body", "inner", "label", "literal", "match", "plan"),
        *("scope", "sort", "until"),
    )

    def __init__(self, plan: Plan, label: Literal, scope: PlanLibrary | None = None) -> None:
        self.plan = plan
        self.label = label
        self.scope = scope
        self.sort = plan.trigger.sort
        self.literal = plan.trigger.literal
        code = compiled(plan)
        self.match = code.match
        self.applies = code.applies
        self.body = code.body
        self.until = code.until
        self.atomic = plan.atomic
        self.inner: PlanLibrary | None = None
        if plan.subplans:
            self.inner = PlanLibrary(scope, is_inside=True)
            for part in plan.subplans:
                self.inner.add(part)

    def __str__(self) -> str:
        return f"@{self.label.functor} {self.plan.trigger}"


_SORTS = ("+", "-", "+!", "-!", "+?", "-?", "^!", "^?")


class PlanLibrary:
    """Plans of an agent or a plan. A plan for any event, `+!G`, is relevant for all goals.

    `outer` is the enclosing library, which is searched if no plan is found here.

    Attributes
    ----------
    has_inner
        True if plans have subplans.
    has_states
        True if there are plans for states of goals, `^!g`.
    has_sleep
        True if there are plans for `jag_sleeping` or `jag_awaking`.
    has_protocol
        True if the program handles messages by its own plans.
    has_inner_updates
        True if subplans handle changes of beliefs.
    has_special
        True if `has_inner` or `has_sleep`.
    """

    def __init__(self, outer: PlanLibrary | None = None, *, is_inside: bool = False) -> None:
        self.outer = outer
        self.has_inner = False
        self.has_states = False
        self.has_sleep = False
        self.has_protocol = False
        self.has_inner_updates = False
        self.has_special = False
        self._is_inside = is_inside
        self._plans: list[LoadedPlan] = []
        self._by_trigger: dict[str, dict[Key, list[LoadedPlan]]] = {sort: {} for sort in _SORTS}
        self._for_any: dict[str, list[LoadedPlan]] = {sort: [] for sort in _SORTS}
        self._by_label: dict[str, LoadedPlan] = {}
        self._made_labels = 0
        self._shares = False

    def __iter__(self) -> Iterator[LoadedPlan]:
        return iter(self._plans)

    def __len__(self) -> int:
        return len(self._plans)

    def take(self, other: PlanLibrary) -> None:
        """Share the plans of another library until the first change."""
        self.has_inner = other.has_inner
        self.has_states = other.has_states
        self.has_sleep = other.has_sleep
        self.has_protocol = other.has_protocol
        self.has_inner_updates = other.has_inner_updates
        self.has_special = other.has_special
        self._plans, self._by_label = other._plans, other._by_label
        self._by_trigger, self._for_any = other._by_trigger, other._for_any
        self._made_labels = other._made_labels
        self._shares = True

    def _stop_sharing(self) -> None:
        """Copy shared lists before a change."""
        if not self._shares:
            return
        self._shares = False
        self._plans, self._by_label = self._plans.copy(), self._by_label.copy()
        self._for_any = {sort: plans.copy() for sort, plans in self._for_any.items()}
        self._by_trigger = {
            sort: {key: plans.copy() for key, plans in filed.items()}
            for sort, filed in self._by_trigger.items()
        }

    def add(self, plan: Plan, source: Literal = FROM_SELF, *, first: bool = False) -> LoadedPlan:
        """Add a plan, or only another source if the plan exists.

        Raises `ValueError` if another plan has its label.
        """
        self._stop_sharing()
        for loaded in self.candidates(plan.trigger.sort, plan.trigger.literal):
            if loaded.plan.is_same(plan) and (not plan.name or plan.name == loaded.label.functor):
                annots = sorted_annots((*loaded.label.annots, source))
                return self._relabel(loaded, loaded.label.with_annots(annots))
        label = plan.label if isinstance(plan.label, Literal) else Literal("")
        if not label.functor:
            label = Literal(self._new_label(), label.args, label.annots)
        if label.functor in self._by_label:
            raise ValueError(f"there is already a plan with the label @{label.functor}")
        own = (
            (source,) if not _is_file(plan.place) else (source, Literal("url", (plan.place.name,)))
        )
        annots = sorted_annots((*label.annots, *own))
        labelled = Literal(label.functor, label.args, annots)
        loaded = LoadedPlan(plan, labelled, self if self._is_inside else None)
        self._by_label[label.functor] = loaded
        self._update_flags(loaded)
        self._file(loaded, first)
        return loaded

    def _update_flags(self, loaded: LoadedPlan) -> None:
        self.has_states = self.has_states or loaded.sort[0] == "^"
        if isinstance(loaded.literal, Literal) and loaded.literal.functor in SLEEPING:
            self.has_sleep = True
        if isinstance(loaded.literal, Literal) and loaded.literal.functor == "kqml_received":
            self.has_protocol = self.has_protocol or loaded.plan.place.file != PROTOCOL
        if self._is_inside and len(loaded.sort) == 1:
            self.has_inner_updates = True
        inner = loaded.inner
        if inner is not None:
            self.has_inner = True
            self.has_states = self.has_states or inner.has_states
            self.has_inner_updates = self.has_inner_updates or inner.has_inner_updates
        self.has_special = self.has_inner or self.has_sleep

    def _relabel(self, plan: LoadedPlan, label: Literal) -> LoadedPlan:
        """Replace a plan by a copy with another label, because others may share it."""
        changed = copy(plan)
        changed.label = label
        filed = self._by_trigger[plan.sort].values()
        # A plan for any event is in the lists of all keys.
        for plans in (self._plans, self._for_any[plan.sort], *filed):
            if plan in plans:
                plans[plans.index(plan)] = changed
        self._by_label[label.functor] = changed
        return changed

    def get(self, label: str) -> LoadedPlan | None:
        """Return the plan with a label, or None."""
        return self._by_label.get(label)

    def _new_label(self) -> str:
        while True:
            self._made_labels += 1
            label = f"p__{self._made_labels}"
            if label not in self._by_label:
                return label

    def _file(self, plan: LoadedPlan, first: bool) -> None:
        self._plans.insert(0 if first else len(self._plans), plan)
        filed = self._by_trigger[plan.sort]
        if not isinstance(plan.literal, Literal):
            catch_all = self._for_any[plan.sort]
            catch_all.insert(0 if first else len(catch_all), plan)
            for plans in filed.values():
                plans.insert(0 if first else len(plans), plan)
            return
        plans = filed.get(plan.literal.key, [])
        if not plans:
            filed[plan.literal.key] = plans
            plans.extend(self._for_any[plan.sort])
        plans.insert(0 if first else len(plans), plan)

    def remove(self, label: str, source: Literal = FROM_SELF) -> None:
        """Remove a source of a plan, and the plan with its last source."""
        self._stop_sharing()
        plan = self._by_label.get(label)
        if plan is None or source not in plan.label.annots:
            return
        annots = tuple(annot for annot in plan.label.annots if annot != source)
        left = plan.label.with_annots(annots)
        if has_source(left):
            self._relabel(plan, left)
            return
        del self._by_label[label]
        self._plans.remove(plan)
        if plan in self._for_any[plan.sort]:
            self._for_any[plan.sort].remove(plan)
        filed = self._by_trigger[plan.sort]
        for key in [key for key, plans in filed.items() if plan in plans]:
            filed[key].remove(plan)
            if not filed[key]:
                del filed[key]

    def candidates(self, sort: str, literal: Literal | Var | Qualified) -> list[LoadedPlan]:
        """Return the plans that may be relevant for an event, in order."""
        if literal.__class__ is Literal:
            plans = self._by_trigger[sort].get(literal.key)
            return self._for_any[sort] if plans is None else plans
        return [plan for plan in self._plans if plan.sort == sort]
