"""Actions that suspend and resume intentions."""

from __future__ import annotations

from ..language.substitution import Unifier, substitute_literal
from ..language.terms import Literal, Term
from ..language.unification import try_unify, unified
from ..reasoning.calls import WAITING, Call
from ..reasoning.circumstance import Circumstance
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
    u, states = dict(call.unifier), circumstance.states
    for action in list(circumstance.pending_actions.values()):
        if action.intention.wants(wanted, u):
            action.intention.is_suspended = True
            circumstance.suspend("suspended", action.intention, reason)
    for _, intention in list(circumstance.pending.values()):
        if intention.wants(wanted, u):
            intention.is_suspended = True
            if states is not None:
                states.note("suspended", "+!", substitute_literal(wanted, u), reason)
    running = [circumstance.atomic, *circumstance.running]
    for candidate in running:
        if candidate is not None and candidate.wants(wanted, u):
            candidate.is_suspended = True
            circumstance.remove_running(candidate)
            circumstance.suspend("suspended", candidate, reason)
    current = call.intention
    suspends_itself = current is not None and current.wants(wanted, u)
    if current is not None and suspends_itself:
        current.is_suspended = True
        circumstance.suspend("suspended-self", current, reason)
    _suspend_events(circumstance, wanted, u, reason)
    return WAITING if suspends_itself else u


def _suspend_events(
    circumstance: Circumstance, wanted: Literal, u: Unifier, reason: Literal
) -> None:
    """Put off the events of a goal, and those for which an intention waits that has it."""
    states = circumstance.states
    for event in circumstance.all_events():
        intention = event.intention
        by_stack = intention is not None and intention.wants(wanted, u)
        if by_stack or _is_goal(event, wanted, u):
            if event is circumstance.atomic_event:
                circumstance.atomic_event = None
            else:
                circumstance.events.remove(event)
            circumstance.suspended_events.append(event)
            if states is not None and event.sort in ("+!", "+?"):
                states.note("suspended", event.sort, event.literal, reason)
            if intention is not None:
                intention.is_suspended = True
                intention.reason = reason


def _is_goal(event: Event, wanted: Literal, u: Unifier) -> bool:
    return event.sort == "+!" and try_unify(wanted, event.literal, u)


@STANDARD.add(".resume", least=1, most=1)
def resume(call: Call, goal: Term) -> object:
    """`.resume(G)`: let go on what is suspended and has a goal."""
    wanted = a_literal("resume", goal)
    circumstance = call.agent.circumstance
    u, states, reason = dict(call.unifier), circumstance.states, Literal("resume_ia")
    for kind, intention in list(circumstance.pending.values()):
        if not intention.is_suspended or not intention.wants(wanted, u):
            continue
        intention.is_suspended = False
        if states is not None:
            states.note_top("resumed", intention, reason)
        if kind == "suspended-self" and intention.top.step is not None:
            intention.top.step = intention.top.step.next
        if kind.startswith("suspended"):
            circumstance.unpend(intention)
            if intention.number not in circumstance.pending_actions:
                circumstance.resume(intention)
        elif states is not None:
            states.note_top("waiting", intention, intention.reason)
    for event in list(circumstance.suspended_events):
        stacked = event.intention
        if _is_goal(event, wanted, u) or (stacked is not None and stacked.wants(wanted, u)):
            circumstance.suspended_events.remove(event)
            if stacked is not None:
                stacked.is_suspended = False
            if states is not None and stacked is not None:
                states.note_top("resumed", stacked, reason)
            elif states is not None and event.sort in ("+!", "+?"):
                states.note("resumed", event.sort, event.literal, reason)
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
