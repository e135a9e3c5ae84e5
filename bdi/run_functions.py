"""Functions whose value depends on the run: `math.random` and `system.time`.

A program is the same for all agents, so each agent puts its own into what it
loads.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from .program import Belief, Program
from .terms import Function, Literal
from .transform import transformed


def with_run_functions(program: Program, functions: Mapping[str, Callable[..., float]]) -> Program:
    """The program with the functions of a run in place of their names."""
    found = False

    def change(part: Any) -> Any:
        nonlocal found
        if isinstance(part, Belief) and _is_plain(part.belief):
            return part
        if isinstance(part, Function) and part.name in functions:
            found = True
            args = transformed(part.args, change)
            return Function(part.name, args, functions[part.name])
        return None

    changed = replace(
        program,
        beliefs=transformed(program.beliefs, change),
        plans=transformed(program.plans, change),
    )
    return changed if found else program


def _is_plain(belief: Literal) -> bool:
    """Whether a belief is of numbers, strings and names alone, as most of many are."""
    return not belief.annots and all(
        isinstance(arg, float | str) or (isinstance(arg, Literal) and arg.is_atom)
        for arg in belief.args
    )
