"""Doubts about a program: what runs, but probably not as its author meant it."""

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
"""Likeness (of `difflib`) from which the name of an event is taken for another one, misspelt."""

CHANGES_PLANS = frozenset({".add_plan", ".include", ".relevant_plans", ".send", ".broadcast"})
"""Internal actions by which a program may have plans that are not written in it."""


def doubts(
    program: Program,
    *,
    actions: Mapping[str, tuple[int, int]] | None = None,
    events: Iterable[str] = (),
) -> tuple[ProgramProblem, ...]:
    """Return what is doubtful in a program, each with its place.

    These are goals for which there is no plan, and internal actions that don't take as many
    arguments, or are called without their dot.

    Args:
        program: the program, with all that it includes.
        actions: the external actions that there are, each with the least and the largest number of
            its arguments; others are doubtful. Not looked at by default.
        events: names of beliefs from outside. A plan for one that is spelt nearly the same, and
            that the program itself does not believe, is doubtful.
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
    """Return the name of the action in a step, or nothing."""
    return step.action.functor if isinstance(step, Act) and isinstance(step.action, Literal) else ""


def _no_plan(goal: Event, program: Program) -> str:
    """Return the message that no plan achieves a goal, or nothing."""
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
    """Return what is wrong with the call of an action, or nothing."""
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
    """Yield the plans for beliefs that nothing adds, spelt nearly as one of `events`."""
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
