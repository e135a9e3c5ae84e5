"""Actions that suspend and resume intentions."""

from __future__ import annotations

from ..language.substitution import Unifier
from ..language.terms import Literal, Term
from ..language.unification import try_unify, unified
from ..reasoning.calls import WAITING, Call
from ..reasoning.intentions import Event
from .arguments import a_literal
from .registry import STANDARD


@STANDARD.add(".suspend", most=1)
def suspend(call: Call, *goal: Term) -> object:
    """`.suspend(G?)`: suspend what has a goal, or the intention that calls."""
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
        if intention.wants(wanted, u) and not intention.is_suspended:
            intention.is_suspended = True
            if circumstance.states is not None:
                circumstance.states.note_top("suspended", intention, reason)
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
    return event.sort == "+!" and try_unify(wanted, event.literal, u)


@STANDARD.add(".resume", least=1, most=1)
def resume(call: Call, goal: Term) -> object:
    """`.resume(G)`: let go on what is suspended and has a goal."""
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
        elif circumstance.states is not None:
            circumstance.states.note_top("resumed", intention, intention.reason)
    for event in list(circumstance.suspended_events):
        stacked = event.intention
        if _is_goal(event, wanted, u) or (stacked is not None and stacked.wants(wanted, u)):
            circumstance.suspended_events.remove(event)
            if stacked is not None:
                stacked.is_suspended = False
            circumstance.post(event)
    return u


@STANDARD.add(".suspended", least=1, most=2)
def suspended(call: Call, goal: Term, *reason: Term) -> object:
    """`.suspended(G, R?)`: hold if an intention that has a goal is suspended or waits; R is why."""
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
