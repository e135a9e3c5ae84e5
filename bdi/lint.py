"""Warnings about programs that are valid but probably wrong."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from difflib import get_close_matches

from .actions import ActionError
from .errors import ProgramProblem
from .internal_actions import STANDARD
from .language.body import Achieve, Act, Event, Place, Update, steps_of
from .language.program import Belief, Goal, Program, all_plans
from .language.terms import Literal

LIKE = 0.85
"""Minimum similarity (of `difflib`) of the name of an event to a known one to be a misspelling."""

CHANGES_PLANS = frozenset({".add_plan", ".include", ".relevant_plans", ".send", ".broadcast"})
"""Internal actions that can add plans to a program."""


def doubts(
    program: Program,
    *,
    actions: Mapping[str, tuple[int, int]] | None = None,
    events: Iterable[str] = (),
) -> tuple[ProgramProblem, ...]:
    """Return warnings about a valid program, in order of their locations.

    Warnings concern goals without a plan, and internal actions that are called without their dot or
    with a wrong number of arguments.

    Parameters
    ----------
    program : Program
        Program with all its included files.
    actions : mapping, optional
        Minimum and maximum number of arguments of each external action, by name. Calls of other
        actions cause warnings. By default external actions are not checked.
    events : iterable of str, optional
        Names of percepts. A plan for a belief that is spelt similarly, and that the program does
        not add itself, causes a warning.

    Returns
    -------
    tuple of ProgramProblem
        Warnings.
    """
    steps = [
        step
        for plan in all_plans(program.plans)
        for step in steps_of(plan.body)
        if isinstance(step, Achieve | Act | Update)
    ]
    called = {name for step in steps if (name := _name(step)).startswith(".")}
    found: dict[ProgramProblem, None] = {}
    for step in (*program.goals, *steps):
        if isinstance(step, Achieve | Goal):
            message = _no_plan(step.goal, program) if called.isdisjoint(CHANGES_PLANS) else ""
        elif isinstance(step, Act) and isinstance(step.action, Literal):
            message = _wrong_action(step.action, actions)
        else:
            continue
        if message:
            found[step.place.problem(message)] = None
    for place, message in _misspelt(program, steps, [*events]):
        found[place.problem(message)] = None
    return tuple(sorted(found, key=lambda one: (one.file, one.line, one.column)))


def _name(step: Achieve | Act | Update) -> str:
    """Return the name of the action in a step, or an empty text."""
    return step.action.functor if isinstance(step, Act) and isinstance(step.action, Literal) else ""


def _no_plan(goal: Event, program: Program) -> str:
    """Return the warning that no plan achieves a goal, or an empty text."""
    if not isinstance(goal, Literal) or "::" in goal.functor:
        return ""
    known: list[str] = []
    for plan in all_plans(program.plans):
        if plan.trigger.sort in ("+!", "-!"):
            if not isinstance(plan.trigger.literal, Literal):
                return ""
            if plan.trigger.literal.key == goal.key:
                return ""
            known.append(_signature(plan.trigger.literal))
    wanted = _signature(goal)
    return f"there is no plan for the goal !{wanted}{_hint(wanted, known)}"


def _wrong_action(action: Literal, actions: Mapping[str, tuple[int, int]] | None) -> str:
    """Return the warning about the call of an action, or an empty text."""
    name, count = action.functor, len(action.args)
    if action.is_internal_action:
        try:
            if name in STANDARD:
                STANDARD[name].check(name, count)
        except ActionError as why:
            return str(why)
    elif f".{name}" in STANDARD and name not in (actions or ()):
        return f"there is no action {name}; did you mean .{name}?"
    elif actions is None or "::" in name:
        return ""
    elif name not in actions:
        return f"there is no action {name}{_hint(name, [*actions])}"
    elif not actions[name][0] <= count <= actions[name][1]:
        least, most = actions[name]
        wanted = str(least) if least == most else f"{least} to {most}"
        return f"the action {name} takes {wanted} arguments, found {count}"
    return ""


def _misspelt(
    program: Program, steps: list[Achieve | Act | Update], events: list[str]
) -> Iterator[tuple[Place, str]]:
    """Yield plans for beliefs that nothing adds and that are spelt similarly to one of `events`."""
    changed = (step.belief for step in steps if isinstance(step, Update))
    believed = {belief.functor for belief in changed if isinstance(belief, Literal)}
    believed |= {one.belief.functor for one in program.beliefs if isinstance(one, Belief)}
    for plan in program.plans:
        literal = plan.trigger.literal
        if plan.trigger.kind or not isinstance(literal, Literal):
            continue
        if literal.functor in believed or literal.functor in events:
            continue
        if near := get_close_matches(literal.functor, events, 1, LIKE):
            yield plan.place, f"nothing adds {literal.functor}; did you mean {near[0]}?"


def _signature(literal: Literal) -> str:
    return f"{literal.functor}/{len(literal.args)}"


def _hint(name: str, known: list[str]) -> str:
    near = get_close_matches(name, known, 1)
    return f"; did you mean {near[0]}?" if near else ""
