"""Internal actions on strings, printing, and ending the program."""

from __future__ import annotations

import re
from collections.abc import Iterator

from ..actions import ActionError
from ..errors import ProgramError
from ..language.loading import parse_term
from ..language.substitution import substitute
from ..language.terms import Literal, Term, Var, make_list, plain_text, text
from ..reasoning.execution import WAITING, Call, Waiting
from .registry import STANDARD, wrong


@STANDARD.add(".substring", least=2, most=4)
def substring(call: Call, part: Term, whole: Term, *position: Term) -> object:
    """`.substring(Part, Whole, Begin?, End?)`: an answer for each occurrence."""
    small, big = plain_text(part), plain_text(whole)
    if not position:
        return small in big
    if isinstance(position[0], float) and isinstance(whole, Var):
        return _piece(call, whole, small, position)
    if isinstance(position[0], float) and isinstance(part, Var):
        return _piece(call, part, big, position)
    return call.each(make_list(position), _places(small, big, len(position)))


def _piece(call: Call, piece: Var, whole: str, position: tuple[Term, ...]) -> object:
    """Unify with the characters between two positions, or up to the end."""
    numbers = [int(number) for number in position if isinstance(number, float)]
    begin, end = numbers[0], numbers[1] if len(numbers) > 1 else len(whole)
    if not 0 <= begin <= end <= len(whole):
        raise ActionError(f"begin {begin}, end {end}, length {len(whole)}")
    return call.unify(piece, whole[begin:end])


def _places(small: str, big: str, count: int) -> Iterator[list[float]]:
    """Yield the begin of each occurrence and, if requested, its last character."""
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
        raise wrong("replace", f"'{pattern}' is not a regular expression: {error}") from None
    return call.unify(result, replaced)


def _groups(replacement: str) -> str:
    r"""Return a replacement with Python's `\1` for Java's `$1`."""
    return re.sub(r"\$(\d)", r"\\\1", replacement)


@STANDARD.add(".term2string", least=2, most=2)
def term2string(call: Call, term: Term, string: Term) -> object:
    """`.term2string(T, S)`: the text of a term, or the term in a text."""
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
    """`.upper_case(S, R)`: a text in upper case."""
    return call.unify(result, plain_text(word).upper())


@STANDARD.add(".lower_case", least=2, most=2)
def lower_case(call: Call, word: Term, result: Term) -> object:
    """`.lower_case(S, R)`: a text in lower case."""
    return call.unify(result, plain_text(word).lower())


VERSION = "3.3.2"
"""Version of Jason with this language."""


def _line(terms: tuple[Term, ...]) -> str:
    return "".join(f"{t}<no-value>" if isinstance(t, Var) else plain_text(t) for t in terms)


@STANDARD.add(".print")
@STANDARD.add(".println")
def print_line(call: Call, *terms: Term) -> bool:
    """`.print(…)`: print the terms on one line."""
    call.agent.say(_line(terms))
    return True


@STANDARD.add(".log", least=1)
def log(call: Call, level: Term, *terms: Term) -> bool:
    """`.log(Level, …)`: print, warn or record the terms, depending on the level."""
    name = level.functor if isinstance(level, Literal) else ""
    if name in ("warning", "severe"):
        call.agent.warn(_line(terms), call.intention)
    elif name in ("fine", "finer", "finest"):
        call.agent.note("log", _line(terms), call.intention)
    else:
        call.agent.say(_line(terms))
    return True


_NAMED = re.compile(r"#\{([A-Za-z0-9_]+)\}")
_FORMAT = re.compile(r"%([-+ 0,#]*)(\d*)(?:\.(\d+))?([sdfeEgxXcbn%])")


@STANDARD.add(".puts", least=1, most=2)
def puts(call: Call, template: Term, *result: Term) -> object:
    """Print a text with values in place of `#{X}`, or unify with it."""
    if not isinstance(template, str):
        raise wrong("puts", "first argument must be a string")

    def value(match: re.Match[str]) -> str:
        try:
            return plain_text(substitute(parse_term(match[1]), call.unifier))
        except ProgramError:
            return match[0]

    parts = [template, *(term for term in result if isinstance(term, str))]
    whole = "".join(_NAMED.sub(value, part) for part in parts)
    if result and isinstance(result[-1], Var):
        return call.unify(whole, result[-1])
    call.agent.say(whole)
    return True


@STANDARD.add(".printf", least=1)
def printf(call: Call, template: Term, *terms: Term) -> bool:
    """Print a text with formats such as `%s`, `%d` and `%.2f`."""
    if not isinstance(template, str):
        raise wrong("printf", "first argument must be a string (the format)")
    left = list(terms)

    def formatted(match: re.Match[str]) -> str:
        flags, width, digits, kind = match.groups()
        if kind in "n%":
            return "\n" if kind == "n" else "%"
        if not left:
            raise ActionError(f"Format specifier '{match[0]}'")
        term = left.pop(0)
        precision = "" if digits is None else f".{digits}"
        if kind in "sbc":
            word = plain_text(term)
            return f"%{flags}{width}{precision}s" % word
        if not isinstance(term, float):
            raise ActionError(f"{kind} != {text(term)}")
        value = int(term) if kind in "dxX" else term
        if "," in flags:
            return f"{value:{width},{precision}{kind}}"
        return f"%{flags}{width}{precision}{kind}" % value

    call.agent.say(_FORMAT.sub(formatted, template))
    return True


@STANDARD.add(".print_unifier", most=0)
def print_unifier(call: Call) -> bool:
    """Print the values of the variables."""
    names = [name for name in call.unifier if not name.startswith("_")]
    values = (f"{name}={text(substitute(Var(name), call.unifier))}" for name in names)
    call.agent.say(f"{{{', '.join(values)}}}")
    return True


@STANDARD.add(".version", least=1, most=1)
def version(call: Call, result: Term) -> object:
    """`.version(V)`: the version of the language."""
    return call.unify(result, VERSION)


@STANDARD.add(".my_name", least=1, most=1)
def my_name(call: Call, name: Term) -> object:
    """`.my_name(N)`: the name of the agent."""
    return call.unify(name, Literal(call.agent.name))


@STANDARD.add(".stopMAS", most=2)
def stop(call: Call, *delay: Term) -> Waiting:
    """`.stopMAS`: end the program."""
    call.agent.note("log", f".stopMAS({','.join(map(text, delay))})", call.intention)
    call.agent.stop()
    return WAITING
