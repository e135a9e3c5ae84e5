"""Functions whose value depends on the run: `math.random` and `system.time`.

A program is the same for all agents, so each agent puts its own into what it
loads.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, TypeVar

from .program import Clause, Program
from .terms import Function
from .transform import transformed

_Clause = TypeVar("_Clause", bound=Clause)


def with_run_functions(program: Program, functions: Mapping[str, Callable[..., float]]) -> Program:
    """The program with the functions of a run in place of their names."""

    def change(part: Any) -> Any:
        if isinstance(part, Function) and part.name in functions:
            return Function(part.name, transformed(part.args, change), functions[part.name])
        return None

    def changed(clause: _Clause) -> _Clause:
        return clause if clause.functions.isdisjoint(functions) else transformed(clause, change)

    return replace(
        program,
        beliefs=tuple(map(changed, program.beliefs)),
        plans=tuple(map(changed, program.plans)),
    )
