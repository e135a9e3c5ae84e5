"""Facts of names, numbers and strings alone, read without the parser.

A program has a handful of plans but may have tens of thousands of facts. One pass over the tokens
of a plain fact takes a small part of the time of the parser.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from lark import Token

from .arithmetic import is_function
from .body import Place
from .builder import string_value
from .program import Belief
from .terms import Literal, Term


def plain_fact(tokens: Sequence[Token], file: str) -> Belief | None:
    """Return the belief in the tokens of a fact like `at(robot1, -3.5, "dock").`, else None."""
    head = tokens[0]
    if head.type != "ATOM" or len(tokens) < 5 or tokens[1].type != "LPAR" or "." in head:
        return None
    if tokens[-2].type != "RPAR" or tokens[-1].type != "DOT":
        return None
    args: list[Term] = []
    last = len(tokens) - 2
    position = 2
    while position < last:
        token = tokens[position]
        kind = token.type
        is_negative = kind == "MINUS"
        if is_negative:
            position += 1
            token = tokens[position]
            kind = token.type
        if kind == "NUMBER":
            value = float(token)
            if math.isinf(value):
                return None
            args.append(-value if is_negative else value)
        elif is_negative:
            return None
        elif kind == "ATOM" and "." not in token:
            args.append(Literal(str(token)))
        elif kind == "STRING":
            args.append(string_value(token))
        else:
            return None
        position += 1
        if tokens[position].type != "COMMA" and position != last:
            return None
        position += 1
    if position != last + 1 or is_function(head, len(args)):
        return None
    return Belief(Literal(str(head), tuple(args)), Place(file, head.line or 0, head.column or 0))
