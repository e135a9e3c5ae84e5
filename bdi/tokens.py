"""Tokens of a program, and where its clauses end."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from importlib.resources import files

from lark import Lark, Token

#: What a trigger or a body formula may follow; a sign after one of these is an UPDATE.
_BEFORE_A_STEP = frozenset({"<-", ";", "{", "}", "|||", "|&|"})
_UPDATES = frozenset({"++", "+<", "+>", "--", "-+"})


@cache
def grammar() -> Lark:
    """The parser of one clause. It is made once, of the grammar beside this file."""
    source = files(__package__).joinpath("agentspeak.lark").read_text(encoding="utf-8")
    return Lark(source, start="clause", parser="lalr", lexer="basic", propagate_positions=True)


def tokenize(source: str, previous: str = "") -> Iterator[Token]:
    """The tokens of a text; characters that belong to none become STRAY tokens.

    `previous` is the token before the text, where it is not the beginning.
    """
    reading = grammar().parse_interactive(source)
    tokens = reading.lexer_thread.lex(reading.parser_state)  # type: ignore[no-untyped-call]
    return _with_updates(tokens, previous)


def _with_updates(tokens: Iterator[Token], previous: str) -> Iterator[Token]:
    """Joins the signs that begin a trigger or a body formula to one UPDATE token."""
    in_label = False
    depth = 0
    following = next(tokens, None)
    while following is not None:
        token, following = following, next(tokens, None)
        if token.value == "@" and token.type != "STRING":
            in_label, depth = True, 0
        depth += {"[": 1, "]": -1}.get(token.value, 0)
        begins_step = previous == "" or previous in _BEFORE_A_STEP or (in_label and depth == 0)
        if token.type in ("PLUS", "MINUS") and begins_step:
            both = token.value + (following.value if following is not None else "")
            if both in _UPDATES:
                following = next(tokens, None)
            else:
                both = token.value
            token = Token.new_borrow_pos("UPDATE", both, token)
            in_label = False
        yield token
        previous = "" if token.type == "DOT" else token.value


def clauses(tokens: Iterator[Token]) -> Iterator[list[Token]]:
    """The tokens of one clause after another; a wrong one ends at its full stop, too."""
    clause: list[Token] = []
    braces = 0
    for token in tokens:
        clause.append(token)
        if token.type == "LBRACE":
            braces += 1
        elif token.type == "RBRACE":
            braces -= 1
        is_directive = clause[0].type == "LBRACE"
        if token.type == "DOT" or (is_directive and braces == 0):
            yield clause
            clause, braces = [], 0
    if clause:
        yield clause


def nesting(tokens: Sequence[Token], brackets: str) -> int:
    """How many of these brackets stand within each other in a clause; `elif` opens one, too."""
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
