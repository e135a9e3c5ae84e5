"""Actions on the agent's own goals and intentions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType

from ..circumstance import event_wants
from ..deliberation import clear
from ..failure import ActionError, end, find_failure_event
from ..intentions import Event, Intention
from ..program import BodyTerm, TriggerTerm
from ..steps import WAITING
from ..terms import Literal, Term, make_list, text
from ..unify import Unifier, substitute, substitute_literal, unified
from .call import Call, InternalAction, a_goal, a_literal


def drop_all_desires(call: Call) -> bool:
    drop_all_intentions(call)
    circumstance = call.agent.circumstance
    circumstance.clear_events(only_goals=True)
    circumstance.suspended_events.clear()
    return True


def drop_all_intentions(call: Call) -> bool:
    call.agent.circumstance.clear_intentions()
    return True


def drop_all_events(call: Call) -> bool:
    circumstance = call.agent.circumstance
    circumstance.clear_events()
    circumstance.suspended_events.clear()
    return True


def drop_event(call: Call, goal: Term) -> bool:
    call.agent.circumstance.remove_goals(a_literal("drop_event", goal), call.unifier)
    return True


def drop_desire(call: Call, goal: Term) -> object:
    drop_event(call, goal)
    return drop_intention(call, goal)


def drop_intention(call: Call, *goal: Term) -> object:
    """Ends the intentions that have a goal, or the one that says so.

    One that drops itself does no further step: it is not put back.
    """
    agent = call.agent
    if not goal:
        if call.intention is not None:
            agent.circumstance.forget(call.intention)
        return WAITING
    wanted = a_goal("drop_intention", goal[0])
    itself = False
    for intention in list(agent.circumstance.intentions()):
        if isinstance(wanted, Literal) and intention.wants(wanted, dict(call.unifier)):
            if intention is call.intention:
                itself = True
            agent.circumstance.drop(intention)
    if itself and call.intention is not None:
        agent.circumstance.forget(call.intention)
        return WAITING
    return True


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
    """A goal that is intended, or whose event waits to be dealt with."""
    pattern = _pattern("desire", goal)
    circumstance = call.agent.circumstance
    events = [circumstance.selected_event, *circumstance.all_events()]
    for event in events:
        if event is not None:
            solution = dict(call.unifier)
            if event_wants(event, pattern, solution):
                yield solution
    yield from _intended(call, pattern, identity, suspended=True)


def _pattern(name: str, goal: Term) -> Literal:
    wanted = a_goal(name, goal)
    if isinstance(wanted, Literal):
        return wanted
    raise ActionError(f"{name}: which goal? {text(goal)} has no value", "wrong_arguments")


def suspend(call: Call, *goal: Term) -> object:
    circumstance = call.agent.circumstance
    reason = Literal("suspend_ia")
    if not goal:
        if call.intention is None:
            return False
        call.intention.is_suspended = True
        circumstance.suspend("suspended-self", call.intention, reason)
        return WAITING
    wanted = a_literal("suspend", goal[0])
    u = dict(call.unifier)
    for action in list(circumstance.pending_actions.values()):
        if action.intention.wants(wanted, u):
            action.intention.is_suspended = True
            circumstance.suspend("suspended", action.intention, reason)
    for _, intention in list(circumstance.pending.values()):
        if intention.wants(wanted, u):
            intention.is_suspended = True
    running = [circumstance.atomic, *circumstance.running]
    for candidate in running:
        if candidate is not None and candidate.wants(wanted, u):
            candidate.is_suspended = True
            circumstance.remove_running(candidate)
            circumstance.suspend("suspended", candidate, reason)
    _suspend_events(call, wanted, u)
    current = call.intention
    if current is not None and current.wants(wanted, u):
        current.is_suspended = True
        circumstance.suspend("suspended-self", current, reason)
        return WAITING
    return u


def _suspend_events(call: Call, wanted: Literal, u: Unifier) -> None:
    circumstance = call.agent.circumstance
    for event in circumstance.all_events():
        intention = event.intention
        by_stack = intention is not None and intention.wants(wanted, u)
        if by_stack or _is_goal(event, wanted, u):
            if event is circumstance.atomic_event:
                circumstance.atomic_event = None
            else:
                circumstance.events.remove(event)
            circumstance.suspended_events.append(event)
            if intention is not None:
                intention.is_suspended = True


def _is_goal(event: Event, wanted: Literal, u: Unifier) -> bool:
    solution = unified(wanted, event.literal, u) if event.sort == "+!" else None
    if solution is not None:
        u.update(solution)
    return solution is not None


def resume(call: Call, goal: Term) -> object:
    wanted = a_literal("resume", goal)
    circumstance = call.agent.circumstance
    u = dict(call.unifier)
    for kind, intention in list(circumstance.pending.values()):
        if not intention.is_suspended or not intention.wants(wanted, u):
            continue
        intention.is_suspended = False
        if kind == "suspended-self" and intention.top.step is not None:
            intention.top.step = intention.top.step.next
        if kind.startswith("suspended"):
            circumstance.take_pending(intention, kind)
            if intention.number not in circumstance.pending_actions:
                circumstance.add_running(intention)
    for event in list(circumstance.suspended_events):
        stacked = event.intention
        if _is_goal(event, wanted, u) or (stacked is not None and stacked.wants(wanted, u)):
            circumstance.suspended_events.remove(event)
            if stacked is not None:
                stacked.is_suspended = False
            circumstance.post(event)
    return u


def suspended(call: Call, goal: Term, *reason: Term) -> object:
    wanted = a_literal("suspended", goal)
    circumstance = call.agent.circumstance
    waiting = [
        *((a.intention, Literal("act")) for a in circumstance.pending_actions.values()),
        *((i, i.reason or Literal("no_reason")) for _, i in circumstance.pending.values()),
    ]
    for intention, why in waiting:
        u = dict(call.unifier)
        if intention.wants(wanted, u):
            return unified(reason[0], why, u) if reason else u
    return False


def fail(call: Call, *annots: Term) -> bool:
    """Fails the plan; the arguments annotate its `-!g` event."""
    if not annots:
        return False
    message = "fail"
    others: list[Term] = []
    for annot in annots:
        if isinstance(annot, Literal) and annot.functor == "error_msg" and annot.args:
            said = annot.args[0]
            message = said if isinstance(said, str) else text(said)
        else:
            others.append(annot)
    raise ActionError(message, annots=tuple(others))


# ---- goals that are said to be achieved, or failed

_RUNS_ON, _FAILS, _IS_OVER = 1, 2, 3


def _achieve(call: Call, intention: Intention, goal: Literal, u: Unifier) -> int:
    """Takes a goal off an intention as if it had been achieved; 0 when it was not there."""
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
    """Takes a goal off an intention as if it had failed; 0 when it was not there."""
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
    return _finish(call, a_literal("succeed_goal", goal), succeeded=True)


def fail_goal(call: Call, goal: Term) -> object:
    return _finish(call, a_literal("fail_goal", goal), succeeded=False)


def _finish(call: Call, goal: Literal, *, succeeded: bool) -> object:
    circumstance = call.agent.circumstance
    take = _achieve if succeeded else _fail
    _finish_events(call, goal, succeeded)
    for running in [circumstance.atomic, *circumstance.running]:
        if running is not None and take(call, running, goal, dict(call.unifier)) > _RUNS_ON:
            circumstance.remove_running(running)
    outcome = 0
    current = call.intention
    if current is not None:
        outcome = take(call, current, goal, dict(call.unifier))
    for action in list(circumstance.pending_actions.values()):
        done = take(call, action.intention, goal, dict(call.unifier))
        if done:
            circumstance.take_action(action.intention)
            if done == _RUNS_ON:
                circumstance.add_running(action.intention)
    for kind, intention in list(circumstance.pending.values()):
        done = take(call, intention, goal, dict(call.unifier))
        if done:
            circumstance.take_pending(intention, kind)
            if done == _RUNS_ON:
                circumstance.add_running(intention)
    if outcome > _RUNS_ON:
        return WAITING
    return True


def _finish_events(call: Call, goal: Literal, succeeded: bool) -> None:
    circumstance = call.agent.circumstance
    take = _achieve if succeeded else _fail
    for event in [*circumstance.all_events(), *circumstance.suspended_events]:
        intention = event.intention
        kept_apart = event in circumstance.suspended_events
        done = 0
        if intention is not None:
            done = take(call, intention, goal, dict(call.unifier))
        if done:
            _take_event(call, event, kept_apart)
            if done == _RUNS_ON and intention is not None:
                circumstance.add_running(intention)
        elif event_wants(event, goal, dict(call.unifier)):
            if not succeeded:
                event.sort = "-!"
                continue
            _take_event(call, event, kept_apart)
            if intention is not None and intention.stack:
                if intention.top.step is not None:
                    intention.top.step = intention.top.step.next
                clear(call.agent, intention)
                if intention.stack:
                    circumstance.add_running(intention)


def _take_event(call: Call, event: Event, kept_apart: bool) -> None:
    circumstance = call.agent.circumstance
    if kept_apart:
        circumstance.remove_suspended_event(event)
    else:
        circumstance.remove_event(event)


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


ACTIONS: Mapping[str, InternalAction] = MappingProxyType(
    {
        ".drop_all_desires": InternalAction(drop_all_desires, 0, 0),
        ".drop_all_intentions": InternalAction(drop_all_intentions, 0, 0),
        ".drop_all_events": InternalAction(drop_all_events, 0, 0),
        ".drop_event": InternalAction(drop_event, 1, 1),
        ".drop_desire": InternalAction(drop_desire, 1, 1),
        ".drop_intention": InternalAction(drop_intention, 0, 1),
        ".intend": InternalAction(intend, 1, 2),
        ".desire": InternalAction(desire, 1, 2),
        ".suspend": InternalAction(suspend, 0, 1),
        ".resume": InternalAction(resume, 1, 1),
        ".suspended": InternalAction(suspended, 1, 2),
        ".fail": InternalAction(fail),
        ".succeed_goal": InternalAction(succeed_goal, 1, 1),
        ".fail_goal": InternalAction(fail_goal, 1, 1),
        ".current_intention": InternalAction(current_intention, 1, 1),
        ".intention": InternalAction(current_intention, 1, 1),
    }
)
