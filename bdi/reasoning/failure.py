"""Failure of plans: the failure plan that replaces them, or the end of the intention.

As in Jason, failure plans are searched for the failed goal, then for the goals below it in the
stack. The plan that called the goal then continues (Bordini, Hübner and Wooldridge, "Programming
Multi-Agent Systems in AgentSpeak using Jason", 2007, sec. 4.2).
"""

from __future__ import annotations

from ..errors import EndlessProgramError, ProgramProblem
from ..language.body import Achieve, Act, Constraint, Place, Test, Update
from ..language.substitution import rename, sorted_annots, substitute
from ..language.terms import Literal, Term, Var
from ..language.unification import unify
from .intentions import Event, Intention
from .state import AgentState

SEARCH_COST = 10
"""Cost, in goals, of one step of the search through the goals of an intention."""

SEARCHED = 20
"""Number of plans in the stack that count as one more failure."""


def find_failure_event(
    agent: AgentState, intention: Intention, event: Event, *, has_plan: bool
) -> Event | None:
    """Return the `-!g` (or `-?g`) event of the nearest goal with a failure plan, or None.

    The search starts at the failed `event` and continues with the goals below it. `has_plan` is
    True if the active plan is that of the failed goal. A failure that reaches below a fork ends the
    other branches (`|&|`) or only its own branch (`|||`).
    """
    failure, height = _search(agent, intention, event.sort, event.literal)
    # The failure plan of a goal without a plan is inside the branch, above the plan that called the
    # goal. As in Jason, this does not count for `|||`.
    above = failure is not None and failure.literal is event.literal and not has_plan
    # Nested forks end from the inside out.
    while intention.fork is not None:
        all_of = intention.fork.all_of
        if height + (above and all_of) > intention.fork_point:
            break
        if not all_of:
            return None
        end_fork(agent, intention)
    return failure


def end_fork(agent: AgentState, intention: Intention) -> None:
    """End all branches of a fork but `intention`, which continues."""
    fork = intention.leave_fork()
    for branch in list(fork.branches):
        if branch is not intention:
            fork.remove(branch)
            agent.circumstance.drop(branch)


def _search(
    agent: AgentState, intention: Intention, sort: str, literal: Literal
) -> tuple[Event | None, int]:
    """Return the failure event and the height of its goal in the stack from 1, or None and 0."""
    below = list(intention.downwards())
    position = 0
    if sort in ("-!", "-?"):
        # After the failure of a failure plan, the search continues below its goal.
        position = 1
        is_below = False
        while position < len(below) and not is_below:
            means = below[position]
            position += 1
            # Skip the goal of the failure plan, and equal goals that follow it.
            while position < len(below) and unify(means.literal, literal, dict(means.u)):
                # Counted, because searches through thousands of goals take too long.
                agent.logic.spend(SEARCH_COST, literal)
                means = below[position]
                position += 1
                is_below = True
        means = below[position - 1]
        sort, literal = means.sort, means.literal
    # A relevant plan is enough. If it is not applicable, the intention ends (`fail_event`).
    while not agent.plans.candidates("-" + sort[1:], literal) and position < len(below):
        means = below[position]
        sort, literal = means.sort, means.literal
        position += 1
    if len(sort) == 2 and agent.plans.candidates("-" + sort[1:], literal):
        return Event("-" + sort[1:], literal, intention), len(below) - max(position - 1, 0)
    return None, 0


def fail(
    agent: AgentState, intention: Intention, annots: tuple[Term, ...], reason: str = ""
) -> None:
    """Fail the current step of an intention: raise the failure event, or end the intention.

    `reason` appears only in the warning.
    """
    means = intention.top
    step = means.step
    failed = Event(means.sort, means.literal, intention)
    event = find_failure_event(agent, intention, failed, has_plan=True)
    code: Term = Literal("no_code")
    place: Place | None = None
    if step is not None:
        place = step.formula.place
        shown = step.formula
        if isinstance(shown, Achieve):
            code = substitute(shown.goal, means.u)
        elif isinstance(shown, Update):
            code = substitute(shown.belief, means.u)
        elif isinstance(shown, Test | Act | Constraint):
            code = substitute(step.term, means.u)
    if agent.circumstance.states is not None and means.is_goal:
        _note_failure(agent, intention, means.sort, means.literal, event, annots)
    if event is None or not means.is_goal:
        why = "; ".join(filter(None, [*map(_summary, annots), reason]))
        at = f" at {place.file}:{place.line}" if place is not None and place.line else ""
        if step is not None and isinstance(step.formula, Act):
            at += f" in {code}"
        if not means.is_goal:
            agent.warn(f"an intention ended: {means.trigger} failed{at}: {why}", intention)
            return
        goal = f"{means.sort}{means.literal.without_annots()}"
        agent.warn(f"no plan for the failure of {goal}{at}: {why}", intention)
        end(agent, intention)
        return
    event.literal = annotated(agent, event, annots, code, place)
    agent.circumstance.post(event)


