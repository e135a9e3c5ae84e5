"""Execution of plan bodies: the operation of each step, and calls of internal actions.

An operation carries out one step and advances the intention, unless the intention waits for an
event or is pending.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from types import MappingProxyType
from typing import TypeAlias

from ..actions import ActionError, error_annots
from ..language.body import BodyTerm
from ..language.operations import Relation
from ..language.quoted import PlanTerm, RuleTerm, plan_change
from ..language.substitution import Unifier, rename, substitute, variable_names
from ..language.terms import ONLY_SELF, Literal, Term, Var, make_term, text
from ..language.unification import unified
from .beliefs import with_source
from .circumstance import Pending, PendingAction, Refused
from .contexts import condition
from .deliberation import move_on, set_deadline
from .failure import end_fork, fail
from .intentions import Event, Intention, IntentionFork, Means
from .logic import Answer
from .plans import BodyStep, compile_body
from .state import AgentState


class Call:
    """One call of an internal action.

    Attributes
    ----------
    agent : AgentState
        State of the agent: beliefs, plans, circumstance and random numbers.
    unifier : dict
        Bindings of the variables. Do not modify them, because actions return new unifiers.
    intention : Intention or None
        Calling intention, or None in a context or query.
    """

    __slots__ = ("agent", "intention", "unifier")

    def __init__(self, agent: AgentState, unifier: Unifier, intention: Intention | None) -> None:
        self.agent = agent
        self.unifier = unifier
        self.intention = intention

    def unify(self, one: object, other: object) -> Unifier | None:
        """Return a unifier that makes two terms equal, or None.

        An action can return the result as its answer.

        Parameters
        ----------
        one, other : object
            Terms, or Python numbers, strings and lists, which are converted to terms.

        Returns
        -------
        dict or None
            Unifier.
        """
        return unified(make_term(one), make_term(other), self.unifier)

    def each(self, variable: Term, values: Iterable[object]) -> Iterator[Unifier]:
        """Yield a unifier for each value with which `variable` unifies.

        An action with several answers can return the result. A plan uses the first, a query all.

        Parameters
        ----------
        variable : Term
            Term to unify.
        values : iterable of object
            Terms, or Python numbers, strings and lists, which are converted to terms.

        Yields
        ------
        dict
            Unifier.
        """
        for value in values:
            solution = self.unify(variable, value)
            if solution is not None:
                yield solution


class Waiting:
    """Return value of an internal action that has suspended the intention."""


WAITING = Waiting()

_ANSWERS = (bool, dict, Waiting, Iterator)


def call(
    agent: AgentState, action: Literal, u: Unifier, intention: Intention | None
) -> Answer | Waiting:
    """Return the answer of an internal action.

    Raises `ActionError` if the action fails, and `ValueError` if its function returns an invalid
    value.
    """
    internal = agent.actions.get(action.functor)
    if internal is None:
        raise ActionError(f"there is no internal action {action.functor}", "action_failed")
    internal.check(action.functor, len(action.args))
    args = tuple([substitute(arg, u) for arg in action.args])
    answer: Answer | Waiting = internal.function(Call(agent, u, intention), *args)
    if answer is None or isinstance(answer, _ANSWERS):
        return answer
    raise ValueError(
        f"the internal action {action.functor} returned {answer!r}, not True, False, None,"
        " a unifier or an iterator of unifiers"
    )


def call_in_query(agent: AgentState, action: Literal, u: Unifier) -> Answer:
    """Return the answer of an internal action in a context or query, or False if it fails."""
    try:
        answer = call(agent, action, u, None)
    except ActionError as error:
        agent.logic.failures += 1
        agent.warn(f"{action.functor}: {error}")
        return False
    return True if isinstance(answer, Waiting) else answer


Operation: TypeAlias = Callable[[AgentState, Intention, Means, BodyStep], None]


def _literal(
    agent: AgentState, intention: Intention, means: Means, step: BodyStep
) -> Literal | None:
    """Return the literal of a step. For other terms, fail the plan and return None."""
    literal = step.build(means.u)
    if isinstance(literal, Literal):
        return literal
    _not_a_literal(agent, intention, means, step)
    return None


def _not_a_literal(agent: AgentState, intention: Intention, means: Means, step: BodyStep) -> None:
    value = substitute(step.term, means.u)
    if isinstance(value, Var):
        message = f"{step.formula.place.line}: Variable '{value}' must be ground."
        fail(agent, intention, error_annots("body_var_without_value", message))
    else:
        message = f"Variable '{step.term}' must be a Literal and not '{text(value)}'"
        fail(agent, intention, error_annots("body_var_not_literal", message))


def _export(agent: AgentState, means: Means, literal: Literal) -> Literal:
    """Return the literal of an event, with fresh variables that the plan awaits."""
    renamed: dict[str, Var] = {}
    exported = rename(literal, agent.names, renamed)
    means.u.update(renamed)
    means.awaited = variable_names(exported)
    return exported


# ---- goals


def _achieve(agent: AgentState, intention: Intention, means: Means, step: BodyStep) -> None:
    goal = _literal(agent, intention, means, step)
    if goal is None:
        return
    if goal.ground:
        means.awaited = ()
    else:
        goal = _export(agent, means, goal)
    event = Event("+!", goal, intention)
    agent.circumstance.post(event)
    if goal.annots is not ONLY_SELF:
        _check_deadline(agent, event)


def _achieve_new(agent: AgentState, intention: Intention, means: Means, step: BodyStep) -> None:
    goal = _literal(agent, intention, means, step)
    if goal is None:
        return
    event = Event("+!", goal if goal.ground else rename(goal, agent.names, {}))
    agent.circumstance.post(event)
    if goal.annots is not ONLY_SELF:
        _check_deadline(agent, event)
    move_on(agent, intention, means)


def _check_deadline(agent: AgentState, event: Event) -> None:
    for annot in event.literal.annots:
        if isinstance(annot, Literal) and annot.functor == "hard_deadline" and annot.args:
            limit = annot.args[0]
            if isinstance(limit, float):
                set_deadline(agent, event, limit)


def _test(agent: AgentState, intention: Intention, means: Means, step: BodyStep) -> None:
    solution = step.check(agent.logic, means.u)
    if solution is not None:
        means.u = solution
        move_on(agent, intention, means)
        return
    formula = substitute(step.term, means.u)
    if isinstance(formula, Literal) and agent.plans.candidates("+?", formula):
        goal = _export(agent, means, with_source(formula))
        agent.circumstance.post(Event("+?", goal, intention))
        return
    message = f"Failed to test '{text(step.term)}'"
    fail(agent, intention, error_annots("test_goal_failed", message))


def _constrain(agent: AgentState, intention: Intention, means: Means, step: BodyStep) -> None:
    solution = step.check(agent.logic, means.u)
    if solution is None:
        place = step.formula.place
        where = f"{place.name}:{place.line}"
        message = f"Constraint {step.term} was not satisfied ({where}) un={_bindings(means.u)}"
        fail(agent, intention, error_annots("constraint_failed", message))
        return
    means.u = solution
    move_on(agent, intention, means)


def _bindings(u: Unifier) -> str:
    named = {name: substitute(Var(name), u) for name in u if not name.startswith("_")}
    return f"{{{', '.join(f'{name}={text(value)}' for name, value in named.items())}}}"


# ---- beliefs


def _add(agent: AgentState, intention: Intention, means: Means, step: BodyStep) -> None:
    changed = step.build(means.u)
    if isinstance(changed, Literal):
        _believe(agent, intention, means, step, changed)
    elif isinstance(changed, RuleTerm):
        agent.beliefs.add_rule(changed.rule, at_end=step.operation == "+>")
        move_on(agent, intention, means)
    else:
        _change_plan(agent, intention, means, step, changed)


def _change_plan(
    agent: AgentState, intention: Intention, means: Means, step: BodyStep, value: Term
) -> None:
    """Add or remove the plan that is the value of a variable."""
    action = plan_change(step.operation, value) if isinstance(value, PlanTerm) else None
    if action is None:
        _not_a_literal(agent, intention, means, step)
    else:
        _call(agent, intention, means, action)


def _believe(
    agent: AgentState, intention: Intention, means: Means, step: BodyStep, literal: Literal
) -> None:
    """Add a belief at the front or the end (`+>`). After `++b` the plan does not wait."""
    if literal.ground:
        means.awaited = ()
    else:
        literal = _export(agent, means, literal)
    added = agent.beliefs.add(literal, at_end=step.operation == "+>")
    _post(agent, intention, means, "+", added, waits=step.operation != "++")


def _post(
    agent: AgentState,
    intention: Intention,
    means: Means,
    sign: str,
    changed: Literal | None,
    *,
    waits: bool,
) -> None:
    """Raise the event of a change of belief, and continue unless the plan waits for it."""
    focus = intention if waits else None
    if changed is None or not agent.changed(sign, changed, focus) or not waits:
        move_on(agent, intention, means)


def _delete(agent: AgentState, intention: Intention, means: Means, step: BodyStep) -> None:
    """Remove a belief or a rule. After `--b` the plan does not wait."""
    changed = step.build(means.u)
    if isinstance(changed, RuleTerm):
        agent.beliefs.remove_rule(changed.rule)
        move_on(agent, intention, means)
        return
    if not isinstance(changed, Literal):
        _change_plan(agent, intention, means, step, changed)
        return
    means.awaited = ()
    removed = agent.beliefs.remove(changed, means.u)
    _post(agent, intention, means, "-", removed, waits=step.operation != "--")


def _replace(agent: AgentState, intention: Intention, means: Means, step: BodyStep) -> None:
    """Replace the first belief of the same key and source (`-+b(X)`)."""
    literal = _literal(agent, intention, means, step)
    if literal is None:
        return
    removed = agent.beliefs.swap(literal) if literal.ground else None
    if removed is not None:
        means.awaited = ()
        if not agent.swapped(removed, literal, intention):
            move_on(agent, intention, means)
        return
    removed = agent.beliefs.remove_first(literal.key, literal.annots)
    if removed is not None:
        agent.changed("-", removed, None)
    _believe(agent, intention, means, step, literal)


# ---- actions


def _act_externally(agent: AgentState, intention: Intention, means: Means, step: BodyStep) -> None:
    _perform(agent, intention, step.build(means.u))  # type: ignore[arg-type]


def _perform(agent: AgentState, intention: Intention, action: Literal) -> None:
    """Call an external action. The intention waits for the outcome."""
    circumstance = agent.circumstance
    pending = PendingAction(agent.next_action_number(), action, intention)
    circumstance.expect(pending)
    if agent.is_observed:
        agent.note("action", action, intention)
    outcome = True if agent.act is None else agent.act(action)
    if isinstance(outcome, Pending):
        return
    if outcome and not circumstance.feedback and circumstance.states is None and agent.is_quiet:
        # The next cycle would handle this outcome first.
        if circumstance.take_action(intention) is pending:
            move_on(agent, intention, intention.stack[-1])
        return
    result = outcome if isinstance(outcome, Refused) else bool(outcome)
    circumstance.feedback.append((pending, result))


def _act_internally(agent: AgentState, intention: Intention, means: Means, step: BodyStep) -> None:
    _call(agent, intention, means, step.term)  # type: ignore[arg-type]


def _do_value(agent: AgentState, intention: Intention, means: Means, step: BodyStep) -> None:
    """Carry out the value of a variable."""
    value = step.build(means.u)
    if isinstance(value, BodyTerm):
        means.step = compile_body(value.body, step.next)
        agent.circumstance.add_running(intention)
    elif isinstance(value, Relation):
        solution = condition(value)(agent.logic, means.u)
        if solution is None:
            message = f"Constraint {value} was not satisfied"
            fail(agent, intention, error_annots("constraint_failed", message))
            return
        means.u = solution
        move_on(agent, intention, means)
    elif isinstance(value, Literal) and value.is_internal_action:
        _call(agent, intention, means, value)
    elif isinstance(value, Literal):
        _perform(agent, intention, value)
    else:
        _not_a_literal(agent, intention, means, step)


def _call(agent: AgentState, intention: Intention, means: Means, action: Literal) -> None:
    try:
        answer = call(agent, action, means.u, intention)
        if answer is not None and not isinstance(answer, bool | dict | Waiting):
            # A step uses only the first answer.
            answer = next(answer, None)
    except ActionError as error:
        fail(agent, intention, error.annots)
        return
    if isinstance(answer, Waiting):
        return
    if answer is None or answer is False:
        fail(agent, intention, error_annots("ia_failed", ""))
        return
    if isinstance(answer, dict):
        means.u = dict(answer)
    # An action that ends a goal of its own intention has removed this plan.
    move_on(agent, intention, intention.top if intention.stack else means)


# ---- control


def _choose(agent: AgentState, intention: Intention, means: Means, step: BodyStep) -> None:
    solution = step.check(agent.logic, means.u)
    if solution is None:
        means.step = step.branches[1]
    else:
        means.u = solution
        means.step = step.branches[0]
    agent.circumstance.add_running(intention)


def _begin_while(agent: AgentState, intention: Intention, means: Means, step: BodyStep) -> None:
    # The state of loops is in the plan, because other intentions run between rounds.
    means.loops = (*means.loops, (means.u, iter(())))
    _repeat_while(agent, intention, means, step)


def _repeat_while(agent: AgentState, intention: Intention, means: Means, step: BodyStep) -> None:
    # The bindings of a round end with it, so the condition uses those from before the loop.
    before, _ = means.loops[-1]
    _iterate(agent, intention, means, step, step.check(agent.logic, before))


def _begin_for(agent: AgentState, intention: Intention, means: Means, step: BodyStep) -> None:
    # All solutions are computed first, because the body may change beliefs.
    solutions = list(agent.logic.solutions(step.term, means.u))
    if not solutions:
        move_on(agent, intention, means)
        return
    means.loops = (*means.loops, (means.u, iter(solutions)))
    _repeat_for(agent, intention, means, step)


def _repeat_for(agent: AgentState, intention: Intention, means: Means, step: BodyStep) -> None:
    _, solutions = means.loops[-1]
    _iterate(agent, intention, means, step, next(solutions, None))


def _iterate(
    agent: AgentState, intention: Intention, means: Means, step: BodyStep, solution: Unifier | None
) -> None:
    """Begin the next round of a loop, or continue with the bindings from before the loop."""
    if solution is None:
        *outer, (means.u, _) = means.loops
        means.loops = tuple(outer)
        means.step = step.next
    else:
        means.u = dict(solution)
        means.step = step.branches[0]
    agent.circumstance.add_running(intention)


def _fork(agent: AgentState, intention: Intention, means: Means, step: BodyStep) -> None:
    fork = IntentionFork(step.operation == "|&|", intention)
    for beginning in step.branches:
        branch = intention.branch(agent.next_intention_number(), fork)
        branch.top.step = beginning
        fork.add(branch)
        agent.circumstance.add_running(branch)
    fork.take_place()
    agent.circumstance.forget(intention)


def _join(agent: AgentState, intention: Intention, means: Means, step: BodyStep) -> None:
    fork = intention.fork
    if fork is not None:
        fork.to_finish -= 1
        if fork.all_of and fork.to_finish > 0:
            fork.remove(intention)
            agent.circumstance.forget(intention)
            return
        end_fork(agent, intention)
    move_on(agent, intention, means)


OPERATIONS: Mapping[str, Operation] = MappingProxyType(
    {
        "!": _achieve,
        "!!": _achieve_new,
        "?": _test,
        "constraint": _constrain,
        "+": _add,
        "+<": _add,
        "+>": _add,
        "++": _add,
        "-": _delete,
        "--": _delete,
        "-+": _replace,
        "external action": _act_externally,
        "internal action": _act_internally,
        "variable": _do_value,
        "if": _choose,
        "while": _begin_while,
        "while again": _repeat_while,
        "for": _begin_for,
        "for again": _repeat_for,
        "|&|": _fork,
        "|||": _fork,
        "join": _join,
    }
)
