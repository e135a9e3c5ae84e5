"""From events to intentions: the plan that is adopted, and the way on when it is done."""

from __future__ import annotations

from ..errors import TooDeepError
from ..language.substitution import Unifier, rename, substitute, substitute_literal
from .actions import error_annots
from .failure import clear_failed, fail_event
from .intentions import Event, Intention, Means
from .plans import LoadedPlan
from .state import AgentState


def deliberate(agent: AgentState) -> None:
    """Take events until one is dealt with; those of beliefs without a plan are discarded."""
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
            # No plan for a change of belief: the plan that made it continues.
            move_on(agent, event.intention, event.intention.top)
            return


def _no_plan(agent: AgentState, event: Event, what: str) -> None:
    message = f"Found a goal for which there is no {what} plan: {event}"
    fail_event(agent, event, error_annots(f"no_{what}", message), message)


def adopt(agent: AgentState, plan: LoadedPlan, event: Event, u: Unifier) -> None:
    """Put a plan on the intention that waits for the event, or on a new one."""
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


def _forget_tail_call(agent: AgentState, intention: Intention, means: Means) -> None:
    """Take the calling plan off if its last step was this goal and it has the same functor.

    Loops by recursion then need no memory. The values that the plan below awaits are handed on.
    """
    top = intention.top
    if not (
        top.sort in ("+!", "+?")
        and means.sort in ("+!", "+?")
        and top.step is not None
        and top.step.next is None
        and top.literal.key == means.literal.key
    ):
        return
    intention.pop()
    if intention.stack:
        _hand_over(agent, intention.top.awaited, top.u, means.u)


def move_on(agent: AgentState, intention: Intention, means: Means) -> None:
    """Finish the current step: the intention goes to the end of the queue."""
    if means.step is not None:
        means.step = means.step.next
    if intention.atomic:
        # Put back before `clear`: it has the next cycle to itself even if its atomic plan is done.
        agent.circumstance.add_running(intention)
        if means.step is None:
            clear(agent, intention)
        return
    if means.step is None:
        clear(agent, intention)
    if intention.stack:
        agent.circumstance.add_running(intention)


def clear(agent: AgentState, intention: Intention) -> None:
    """Take finished plans off an intention, and go on with those that called them."""
    stack = intention.stack
    while stack and stack[-1].step is None:
        top = intention.pop()
        if top.sort in ("-!", "-?") and stack:
            clear_failed(intention, top.literal)
        if not stack:
            break
        means = stack[-1]
        if means.step is not None:
            _hand_over(agent, means.awaited, top.u, means.u)
            means.step = means.step.next
    if not stack:
        agent.circumstance.remove_running(intention)
        agent.circumstance.forget(intention)


def _hand_over(agent: AgentState, awaited: tuple[str, ...], u: Unifier, to: Unifier) -> None:
    """Bind in `to` the variables awaited by a plan to the values that they have in `u`."""
    for name in awaited:
        value = u.get(name)
        if value is not None:
            to[name] = rename(substitute(value, u), agent.names, {})
