"""Programs, and parts of them, from texts.

The parser, and lark with it, is loaded with the first text that is read: programs in the package
are kept as they were read, and people who run these need none.
"""

from __future__ import annotations

from typing import Any

from ..errors import Problem, ProgramError
from .program import Belief, Clause, Plan, Rule
from .terms import Literal, Term, TriggerTerm


def read_clauses(source: str, file: str) -> tuple[tuple[Clause, ...], tuple[Problem, ...]]:
    """Return the clauses of a text, in order, and the problems of those that cannot be read."""
    from . import parser

    return parser.read_clauses(source, file)


def _parse_part(source: str, before: str = "") -> Any:
    from . import parser

    return parser.parse_part(source, before)


def _wrong_part(source: str, expected: str) -> ProgramError:
    return ProgramError([Problem(source, 0, 0, f"{expected} is expected")])


def parse_literal(source: str) -> Literal:
    """Return the belief, goal or percept in `source`, as `gantry_detected(3)[source(percept)]`.

    Raises:
        ProgramError: `source` is not one literal.
    """
    clause = _parse_part(source)
    if isinstance(clause, Belief):
        return clause.belief
    raise _wrong_part(source, "a literal")


def parse_term(source: str) -> Term:
    """Return the term or formula in `source`.

    Raises:
        ProgramError: `source` is not one term.
    """
    clause = _parse_part(source, "term :- ")
    if isinstance(clause, Rule):
        return clause.body
    raise _wrong_part(source, "a term")


def parse_trigger(source: str) -> TriggerTerm:
    """Return the event in `source`, as `+work_completed(_)`."""
    clause = _parse_part(source)
    if isinstance(clause, Plan):
        return TriggerTerm(clause.trigger.sort, clause.trigger.literal)
    raise _wrong_part(source, "an event, as +b or +!g,")


def parse_plan(source: str) -> Plan:
    """Return the plan in `source`, with or without its full stop."""
    whole = source.rstrip()
    clause = _parse_part(whole[:-1] if whole.endswith(".") else whole)
    if isinstance(clause, Plan):
        return clause
    raise _wrong_part(source, "a plan")
