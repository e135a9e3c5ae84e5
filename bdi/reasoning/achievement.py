"""Goals taken off the intentions before their plans are done: achieved, or failed.

That is what `.succeed_goal` and `.fail_goal` do, a goal condition (`<:`) that holds, and a
deadline.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from ..language.order import with_more_annots
from ..language.substitution import Unifier, substitute, substitute_literal
from ..language.terms import Literal, Term
from .deliberation import clear
from .failure import end, find_failure_event
from .intentions import Event, Goals, Intention, Means
from .state import MILLISECOND, AgentState

_RUNS_ON, _FAILS, _IS_OVER = 1, 2, 3
_Take: TypeAlias = Callable[[Intention, Goals, Unifier], int]


class Finish:
    """Finishing of goals: `take` takes them off an intention, in whatever state it is.

    Args:
        agent: state of the agent.
        goals: the goals.
        caller: the intention that finishes them, if one does: it is being carried out.
        failed: True if they count as failed and not as achieved.
        annots: further annotations of the events of failure.
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
        """Finish the goals in all intentions and events; return False if the caller is over."""
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
        """Take the goals off one intention; return 0 if it has none of them."""
        return self._fail(intention, dict(u)) if self._failed else self._achieve(intention, dict(u))

    def _achieve(self, intention: Intention, u: Unifier) -> int:
        dropped = intention.drop_goal(self._goals, u)
        if dropped is None:
            return 0
        self._note(dropped.literal, "achieved", "finished")
        if intention.is_finished:
            clear(self._agent, intention)
            return _IS_OVER
        # The step that called the goal is done; the caller's own is moved on after this action.
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
            # Spelt as Jason spells it.
            self._agent.circumstance.resume(intention, Literal("suceed_internal_action"))

    def _finish_event(self, event: Event) -> None:
        """Finish a goal that no plan has been chosen for yet."""
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
    """Finish the goals of plans whose condition (`+!g <: condition`) holds."""
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
    """Have a goal fail if it is not achieved in time (`!g[hard_deadline(100)]`)."""
    intention, goal = event.intention, event.literal
    height = 0 if intention is None else len(intention.stack)
    reached: tuple[Term, ...] = (
        Literal("error", (Literal("deadline_reached"),)),
        Literal("error_msg", ("",)),
    )

    def check() -> None:
        if intention is None:
            circumstance = agent.circumstance
            # `!!g` has an intention of its own, unknown here: any that pursues such a goal counts.
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
