"""Plan bodies made ready to run: a graph of steps, each with what it does and what follows.

A step's `run(agent, intention, means, step)` does it once. Unless it raised an
event or left the intention waiting, it moves the plan on (`agent.move_on`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, TypeAlias

from .beliefs import has_source
from .compiled import Build, Condition, builder, condition
from .failure import ActionError, end_fork, error_annots, fail
from .intentions import Event, Fork, Intention, Means
from .order import sorted_annots
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
from .terms import FROM_SELF, ONLY_SELF, TRUE, Literal, Relation, Term, Var, text
from .unify import Unifier, rename, substitute, variable_names, walk

if TYPE_CHECKING:
    from .agent import Agent

Run: TypeAlias = "Callable[[Agent, Intention, Means, Step], None]"


class Step:
    """One step of a body.

    `term` is the goal, belief, action or condition it is about; `build` makes
    its value, `check` asks whether it holds. `branches` are the beginnings of
    the bodies inside it.
    """

    __slots__ = ("branches", "build", "check", "formula", "next", "run", "term")

    def __init__(
        self, run: Run, formula: BodyFormula, following: Step | None, term: Term = TRUE
    ) -> None:
        self.run = run
        self.formula = formula
        self.next = following
        self.term = term
        self.branches: tuple[Step | None, ...] = ()
        if isinstance(formula, Achieve | Update | Act):
            self.build: Build = builder(term)
        else:
            self.check: Condition = condition(term)

    @property
    def goal(self) -> Literal | Var | None:
        """The subgoal the step waits for, if it is one."""
        formula = self.formula
        return formula.goal if isinstance(formula, Achieve) and not formula.new_focus else None


def compile_body(body: Body, following: Step | None = None) -> Step | None:
    """The first step of a body that goes on with `following`."""
    for formula in reversed(body):
        following = _compile(formula, following)
    return following


def _compile(formula: BodyFormula, following: Step | None) -> Step:
    if isinstance(formula, Achieve):
        run = achieve_new if formula.new_focus else achieve
        return Step(run, formula, following, _with_source(formula.goal))
    if isinstance(formula, Test):
        return Step(test, formula, following, formula.formula)
    if isinstance(formula, Update):
        return Step(_UPDATES[formula.operator], formula, following, _with_source(formula.belief))
    if isinstance(formula, Act):
        return Step(_act_of(formula.action), formula, following, formula.action)
    if isinstance(formula, Constraint):
        return Step(constrain, formula, following, formula.relation)
    if isinstance(formula, If):
        step = Step(choose, formula, following, formula.condition)
        step.branches = (
            compile_body(formula.then, following),
            compile_body(formula.otherwise, following),
        )
        return step
    if isinstance(formula, While):
        return _compile_loop(begin_while, again_while, formula, formula.condition, following)
    if isinstance(formula, For):
        return _compile_loop(begin_for, again_for, formula, formula.generator, following)
    step = Step(fork_all if formula.all_of else fork_any, formula, following)
    meeting = Step(join, formula, following)
    step.branches = tuple(compile_body(branch, meeting) for branch in formula.branches)
    return step


def _compile_loop(
    begin: Run, again: Run, formula: While | For, term: Term, following: Step | None
) -> Step:
    first = Step(begin, formula, following, term)
    later = Step(again, formula, following, term)
    inside = compile_body(formula.body, later) or later
    first.branches = later.branches = (inside,)
    return first


def _with_source(literal: Literal | Var) -> Literal | Var:
    """The literal with `source(self)`, unless it says itself where it comes from."""
    return with_source(literal) if isinstance(literal, Literal) else literal


def with_source(literal: Literal, source: Literal = FROM_SELF) -> Literal:
    """The literal as it is if it has a source, else with the one given."""
    if not literal.annots and source is FROM_SELF:
        return literal.with_annots(ONLY_SELF)
    if has_source(literal):
        return literal
    return literal.with_annots(sorted_annots((*literal.annots, source)))


def _act_of(action: Term) -> Run:
    if isinstance(action, Literal):
        return act_internal if action.is_internal_action else act_external
    return act_variable


# ---- goals


def _built(agent: Agent, means: Means, step: Step) -> Literal | None:
    """The literal of a step, or None when a variable stands for none."""
    literal = step.build(means.u)
    if step.term.__class__ is Literal:
        return literal  # type: ignore[return-value]
    return with_source(literal) if isinstance(literal, Literal) else None


def _export(agent: Agent, means: Means, literal: Literal) -> Literal:
    """The literal with fresh variables for those unbound, whose values the plan awaits."""
    renamed: dict[str, Var] = {}
    exported = rename(literal, agent.names, renamed)
    means.u.update(renamed)
    means.awaited = variable_names(exported)
    return exported  # type: ignore[return-value]


def _not_a_literal(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    value = walk(step.term, means.u)
    if isinstance(value, Var):
        message = f"{step.formula.place.line}: Variable '{value}' must be ground."
        fail(agent, intention, error_annots("body_var_without_value", message))
    else:
        message = f"Variable '{step.term}' must be a Literal and not '{text(value)}'"
        fail(agent, intention, error_annots("body_var_not_literal", message))


def achieve(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    literal = _built(agent, means, step)
    if literal is None:
        _not_a_literal(agent, intention, means, step)
        return
    if literal.ground:
        means.awaited = ()
    else:
        literal = _export(agent, means, literal)
    agent.circumstance.post(Event("+!", literal, intention))


def achieve_new(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    literal = _built(agent, means, step)
    if literal is None:
        _not_a_literal(agent, intention, means, step)
        return
    if not literal.ground:
        literal = rename(literal, agent.names, {})  # type: ignore[assignment]
    agent.circumstance.post(Event("+!", literal))
    agent.move_on(intention, means)


def test(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    solution = step.check(agent.logic, means.u)
    if solution is not None:
        means.u = solution
        agent.move_on(intention, means)
        return
    formula = substitute(step.term, means.u)
    if isinstance(formula, Literal) and agent.plans.candidates("+?", formula):
        literal = _export(agent, means, with_source(formula))
        agent.circumstance.post(Event("+?", literal, intention))
        return
    message = f"Failed to test '{text(step.term)}'"
    fail(agent, intention, error_annots("test_goal_failed", message))


def constrain(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    solution = step.check(agent.logic, means.u)
    if solution is None:
        message = f"Constraint {step.formula} was not satisfied ({step.formula.place.line})"
        fail(agent, intention, error_annots("constraint_failed", message))
        return
    means.u = solution
    agent.move_on(intention, means)


# ---- beliefs


def _add(
    agent: Agent,
    intention: Intention,
    means: Means,
    literal: Literal,
    *,
    at_end: bool = False,
    same_focus: bool = True,
) -> None:
    if literal.ground:
        means.awaited = ()
    else:
        literal = _export(agent, means, literal)
    added = agent.beliefs.add(literal, at_end=at_end)
    focus = intention if same_focus else None
    if added is None or not agent.changed("+", added, focus) or not same_focus:
        agent.move_on(intention, means)


def add_belief(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    literal = _built(agent, means, step)
    if literal is None:
        _not_a_literal(agent, intention, means, step)
    else:
        _add(agent, intention, means, literal)


def add_belief_at_end(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    literal = _built(agent, means, step)
    if literal is None:
        _not_a_literal(agent, intention, means, step)
    else:
        _add(agent, intention, means, literal, at_end=True)


def add_belief_new(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    literal = _built(agent, means, step)
    if literal is None:
        _not_a_literal(agent, intention, means, step)
    else:
        _add(agent, intention, means, literal, same_focus=False)


def replace_belief(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    """`-+b(X)`: the first `b` of the agent's own goes, whatever its arguments."""
    literal = _built(agent, means, step)
    if literal is None:
        _not_a_literal(agent, intention, means, step)
        return
    removed = agent.beliefs.remove_first(literal.key, literal.annots)
    if removed is not None:
        agent.changed("-", removed, None)
    _add(agent, intention, means, literal)


