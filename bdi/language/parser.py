"""From a text to its clauses.

The grammar is that of one clause, so that a mistake ends with the clause it is in: all wrong
clauses of a program are reported at once, each with its place.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import lru_cache
from types import MappingProxyType
from typing import Any

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedInput, UnexpectedToken, VisitError

from ..errors import Problem, ProgramError, TooDeepError
from .builder import Builder, RefusedError, stray_message
from .facts import plain_fact
from .program import Clause, Plan
from .tokens import clauses, grammar, is_block, nesting, tokenize

_NAMES = {
    "ATOM": "a name",
    "VAR": "a variable",
    "ANONYMOUS": "'_'",
    "NUMBER": "a number",
    "STRING": "a string",
    "RELATION": "a comparison",
    "UPDATE": "'+' or '-'",
}

_BEGIN_A_LITERAL = frozenset({"ATOM", "VAR", "ANONYMOUS", "TILDE", "TRUE", "FALSE"})
_BEGIN_A_TERM = frozenset({"NUMBER", "STRING", "LPAR", "LSQB", "LBRACE", "PLUS", "MINUS", "NOT"})
_KINDS = (
    ("a term", _BEGIN_A_LITERAL | {"NUMBER", "LPAR"}),
    ("a literal", _BEGIN_A_LITERAL),
)

_UNNAMED = frozenset({"$END", "STRAY", "_NAMESPACE", "GOAL_STATE"})
"""Tokens that no list of what is expected names."""

_OPERATORS = frozenset({"'*'", "'**'", "'+'", "'-'", "'/'", "'div'", "'mod'"})

MOST_NESTED = MappingProxyType({"{}": 60, "(){}[]": 250})
"""Largest nesting of each set of brackets; a branch after `elif` is one level."""

#: Value of the full stop that is put after a part of a clause.
_END = "the end"


# ---- reading clauses


def parse_clause(tokens: Sequence[Token], file: str) -> Any:
    """Return the clause of the tokens; raise an error of lark's, or TooDeepError."""
    for brackets, most in MOST_NESTED.items():
        if len(tokens) > most and nesting(tokens, brackets) > most:
            raise TooDeepError(f"brackets within brackets, more than {most} deep")
    parser = grammar().parse_interactive()
    for token in tokens:
        parser.feed_token(token)
    tree: Tree[Token] = parser.feed_eof(tokens[-1] if tokens else None)
    return Builder(file).transform(tree)


def _problem(error: Exception, tokens: Sequence[Token], file: str) -> Problem:
    """Return the problem for which a clause could not be read."""
    if isinstance(error, VisitError) and isinstance(error.orig_exc, RefusedError):
        refused = error.orig_exc
        return Problem(file, refused.line, refused.column, str(refused))
    if isinstance(error, VisitError):
        # A term over the limits of size and depth.
        error = TooDeepError(str(error.orig_exc))
    if isinstance(error, RecursionError | TooDeepError):
        what = "too deeply nested" if isinstance(error, RecursionError) else str(error)
        return Problem(file, tokens[0].line or 0, tokens[0].column or 0, what)
    if isinstance(error, UnexpectedToken):
        token = error.token
        line, column = token.line or 0, token.column or 0
        stray = next((t for t in tokens if t.type == "STRAY"), None)
        if stray is not None and (stray.line, stray.column) <= (line, column):
            return Problem(file, stray.line or 0, stray.column or 0, stray_message(stray))
        found = f"'{token}'"
        if token.type == "$END" or token == _END:
            last = tokens[-1] if token.type == "$END" or len(tokens) < 2 else tokens[-2]
            found, line, column = "the end", last.end_line or 0, last.end_column or 0
        expected = _expected(_acceptable(tokens, error.token))
        return Problem(file, line, column, f"found {found}, expected {expected}")
    raise error


