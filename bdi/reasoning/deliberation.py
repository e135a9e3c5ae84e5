"""Deliberation: adoption of a plan for an event, and goals that end before their plan.

Goals end early by `.succeed_goal`, `.fail_goal`, a goal condition (`<:`) or a deadline.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeAlias

from ..actions import error_annots
from ..errors import TooDeepError
from ..language.body import Act
from ..language.program import Plan, Trigger
from ..language.substitution import (
    Unifier,
    rename,
    substitute,
    substitute_literal,
    with_more_annots,
)
from ..language.terms import TRUE, Literal, Term
from ..language.unification import unified
from .failure import clear_failed, end, fail_event, find_failure_event
from .intentions import Event, Goals, Intention, Means
from .plans import LoadedPlan, PlanLibrary, compiled
from .state import MILLISECOND, AgentState


def deliberate(agent: AgentState) -> None:
    """Take events until one is handled. Belief events without a plan are discarded."""
    circumstance = agent.circumstance
    # The selection functions are the defaults of Jason: the oldest event, its first applicable
    # plan, and the first solution of the context (R. H. Bordini, J. F. Hübner and M. Wooldridge,
    # "Programming Multi-Agent Systems in AgentSpeak using Jason", 2007, 4.1). The event of an
    # atomic intention comes first, because nothing else runs until it is handled.
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
            option, is_relevant = _option_inside(agent, event)
            if option is not None:
                adopt(agent, option[0], event, option[1])
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
            # Without a plan for its belief event, the plan that raised it continues.
            move_on(agent, event.intention, event.intention.top)
            return


_Option: TypeAlias = tuple[LoadedPlan, Unifier]


def _option_inside(agent: AgentState, event: Event) -> tuple[_Option | None, bool]:
    """Return the plan for an event, and whether any plan is relevant.

    The subplans of the plan that raised the event are searched first, then the outer libraries.
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
    """Yield the library of a plan and its outer libraries."""
    while library is not None:
        yield library
        library = library.outer


def _begin(plan: LoadedPlan, literal: Literal, intention: Intention | None) -> Unifier | None:
    """Return the bindings of a plan for an event. A subplan shares those of its plan."""
    if intention is not None and plan.scope is not None:
        for means in intention.downwards():
            if means.plan.inner is plan.scope:
                return unified(plan.literal, literal, means.first)
    return plan.match(literal)


def _share(agent: AgentState, event: Event) -> None:
    """Post a belief event for each intention that has a subplan for it.

    A copy of the intention carries out the subplan and ends with it.
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
    label=None,
    trigger=Trigger("+", "", Literal("event")),
    context=TRUE,
    # The first step waits for the event.
    body=(Act(Literal(".perceive")), Act(Literal(".drop_intention"))),
)


def _no_plan(agent: AgentState, event: Event, what: str) -> None:
    message = f"Found a goal for which there is no {what} plan: {event}"
    fail_event(agent, event, error_annots(f"no_{what}", message), message)


def adopt(agent: AgentState, plan: LoadedPlan, event: Event, u: Unifier) -> None:
    """Add a plan to the intention that waits for the event, or to a new one."""
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
        # A tail call needs no entry of the calling plan, which has no further steps.
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
    """Remove the calling plan after its last step, so that tail recursion needs no memory.

    The values that the plan below awaits are copied.
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
    """Finish the current step, and queue the intention."""
    step = means.step
    if step is not None:
        means.step = step = step.next
    if intention.atomic:
        # Queued before `clear`, so that the next cycle is atomic even if its atomic plan has ended.
        agent.circumstance.add_running(intention)
        if step is None:
            clear(agent, intention)
        return
    if step is None and not clear(agent, intention):
        return
    if intention.stack:
        agent.circumstance.add_running(intention)


