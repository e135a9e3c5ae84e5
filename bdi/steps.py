"""Plan bodies made ready to run: a graph of steps, each with what it does and what follows.

A step's `run(agent, intention, means, step)` does it once. Unless it raised an
event or left the intention waiting, it moves the plan on (`agent.move_on`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

from .failure import ActionError, error_annots, fail
from .intentions import Event, Fork, Intention, Means
from .program import (
    Achieve,
    Act,
    Body,
    BodyFormula,
    BodyTerm,
    Constraint,
    For,
    If,
    Test,
    Update,
    While,
)
from .program import Fork as ForkFormula
from .terms import FROM_SELF, Literal, Relation, Term, Var, text
from .unify import Unifier, rename, substitute, variable_names, walk

if TYPE_CHECKING:
    from .agent import Agent

Run: TypeAlias = "Callable[[Agent, Intention, Means, Step], None]"


class Step:
    """One step of a body; `branches` are the beginnings of the bodies inside it."""

    __slots__ = ("branches", "formula", "goal", "next", "run", "shown", "term")

    def __init__(
        self,
        run: Run,
        formula: BodyFormula,
        following: Step | None,
        *,
        term: Term | None = None,
        goal: Term | None = None,
    ) -> None:
        self.run = run
        self.formula = formula
        self.next = following
        self.term = term
        self.goal = goal
        self.shown = term
        self.branches: tuple[Step | None, ...] = ()


def compile_body(body: Body, following: Step | None = None) -> Step | None:
    """The first step of a body that goes on with `following`."""
    for formula in reversed(body):
        following = _compile(formula, following)
    return following


def _compile(formula: BodyFormula, following: Step | None) -> Step:
    if isinstance(formula, Achieve):
        run = achieve_new if formula.new_focus else achieve
        goal = _with_source(formula.goal)
        step = Step(run, formula, following, term=goal, goal=formula.goal)
        step.shown = formula.goal
        return step
    if isinstance(formula, Test):
        return Step(test, formula, following, term=formula.formula)
    if isinstance(formula, Update):
        step = Step(_UPDATES[formula.operator], formula, following, term=formula.belief)
        if isinstance(formula.belief, Literal):
            step.term = _with_source(formula.belief)
        return step
    if isinstance(formula, Act):
        return Step(_act_of(formula.action), formula, following, term=formula.action)
    if isinstance(formula, Constraint):
        return Step(constrain, formula, following, term=formula.relation)
    if isinstance(formula, If):
        step = Step(choose, formula, following, term=formula.condition)
        step.branches = (
            compile_body(formula.then, following),
            compile_body(formula.otherwise, following),
        )
        step.shown = None
        return step
    if isinstance(formula, While):
        return _compile_loop(begin_while, again_while, formula, formula.condition, following)
    if isinstance(formula, For):
        return _compile_loop(begin_for, again_for, formula, formula.generator, following)
    step = Step(fork, formula, following)
    join_step = Step(join, formula, following)
    step.branches = tuple(compile_body(branch, join_step) for branch in formula.branches)
    return step


def _compile_loop(
    begin: Run, again: Run, formula: While | For, condition: Term, following: Step | None
) -> Step:
    first = Step(begin, formula, following, term=condition)
    later = Step(again, formula, following, term=condition)
    body = formula.body
    inside = compile_body(body, later) or later
    for step in (first, later):
        step.branches = (inside,)
        step.shown = None
    return first


def _with_source(literal: Literal | Var) -> Literal | Var:
    """The literal with `source(self)`, unless it says itself where it comes from."""
    if not isinstance(literal, Literal):
        return literal
    return agent_source(literal)


def agent_source(literal: Literal, source: Literal = FROM_SELF) -> Literal:
    from .beliefs import has_source
    from .order import sorted_annots

    if has_source(literal):
        return literal
    return literal.with_annots(sorted_annots((*literal.annots, source)))


def _act_of(action: Term) -> Run:
    if isinstance(action, Literal):
        return act_internal if action.is_internal_action else act_external
    return act_variable


# ---- goals


def _goal_literal(agent: Agent, means: Means, step: Step) -> Literal | None:
    """The literal of an event with fresh variables for those unbound, or None when it failed."""
    term = step.term
    literal = substitute(term, means.u)  # type: ignore[arg-type]
    if literal.__class__ is not Literal:
        return None
    if not step.term.__class__ is Literal:
        literal = agent_source(literal)  # type: ignore[arg-type]
    if literal.ground:  # type: ignore[union-attr]
        means.awaited = ()
        return literal  # type: ignore[return-value]
    renamed: dict[str, Var] = {}
    literal = rename(literal, agent.names, renamed)
    for name, fresh in renamed.items():
        means.u[name] = fresh
    means.awaited = variable_names(literal)
    return literal  # type: ignore[return-value]


def _not_a_literal(agent: Agent, intention: Intention, step: Step, means: Means) -> None:
    value = walk(step.term, means.u)  # type: ignore[arg-type]
    if isinstance(value, Var):
        message = f"variable {value} has no value"
        fail(agent, intention, error_annots("body_var_without_value", message))
    else:
        message = f"{step.term} stands for {text(value)}, which is no literal"
        fail(agent, intention, error_annots("body_var_not_literal", message))


def achieve(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    literal = _goal_literal(agent, means, step)
    if literal is None:
        _not_a_literal(agent, intention, step, means)
        return
    agent.circumstance.post(Event("+!", literal, intention))


def achieve_new(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    awaited = means.awaited
    literal = _goal_literal(agent, means, step)
    means.awaited = awaited
    if literal is None:
        _not_a_literal(agent, intention, step, means)
        return
    agent.circumstance.post(Event("+!", literal))
    agent.move_on(intention, means)


def test(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    solution = agent.logic.first(step.term, means.u)  # type: ignore[arg-type]
    if solution is not None:
        means.u = dict(solution)
        agent.move_on(intention, means)
        return
    formula = substitute(step.term, means.u)  # type: ignore[arg-type]
    if isinstance(formula, Literal) and agent.plans.candidates("+?", formula):
        literal = _goal_literal(agent, means, step)
        if literal is not None:
            agent.circumstance.post(Event("+?", agent_source(literal), intention))
            return
    message = f"Failed to test '{text(step.term)}'"  # type: ignore[arg-type]
    fail(agent, intention, error_annots("test_goal_failed", message))


def constrain(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    solution = agent.logic.first(step.term, means.u)  # type: ignore[arg-type]
    if solution is None:
        message = f"Constraint {step.formula} was not satisfied ({step.formula.place.line})"
        fail(agent, intention, error_annots("constraint_failed", message))
        return
    means.u = dict(solution)
    agent.move_on(intention, means)


# ---- beliefs


def _belief(agent: Agent, means: Means, step: Step) -> Literal | None:
    literal = substitute(step.term, means.u)  # type: ignore[arg-type]
    return agent_source(literal) if isinstance(literal, Literal) else None


def _add(
    agent: Agent,
    intention: Intention,
    means: Means,
    step: Step,
    *,
    at_end: bool = False,
    same_focus: bool = True,
) -> None:
    literal = _goal_literal(agent, means, step)
    if literal is None:
        _not_a_literal(agent, intention, step, means)
        return
    added = agent.beliefs.add(literal, at_end=at_end)
    if added is not None:
        agent.circumstance.post(Event("+", added, intention if same_focus else None))
    if added is None or not same_focus:
        agent.move_on(intention, means)


def add_belief(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    _add(agent, intention, means, step)


def add_belief_at_end(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    _add(agent, intention, means, step, at_end=True)


def add_belief_new(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    _add(agent, intention, means, step, same_focus=False)


def replace_belief(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    literal = _belief(agent, means, step)
    if literal is None:
        _not_a_literal(agent, intention, step, means)
        return
    anything = tuple(agent.names.fresh() for _ in literal.args)
    pattern = Literal(literal.functor, anything, literal.annots, literal.negated)
    removed = agent.beliefs.remove(pattern, {})
    if removed is not None:
        agent.circumstance.post(Event("-", removed))
    _add(agent, intention, means, step)


def _delete(
    agent: Agent, intention: Intention, means: Means, step: Step, same_focus: bool
) -> None:
    literal = _belief(agent, means, step)
    if literal is None:
        _not_a_literal(agent, intention, step, means)
        return
    means.awaited = ()
    removed = agent.beliefs.remove(literal, means.u)
    if removed is not None:
        agent.circumstance.post(Event("-", removed, intention if same_focus else None))
    if removed is None or not same_focus:
        agent.move_on(intention, means)


def delete_belief(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    _delete(agent, intention, means, step, True)


def delete_belief_new(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    _delete(agent, intention, means, step, False)


_UPDATES: dict[str, Run] = {
    "+": add_belief,
    "+<": add_belief,
    "+>": add_belief_at_end,
    "++": add_belief_new,
    "-": delete_belief,
    "--": delete_belief_new,
    "-+": replace_belief,
}


# ---- actions


def act_external(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    action = substitute(step.term, means.u)  # type: ignore[arg-type]
    agent.request(action, intention)  # type: ignore[arg-type]


def act_variable(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    value = substitute(step.term, means.u)  # type: ignore[arg-type]
    if isinstance(value, BodyTerm):
        means.step = compile_body(value.body, step.next)
        agent.circumstance.add_running(intention)
    elif isinstance(value, Relation):
        solution = agent.logic.first(value, means.u)
        if solution is None:
            message = f"Constraint {value} was not satisfied"
            fail(agent, intention, error_annots("constraint_failed", message))
        else:
            means.u = dict(solution)
            agent.move_on(intention, means)
    elif isinstance(value, Literal) and value.is_internal_action:
        _call(agent, intention, means, value)
    elif isinstance(value, Literal):
        agent.request(value, intention)
    else:
        _not_a_literal(agent, intention, step, means)


def act_internal(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    _call(agent, intention, means, step.term)  # type: ignore[arg-type]


def _call(agent: Agent, intention: Intention, means: Means, action: Literal) -> None:
    try:
        answer = agent.call(action, means.u, intention)
        if answer is not None and not isinstance(answer, bool | dict | Waiting):
            answer = next(answer, None)
    except ActionError as error:
        fail(agent, intention, error.error_annots)
        return
    if isinstance(answer, Waiting):
        return
    if answer is None or answer is False:
        fail(agent, intention, error_annots("ia_failed", ""))
        return
    if isinstance(answer, dict):
        means.u = dict(answer)
    agent.move_on(intention, means)


class Waiting:
    """What an internal action answers that has put its intention somewhere else."""


WAITING = Waiting()


# ---- control


def choose(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    solution = agent.logic.first(step.term, means.u)  # type: ignore[arg-type]
    if solution is None:
        means.step = step.branches[1]
    else:
        means.u = dict(solution)
        means.step = step.branches[0]
    agent.circumstance.add_running(intention)


def begin_while(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    means.loops.append(means.u)
    again_while(agent, intention, means, step)


def again_while(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    before: Unifier = means.loops[-1]  # type: ignore[assignment]
    solution = agent.logic.first(step.term, before)  # type: ignore[arg-type]
    if solution is None:
        means.u = means.loops.pop()  # type: ignore[assignment]
        means.step = step.next
    else:
        means.u = dict(solution)
        means.step = step.branches[0]
    agent.circumstance.add_running(intention)


def begin_for(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    solutions = list(agent.logic.solutions(step.term, means.u))  # type: ignore[arg-type]
    if not solutions:
        agent.move_on(intention, means)
        return
    means.loops.append((means.u, iter(solutions)))
    again_for(agent, intention, means, step)


def again_for(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    before, solutions = means.loops[-1]  # type: ignore[misc]
    solution = next(solutions, None)  # type: ignore[has-type]
    if solution is None:
        means.loops.pop()
        means.u = before  # type: ignore[has-type]
        means.step = step.next
    else:
        means.u = dict(solution)
        means.step = step.branches[0]
    agent.circumstance.add_running(intention)


def fork(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    formula = step.formula
    assert_fork = formula if isinstance(formula, ForkFormula) else None
    whole = Fork(assert_fork.all_of if assert_fork is not None else True)
    for beginning in step.branches:
        branch = intention.branch(agent.next_intention_number(), whole)
        branch.top.step = beginning
        whole.add(branch)
        agent.circumstance.add_running(branch)
    agent.circumstance.forget(intention)


def join(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    whole = intention.fork
    if whole is None:
        agent.move_on(intention, means)
        return
    whole.to_finish -= 1
    if whole.all_of:
        if whole.to_finish > 0:
            return
    else:
        whole.branches.remove(intention)
        for branch in list(whole.branches):
            agent.circumstance.drop(branch)
    agent.move_on(intention, means)
