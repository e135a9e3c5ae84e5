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
from .terms import Literal, Term, atom


def plain_fact(tokens: Sequence[Token], file: str) -> Belief | None:
    """Return the belief in the tokens of a fact like `at(robot1, -3.5, "dock").`, else None."""
    head = tokens[0]
    if head.type != "ATOM" or len(tokens) < 5 or tokens[1].type != "LPAR" or "." in head:
        return None
    if tokens[-2].type != "RPAR" or tokens[-1].type != "DOT":
        return None
    args: list[Term] = []
    rest = iter(tokens[2:-2])
    for token in rest:
        if token.type == "ATOM" and "." not in token:
            args.append(atom(str(token)))
        elif token.type == "STRING":
            args.append(string_value(token))
        else:
            number = next(rest, token) if token.type == "MINUS" else token
            if number.type != "NUMBER" or math.isinf(value := float(number)):
                return None
            args.append(value if number is token else -value)
        following = next(rest, None)
        if following is None:
            break
        if following.type != "COMMA":
            return None
    else:
        return None  # no argument, or a comma after the last
    if is_function(head, len(args)):
        return None
    return Belief(Literal(str(head), tuple(args)), Place(file, head.line or 0, head.column or 0))