def clear(agent: AgentState, intention: Intention) -> bool:
    """Remove finished plans of an intention, and continue with the plans that called them.

    Return False if the intention waits until the condition of a finished plan holds.
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
        # The plans that a failure plan has replaced are still below it.
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
    """Copy the values of the variables awaited by a plan from `u` to `to`."""
    for name in awaited:
        value = u.get(name)
        if value is not None:
            # Unbound variables are renamed, because the caller may use the same names.
            to[name] = rename(substitute(value, u), agent.names, {})


_RUNS_ON, _FAILS, _IS_OVER = 1, 2, 3


class Finish:
    """End of goals of intentions in any state.

    `caller` is the intention that ends them, if any. If `failed`, the goals count as failed, with
    additional annotations `annots` of the failure events.
    """

    def __init__(
        self,
        agent: AgentState,
        goals: Goals,
        caller: Intention | None,
        *,
        failed: bool = False,
        annots: tuple[Term, ...] = (),
    ) -> None:
        self._agent = agent
        self._goals = goals
        self._caller = caller
        self._failed = failed
        self._annots = annots

    def everywhere(self, u: Unifier) -> bool:
        """End the goals in all intentions and events. Return False if the caller has ended."""
        circumstance = self._agent.circumstance
        for event in [*circumstance.all_events(), *circumstance.suspended_events]:
            done = 0 if event.intention is None else self.take(event.intention, u)
            if done:
                circumstance.remove_event(event)
                self._run_on(event.intention, done)
            elif self._goals.goal is not None and event.is_for(self._goals.goal, dict(u)):
                self._finish_event(event)
        for running in [circumstance.atomic, *circumstance.running]:
            if running is not None and self.take(running, u) > _RUNS_ON:
                circumstance.remove_running(running)
        outcome = 0 if self._caller is None else self.take(self._caller, u)
        for action in list(circumstance.pending_actions.values()):
            done = self.take(action.intention, u)
            if done:
                circumstance.take_action(action.intention)
                self._run_on(action.intention, done)
        for kind, intention in list(circumstance.pending.values()):
            done = self.take(intention, u)
            if done:
                circumstance.take_pending(intention, kind)
                if intention.wait is not None:
                    intention.wait.cancel()
                self._run_on(intention, done)
        return outcome <= _RUNS_ON

    def take(self, intention: Intention, u: Unifier) -> int:
        """Remove the goals from an intention. Return 0 if it has none of them."""
        return self._fail(intention, dict(u)) if self._failed else self._achieve(intention, dict(u))

    def _achieve(self, intention: Intention, u: Unifier) -> int:
        dropped = intention.drop_goal(self._goals, u)
        if dropped is None:
            return 0
        self._note(dropped.literal, "achieved", "finished")
        if intention.is_finished:
            clear(self._agent, intention)
            return _IS_OVER
        # The step that called the goal is finished. The step of the caller ends with this action.
        if intention is not self._caller and intention.top.step is not None:
            intention.top.step = intention.top.step.next
        clear(self._agent, intention)
        return _RUNS_ON

    def _fail(self, intention: Intention, u: Unifier) -> int:
        agent = self._agent
        dropped = intention.drop_goal(self._goals, u)
        if dropped is None:
            return 0
        self._note_failure(dropped.literal)
        goal = self._goals.goal
        wanted = dropped.literal if goal is None else substitute(goal, u)
        failed = Event("+!", wanted if isinstance(wanted, Literal) else dropped.literal, intention)
        event = find_failure_event(agent, intention, failed, has_plan=False)
        if event is None:
            self._note(dropped.literal, "finished")
            end(agent, intention)
            return _IS_OVER
        event.literal = with_more_annots(substitute_literal(event.literal, u), *self._annots)
        agent.circumstance.post(event)
        return _FAILS

    def _note(self, goal: Literal, *states: str) -> None:
        noted = self._agent.circumstance.states
        if noted is not None:
            for state in states:
                noted.note(state, "+!", goal)

    def _note_failure(self, goal: Literal) -> None:
        noted = self._agent.circumstance.states
        if noted is not None:
            noted.note("failed", "+!", goal, Literal("drop_by_fail_goal"))

    def _run_on(self, intention: Intention | None, done: int) -> None:
        if done == _RUNS_ON and intention is not None and intention.stack:
            # The spelling of Jason.
            self._agent.circumstance.resume(intention, Literal("suceed_internal_action"))

    def _finish_event(self, event: Event) -> None:
        """End a goal without a plan yet."""
        if self._failed:
            self._note_failure(event.literal)
            event.sort = "-!"
            if self._annots:
                event.literal = with_more_annots(event.literal, *self._annots)
            return
        circumstance, intention = self._agent.circumstance, event.intention
        circumstance.remove_event(event)
        self._note(event.literal, "achieved", "finished")
        if intention is not None and intention.stack:
            if intention.top.step is not None:
                intention.top.step = intention.top.step.next
            clear(self._agent, intention)
            if intention.stack:
                circumstance.add_running(intention)


# ---- conditions and deadlines of goals


def finish_satisfied(agent: AgentState) -> None:
    """End the goals of plans whose condition (`+!g <: condition`) holds."""
    pending = [
        means
        for intention in agent.circumstance.intentions()
        for means in intention.stack
        if means.plan.until is not None
    ]
    agent.circumstance.has_conditions = bool(pending)
    if not any(_is_satisfied(agent, means) for means in pending):
        return

    def holds(means: Means, u: Unifier) -> bool:
        return means.plan.until is not None and _is_satisfied(agent, means)

    Finish(agent, Goals(holds), None).everywhere({})


def _is_satisfied(agent: AgentState, means: Means) -> bool:
    until = means.plan.until
    return until is not None and until(agent.logic, means.u) is not None


def set_deadline(agent: AgentState, event: Event, milliseconds: float) -> None:
    """Schedule the failure of a goal that is not achieved in time (`!g[hard_deadline(100)]`)."""
    intention, goal = event.intention, event.literal
    height = 0 if intention is None else len(intention.stack)
    reached: tuple[Term, ...] = (
        Literal("error", (Literal("deadline_reached"),)),
        Literal("error_msg", ("",)),
    )

    def check() -> None:
        if intention is None:
            circumstance = agent.circumstance
            # The intention of `!!g` is unknown, so any intention with such a goal counts.
            wanted = any(one.wants(goal, {}) for one in circumstance.intentions()) or any(
                one.is_for(goal, {}) for one in circumstance.all_events()
            )
        else:
            wanted = len(intention.stack) >= height and intention.wants(goal, {})
        if wanted:
            finish = Finish(agent, Goals.of(goal), None, failed=True, annots=reached)
            finish.everywhere({})

    agent.alarms.set(
        agent.clock + int(milliseconds) * MILLISECOND, lambda: agent.tasks.append(check)
    )
