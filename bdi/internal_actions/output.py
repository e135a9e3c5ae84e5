"""Printing, and ending the program."""

from __future__ import annotations

import re
from collections.abc import Mapping

from ..errors import ProgramError
from ..language.parser import parse_term
from ..language.substitution import substitute
from ..language.terms import Literal, Term, Var, plain_text, text
from ..reasoning.actions import ActionError, InternalAction
from ..reasoning.calls import WAITING, Call, Waiting
from .arguments import wrong

VERSION = "3.3.2"
"""Version of Jason whose language this is."""


def _line(terms: tuple[Term, ...]) -> str:
    return "".join(f"{t}<no-value>" if isinstance(t, Var) else plain_text(t) for t in terms)


def print_line(call: Call, *terms: Term) -> bool:
    """`.print(…)`: print the terms one after another, on one line."""
    call.agent.say(_line(terms))
    return True


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


def print_unifier(call: Call) -> bool:
    """Print the values of the variables."""
    names = [name for name in call.unifier if not name.startswith("_")]
    values = (f"{name}={text(substitute(Var(name), call.unifier))}" for name in names)
    call.agent.say(f"{{{', '.join(values)}}}")
    return True


def version(call: Call, result: Term) -> object:
    """`.version(V)`: the version of the language."""
    return call.unify(result, VERSION)


def my_name(call: Call, name: Term) -> object:
    """`.my_name(N)`: the name of the agent."""
    return call.unify(name, Literal(call.agent.name))


def stop(call: Call, *delay: Term) -> Waiting:
    """`.stopMAS`: end the program."""
    call.agent.note("log", f".stopMAS({','.join(map(text, delay))})", call.intention)
    call.agent.stop()
    return WAITING


ACTIONS: Mapping[str, InternalAction] = {
    ".print": InternalAction(print_line),
    ".println": InternalAction(print_line),
    ".log": InternalAction(log, 1),
    ".puts": InternalAction(puts, 1, 2),
    ".printf": InternalAction(printf, 1),
    ".print_unifier": InternalAction(print_unifier, 0, 0),
    ".version": InternalAction(version, 1, 1),
    ".my_name": InternalAction(my_name, 1, 1),
    ".stopMAS": InternalAction(stop, 0, 2),
}
