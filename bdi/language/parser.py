"""Parser of AgentSpeak: tokens, clauses and syntax errors.

The grammar describes one clause, so that an error ends with its clause and all invalid clauses of a
program are reported together.
"""

from __future__ import annotations

import sys
from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from functools import cache, lru_cache
from importlib.util import cache_from_source
from itertools import islice
from pathlib import Path
from types import MappingProxyType
from typing import Any

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedInput, UnexpectedToken, VisitError

from ..errors import ProgramError, ProgramProblem, TooDeepError
from .body import Place
from .builder import Builder, ClauseError, stray_message
from .program import Clause, Plan

#: Tokens before a trigger or a body formula. A sign after one of these is an UPDATE.
_BEFORE_A_STEP = frozenset({"<-", ";", "{", "}", "|||", "|&|"})
_UPDATES = frozenset({"++", "+<", "+>", "--", "-+"})
#: Tokens after a step.
_AFTER_A_STEP = frozenset({";", ")", "}", "|||", "|&|", "."})
_AFTER_A_SIGNED_LITERAL = _AFTER_A_STEP | {":", "<-", "<:"}
_ENDS_A_TERM = frozenset({"RPAR", "RSQB", "ATOM", "VAR", "ANONYMOUS", "NUMBER", "STRING"})
_GOAL_SIGNS = frozenset({"!", "!!", "?"})
_OPENING = frozenset({"LPAR", "LSQB", "LBRACE"})
_CLOSING = frozenset({"RPAR", "RSQB", "RBRACE"})


@cache
def grammar() -> Lark:
    """Return the parser of one clause, created from the grammar beside this file.

    Its tables are cached beside the bytecode of this file, if Python caches that.
    """
    source = Path(__file__).with_name("agentspeak.lark").read_text(encoding="utf-8")
    cache = Path(cache_from_source(__file__)).with_name("agentspeak.tables")
    keep = cache.is_file() or (cache.parent.is_dir() and not sys.dont_write_bytecode)
    return Lark(
        source,
        start="clause",
        parser="lalr",
        lexer="basic",
        propagate_positions=True,
        cache=str(cache) if keep else False,
    )


def tokenize(source: str, previous: str = "") -> Iterator[Token]:
    """Return the tokens of a text. Invalid characters become STRAY tokens.

    `previous` is the token before the text, empty at the beginning.
    """
    reading = grammar().parse_interactive(source)
    tokens = reading.lexer_thread.lex(reading.parser_state)
    return _with_semicolons(_with_updates(list(tokens), previous))


def _with_semicolons(tokens: Iterator[Token]) -> Iterator[Token]:
    """Insert the optional semicolons before goals in bodies."""
    in_body, previous = False, ""
    for token in tokens:
        if token.type == "DOT":
            in_body = False
        in_body = in_body or token.type == "_ARROW"
        # After a term, a goal can only be the next step.
        if in_body and token.value in _GOAL_SIGNS and previous in _ENDS_A_TERM:
            yield Token.new_borrow_pos("SEMICOLON", ";", token)
        yield token
        previous = token.type


def _with_updates(tokens: Sequence[Token], previous: str) -> Iterator[Token]:
    """Join the signs at the start of a trigger or a body formula to one UPDATE token."""
    around_terms = _brackets_around_terms(tokens)
    begins_step = previous == "" or previous in _BEFORE_A_STEP
    in_label = False
    depth = 0
    numbered = enumerate(tokens)
    for index, token in numbered:
        if token.value == "@" and token.type != "STRING":
            in_label, depth = True, 0
        depth += {"[": 1, "]": -1}.get(token.value, 0)
        begins_step = begins_step or (in_label and depth == 0)
        if token.type in ("PLUS", "MINUS") and begins_step and not _is_compared(tokens, index):
            both = token.value + "".join(tokens[index + 1 : index + 2])
            if both in _UPDATES:
                next(numbered)
            else:
                both = token.value
            token = Token.new_borrow_pos("UPDATE", both, token)
            in_label = False
        yield token
        if token.type == "LPAR":
            begins_step = begins_step and index not in around_terms
        else:
            begins_step = token.type == "DOT" or token.value in _BEFORE_A_STEP


def _is_compared(tokens: Sequence[Token], index: int) -> bool:
    """Return whether the step that begins with the sign at `index` is a comparison, `-X < 3`."""
    depth = 0
    for token in islice(tokens, index + 1, None):
        # A step without a comparison is an update.
        if depth == 0 and token.value in _AFTER_A_SIGNED_LITERAL:
            return False
        if depth == 0 and token.type == "RELATION" and token is not tokens[index + 1]:
            return True
        depth += (token.type in _OPENING) - (token.type in _CLOSING)
    return False


