"""Actions on the plan library."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from ..errors import ProgramError
from ..language.loading import find_included, parse_file
from ..language.program import Plan, PlanTerm
from ..language.substitution import Unifier, rename
from ..language.terms import Cons, Literal, Nil, Term, Var, make_list, plain_text, text
from ..language.texts import parse_plan
from ..reasoning.actions import ActionError
from ..reasoning.beliefs import has_source
from ..reasoning.calls import Call
from ..reasoning.loading import add_plan as load_plan
from ..reasoning.loading import add_program
from ..reasoning.mail import without_source
from ..reasoning.plans import LoadedPlan
from .arguments import a_trigger, wrong
from .registry import STANDARD


@STANDARD.add(".include", least=1, most=2)
def include(call: Call, name: Term, *namespace: Term) -> object:
    """Add the plans of a file after those there are, and its beliefs and goals.

    An unbound namespace becomes a new one.
    """
    space, answer = "default", call.unifier
    if namespace and isinstance(namespace[0], Var):
        space = call.agent.names.fresh().name.replace("_", "ns")
        answer = {**call.unifier, namespace[0].name: Literal(space)}
    elif namespace:
        space = text(namespace[0])
    if not isinstance(name, str):
        raise wrong("include", "first argument must be a string.")
    agent = call.agent
    found = find_included(name, agent.program.folder)
    if isinstance(found, str):
        raise ActionError(found)
    try:
        add_program(agent, parse_file(found, namespace=space))
    except ProgramError as error:
        raise ActionError(str(error)) from None
    return answer


def _plan(term: Term) -> Plan:
    if isinstance(term, PlanTerm):
        return term.plan
    if isinstance(term, str):
        try:
            return parse_plan(term)
        except ProgramError as error:
            raise ActionError(str(error), "wrong_arguments") from None
    raise wrong("add_plan", f"The term '{text(term)}' can not be used as a plan for .add_plan.")


@STANDARD.add(".add_plan", least=1, most=3)
def add_plan(call: Call, plans: Term, *more: Term) -> bool:
    """`.add_plan(P, Source?, begin?)`: add a plan, given as term or text, or a list of them."""
    source = Literal("source", (more[0] if more else Literal("self"),))
    first = len(more) > 1 and text(more[1]) == "begin"
    agent = call.agent
    for term in plans if isinstance(plans, Nil | Cons) else (plans,):
        plan = _plan(term)
        if plan.name.startswith("p__"):
            plan = replace(plan, label=None)
        try:
            load_plan(agent, plan, source, first=first)
        except (ValueError, ProgramError) as error:
            raise ActionError(str(error)) from None
    return True


@STANDARD.add(".remove_plan", least=1, most=2)
def remove_plan(call: Call, labels: Term, *more: Term) -> bool:
    """`.remove_plan(Label, Source?)`: take a source off plans; those without one are removed."""
    source = Literal("source", (more[0] if more else Literal("self"),))
    for label in labels if isinstance(labels, Nil | Cons) else (labels,):
        if isinstance(label, PlanTerm):
            name = _label_of(call, label.plan)
        else:
            name = label.lstrip("@") if isinstance(label, str) else text(label).split("[")[0]
        call.agent.plans.remove(name, source)
    return True


def _label_of(call: Call, plan: Plan) -> str:
    if plan.name:
        return plan.name
    for known in call.agent.plans:
        if known.plan.is_same(plan):
            return known.label.functor
    return ""


def _relevant(call: Call, event: Term) -> list[LoadedPlan]:
    """Return the plans that are relevant for an event."""
    trigger = a_trigger(event)
    if trigger is None:
        raise wrong(
            "relevant_plans",
            f"first argument '{text(event)}' must follow the syntax of a trigger.",
        )
    wanted = trigger.literal
    found = []
    for plan in call.agent.plans.candidates(trigger.sort, wanted):
        known = plan.plan.trigger.literal
        fresh = rename(known, call.agent.names, {})
        # A plan that asks for a source is relevant for an event that names none.
        if isinstance(wanted, Literal) and not has_source(wanted):
            fresh = without_source(fresh)
        if call.unify(fresh, wanted) is not None:
            found.append(plan)
    return found


def _as_term(call: Call, plan: LoadedPlan) -> PlanTerm:
    """Return a plan as a term: with its label, and variables that are not those of the caller."""
    labelled = PlanTerm(replace(plan.plan, label=plan.label))
    renamed = rename(labelled, call.agent.names, {})
    return renamed if isinstance(renamed, PlanTerm) else labelled


@STANDARD.add(".relevant_plans", least=2, most=3)
def relevant_plans(call: Call, event: Term, plans: Term, *labels: Term) -> object:
    """`.relevant_plans({+!g}, Ps, Labels?)`: the plans for an event, and their labels."""
    found = _relevant(call, event)
    terms: list[Term] = [make_list(_as_term(call, plan) for plan in found)]
    if labels:
        terms.append(make_list(plan.label for plan in found))
    return call.unify(make_list(terms), make_list([plans, *labels]))


@STANDARD.add(".relevant_plan", least=2, most=3)
def relevant_plan(call: Call, event: Term, plan: Term, *label: Term) -> Iterator[Unifier]:
    """Yield an answer for each relevant plan."""
    pairs = ([_as_term(call, found), found.label] for found in _relevant(call, event))
    return call.each(make_list([plan, *label]), (pair[: 1 + len(label)] for pair in pairs))


@STANDARD.add(".plan_label", least=2, most=2)
def plan_label(call: Call, plan: Term, label: Term) -> object:
    """`.plan_label(P, Label)`: the plan that has a label."""
    name = label.functor if isinstance(label, Literal) else plain_text(label)
    found = call.agent.plans.get(name)
    return False if found is None else call.unify(_as_term(call, found), plan)


@STANDARD.add(".list_plans", most=1)
def list_plans(call: Call, *event: Term) -> bool:
    """Print the plans, or those that are relevant for an event."""
    shown = _relevant(call, event[0]) if event else list(call.agent.plans)
    for plan in shown:
        call.agent.say(f"{replace(plan.plan, label=plan.label)}.")
    return True
