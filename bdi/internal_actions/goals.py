"""Internal actions on goals and intentions: ending, suspending, control structures."""

from __future__ import annotations

from collections.abc import Iterator

from ..actions import ActionError
from ..language.body import Achieve, Act, Body, BodyFormula, BodyTerm, For, ForkJoin, If, While
from ..language.operations import TriggerTerm
from ..language.substitution import (
    Unifier,
    rename,
    substitute,
    substitute_literal,
    with_more_annots,
)
from ..language.terms import Literal, Term, Var, make_list, plain_text, text
from ..language.unification import try_unify, unified
from ..reasoning.circumstance import Circumstance
from ..reasoning.deliberation import Finish
from ..reasoning.execution import OPERATIONS, WAITING, Call, Waiting
from ..reasoning.intentions import Event, Goals, Intention, Means
from ..reasoning.plans import compile_body
from .registry import STANDARD, a_goal, a_literal, wrong


@STANDARD.add(".drop_all_desires", most=0)
def drop_all_desires(call: Call) -> bool:
    """Drop all intentions but the calling one, and the events of goals."""
    call.agent.circumstance.clear_intentions()
    call.agent.circumstance.clear_events(only_goals=True)
    return True


@STANDARD.add(".drop_all_intentions", most=0)
def drop_all_intentions(call: Call) -> bool:
    """Drop all intentions but the calling one."""
    call.agent.circumstance.clear_intentions()
    return True


@STANDARD.add(".drop_all_events", most=0)
def drop_all_events(call: Call) -> bool:
    """Drop all events."""
    call.agent.circumstance.clear_events()
    return True


@STANDARD.add(".drop_event", least=1, most=1)
def drop_event(call: Call, goal: Term) -> bool:
    """Drop the events of a goal."""
    call.agent.circumstance.remove_goals(a_literal("drop_event", goal), call.unifier)
    return True


@STANDARD.add(".drop_desire", least=1, most=1)
def drop_desire(call: Call, goal: Term) -> object:
    """Drop a goal: its events and its intentions."""
    drop_event(call, goal)
    return drop_intention(call, goal)


@STANDARD.add(".drop_intention", most=1)
def drop_intention(call: Call, *goal: Term) -> object:
    """End the intentions with a goal, or the calling one, which carries out no further step."""
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


@STANDARD.add(".drop_future_intention", least=1, most=1)
def drop_future_intention(call: Call, goal: Term) -> object:
    """End the intentions whose plan has a step `!g` or `!!g`."""
    wanted = a_literal("drop_future_intention", goal)
    agent, itself = call.agent, False
    for intention in list(agent.circumstance.intentions()):
        steps = intention.top.plan.plan.body
        goals = [step.goal for step in steps if isinstance(step, Achieve)]
        if any(call.unify(step, wanted) is not None for step in goals):
            itself = itself or intention is call.intention
            agent.circumstance.drop(intention)
    if itself and call.intention is not None:
        agent.circumstance.forget(call.intention)
        return WAITING
    return True


