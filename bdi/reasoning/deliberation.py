"""From events to intentions: the plan that is adopted, and the way on when it is done."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeAlias

from ..errors import TooDeepError
from ..language.body import Act
from ..language.program import Plan, Trigger
from ..language.substitution import Unifier, rename, substitute, substitute_literal
from ..language.terms import TRUE, Literal
from ..language.unification import unified
from .actions import error_annots
from .failure import clear_failed, fail_event
from .intentions import Event, Intention, Means
from .plans import LoadedPlan, PlanLibrary, compiled
from .state import AgentState


def deliberate(agent: AgentState) -> None:
    """Take events until one is dealt with; those of beliefs without a plan are discarded."""
    circumstance = agent.circumstance
    # The selection functions are Jason's usual ones: the oldest event, and of its applicable plans
    # the first in the program, with the first answer of its context (R. H. Bordini, J. F. Hübner
    # and M. Wooldridge, "Programming Multi-Agent Systems in AgentSpeak using Jason", 2007, 4.1).
    # What an atomic intention waits for comes before all else: nothing else runs meanwhile.
    while True:
        event = circumstance.atomic_event
        if event is not None:
            circumstance.atomic_event = None
        elif circumstance.events:
            event = circumstance.events.popleft()
        else:
            return
        circumstance.selected_event = event
        if agent.plans.has_inner:
            if agent.plans.has_inner_updates:
                _share(agent, event)
            found, is_relevant = _option_inside(agent, event)
            if found is not None:
                adopt(agent, found[0], event, found[1])
                return
        else:
            literal = event.literal
            candidates = agent.plans.candidates(event.sort, literal)
            for plan in candidates:
                u = plan.match(literal)
                if u is not None and plan.applies is not None:
                    u = plan.applies(agent.logic, u)
                if u is not None:
                    adopt(agent, plan, event, u)
                    return
            is_relevant = bool(candidates)
        if event.is_goal:
            _no_plan(agent, event, "applicable" if is_relevant else "relevant")
            return
        if event.intention is not None:
            # No plan for a change of belief: the plan that made it continues.
            move_on(agent, event.intention, event.intention.top)
            return


_Option: TypeAlias = "tuple[LoadedPlan, Unifier]"


def _option_inside(agent: AgentState, event: Event) -> tuple[_Option | None, bool]:
    """Return the plan for an event, from the innermost library on; True if one was relevant.

    The plans inside the plan that raised the event come first, then those beside that plan.
    """
    if event.option is not None:
        return event.option, True
    intention = event.intention
    libraries = [agent.plans]
    if intention is not None and intention.stack:
        plan = intention.top.plan
        library = plan.scope if plan.inner is None else plan.inner
        libraries = [*_outwards(library), agent.plans]
    is_relevant = False
    for library in libraries:
        for plan in library.candidates(event.sort, event.literal):
            is_relevant = True
            u = _begin(plan, event.literal, intention)
            if u is not None and plan.applies is not None:
                u = plan.applies(agent.logic, u)
            if u is not None:
                return (plan, u), True
    return None, is_relevant


def _outwards(library: PlanLibrary | None) -> Iterator[PlanLibrary]:
    """Yield the library of a plan, and those around it."""
    while library is not None:
        yield library
        library = library.outer


def _begin(plan: LoadedPlan, literal: Literal, intention: Intention | None) -> Unifier | None:
    """Return the bindings of a plan for an event: with those of the plan that it is inside of."""
    if intention is not None and plan.scope is not None:
        for means in intention.downwards():
            if means.plan.inner is plan.scope:
                return unified(plan.literal, literal, means.first)
    return plan.match(literal)


def _share(agent: AgentState, event: Event) -> None:
    """Have each intention deal with a change of belief for which its plans have plans inside.

    The intention goes on; a copy of it carries the plan out, and ends with it.
    """
    circumstance = agent.circumstance
    if event.intention is not None or len(event.sort) != 1 or event.option is not None:
        return
    for intention in list(circumstance.intentions()):
        option = _inside(agent, event, intention)
        if option is None or intention.outer is not None:
            continue
        copy = intention.copy(agent.next_intention_number())
        copy.outer = intention
        ending = compiled(_ENDING).body
        loaded = LoadedPlan(_ENDING, Literal("ending"))
        copy.push(Means(loaded, event.sort, event.literal, {}, ending))
        shared = Event(event.sort, event.literal, copy)
        shared.option = option
        circumstance.post(shared)


def _inside(agent: AgentState, event: Event, intention: Intention) -> _Option | None:
    for means in intention.downwards():
        if means.plan.inner is None:
            continue
        for plan in means.plan.inner.candidates(event.sort, event.literal):
            u = unified(plan.literal, event.literal, means.u)
            if u is not None and plan.applies is not None:
                u = plan.applies(agent.logic, u)
            if u is not None:
                return plan, u
    return None


_ENDING = Plan(
    None,
    Trigger("+", "", Literal("event")),
    TRUE,
    # The first step is the one that waits for the event.
    (Act(Literal(".perceive")), Act(Literal(".drop_intention"))),
)


def _no_plan(agent: AgentState, event: Event, what: str) -> None:
    message = f"Found a goal for which there is no {what} plan: {event}"
    fail_event(agent, event, error_annots(f"no_{what}", message), message)


def adopt(agent: AgentState, plan: LoadedPlan, event: Event, u: Unifier) -> None:
    """Put a plan on the intention that waits for the event, or on a new one."""
    literal = event.literal if event.literal.ground else substitute_literal(event.literal, u)
    means = Means(plan, event.sort, literal, u, plan.body)
    circumstance = agent.circumstance
    if plan.until is not None:
        circumstance.has_conditions = True
    if circumstance.states is not None and event.sort == "+!":
        circumstance.states.note("executing", event.sort, literal)
    intention = event.intention
    if intention is None:
        intention = Intention(agent.next_intention_number())
    elif intention.stack:
        top = intention.stack[-1]
        # The calling plan has nothing left to do: it need not wait for the one it calls.
        if top.step is not None and top.step.next is None and top.literal.key == literal.key:
            _forget_tail_call(agent, intention, means)
        if len(intention.stack) >= agent.max_depth:
            raise TooDeepError(f"{plan.plan.trigger} calls itself too deeply")
    intention.stack.append(means)
    if plan.atomic:
        intention.atomic += 1
    circumstance.add_running(intention)
    if agent.is_observed:
        agent.note("plan", event, intention)


def _forget_tail_call(agent: AgentState, intention: Intention, means: Means) -> None:
    """Take the calling plan off, whose last step this goal was, if it was for one of its functor.

    Loops by recursion then need no memory. The values that the plan below awaits are handed on.
    """
    top = intention.top
    if top.sort not in ("+!", "+?") or means.sort not in ("+!", "+?"):
        return
    intention.pop()
    states = agent.circumstance.states
    if states is not None:
        states.note("achieved", top.sort, top.literal)
        states.note("finished", top.sort, top.literal)
    if intention.stack:
        _hand_over(agent, intention.top.awaited, top.u, means.u)


def move_on(agent: AgentState, intention: Intention, means: Means) -> None:
    """Finish the current step: the intention goes to the end of the queue."""
    step = means.step
    if step is not None:
        means.step = step = step.next
    if intention.atomic:
        # Put back before `clear`: it has the next cycle to itself even if its atomic plan is done.
        agent.circumstance.add_running(intention)
        if step is None:
            clear(agent, intention)
        return
    if step is None and not clear(agent, intention):
        return
    if intention.stack:
        agent.circumstance.add_running(intention)


def clear(agent: AgentState, intention: Intention) -> bool:
    """Take finished plans off an intention, and go on with those that called them.

    Return False if it waits until the condition of a finished plan holds.
    """
    stack = intention.stack
    circumstance = agent.circumstance
    states = circumstance.states
    while stack:
        top = stack[-1]
        if top.step is not None:
            return True
        plan = top.plan
        if plan.until is not None:
            circumstance.remove_running(intention)
            reason = Literal("wait_goal_condition")
            circumstance.suspend("wait_goal_condition", intention, reason)
            return False
        stack.pop()
        if plan.atomic:
            intention.atomic -= 1
        if states is not None and top.is_goal:
            states.note("achieved", top.sort, top.literal)
            states.note("finished", top.sort, top.literal)
        # A failure plan is done: what it replaced is still on the stack, below it.
        if top.sort in ("-!", "-?") and stack:
            clear_failed(intention, top.literal)
        if not stack:
            break
        means = stack[-1]
        if means.step is not None:
            if means.awaited:
                _hand_over(agent, means.awaited, top.u, means.u)
            means.step = means.step.next
    circumstance.remove_running(intention)
    circumstance.forget(intention)
    return True


def _hand_over(agent: AgentState, awaited: tuple[str, ...], u: Unifier, to: Unifier) -> None:
    """Bind in `to` the variables awaited by a plan to the values that they have in `u`."""
    for name in awaited:
        value = u.get(name)
        if value is not None:
            # What is open in it gets fresh names: those of the called plan may be the caller's too.
            to[name] = rename(substitute(value, u), agent.names, {})
