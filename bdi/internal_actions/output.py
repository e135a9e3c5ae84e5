"""Printing, and ending the program."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from ..steps import WAITING, Waiting
from ..terms import Literal, Term, display, text
from .call import Call, InternalAction


def print_line(call: Call, *terms: Term) -> bool:
    call.agent.say("".join(map(display, terms)))
    return True


def log(call: Call, level: Term, *terms: Term) -> bool:
    line = "".join(map(display, terms))
    if isinstance(level, Literal) and level.functor in ("warning", "severe"):
        call.agent.warn(line, call.intention)
    elif isinstance(level, Literal) and level.functor in ("fine", "finer", "finest"):
        call.agent.note("log", line, call.intention)
    else:
        call.agent.say(line)
    return True


def my_name(call: Call, name: Term) -> object:
    return call.unify(name, Literal(call.agent.name))


def stop(call: Call, *delay: Term) -> Waiting:
    call.agent.note("log", f".stopMAS({','.join(map(text, delay))})", call.intention)
    call.agent.stop()
    return WAITING


ACTIONS: Mapping[str, InternalAction] = MappingProxyType(
    {
        ".print": InternalAction(print_line),
        ".println": InternalAction(print_line),
        ".log": InternalAction(log, 1),
        ".my_name": InternalAction(my_name, 1, 1),
        ".stopMAS": InternalAction(stop, 0, 2),
    }
)
