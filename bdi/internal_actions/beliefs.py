"""Internal actions on beliefs, annotations and the plan library."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from ..actions import ActionError
from ..errors import ProgramError
from ..language.loading import find_included, parse_file, parse_plan
from ..language.operations import Qualified
from ..language.program import Plan, Rule
from ..language.quoted import PlanTerm, RuleTerm
from ..language.substitution import Unifier, distinct, rename, substitute, with_more_annots
from ..language.terms import (
    FALSE,
    TRUE,
    Cons,
    Literal,
    Nil,
    Term,
    Var,
    make_list,
    namespace_of,
    plain_text,
    text,
)
from ..reasoning.beliefs import has_source, with_source
from ..reasoning.contexts import condition
from ..reasoning.execution import Call
from ..reasoning.plans import LoadedPlan
from ..reasoning.state import add_plan as load_plan, add_program
from .messages import nested_source, without_source
from .registry import STANDARD, a_list, a_literal, a_trigger, wrong


@STANDARD.add(".abolish", least=1, most=1)
def abolish(call: Call, pattern: Term) -> bool:
    """Remove all beliefs that match, from any source if the pattern names none."""
    if not isinstance(pattern, Literal | Var | Qualified):
        raise wrong("abolish", "first argument must be a literal or variable.")
    for found in call.agent.beliefs.matching(pattern, call.unifier):
        call.agent.abolish(found)
    return True


@STANDARD.add(".perceive", most=0)
def perceive(call: Call) -> bool:
    """Do nothing, because percepts are believed immediately."""
    return True


@STANDARD.add(".asserta", least=1, most=1)
def asserta(call: Call, belief: Term) -> bool:
    """Add a belief or a rule before the others, by default with the source `self`."""
    if isinstance(belief, RuleTerm):
        rule = belief.rule
        call.agent.beliefs.add_rule(Rule(with_source(rule.head), rule.body, rule.place))
    else:
        call.agent.believe(a_literal("asserta", belief))
    return True


@STANDARD.add(".assertz", least=1, most=1)
def assertz(call: Call, belief: Term) -> bool:
    """Add a belief or a rule after the others, without a default source."""
    if isinstance(belief, RuleTerm):
        call.agent.beliefs.add_rule(belief.rule, at_end=True)
    else:
        call.agent.add_belief(a_literal("assertz", belief), at_end=True)
    return True


@STANDARD.add(".belief", least=1, most=1)
def belief(call: Call, pattern: Term) -> Iterator[Unifier]:
    """Yield an answer for each stored belief, without rules."""
    if isinstance(pattern, Literal | Var | Qualified):
        beliefs = call.agent.beliefs.matching(pattern, call.unifier)
        yield from call.each(pattern, beliefs)


@STANDARD.add(".relevant_rules", least=2, most=2)
def relevant_rules(call: Call, head: Term, result: Term) -> object:
    """Unify with the rules whose head unifies, without their sources."""
    if not isinstance(head, Literal | Var | Qualified):
        raise wrong("relevant_rules", "first argument must be a literal or variable.")
    rules = [
        RuleTerm(Rule(_bare(rule.head), rule.body, rule.place))
        for rule in call.agent.beliefs.rules()
        if call.unify(head, _bare(rule.head)) is not None
    ]
    return call.unify(make_list(rules), result)


def _bare(head: Literal) -> Literal:
    bare = without_source(head)
    return bare if isinstance(bare, Literal) else head


@STANDARD.add(".list_rules", most=0)
def list_rules(call: Call) -> bool:
    """Print the rules."""
    for rule in call.agent.beliefs.rules():
        call.agent.say(str(rule))
    return True


def answers(call: Call, term: Term, formula: Term) -> list[Term]:
    """Return the values of a term in all solutions of a formula."""
    return [substitute(term, u) for u in call.agent.logic.solutions(formula, call.unifier)]


@STANDARD.add(".findall", least=3, most=3)
def findall(call: Call, term: Term, formula: Term, result: Term) -> object:
    """`.findall(T, F, L)`: the values of a term in all solutions of a formula."""
    return call.unify(result, call.agent.logic.collected(term, formula, call.unifier))


@STANDARD.add(".setof", least=3, most=3)
def setof(call: Call, term: Term, formula: Term, result: Term) -> object:
    """`.setof(T, F, L)`: as `.findall`, in standard order without duplicates."""
    return call.unify(result, make_list(distinct(answers(call, term, formula))))


@STANDARD.add(".count", least=2, most=3)
def count(call: Call, what: Term, *more: Term) -> object:
    """`.count(Formula, N)`, or `.count(Element, List, N)` for the elements that unify."""
    if len(more) == 1:
        number = sum(1 for _ in call.agent.logic.solutions(what, call.unifier))
        return call.unify(more[0], number)
    elements = a_list("count", more[0], "second")
    number = sum(call.unify(what, element) is not None for element in elements)
    return call.unify(more[1], number)


def _annotated(term: Term, annot: Term) -> Term:
    if isinstance(term, Nil | Cons):
        return make_list([_annotated(element, annot) for element in term])
    if not isinstance(term, Literal):
        return term
    return with_more_annots(term, annot)


@STANDARD.add(".add_annot", least=3, most=3)
def add_annot(call: Call, term: Term, annot: Term, result: Term) -> object:
    """`.add_annot(T, A, R)`: a literal, or each of a list, with one more annotation."""
    return call.unify(result, _annotated(term, annot))


@STANDARD.add(".add_nested_source", least=3, most=3)
def add_nested_source(call: Call, term: Term, source: Term, result: Term) -> object:
    """`.add_nested_source(T, S, R)`: a literal, or each of a list, as reported by S."""
    return call.unify(nested_source(term, source), result)


@STANDARD.add(".remove_source_annot", least=2, most=3)
def remove_source_annot(call: Call, term: Term, result: Term, *source: Term) -> object:
    """`.remove_source_annot(T, R, S?)`: a literal or list without its sources, or without one."""
    return call.unify(without_source(term, *source), result)


@STANDARD.add(".eval", least=2, most=2)
def evaluate(call: Call, result: Term, formula: Term) -> object:
    """`.eval(R, F)`: whether a formula holds."""
    solution = condition(formula)(call.agent.logic, call.unifier)
    return call.unify(result, FALSE if solution is None else TRUE)


@STANDARD.add(".copy_term", least=2, most=2)
@STANDARD.add(".rename_apart", least=2, most=2)
def copy_term(call: Call, term: Term, copy: Term) -> object:
    """Unify with a copy of a term with fresh variables."""
    return call.unify(rename(term, call.agent.names, {}), copy)


@STANDARD.add(".namespace", least=1, most=1)
def namespace(call: Call, name: Term) -> object:
    """Yield the namespaces of beliefs and plans, without local ones."""
    agent = call.agent
    functors = [belief.functor for belief in agent.beliefs]
    functors += [p.literal.functor for p in agent.plans if isinstance(p.literal, Literal)]
    names = dict.fromkeys(("default", *map(namespace_of, functors)))
    return call.each(name, [Literal(space) for space in names if not space.startswith("#")])


@STANDARD.add(".include", least=1, most=2)
def include(call: Call, name: Term, *namespace: Term) -> object:
    """Add the plans of a file after the others, then its beliefs and goals.

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
    path = find_included(name, agent.program.folder)
    if isinstance(path, str):
        raise ActionError(path)
    try:
        add_program(agent, parse_file(path, namespace=space))
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
    """`.remove_plan(Label, Source?)`: remove a source of plans, and plans without sources."""
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
    relevant = []
    for plan in call.agent.plans.candidates(trigger.sort, wanted):
        own = plan.plan.trigger.literal
        fresh = rename(own, call.agent.names, {})
        # A plan that requires a source is relevant for an event without one.
        if isinstance(wanted, Literal) and not has_source(wanted):
            fresh = without_source(fresh)
        if call.unify(fresh, wanted) is not None:
            relevant.append(plan)
    return relevant