def _brackets_around_terms(tokens: Sequence[Token]) -> set[int]:
    """Return the indices of the opening brackets that cannot enclose a group of steps.

    The token after the closing bracket distinguishes `(-X) < 3` from `(-b; a)`.
    """
    found: set[int] = set()
    opened: list[int] = []
    for index, token in enumerate(tokens):
        if token.type == "DOT":
            opened.clear()
        elif token.type == "LPAR":
            opened.append(index)
        elif token.type == "RPAR" and opened:
            begin = opened.pop()
            if index + 1 < len(tokens) and tokens[index + 1].value not in _AFTER_A_STEP:
                found.add(begin)
    return found


def clauses(tokens: Iterator[Token]) -> Iterator[list[Token]]:
    """Yield the tokens of each clause. Invalid clauses also end at a full stop.

    The subplans in braces after the full stop of a plan are one clause. Braces before the body, as
    in `+!g { <- a. +!h <- b. }`, are moved after it.
    """
    clause: list[Token] = []
    braces = 0
    for token in tokens:
        clause.append(token)
        if token.type == "LBRACE":
            braces += 1
        elif token.type == "RBRACE":
            braces -= 1
        if clause[0].type == "LBRACE":
            is_over = braces == 0 or (token.type == "DOT" and not is_block(clause))
        elif token.type in ("DOT", "RBRACE"):
            opens = _opening(clause) is not None
            is_over = braces == 0 if opens else token.type == "DOT"
        else:
            is_over = False
        if is_over:
            yield from _divided(clause)
            clause, braces = [], 0
    if clause:
        yield clause


def is_block(clause: Sequence[Token]) -> bool:
    """Return whether a clause consists of subplans, `{ +!g <- a. @l +h. }`."""
    begins = len(clause) > 1 and clause[0].type == "LBRACE"
    return begins and (clause[1].type in ("UPDATE", "GOAL_STATE") or clause[1].value == "@")


def _opening(clause: Sequence[Token]) -> int | None:
    """Return the index of the brace that opens a plan before its body."""
    if clause[0].type not in ("UPDATE", "GOAL_STATE") and clause[0].value != "@":
        return None
    depth = 0
    for index, token in enumerate(clause[:-1]):
        if token.type == "_ARROW" and depth == 0:
            return None
        if token.type == "LBRACE" and depth == 0 and clause[index - 1].type != "RELATION":
            following = clause[index + 1]
            is_plan = following.type in ("_ARROW", "UPDATE", "GOAL_STATE", "RBRACE")
            return index if is_plan or following.value == "@" else None
        depth += (token.type in _OPENING) - (token.type in _CLOSING)
    return None


def _divided(clause: list[Token]) -> Iterator[list[Token]]:
    """Yield a clause, or a plan and its subplans if their braces are before the body."""
    opening = _opening(clause)
    if opening is None:
        yield clause
        return
    head, inside = clause[:opening], clause[opening + 1 :]
    if inside and inside[0].type == "_ARROW":
        stop = next((i for i, token in enumerate(inside) if token.type == "DOT"), len(inside) - 1)
        head, inside = head + inside[: stop + 1], inside[stop + 1 :]
    else:
        head = [*head, Token.new_borrow_pos("DOT", ".", clause[opening])]
    yield head
    if len(inside) > 1:
        yield [clause[opening], *inside]


def nesting(tokens: Sequence[Token], brackets: str) -> int:
    """Return the nesting of these brackets in a clause. An `elif` is one level."""
    opening, closing = brackets[::2], brackets[1::2]
    deepest = depth = 0
    for token in tokens:
        if token.type == "STRING":
            continue
        if token.value in opening or token.type == "ELIF":
            depth += 1
            deepest = max(deepest, depth)
        elif token.value in closing:
            depth -= 1
    return deepest


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
"""Tokens that are not listed as expected."""

_OPERATORS = frozenset({"'*'", "'**'", "'+'", "'-'", "'/'", "'div'", "'mod'"})

MOST_NESTED = MappingProxyType({"{}": 60, "(){}[]": 250})
"""Maximum nesting of each set of brackets. A branch after `elif` is one level."""

#: Value of the full stop added after a part of a clause.
_END = "the end"


