"""Actions that look for, drop or finish the agent's own goals and intentions."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TypeAlias

from ..language.body import BodyTerm
from ..language.substitution import Unifier, substitute, substitute_literal
from ..language.terms import Literal, Term, TriggerTerm, make_list, plain_text, text
from ..language.unification import unified
from ..reasoning.actions import ActionError, InternalAction
from ..reasoning.calls import WAITING, Call
from ..reasoning.deliberation import clear
from ..reasoning.failure import end, find_failure_event
from ..reasoning.intentions import Event, Intention
from .arguments import a_goal, a_literal


def drop_all_desires(call: Call) -> bool:
    call.agent.circumstance.clear_intentions()
    call.agent.circumstance.clear_events(only_goals=True)
    return True


def drop_all_intentions(call: Call) -> bool:
    call.agent.circumstance.clear_intentions()
    return True


def drop_all_events(call: Call) -> bool:
    call.agent.circumstance.clear_events()
    return True


def drop_event(call: Call, goal: Term) -> bool:
    call.agent.circumstance.remove_goals(a_literal("drop_event", goal), call.unifier)
    return True


def drop_desire(call: Call, goal: Term) -> object:
    drop_event(call, goal)
    return drop_intention(call, goal)


def drop_intention(call: Call, *goal: Term) -> object:
    """End the intentions that have a goal, or the one that calls.

    One that ends itself carries out no further step: it is not put back among those that run.
    """
    agent = call.agent
    itself = not goal
    if goal:
        wanted = a_goal("drop_intention", goal[0])
        for intention in list(agent.circumstance.intentions()):
            if isinstance(wanted, Literal) and intention.wants(wanted, dict(call.unifier)):
                itself = itself or intention is call.intention
                agent.circumstance.drop(intention)
    if not itself:
        return True
    if call.intention is not None:
        agent.circumstance.forget(call.intention)
    return WAITING


def _intended(
    call: Call, goal: Literal, identity: tuple[Term, ...], *, suspended: bool
) -> Iterator[Unifier]:
    for intention in call.agent.circumstance.intentions():
        if intention.is_suspended and not suspended:
            continue
        for means in intention.downwards():
            if means.sort == "+!":
                solution = unified(goal, means.literal, call.unifier)
                if solution is not None and identity:
                    solution = unified(identity[0], float(intention.number), solution)
                if solution is not None:
                    yield solution


def intend(call: Call, goal: Term, *identity: Term) -> Iterator[Unifier]:
    return _intended(call, _pattern("intend", goal), identity, suspended=False)


def desire(call: Call, goal: Term, *identity: Term) -> Iterator[Unifier]:
    """Yield the goals that are intended, or whose event is to be dealt with."""
    pattern = _pattern("desire", goal)
    circumstance = call.agent.circumstance
    for event in (circumstance.selected_event, *circumstance.all_events()):
        if event is not None:
            solution = dict(call.unifier)
            if event.is_for(pattern, solution):
                yield solution
    yield from _intended(call, pattern, identity, suspended=True)


def _pattern(name: str, goal: Term) -> Literal:
    wanted = a_goal(name, goal)
    if isinstance(wanted, Literal):
        return wanted
    raise ActionError(f"{name}: which goal? {text(goal)} has no value", "wrong_arguments")


def fail(call: Call, *annots: Term) -> bool:
    """Fail the plan; the arguments annotate its `-!g` event."""
    if not annots:
        return False
    message = "fail"
    others: list[Term] = []
    for annot in annots:
        if isinstance(annot, Literal) and annot.functor == "error_msg" and annot.args:
            message = plain_text(annot.args[0])
        else:
            others.append(annot)
    raise ActionError(message, annots=tuple(others))


# ---- goals declared achieved or failed

_RUNS_ON, _FAILS, _IS_OVER = 1, 2, 3
_Take: TypeAlias = Callable[[Call, Intention, Literal, Unifier], int]


def _achieve(call: Call, intention: Intention, goal: Literal, u: Unifier) -> int:
    """Take a goal off an intention as if it had been achieved; return 0 if it was not there."""
    if intention.drop_goal(goal, u) is None:
        return 0
    if intention.is_finished:
        clear(call.agent, intention)
        return _IS_OVER
    if intention is not call.intention and intention.top.step is not None:
        intention.top.step = intention.top.step.next
    clear(call.agent, intention)
    return _RUNS_ON


def _fail(call: Call, intention: Intention, goal: Literal, u: Unifier) -> int:
    """Take a goal off an intention as if it had failed; return 0 if it was not there."""
    agent = call.agent
    if intention.drop_goal(goal, u) is None:
        return 0
    wanted = substitute(goal, u)
    failed = Event("+!", wanted if isinstance(wanted, Literal) else goal, intention)
    event = find_failure_event(agent, intention, failed)
    if event is None:
        end(agent, intention)
        return _IS_OVER
    event.literal = substitute_literal(event.literal, u)
    agent.circumstance.post(event)
    return _FAILS


def succeed_goal(call: Call, goal: Term) -> object:
    return _finish(call, a_literal("succeed_goal", goal), _achieve)


def fail_goal(call: Call, goal: Term) -> object:
    return _finish(call, a_literal("fail_goal", goal), _fail)


def _finish(call: Call, goal: Literal, take: _Take) -> object:
    """Take a goal off all intentions, in whatever state they are, and off the events."""
    circumstance = call.agent.circumstance

    def taken(intention: Intention) -> int:
        return take(call, intention, goal, dict(call.unifier))

    for event in [*circumstance.all_events(), *circumstance.suspended_events]:
        done = 0 if event.intention is None else taken(event.intention)
        if done:
            circumstance.remove_event(event)
            _run_on(call, event.intention, done)
        elif event.is_for(goal, dict(call.unifier)):
            _finish_event(call, event, take)
    for running in [circumstance.atomic, *circumstance.running]:
        if running is not None and taken(running) > _RUNS_ON:
            circumstance.remove_running(running)
    outcome = 0 if call.intention is None else taken(call.intention)
    for action in list(circumstance.pending_actions.values()):
        done = taken(action.intention)
        if done:
            circumstance.take_action(action.intention)
            _run_on(call, action.intention, done)
    for kind, intention in list(circumstance.pending.values()):
        done = taken(intention)
        if done:
            circumstance.take_pending(intention, kind)
            _run_on(call, intention, done)
    return WAITING if outcome > _RUNS_ON else True


def _run_on(call: Call, intention: Intention | None, done: int) -> None:
    if done == _RUNS_ON and intention is not None:
        call.agent.circumstance.add_running(intention)


def _finish_event(call: Call, event: Event, take: _Take) -> None:
    """Finish a goal that no plan has been chosen for yet."""
    if take is _fail:
        event.sort = "-!"
        return
    circumstance, intention = call.agent.circumstance, event.intention
    circumstance.remove_event(event)
    if intention is not None and intention.stack:
        if intention.top.step is not None:
            intention.top.step = intention.top.step.next
        clear(call.agent, intention)
        if intention.stack:
            circumstance.add_running(intention)


def current_intention(call: Call, description: Term) -> object:
    """`intention(Id, [im(Label, {Trigger}, {Body left}, Bindings), …])`."""
    intention = call.intention
    selected = call.agent.circumstance.selected_event
    if intention is None and selected is not None:
        intention = selected.intention
    return False if intention is None else call.unify(description, _description(intention))


def _description(intention: Intention) -> Literal:
    stack: list[Term] = []
    for means in intention.downwards():
        left = []
        step = means.step
        while step is not None:
            left.append(step.formula)
            step = step.next
        bindings = make_list(
            Literal("map", (name, substitute(value, means.u))) for name, value in means.u.items()
        )
        trigger = TriggerTerm(means.sort, means.literal)
        stack.append(
            Literal("im", (text(means.plan.label), trigger, BodyTerm(tuple(left)), bindings))
        )
    return Literal("intention", (float(intention.number), make_list(stack)))


ACTIONS: Mapping[str, InternalAction] = {
    ".drop_all_desires": InternalAction(drop_all_desires, 0, 0),
    ".drop_all_intentions": InternalAction(drop_all_intentions, 0, 0),
    ".drop_all_events": InternalAction(drop_all_events, 0, 0),
    ".drop_event": InternalAction(drop_event, 1, 1),
    ".drop_desire": InternalAction(drop_desire, 1, 1),
    ".drop_intention": InternalAction(drop_intention, 0, 1),
    ".intend": InternalAction(intend, 1, 2),
    ".desire": InternalAction(desire, 1, 2),
    ".fail": InternalAction(fail),
    ".succeed_goal": InternalAction(succeed_goal, 1, 1),
    ".fail_goal": InternalAction(fail_goal, 1, 1),
    ".current_intention": InternalAction(current_intention, 1, 1),
    ".intention": InternalAction(current_intention, 1, 1),
}
