"""Calls of internal actions from plans, contexts and queries."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ..language.substitution import Unifier, substitute
from ..language.terms import Literal, Term, make_term
from ..language.unification import unified
from .actions import ActionError
from .intentions import Intention
from .logic import Answer
from .state import AgentState


class Call:
    """One use of an internal action.

    Attributes:
        agent: state of the agent: its beliefs, plans, circumstance and random numbers.
        unifier: bindings of the variables. It stays as it is: an action returns new unifiers.
        intention: the intention that calls, or None in a context or query.
    """

    __slots__ = ("agent", "intention", "unifier")

    def __init__(self, agent: AgentState, unifier: Unifier, intention: Intention | None) -> None:
        self.agent = agent
        self.unifier = unifier
        self.intention = intention

    def unify(self, one: object, other: object) -> Unifier | None:
        """Return a unifier with which the two are equal, or None: the answer of an action.

        Python numbers, strs and lists are made terms.
        """
        return unified(make_term(one), make_term(other), self.unifier)

    def each(self, variable: Term, values: Iterable[object]) -> Iterator[Unifier]:
        """Yield a unifier for each of the values with which `variable` unifies.

        It is the answer of an action that has several: a plan takes the first, a query tries all.
        Python numbers, strs and lists are made terms.
        """
        for value in values:
            solution = self.unify(variable, value)
            if solution is not None:
                yield solution


class Waiting:
    """Answer of an internal action that has suspended its intention."""


WAITING = Waiting()

_ANSWERS = (bool, dict, Waiting, Iterator)


def call(
    agent: AgentState, action: Literal, u: Unifier, intention: Intention | None
) -> Answer | Waiting:
    """Return the answer of an internal action.

    Raises:
        ActionError: the action fails.
        ValueError: its function returned something that is no answer.
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
    """Return the answer of an internal action in a context or query, False if it fails."""
    try:
        answer = call(agent, action, u, None)
    except ActionError as error:
        agent.logic.failures += 1
        agent.warn(f"{action.functor}: {error}")
        return False
    return True if isinstance(answer, Waiting) else answer