def _as_term(call: Call, plan: LoadedPlan) -> PlanTerm:
    """Return a plan as a term with its label and fresh variables."""
    labelled = PlanTerm(replace(plan.plan, label=plan.label))
    renamed = rename(labelled, call.agent.names, {})
    return renamed if isinstance(renamed, PlanTerm) else labelled


@STANDARD.add(".relevant_plans", least=2, most=3)
def relevant_plans(call: Call, event: Term, plans: Term, *labels: Term) -> object:
    """`.relevant_plans({+!g}, Ps, Labels?)`: the plans for an event, and their labels."""
    relevant = _relevant(call, event)
    terms: list[Term] = [make_list(_as_term(call, plan) for plan in relevant)]
    if labels:
        terms.append(make_list(plan.label for plan in relevant))
    return call.unify(make_list(terms), make_list([plans, *labels]))


@STANDARD.add(".relevant_plan", least=2, most=3)
def relevant_plan(call: Call, event: Term, plan: Term, *label: Term) -> Iterator[Unifier]:
    """Yield an answer for each relevant plan."""
    pairs = ([_as_term(call, loaded), loaded.label] for loaded in _relevant(call, event))
    return call.each(make_list([plan, *label]), (pair[: 1 + len(label)] for pair in pairs))


@STANDARD.add(".plan_label", least=2, most=2)
def plan_label(call: Call, plan: Term, label: Term) -> object:
    """`.plan_label(P, Label)`: the plan with a label."""
    name = label.functor if isinstance(label, Literal) else plain_text(label)
    loaded = call.agent.plans.get(name)
    return False if loaded is None else call.unify(_as_term(call, loaded), plan)


@STANDARD.add(".list_plans", most=1)
def list_plans(call: Call, *event: Term) -> bool:
    """Print the plans, or those that are relevant for an event."""
    shown = _relevant(call, event[0]) if event else list(call.agent.plans)
    for plan in shown:
        call.agent.say(f"{replace(plan.plan, label=plan.label)}.")
    return True