def fail_event(agent: AgentState, event: Event, annots: tuple[Term, ...], why: str) -> None:
    """Fail a goal without an applicable plan: raise the failure event, or end the intention."""
    failure: Event | None = None
    if event.sort[0] == "+":
        if event.intention is not None:
            failure = find_failure_event(agent, event.intention, event, has_plan=False)
        elif agent.plans.candidates("-" + event.sort[1:], event.literal):
            failure = Event("-" + event.sort[1:], event.literal)
    if agent.circumstance.states is not None and event.sort[0] == "+":
        _note_failure(agent, event.intention, event.sort, event.literal, failure, annots)
    if failure is None:
        agent.warn(why, event.intention)
        if event.intention is not None:
            end(agent, event.intention)
        return
    place = None
    if event.intention is not None and event.intention.stack:
        step = event.intention.top.step
        place = None if step is None else step.formula.place
    failure.literal = annotated(agent, failure, annots, event.literal, place)
    agent.circumstance.post(failure)


def _note_failure(
    agent: AgentState,
    intention: Intention | None,
    sort: str,
    goal: Literal,
    failure: Event | None,
    annots: tuple[Term, ...],
) -> None:
    """Record the states of a failed goal and of the goals below it."""
    states = agent.circumstance.states
    assert states is not None  # checked by the callers
    states.note("failed", sort, goal, _reason(annots))
    if failure is not None:
        states.note("executing", sort, goal, Literal("has_failure_plan"))
        return
    states.note("finished", sort, goal)
    if intention is not None:
        states.note_all("failed", intention, but=goal)


_REASONS = ("action_failed", "ask_failed", "constraint_failed", "test_goal_failed", "wait_timeout")


def _reason(annots: tuple[Term, ...]) -> Literal | None:
    """Return the reason of the state `failed`."""
    for annot in annots:
        error = annot.args[0] if isinstance(annot, Literal) and annot.functor == "error" else None
        if isinstance(error, Literal):
            if error.functor.startswith("body_var"):
                return None
            if error.functor.startswith("no_"):
                return Literal(f"{error.functor}_plan")
            return error if error.functor in _REASONS else Literal("ia_failed")
    return None


def end(agent: AgentState, intention: Intention) -> None:
    """End a failed intention, and the other branches of its `|&|`."""
    while (
        intention.fork is not None
        and intention.fork.all_of
        and len(intention.stack) >= intention.fork_point
    ):
        end_fork(agent, intention)
        agent.circumstance.drop(intention)
    if intention.fork is not None:
        intention.fork.remove(intention)
    agent.circumstance.forget(intention)


def _summary(annot: Term) -> str:
    if isinstance(annot, Literal) and annot.args:
        value = annot.args[0]
        return value if isinstance(value, str) else str(value)
    return str(annot)


def annotated(
    agent: AgentState, failure: Event, annots: tuple[Term, ...], code: Term, place: Place | None
) -> Literal:
    """Return the literal of a failure event, annotated with the cause and the location.

    Raises `EndlessProgramError` if too many goals have failed at one time.
    """
    literal, logic, intention = failure.literal, agent.logic, failure.intention
    # The cost of a failure grows with the stack.
    logic.failures_left -= 1 if intention is None else 1 + len(intention.stack) // SEARCHED
    if logic.failures_left < 0:
        goal = literal.without_annots()
        message = f"goals fail again and again at {agent.now:g} s, at last {goal}"
        message += ": this plan does not end"
        source = ProgramProblem(file=agent.program.source, message=message)
        raise EndlessProgramError([source if place is None else place.problem(message)])
    added: list[Term] = [*literal.annots, *annots]
    if place is not None:
        added.append(Literal("code_src", (place.name,)))
        added.append(Literal("code_line", (float(place.line),)))
    # The variables are renamed, so that they do not bind those of another plan.
    added.append(Literal("code", (rename(code, agent.names, {}),)))
    return literal.with_annots(sorted_annots(tuple(added)))


def clear_failed(intention: Intention, literal: Literal) -> None:
    """Remove the plans between a finished failure plan and its goal."""

    def called(means_index: int) -> bool:
        means = intention.stack[means_index]
        step = means.step
        return (
            step is not None
            and step.goal is not None
            and not isinstance(step.goal, Var)
            and unify(step.goal, literal, dict(means.u))
        )

    if called(-1):
        return
    means = intention.pop()
    # The failure plan has replaced all plans above the step that called its goal.
    while intention.stack and not (means.is_goal and unify(means.literal, literal, dict(means.u))):
        step = means.step
        if step is not None and step.goal is not None and unify(step.goal, literal, dict(means.u)):
            break
        means = intention.pop()