# ---- reading clauses


def parse_clause(tokens: Sequence[Token], file: str) -> Any:
    """Return the clause of the tokens. Raises an error of lark, or `TooDeepError`."""
    for brackets, most in MOST_NESTED.items():
        if len(tokens) > most and nesting(tokens, brackets) > most:
            raise TooDeepError(f"brackets nested more than {most} deep")
    parser = grammar().parse_interactive()
    for token in tokens:
        parser.feed_token(token)
    tree: Tree[Token] = parser.feed_eof(tokens[-1] if tokens else None)
    return Builder(file).transform(tree)


def _place(token: Token, file: str) -> Place:
    return Place(file, token.line or 0, token.column or 0)


def _problem(error: Exception, tokens: Sequence[Token], file: str) -> ProgramProblem:
    """Return the problem of an invalid clause."""
    if isinstance(error, VisitError) and isinstance(error.orig_exc, ClauseError):
        refused = error.orig_exc
        place = Place(file, refused.line, refused.column)
        return place.problem(str(refused))
    if isinstance(error, VisitError):
        error = TooDeepError(str(error.orig_exc))
    if isinstance(error, RecursionError | TooDeepError):
        what = "too deeply nested" if isinstance(error, RecursionError) else str(error)
        return _place(tokens[0], file).problem(what)
    if isinstance(error, UnexpectedToken):
        token = error.token
        line, column = token.line or 0, token.column or 0
        stray = next((t for t in tokens if t.type == "STRAY"), None)
        if stray is not None and (stray.line, stray.column) <= (line, column):
            return _place(stray, file).problem(stray_message(stray))
        found = f"'{token}'"
        if token.type == "$END" or token == _END:
            last = tokens[-1] if token.type == "$END" or len(tokens) < 2 else tokens[-2]
            found, line, column = "the end", last.end_line or 0, last.end_column or 0
        expected = _expected(_acceptable(tokens, error.token))
        return Place(file, line, column).problem(f"found {found}, expected {expected}")
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
"""Maximum length of texts whose clauses are cached, because people share programs."""


def read_clauses(source: str, file: str) -> tuple[tuple[Clause, ...], tuple[ProgramProblem, ...]]:
    """Return the clauses of a text in order, and the problems of invalid clauses."""
    read = _remembered_clauses if len(source) <= REMEMBERED else _read_clauses
    return read(source, file)


def _read_clauses(source: str, file: str) -> tuple[tuple[Clause, ...], tuple[ProgramProblem, ...]]:
    found: list[Clause] = []
    problems: list[ProgramProblem] = []
    for tokens in clauses(tokenize(source)):
        try:
            if is_block(tokens) and found and isinstance(found[-1], Plan):
                found[-1] = replace(found[-1], subplans=_subplans(tokens, file, problems))
            else:
                found.append(parse_clause(tokens, file))
        except (UnexpectedInput, VisitError, RecursionError, TooDeepError) as error:
            problems.append(_problem(error, tokens, file))
    return tuple(found), tuple(problems)


def _subplans(
    tokens: Sequence[Token], file: str, problems: list[ProgramProblem]
) -> tuple[Plan, ...]:
    """Return the plans in braces after a plan, and append their problems."""
    inner = tokens[1:-1] if tokens[-1].type == "RBRACE" else tokens[1:]
    plans: list[Plan] = []
    if tokens[-1].type != "RBRACE":
        problems.append(_place(tokens[0], file).problem(_NOT_CLOSED))
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
                problems.append(_place(clause[0], file).problem(_NO_PLAN))
        except (UnexpectedInput, VisitError, RecursionError, TooDeepError) as error:
            problems.append(_problem(error, clause, file))
    return tuple(plans)


_NOT_CLOSED = "the braces around subplans are not closed"
_NO_PLAN = "the braces of a plan may contain only plans"


_remembered_clauses = lru_cache(maxsize=64)(_read_clauses)


def parse_part(source: str, before: str = "") -> Any:
    """Return the clause that consists of `before`, a part of a clause, and a full stop.

    Raises `ProgramError` if this is not a clause.
    """
    first = list(tokenize(before)) if before else []
    previous = str(first[-1]) if first else ""
    tokens = [*first, *tokenize(source, previous), Token("DOT", _END)]
    try:
        return parse_clause(tokens, source)
    except (UnexpectedInput, VisitError, RecursionError, TooDeepError) as error:
        raise ProgramError([_problem(error, tokens, source)]) from None
