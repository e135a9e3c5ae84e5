"""The plan library: plans in order, found by their trigger."""

from __future__ import annotations

from collections.abc import Iterator

from .compiled import condition, matcher
from .order import sorted_annots
from .program import Plan
from .steps import Step, compile_body
from .terms import FROM_SELF, TRUE, Literal, Var

Key = tuple[str, int, bool]


class LoadedPlan:
    """A plan ready to run: its body compiled, its label complete."""

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

    @property
    def place(self) -> str:
        return f"{self.plan.place.file}:{self.plan.place.line}"

    def __str__(self) -> str:
        return f"@{self.label.functor} {self.plan.trigger}"


class PlanLibrary:
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

    def by_label(self, label: str) -> LoadedPlan | None:
        return self._by_label.get(label)

    def add(self, plan: Plan, source: Literal = FROM_SELF, *, first: bool = False) -> LoadedPlan:
        """Adds a plan; one that is there already just gets another source.

        Raises ValueError when another plan has its label.
        """
        for known in self._plans:
            if (known.plan.trigger, known.plan.context, known.plan.body) == (
                plan.trigger,
                plan.context,
                plan.body,
            ) and (not plan.name or plan.name == known.label.functor):
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

    def remove(self, label: str, source: Literal = FROM_SELF) -> bool:
        """Takes a source off a plan, and the plan when it was the last one."""
        plan = self._by_label.get(label)
        if plan is None or source not in plan.label.annots:
            return plan is not None
        annots = tuple(annot for annot in plan.label.annots if annot != source)
        plan.label = plan.label.with_annots(annots)
        if any(isinstance(a, Literal) and a.functor == "source" for a in annots):
            return True
        del self._by_label[label]
        self._plans.remove(plan)
        if plan in self._for_any[plan.sort]:
            self._for_any[plan.sort].remove(plan)
        filed = self._by_trigger[plan.sort]
        for key in [key for key, plans in filed.items() if plan in plans]:
            filed[key].remove(plan)
            if not filed[key]:
                del filed[key]
        return True

    def candidates(self, sort: str, literal: Literal | Var) -> list[LoadedPlan]:
        """The plans whose trigger has the event's sort and functor, in order."""
        if isinstance(literal, Var):
            return [plan for plan in self._plans if plan.sort == sort]
        plans = self._by_trigger[sort].get(literal.key)
        return self._for_any[sort] if plans is None else plans
