"""Actions on strings."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from types import MappingProxyType

from ..errors import ProgramError
from ..failure import ActionError
from ..parser import parse_term
from ..terms import Term, Var, make_list, text
from .call import Call, InternalAction, plain, wrong


def substring(call: Call, part: Term, whole: Term, *position: Term) -> object:
    """Whether a text is in another; with a third argument also where, each place in turn."""
    small, big = plain(part), plain(whole)
    if not position:
        return small in big
    return call.each(make_list(position), _places(small, big, len(position)))


def _places(small: str, big: str, count: int) -> Iterator[list[float]]:
    start = big.find(small)
    while 0 <= start < len(big):
        yield [float(start), float(start + len(small))][:count]
        start = big.find(small, start + 1)


def replace(call: Call, whole: Term, pattern: Term, by: Term, result: Term) -> object:
    """Replaces what a regular expression matches."""
    if not isinstance(pattern, str) or not isinstance(by, str):
        raise wrong("replace", "second and third argument must be strings")
    try:
        replaced = re.sub(pattern, lambda found: found.expand(_groups(by)), plain(whole))
    except re.error as error:
        raise wrong("replace", f"'{pattern}' is no regular expression: {error}") from None
    return call.unify(result, replaced)


def _groups(replacement: str) -> str:
    """Java's `$1` as Python's `\\1`."""
    return re.sub(r"\$(\d)", r"\\\1", replacement)


def term2string(call: Call, term: Term, string: Term) -> object:
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


def upper_case(call: Call, word: Term, result: Term) -> object:
    return call.unify(result, plain(word).upper())


def lower_case(call: Call, word: Term, result: Term) -> object:
    return call.unify(result, plain(word).lower())


ACTIONS: Mapping[str, InternalAction] = MappingProxyType(
    {
        ".substring": InternalAction(substring, 2, 4),
        ".replace": InternalAction(replace, 4, 4),
        ".term2string": InternalAction(term2string, 2, 2),
        ".upper_case": InternalAction(upper_case, 2, 2),
        ".lower_case": InternalAction(lower_case, 2, 2),
    }
)
