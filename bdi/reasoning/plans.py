"""The plan library: plans in order, indexed by their trigger."""

from __future__ import annotations

from collections.abc import Iterator

from ..language.order import sorted_annots
from ..language.program import Plan
from ..language.terms import FROM_SELF, TRUE, Literal, Var
from .beliefs import Key, has_source
from .bodies import Step, compile_body
from .compiled import condition, matcher


class LoadedPlan:
    """Plan ready to run: trigger, context and body compiled, label with a name and sources."""

    __slots__ = ("applies", "atomic", "body", "label", "literal", "match", "plan", "sort")

    def __init__(self, plan: Plan, label: Literal) -> None:
        self.plan = plan
        self.label = label
        self.sort = plan.trigger.sort
        self.literal = plan.trigger.literal
        self.match = matcher(plan.trigger.literal)
        self.applies = None if plan.context == TRUE else condition(plan.context)
        self.body: Step | None = compile_body(plan.body)
        self.atomic = plan.atomic

    def __str__(self) -> str:
        return f"@{self.label.functor} {self.plan.trigger}"


class PlanLibrary:
    """The plans of an agent. A plan for any event, as `+!G`, is found among those of each."""

    def __init__(self) -> None:
        self._plans: list[LoadedPlan] = []
        self._by_trigger: dict[str, dict[Key, list[LoadedPlan]]] = {
            sort: {} for sort in ("+", "-", "+!", "-!", "+?", "-?")
        }
        self._for_any: dict[str, list[LoadedPlan]] = {sort: [] for sort in self._by_trigger}
        self._by_label: dict[str, LoadedPlan] = {}
        self._made_labels = 0

    def __iter__(self) -> Iterator[LoadedPlan]:
        return iter(self._plans)

    def __len__(self) -> int:
        return len(self._plans)

    def add(self, plan: Plan, source: Literal = FROM_SELF, *, first: bool = False) -> LoadedPlan:
        """Add a plan, or only another source to a plan that is there already.

        Raises:
            ValueError: another plan has its label.
        """
        for known in self._plans:
            if known.plan.is_same(plan) and (not plan.name or plan.name == known.label.functor):
                known.label = known.label.with_annots(sorted_annots((*known.label.annots, source)))
                return known
        label = plan.label or Literal("")
        if not label.functor:
            label = Literal(self._new_label(), (), label.annots)
        if label.functor in self._by_label:
            raise ValueError(f"there is already a plan with the label @{label.functor}")
        loaded = LoadedPlan(plan, label.with_annots(sorted_annots((*label.annots, source))))
        self._by_label[label.functor] = loaded
        self._file(loaded, first)
        return loaded

    def _new_label(self) -> str:
        while True:
            self._made_labels += 1
            label = f"l__{self._made_labels}"
            if label not in self._by_label:
                return label

    def _file(self, plan: LoadedPlan, first: bool) -> None:
        self._plans.insert(0 if first else len(self._plans), plan)
        filed = self._by_trigger[plan.sort]
        if isinstance(plan.literal, Var):
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
        """Take a source off the plan with a label, and remove the plan if it was the last."""
        plan = self._by_label.get(label)
        if plan is None or source not in plan.label.annots:
            return
        annots = tuple(annot for annot in plan.label.annots if annot != source)
        plan.label = plan.label.with_annots(annots)
        if has_source(plan.label):
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

    def candidates(self, sort: str, literal: Literal | Var) -> list[LoadedPlan]:
        """Return the plans whose trigger has the sort and key of an event, in order."""
        if isinstance(literal, Var):
            return [plan for plan in self._plans if plan.sort == sort]
        plans = self._by_trigger[sort].get(literal.key)
        return self._for_any[sort] if plans is None else plans
