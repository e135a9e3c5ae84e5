"""Actions on the plan library."""

from __future__ import annotations

from collections.abc import Mapping

from ..errors import ProgramError
from ..language.loading import find_included, parse_file
from ..language.parser import parse_plan
from ..language.program import Plan, PlanTerm, Program
from ..language.terms import Cons, Literal, Nil, Term, make_list, text
from ..reasoning.actions import ActionError, InternalAction, check_actions
from ..reasoning.calls import Call
from .arguments import a_trigger, wrong


def include(call: Call, name: Term) -> bool:
    """Add the plans of a file after those there are, and its beliefs and goals."""
    if not isinstance(name, str):
        raise wrong("include", "first argument must be a string.")
    agent = call.agent
    found = find_included(name, agent.program.folder)
    if isinstance(found, str):
        raise ActionError(found)
    try:
        agent.add_program(parse_file(found))
    except ProgramError as error:
        raise ActionError(str(error)) from None
    return True


def _plan(term: Term) -> Plan:
    if isinstance(term, PlanTerm):
        return term.plan
    if isinstance(term, str):
        try:
            return parse_plan(term)
        except ProgramError as error:
            raise ActionError(str(error), "wrong_arguments") from None
    raise wrong("add_plan", f"The term '{text(term)}' can not be used as a plan for .add_plan.")


def add_plan(call: Call, plans: Term, *more: Term) -> bool:
    source = Literal("source", (more[0] if more else Literal("self"),))
    first = len(more) > 1 and text(more[1]) == "begin"
    agent = call.agent
    for term in plans if isinstance(plans, Nil | Cons) else (plans,):
        plan = _plan(term)
        try:
            check_actions(Program(agent.program.source, plans=(plan,)), agent.actions)
            agent.plans.add(plan, source, first=first)
        except (ValueError, ProgramError) as error:
            raise ActionError(str(error)) from None
    return True


def remove_plan(call: Call, labels: Term, *more: Term) -> bool:
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


def relevant_plans(call: Call, event: Term, plans: Term, *labels: Term) -> object:
    trigger = a_trigger(event)
    if trigger is None:
        raise wrong(
            "relevant_plans",
            f"first argument '{text(event)}' must follow the syntax of a trigger.",
        )
    found = [
        plan
        for plan in call.agent.plans.candidates(trigger.sort, trigger.literal)
        if call.unify(trigger.literal, plan.plan.trigger.literal) is not None
    ]
    terms: list[Term] = [make_list(PlanTerm(plan.plan) for plan in found)]
    if labels:
        terms.append(make_list(plan.label for plan in found))
    return call.unify(make_list(terms), make_list([plans, *labels]))


ACTIONS: Mapping[str, InternalAction] = {
    ".include": InternalAction(include, 1, 1),
    ".add_plan": InternalAction(add_plan, 1, 3),
    ".remove_plan": InternalAction(remove_plan, 1, 2),
    ".relevant_plans": InternalAction(relevant_plans, 2, 3),
}
