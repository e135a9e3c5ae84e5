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
    """Return the error of an action that got a wrong argument."""
    return ActionError(f"Wrong argument for internal action '{name}': {reason}", "wrong_arguments")


def a_list(name: str, term: Term, which: str) -> Nil | Cons:
    """Return a list; raise the error of a wrong argument for anything else."""
    if isinstance(term, Nil | Cons):
        return term
    raise wrong(name, f"{which} argument must be a list and not '{text(term)}'.")


def a_number(name: str, term: Term, which: str) -> float:
    """Return a number; raise the error of a wrong argument for anything else."""
    if isinstance(term, float):
        return term
    raise wrong(name, f"{which} parameter ('{text(term)}') must be a number!")


def a_literal(name: str, term: Term) -> Literal:
    """Return a literal; raise the error of a wrong argument for anything else."""
    if isinstance(term, Literal):
        return term
    raise wrong(name, "first argument must be a literal")


def a_goal(name: str, term: Term) -> Literal | Var:
    """Return a literal or an unbound variable; raise the error of a wrong argument otherwise."""
    if isinstance(term, Literal | Var):
        return term
    raise wrong(name, f"first argument '{text(term)}' must be a literal or variable")


def a_trigger(term: Term) -> TriggerTerm | None:
    """Return the event in a term, `{+b}` or the same in a string; None if it is none."""
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
