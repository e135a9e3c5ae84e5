"""What becomes of an intention whose plan fails."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .intentions import Event, Intention
from .order import sorted_annots
from .program import Achieve, Act, Constraint, Place, Test, Update
from .terms import Literal, Term, Var
from .unify import rename, substitute, unify

if TYPE_CHECKING:
    from .agent import Agent


class ActionError(Exception):
    """An internal action that cannot be done: its `error` and message annotate the `-!g` event."""

    def __init__(
        self, message: str, error: str = "internal_action", annots: tuple[Term, ...] = ()
    ) -> None:
        self.message = message
        self.error = error
        self.annots = annots
        super().__init__(message)

    @property
    def error_annots(self) -> tuple[Term, ...]:
        return (*error_annots(self.error, self.message), *self.annots)


def error_annots(error: str, message: str) -> tuple[Term, ...]:
    return (Literal("error", (Literal(error),)), Literal("error_msg", (message,)))


def find_failure_event(agent: Agent, intention: Intention, event: Event) -> Event | None:
    """The `-!g` (or `-?g`) event of the nearest goal that has a plan for it.

    `event` is what failed; the goals below it are asked in turn. In a fork a
    failure that reaches below the fork ends the other branches (`|&|`) or just
    its own (`|||`).
    """
    found, height = _search(agent, intention, event.sort, event.literal)
    while intention.fork is not None and height <= intention.fork_point:
        if not intention.fork.all_of:
            return None
        end_fork(agent, intention)
    return found


def end_fork(agent: Agent, intention: Intention) -> None:
    """Of the fork that `intention` is a branch of, it alone goes on: the other branches end."""
    fork = intention.leave_fork()
    for branch in list(fork.branches):
        if branch is not intention:
            fork.remove(branch)
            agent.circumstance.drop(branch)


DEAR = 10
"""A goal below that is looked at, failure after failure, counts as so many goals."""


def _search(
    agent: Agent, intention: Intention, sort: str, literal: Literal
) -> tuple[Event | None, int]:
    """The event, and how high in the stack (from 1) the plan of its goal is; 0 without one."""
    below = list(intention.downwards())
    position = 0
    if sort in ("-!", "-?"):
        # A failure plan that fails: go on below the goal it was for.
        position = 1
        found = False
        while position < len(below) and not found:
            means = below[position]
            position += 1
            while position < len(below) and unify(means.literal, literal, dict(means.u)):
                agent.logic.spend(DEAR, literal)
                means = below[position]
                position += 1
                found = True
        means = below[position - 1]
        sort, literal = means.sort, means.literal
    while not agent.plans.candidates("-" + sort[1:], literal) and position < len(below):
        means = below[position]
        sort, literal = means.sort, means.literal
        position += 1
    if len(sort) == 2 and agent.plans.candidates("-" + sort[1:], literal):
        return Event("-" + sort[1:], literal, intention), len(below) - max(position - 1, 0)
    return None, 0


def fail(agent: Agent, intention: Intention, annots: tuple[Term, ...]) -> None:
    """The current step of an intention failed: a failure plan goes on, or the intention ends."""
    means = intention.top
    step = means.step
    event = find_failure_event(agent, intention, Event(means.sort, means.literal, intention))
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
    if not means.is_goal:
        agent.warn(f"an intention ended: {means.trigger} could not be finished", intention)
        return
    if event is None:
        why = "; ".join(_said(annot) for annot in annots)
        at = f" at {place.file}:{place.line}" if place is not None and place.line else ""
        agent.warn(
            f"no plan for the failure of {means.sort}{means.literal.without_annots()}{at}: {why}",
            intention,
        )
        end(agent, intention)
        return
    event.literal = annotated(agent, event.literal, annots, code, place)
    agent.circumstance.post(event)


def fail_event(agent: Agent, event: Event, annots: tuple[Term, ...], why: str) -> None:
    """No plan could be used for a goal: its own failure plan goes on, or one below it."""
    failure: Event | None = None
    if event.sort[0] == "+":
        if event.intention is not None:
            failure = find_failure_event(agent, event.intention, event)
        elif agent.plans.candidates("-" + event.sort[1:], event.literal):
            failure = Event("-" + event.sort[1:], event.literal)
    if failure is None:
        agent.warn(why, event.intention)
        if event.intention is not None:
            end(agent, event.intention)
        return
    place = None
    if event.intention is not None and event.intention.stack:
        step = event.intention.top.step
        place = None if step is None else step.formula.place
    failure.literal = annotated(agent, failure.literal, annots, event.literal, place)
    agent.circumstance.post(failure)


def end(agent: Agent, intention: Intention) -> None:
    """An intention fails for good; so do the others of its `|&|`."""
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


def _said(annot: Term) -> str:
    if isinstance(annot, Literal) and annot.args:
        value = annot.args[0]
        return value if isinstance(value, str) else str(value)
    return str(annot)


def annotated(
    agent: Agent, literal: Literal, annots: tuple[Term, ...], code: Term, place: Place | None
) -> Literal:
    """The literal of a failure event with what went wrong and where as annotations."""
    added: list[Term] = [*literal.annots, *annots]
    if place is not None:
        added.append(Literal("code_src", (place.file,)))
        added.append(Literal("code_line", (float(place.line),)))
    added.append(Literal("code", (rename(code, agent.names, {}),)))
    return literal.with_annots(sorted_annots(tuple(added)))


def clear_failed(intention: Intention, literal: Literal) -> None:
    """After a failure plan has ended: drops the plans between it and the goal it was for."""

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
    while intention.stack and not (means.is_goal and unify(means.literal, literal, dict(means.u))):
        step = means.step
        if step is not None and step.goal is not None and unify(step.goal, literal, dict(means.u)):
            break
        means = intention.pop()
