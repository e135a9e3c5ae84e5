"""Actions on strings."""

from __future__ import annotations

import re
from collections.abc import Iterator

from ..errors import ProgramError
from ..language.terms import Term, Var, make_list, plain_text, text
from ..language.texts import parse_term
from ..reasoning.actions import ActionError
from ..reasoning.calls import Call
from .arguments import wrong
from .registry import STANDARD


@STANDARD.add(".substring", least=2, most=4)
def substring(call: Call, part: Term, whole: Term, *position: Term) -> object:
    """`.substring(Part, Whole)`, with its begin and end, place by place, in further arguments."""
    small, big = plain_text(part), plain_text(whole)
    if not position:
        return small in big
    if isinstance(position[0], float) and isinstance(whole, Var):
        return _piece(call, whole, small, position)
    if isinstance(position[0], float) and isinstance(part, Var):
        return _piece(call, part, big, position)
    return call.each(make_list(position), _places(small, big, len(position)))


def _piece(call: Call, piece: Var, whole: str, position: tuple[Term, ...]) -> object:
    """Unify with the characters from one position up to another, or to the end."""
    numbers = [int(number) for number in position if isinstance(number, float)]
    begin, end = numbers[0], numbers[1] if len(numbers) > 1 else len(whole)
    if not 0 <= begin <= end <= len(whole):
        raise ActionError(f"begin {begin}, end {end}, length {len(whole)}")
    return call.unify(piece, whole[begin:end])


def _places(small: str, big: str, count: int) -> Iterator[list[float]]:
    """Yield where a part begins and, if asked for, its last character."""
    start = big.find(small)
    while 0 <= start < len(big):
        yield [float(start), float(start + len(small) - 1)][:count]
        start = big.find(small, start + 1)


@STANDARD.add(".replace", least=4, most=4)
def replace(call: Call, whole: Term, pattern: Term, by: Term, result: Term) -> object:
    """Replace the matches of a regular expression."""
    if not isinstance(pattern, str) or not isinstance(by, str):
        raise wrong("replace", "second and third argument must be strings")
    try:
        replaced = re.sub(pattern, lambda found: found.expand(_groups(by)), plain_text(whole))
    except re.error as error:
        raise wrong("replace", f"'{pattern}' is no regular expression: {error}") from None
    return call.unify(result, replaced)


def _groups(replacement: str) -> str:
    """Return a replacement with Python's `\\1` for Java's `$1`."""
    return re.sub(r"\$(\d)", r"\\\1", replacement)


@STANDARD.add(".term2string", least=2, most=2)
def term2string(call: Call, term: Term, string: Term) -> object:
    """`.term2string(T, S)`: the text of a term, or the term that a text stands for."""
    if not isinstance(term, Var):
        if isinstance(string, str):
            return text(term) == string
        if isinstance(string, Var):
            return call.unify(string, text(term))
    elif isinstance(string, str):
        try:
            return call.unify(term, parse_term(string))
        except ProgramError as error:
            raise ActionError(str(error)) from None
    raise ActionError("invalid case of term2string")


@STANDARD.add(".upper_case", least=2, most=2)
def upper_case(call: Call, word: Term, result: Term) -> object:
    """`.upper_case(S, R)`: a text in capitals."""
    return call.unify(result, plain_text(word).upper())


@STANDARD.add(".lower_case", least=2, most=2)
def lower_case(call: Call, word: Term, result: Term) -> object:
    """`.lower_case(S, R)`: a text in small letters."""
    return call.unify(result, plain_text(word).lower())
