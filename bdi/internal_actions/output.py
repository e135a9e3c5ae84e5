"""Printing, and ending the program."""

from __future__ import annotations

from collections.abc import Mapping

from ..language.terms import Literal, Term, Var, plain_text, text
from ..reasoning.actions import InternalAction
from ..reasoning.calls import WAITING, Call, Waiting


def _line(terms: tuple[Term, ...]) -> str:
    return "".join(f"{t}<no-value>" if isinstance(t, Var) else plain_text(t) for t in terms)


def print_line(call: Call, *terms: Term) -> bool:
    call.agent.say(_line(terms))
    return True


def log(call: Call, level: Term, *terms: Term) -> bool:
    name = level.functor if isinstance(level, Literal) else ""
    if name in ("warning", "severe"):
        call.agent.warn(_line(terms), call.intention)
    elif name in ("fine", "finer", "finest"):
        call.agent.note("log", _line(terms), call.intention)
    else:
        call.agent.say(_line(terms))
    return True


def my_name(call: Call, name: Term) -> object:
    return call.unify(name, Literal(call.agent.name))


def stop(call: Call, *delay: Term) -> Waiting:
    call.agent.note("log", f".stopMAS({','.join(map(text, delay))})", call.intention)
    call.agent.stop()
    return WAITING


ACTIONS: Mapping[str, InternalAction] = {
    ".print": InternalAction(print_line),
    ".println": InternalAction(print_line),
    ".log": InternalAction(log, 1),
    ".my_name": InternalAction(my_name, 1, 1),
    ".stopMAS": InternalAction(stop, 0, 2),
}
