"""Registry of the standard internal actions, and checks of their arguments."""

from __future__ import annotations

from ..actions import ActionError, InternalActions
from ..errors import ProgramError
from ..language.body import BodyTerm
from ..language.loading import parse_trigger
from ..language.operations import TriggerTerm
from ..language.terms import Cons, Literal, Nil, Term, Var, text

STANDARD = InternalActions()


def wrong(name: str, reason: str) -> ActionError:
    """Return the error of an invalid argument."""
    return ActionError(f"Wrong argument for internal action '{name}': {reason}", "wrong_arguments")


def a_list(name: str, term: Term, which: str) -> Nil | Cons:
    """Return a list. Raises `ActionError` for other terms."""
    if isinstance(term, Nil | Cons):
        return term
    raise wrong(name, f"{which} argument must be a list and not '{text(term)}'.")


def a_number(name: str, term: Term, which: str) -> float:
    """Return a number. Raises `ActionError` for other terms."""
    if isinstance(term, float):
        return term
    raise wrong(name, f"{which} parameter ('{text(term)}') must be a number!")


def a_literal(name: str, term: Term) -> Literal:
    """Return a literal. Raises `ActionError` for other terms."""
    if isinstance(term, Literal):
        return term
    raise wrong(name, "first argument must be a literal")


def a_goal(name: str, term: Term) -> Literal | Var:
    """Return a literal or an unbound variable. Raises `ActionError` for other terms."""
    if isinstance(term, Literal | Var):
        return term
    raise wrong(name, f"first argument '{text(term)}' must be a literal or variable")


def a_trigger(term: Term) -> TriggerTerm | None:
    """Return the event in a term or a string, such as `{+b}`, or None."""
    if isinstance(term, TriggerTerm):
        return term
    if isinstance(term, BodyTerm):
        return term.as_trigger
    if isinstance(term, str):
        try:
            return parse_trigger(term)
        except ProgramError as error:
            raise ActionError(str(error), "wrong_arguments") from None
    return None
