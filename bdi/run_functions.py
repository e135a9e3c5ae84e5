"""Functions whose value depends on the run: `math.random` and `system.time`.

A program is the same for all agents, so each agent puts its own into what it
loads.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from .program import Program
from .terms import Function
from .transform import transformed


def with_run_functions(program: Program, functions: Mapping[str, Callable[..., float]]) -> Program:
    """The program with the functions of a run in place of their names."""
    found = False

    def change(part: Any) -> Any:
        nonlocal found
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