def _acceptable(tokens: Sequence[Token], wrong: Token) -> Collection[str]:
    """Return the types of tokens that the grammar accepts in place of a wrong one."""
    parser = grammar().parse_interactive()
    for token in tokens:
        if token is wrong:
            break
        parser.feed_token(token)
    accepts: Collection[str] = parser.accepts()
    return accepts


def _expected(names: Collection[str]) -> str:
    """Return a list of token types in words."""
    parser: Lark = grammar()
    left = set(names) - _UNNAMED
    words = []
    for word, begins in _KINDS:
        if begins <= left:
            words.append(word)
            left -= begins | _BEGIN_A_LITERAL | _BEGIN_A_TERM
    words += sorted(_NAMES.get(name, "") for name in left & _NAMES.keys())
    signs = {f"'{parser.get_terminal(name).pattern.value}'" for name in left - _NAMES.keys()}
    if signs >= _OPERATORS:
        words.append("an operator")
        signs -= _OPERATORS
    words += sorted(signs)
    if len(words) < 2:
        return "".join(words) or "nothing more"
    return f"{', '.join(words[:-1])} or {words[-1]}"


REMEMBERED = 50_000
"""Longest text (characters) whose clauses are cached: many people share a few programs."""


def read_clauses(source: str, file: str) -> tuple[tuple[Clause, ...], tuple[Problem, ...]]:
    """Return the clauses of a text, in order, and the problems of those that cannot be read."""
    read = _remembered_clauses if len(source) <= REMEMBERED else _read_clauses
    return read(source, file)


def _read_clauses(source: str, file: str) -> tuple[tuple[Clause, ...], tuple[Problem, ...]]:
    found: list[Clause] = []
    problems: list[Problem] = []
    for tokens in clauses(tokenize(source)):
        try:
            if is_block(tokens) and found and isinstance(found[-1], Plan):
                found[-1] = replace(found[-1], subplans=_subplans(tokens, file, problems))
            else:
                found.append(plain_fact(tokens, file) or parse_clause(tokens, file))
        except (UnexpectedInput, VisitError, RecursionError, TooDeepError) as error:
            problems.append(_problem(error, tokens, file))
    return tuple(found), tuple(problems)


def _subplans(tokens: Sequence[Token], file: str, problems: list[Problem]) -> tuple[Plan, ...]:
    """Return the plans in the braces after a plan, and append what is wrong with them."""
    inner = tokens[1:-1] if tokens[-1].type == "RBRACE" else tokens[1:]
    plans: list[Plan] = []
    if tokens[-1].type != "RBRACE":
        problems.append(Problem(file, tokens[0].line or 0, tokens[0].column or 0, _NOT_CLOSED))
    for clause in clauses(iter(inner)):
        try:
            if is_block(clause) and plans:
                nested = _subplans(clause, file, problems)
                plans[-1] = replace(plans[-1], subplans=nested)
                continue
            plan = parse_clause(clause, file)
            if isinstance(plan, Plan):
                plans.append(plan)
            else:
                place = Problem(file, clause[0].line or 0, clause[0].column or 0, _NO_PLAN)
                problems.append(place)
        except (UnexpectedInput, VisitError, RecursionError, TooDeepError) as error:
            problems.append(_problem(error, clause, file))
    return tuple(plans)


_NOT_CLOSED = "the braces around the plans inside a plan are not closed"
_NO_PLAN = "inside a plan there are plans only"


_remembered_clauses = lru_cache(maxsize=64)(_read_clauses)


def parse_part(source: str, before: str = "") -> Any:
    """Return the clause of `before`, a part of a clause, and a full stop.

    Raises:
        ProgramError: they make no clause.
    """
    first = list(tokenize(before)) if before else []
    previous = str(first[-1]) if first else ""
    tokens = [*first, *tokenize(source, previous), Token("DOT", _END)]
    try:
        return parse_clause(tokens, source)
    except (UnexpectedInput, VisitError, RecursionError, TooDeepError) as error:
        raise ProgramError([_problem(error, tokens, source)]) from None