def _delete(
    agent: Agent, intention: Intention, means: Means, step: Step, *, same_focus: bool
) -> None:
    literal = _built(agent, means, step)
    if literal is None:
        _not_a_literal(agent, intention, means, step)
        return
    means.awaited = ()
    removed = agent.beliefs.remove(literal, means.u)
    focus = intention if same_focus else None
    if removed is None or not agent.changed("-", removed, focus) or not same_focus:
        agent.move_on(intention, means)


def delete_belief(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    _delete(agent, intention, means, step, same_focus=True)


def delete_belief_new(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    _delete(agent, intention, means, step, same_focus=False)


_UPDATES: Mapping[str, Run] = MappingProxyType(
    {
        "+": add_belief,
        "+<": add_belief,
        "+>": add_belief_at_end,
        "++": add_belief_new,
        "-": delete_belief,
        "--": delete_belief_new,
        "-+": replace_belief,
    }
)


# ---- actions


def act_external(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    agent.request(step.build(means.u), intention)  # type: ignore[arg-type]


def act_variable(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    value = step.build(means.u)
    if isinstance(value, BodyTerm):
        means.step = compile_body(value.body, step.next)
        agent.circumstance.add_running(intention)
    elif isinstance(value, Relation):
        solution = agent.logic.first(value, means.u)
        if solution is None:
            message = f"Constraint {value} was not satisfied"
            fail(agent, intention, error_annots("constraint_failed", message))
        else:
            means.u = solution
            agent.move_on(intention, means)
    elif isinstance(value, Literal) and value.is_internal_action:
        _call(agent, intention, means, value)
    elif isinstance(value, Literal):
        agent.request(value, intention)
    else:
        _not_a_literal(agent, intention, means, step)


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
    # An action that achieves a goal of its own intention takes this plan off it, too.
    agent.move_on(intention, intention.top if intention.stack else means)


class Waiting:
    """What an internal action answers that has put its intention somewhere else."""


WAITING = Waiting()


# ---- control


def choose(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    solution = step.check(agent.logic, means.u)
    if solution is None:
        means.step = step.branches[1]
    else:
        means.u = solution
        means.step = step.branches[0]
    agent.circumstance.add_running(intention)


def begin_while(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    means.loops.append((means.u, iter(())))
    again_while(agent, intention, means, step)


def again_while(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    before, _ = means.loops[-1]
    _iterate(agent, intention, means, step, step.check(agent.logic, before))


def begin_for(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    solutions = list(agent.logic.solutions(step.term, means.u))
    if not solutions:
        agent.move_on(intention, means)
        return
    means.loops.append((means.u, iter(solutions)))
    again_for(agent, intention, means, step)


def again_for(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    _, solutions = means.loops[-1]
    _iterate(agent, intention, means, step, next(solutions, None))


def _iterate(
    agent: Agent, intention: Intention, means: Means, step: Step, solution: Unifier | None
) -> None:
    """Once more through a loop's body, or on as if nothing in it had been bound."""
    if solution is None:
        means.u, _ = means.loops.pop()
        means.step = step.next
    else:
        means.u = dict(solution)
        means.step = step.branches[0]
    agent.circumstance.add_running(intention)


def fork_all(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    _fork(agent, intention, step, Fork(True, intention))


def fork_any(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    _fork(agent, intention, step, Fork(False, intention))


def _fork(agent: Agent, intention: Intention, step: Step, fork: Fork) -> None:
    for beginning in step.branches:
        branch = intention.branch(agent.next_intention_number(), fork)
        branch.top.step = beginning
        fork.add(branch)
        agent.circumstance.add_running(branch)
    fork.take_place()
    agent.circumstance.forget(intention)


def join(agent: Agent, intention: Intention, means: Means, step: Step) -> None:
    fork = intention.fork
    if fork is not None:
        fork.to_finish -= 1
        if fork.all_of and fork.to_finish > 0:
            fork.remove(intention)
            agent.circumstance.forget(intention)
            return
        end_fork(agent, intention)
    agent.move_on(intention, means)
