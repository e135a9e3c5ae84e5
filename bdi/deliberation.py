"""From events to intentions: which plan is adopted, and what happens when it is over."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .errors import TooDeepError
from .failure import clear_failed, error_annots, fail_event
from .intentions import Event, Intention, Means
from .plans import LoadedPlan
from .unify import Unifier, rename, substitute, substitute_literal

if TYPE_CHECKING:
    from .agent import Agent


def deliberate(agent: Agent) -> None:
    """Takes events until one is dealt with; those of beliefs without a plan are discarded."""
    circumstance = agent.circumstance
    while True:
        event = circumstance.atomic_event
        if event is not None:
            circumstance.atomic_event = None
        elif circumstance.events:
            event = circumstance.events.popleft()
        else:
            return
        circumstance.selected_event = event
        literal = event.literal
        candidates = agent.plans.candidates(event.sort, literal)
        for plan in candidates:
            u = plan.match(literal)
            if u is not None and plan.applies is not None:
                u = plan.applies(agent.logic, u)
            if u is not None:
                adopt(agent, plan, event, u)
                return
        if event.is_goal:
            _no_plan(agent, event, "applicable" if candidates else "relevant")
            return
        if event.intention is not None:
            # Nobody cares for a change of belief: the plan that made it goes on.
            agent.move_on(event.intention, event.intention.top)
            return


def _no_plan(agent: Agent, event: Event, what: str) -> None:
    message = f"Found a goal for which there is no {what} plan: {event}"
    fail_event(agent, event, error_annots(f"no_{what}", message), message)


def adopt(agent: Agent, plan: LoadedPlan, event: Event, u: Unifier) -> None:
    """Puts a plan on the intention that waits for the event, or on a new one."""
    literal = event.literal if event.literal.ground else substitute_literal(event.literal, u)
    means = Means(plan, event.sort, literal, u, plan.body)
    intention = event.intention
    if intention is None:
        intention = Intention(agent.next_intention_number())
    elif intention.stack:
        _forget_tail_call(agent, intention, means)
        if len(intention.stack) >= agent.max_depth:
            raise TooDeepError(f"{plan.plan.trigger} calls itself too deeply")
    intention.push(means)
    agent.circumstance.add_running(intention)
    agent.note("plan", event, intention)


def _forget_tail_call(agent: Agent, intention: Intention, means: Means) -> None:
    """A goal that ends by calling one of the same functor leaves no trace.

    What it has found out for the plan below it goes along.
    """
    top = intention.top
    if not (
        len(top.sort) == 2
        and top.sort[0] == "+"
        and len(means.sort) == 2
        and means.sort[0] == "+"
        and top.step is not None
        and top.step.next is None
        and top.literal.key == means.literal.key
    ):
        return
    intention.pop()
    if intention.stack:
        for name in intention.top.awaited:
            value = top.u.get(name)
            if value is not None:
                means.u[name] = rename(substitute(value, top.u), agent.names, {})


def clear(agent: Agent, intention: Intention) -> None:
    """Takes finished plans off an intention and goes on with those that called them."""
    stack = intention.stack
    while stack and stack[-1].step is None:
        top = intention.pop()
        if top.sort[0] == "-" and len(top.sort) == 2 and stack:
            clear_failed(intention, top.literal)
        if not stack:
            break
        means = stack[-1]
        if means.step is not None:
            _hand_back(agent, means, top.u)
            means.step = means.step.next
    if not stack:
        agent.circumstance.remove_running(intention)
        agent.circumstance.forget(intention)


def _hand_back(agent: Agent, means: Means, u: Unifier) -> None:
    """What a plan has found out for the variables of the one that called it."""
    for name in means.awaited:
        value = u.get(name)
        if value is not None:
            means.u[name] = rename(substitute(value, u), agent.names, {})