def _intended(
    call: Call, goal: Literal | Var, identity: tuple[Term, ...], *, suspended: bool
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


@STANDARD.add(".intend", least=1, most=2)
def intend(call: Call, goal: Term, *identity: Term) -> Iterator[Unifier]:
    """Yield the goals of intentions that are not suspended."""
    return _intended(call, a_goal("intend", goal), identity, suspended=False)


@STANDARD.add(".desire", least=1, most=2)
def desire(call: Call, goal: Term, *identity: Term) -> Iterator[Unifier]:
    """Yield the goals of intentions and of queued events."""
    pattern = a_goal("desire", goal)
    circumstance = call.agent.circumstance
    events = (*circumstance.all_events(), *circumstance.suspended_events)
    for event in (circumstance.selected_event, *events):
        solution: Unifier | None = dict(call.unifier)
        if event is None or solution is None or not event.is_for(pattern, solution):
            continue
        if identity and event.intention is not None:
            solution = unified(identity[0], float(event.intention.number), solution)
        if solution is not None:
            yield solution
    yield from _intended(call, pattern, identity, suspended=True)


@STANDARD.add(".fail")
def fail(call: Call, *annots: Term) -> bool:
    """Fail the plan. The arguments annotate its `-!g` event."""
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


@STANDARD.add(".succeed_goal", least=1, most=1)
def succeed_goal(call: Call, goal: Term) -> object:
    """Finish a goal as if it were achieved."""
    return _finish(call, a_literal("succeed_goal", goal), failed=False)


@STANDARD.add(".fail_goal", least=1, most=1)
def fail_goal(call: Call, goal: Term) -> object:
    """Finish a goal as if its plan had failed."""
    return _finish(call, a_literal("fail_goal", goal), failed=True)


def _finish(call: Call, goal: Literal, *, failed: bool) -> object:
    """End a goal of intentions in any state, and of events."""
    finish = Finish(call.agent, Goals.of(goal), call.intention, failed=failed)
    return True if finish.everywhere(call.unifier) else WAITING


@STANDARD.add(".done", most=1)
def done(call: Call, *goal: Term) -> object:
    """`.done` or `.done(g)`: achieve a goal of this intention, by default the nearest."""
    intention = call.intention
    if intention is None:
        return False
    itself = intention.outer or intention
    if goal:
        wanted = Goals.of(a_literal("done", goal[0]))
    else:
        top = itself.top
        wanted = Goals(lambda means, u: means is top)
    finish = Finish(call.agent, wanted, intention)
    outcome = finish.take(intention, call.unifier)
    if intention.outer is not None:
        return _done_for(call, intention.outer, wanted)
    return WAITING if outcome > 1 else True


def _done_for(call: Call, whole: Intention, goals: Goals) -> object:
    """Achieve a goal of the intention for which a subplan works, and end that subplan."""
    circumstance = call.agent.circumstance
    outcome = Finish(call.agent, goals, None).take(whole, call.unifier)
    if outcome:
        circumstance.remove_running(whole)
        circumstance.unpend(whole)
        if outcome == 1 and whole.stack:
            circumstance.add_running(whole)
    if call.intention is not None:
        call.intention.stack.clear()
        circumstance.forget(call.intention)
    return WAITING


def _current(call: Call) -> Intention | None:
    """Return the running intention, or the one whose event is being handled."""
    circumstance = call.agent.circumstance
    event = circumstance.selected_event
    selected = call.intention or circumstance.selected
    return event.intention if selected is None and event is not None else selected


@STANDARD.add(".current_intention", least=1, most=1)
def current_intention(call: Call, description: Term) -> object:
    """`intention(Id, [im(Label, {Trigger}, {Body left}, Bindings), …])`."""
    intention = _current(call)
    return False if intention is None else call.unify(description, _described(call, intention))


def intention(call: Call, number: Term, state: Term, *more: Term) -> Iterator[Unifier]:
    """`.intention(Number, State, Stack?, current?)`, for each intention or the calling one."""
    circumstance = call.agent.circumstance
    current = _current(call)
    only_current = len(more) > 1 and text(more[1]) == "current"
    for one in list(circumstance.intentions()):
        if only_current and one is not current:
            continue
        # Variables of the plans are renamed, because the caller may use the same names.
        description = rename(_state(circumstance, one, only_current), call.agent.names, {})
        terms: list[Term] = [float(one.number), description]
        if more:
            terms.append(_described(call, one).args[1])
        solution = call.unify(make_list([number, state, *more[:1]]), make_list(terms))
        if solution is not None:
            yield solution


def _state(circumstance: Circumstance, one: Intention, is_current: bool) -> Literal:
    """Return the state of an intention: running, suspended, or waiting with the reason."""
    if is_current:
        return Literal("running")
    if one.number in circumstance.pending_actions:
        why = "action"
    elif one.is_suspended:
        return Literal("suspended")
    elif one.number in circumstance.pending:
        why = "reason"
    else:
        return Literal("running")
    return Literal("waiting", (), (Literal(why, (one.reason or Literal("no_reason"),)),))


@STANDARD.add(".intention", least=1, most=4)
def _one_or_all(call: Call, *args: Term) -> object:
    return current_intention(call, *args) if len(args) == 1 else intention(call, *args)


def _described(call: Call, intention: Intention) -> Literal:
    """Return an intention as a term with fresh variables."""
    return rename(_description(intention), call.agent.names, {})


def _label(means: Means) -> Literal:
    """Return the label of a plan, annotated with its location."""
    place = means.plan.plan.place
    if not place.line:
        return means.plan.label
    line, source = Literal("code_line", (float(place.line),)), Literal("code_src", (place.name,))
    return with_more_annots(means.plan.label, line, source)


def _description(intention: Intention) -> Literal:
    stack: list[Term] = []
    for means in intention.downwards():
        left = []
        step = means.step
        while step is not None:
            if step.operation != "join":  # the end of a branch, which is not in the source
                left.append(step.formula)
            step = step.next
        bindings = make_list(
            Literal("map", (name, substitute(value, means.u))) for name, value in means.u.items()
        )
        trigger = TriggerTerm(means.sort, means.literal)
        stack.append(Literal("im", (_label(means), trigger, BodyTerm(tuple(left)), bindings)))
    return Literal("intention", (float(intention.number), make_list(stack)))


@STANDARD.add(".suspend", most=1)
def suspend(call: Call, *goal: Term) -> object:
    """`.suspend(G?)`: suspend the intentions with a goal, or the calling one."""
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
    """Suspend the events of a goal, and those of intentions with the goal."""
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
    """`.resume(G)`: resume the suspended intentions with a goal."""
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
    """`.suspended(G, R?)`: whether an intention with a goal is suspended or waits for R."""
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


def _body(name: str, term: Term) -> Body:
    if isinstance(term, BodyTerm):
        return term.body
    if isinstance(term, Literal | Var):
        return (Act(term),)
    raise wrong(name, f"'{text(term)}' is not the body of a plan.")


def _carry_out(call: Call, formula: BodyFormula) -> Waiting:
    """Carry out a control structure in place of the calling step."""
    intention = call.intention
    assert intention is not None  # control structures are not allowed in contexts
    means = intention.top
    means.step = compile_body((formula,), None if means.step is None else means.step.next)
    assert means.step is not None  # it begins with the formula
    OPERATIONS[means.step.operation](call.agent, intention, means, means.step)
    return WAITING


@STANDARD.add(".if_then_else", least=2, most=3, in_context=False)
def if_then_else(call: Call, condition: Term, then: Term, *otherwise: Term) -> Waiting:
    """`.if_then_else(F, {a}, {b}?)`: carry out one body or the other."""
    bodies = [_body("if_then_else", term) for term in (then, *otherwise)]
    step = If(condition=condition, then=bodies[0], otherwise=bodies[1] if otherwise else ())
    return _carry_out(call, step)


@STANDARD.add(".loop", least=2, most=2, in_context=False)
def loop(call: Call, condition: Term, body: Term) -> Waiting:
    """`.loop(F, {a})`: carry out a body as long as a formula holds."""
    return _carry_out(call, While(condition, _body("loop", body)))


@STANDARD.add(".foreach", least=2, most=2, in_context=False)
def foreach(call: Call, generator: Term, body: Term) -> Waiting:
    """`.foreach(F, {a})`: carry out a body for each solution of a formula."""
    return _carry_out(call, For(generator, _body("foreach", body)))


@STANDARD.add(".fork", least=2, in_context=False)
def fork(call: Call, kind: Term, *branches: Term) -> Waiting:
    """`.fork(and, {a}, {b})`: carry out bodies concurrently, until all or the first end."""
    name = text(kind)
    if name not in ("and", "or"):
        raise wrong("fork", "first argument must be 'and' or 'or'.")
    return _carry_out(call, ForkJoin(name == "and", tuple(_body("fork", b) for b in branches)))
