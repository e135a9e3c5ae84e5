"""Printing, and ending the program."""

from __future__ import annotations

import re

from ..errors import ProgramError
from ..language.substitution import substitute
from ..language.terms import Literal, Term, Var, plain_text, text
from ..language.texts import parse_term
from ..reasoning.actions import ActionError
from ..reasoning.calls import WAITING, Call, Waiting
from .arguments import wrong
from .registry import STANDARD

VERSION = "3.3.2"
"""Version of Jason whose language this is."""


def _line(terms: tuple[Term, ...]) -> str:
    return "".join(f"{t}<no-value>" if isinstance(t, Var) else plain_text(t) for t in terms)


@STANDARD.add(".print")
@STANDARD.add(".println")
def print_line(call: Call, *terms: Term) -> bool:
    """`.print(…)`: print the terms one after another, on one line."""
    call.agent.say(_line(terms))
    return True


@STANDARD.add(".log", least=1)
def log(call: Call, level: Term, *terms: Term) -> bool:
    """`.log(Level, …)`: print, warn, or only note, as the level says."""
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
    """Print a text with the values of the variables in it, `#{X}`, or unify with it."""
    if not isinstance(template, str):
        raise wrong("puts", "first argument must be a string")

    def value(found: re.Match[str]) -> str:
        try:
            return plain_text(substitute(parse_term(found[1]), call.unifier))
        except ProgramError:
            return found[0]

    parts = [template, *(term for term in result if isinstance(term, str))]
    whole = "".join(_NAMED.sub(value, part) for part in parts)
    if result and isinstance(result[-1], Var):
        return call.unify(whole, result[-1])
    call.agent.say(whole)
    return True


@STANDARD.add(".printf", least=1)
def printf(call: Call, template: Term, *terms: Term) -> bool:
    """Print a text with `%s`, `%d`, `%.2f` … in it."""
    if not isinstance(template, str):
        raise wrong("printf", "first argument must be a string (the format)")
    left = list(terms)

    def formatted(found: re.Match[str]) -> str:
        flags, width, digits, kind = found.groups()
        if kind in "n%":
            return "\n" if kind == "n" else "%"
        if not left:
            raise ActionError(f"Format specifier '{found[0]}'")
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
