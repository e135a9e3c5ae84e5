"""Functions whose value depends on the run: `math.random` and `system.time`.

A program is the same for all agents, so each agent puts its own into what it
loads.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any, TypeAlias

from .program import Place, Program
from .terms import (
    And,
    AnnotatedVar,
    Arithmetic,
    Cons,
    Function,
    Literal,
    Not,
    Or,
    Relation,
    make_list,
)

RunFunctions: TypeAlias = Mapping[str, Callable[..., float]]


def with_run_functions(program: Program, functions: RunFunctions) -> Program:
    """The program with the functions of a run in place of their names."""
    return replace(
        program,
        beliefs=_bound(program.beliefs, functions),
        goals=_bound(program.goals, functions),
        plans=_bound(program.plans, functions),
    )


def _bound(part: Any, functions: RunFunctions) -> Any:
    def inside(inner: Any) -> Any:
        return _bound(inner, functions)

    if isinstance(part, Function):
        calculate = functions.get(part.name)
        return Function(part.name, inside(part.args), calculate) if calculate else part
    if isinstance(part, tuple):
        return tuple(map(inside, part))
    if isinstance(part, Literal):
        if part.ground:
            return part
        return Literal(part.functor, inside(part.args), inside(part.annots), part.negated)
    if isinstance(part, AnnotatedVar):
        return AnnotatedVar(part.name, inside(part.annots))
    if isinstance(part, Arithmetic):
        return Arithmetic(part.operator, inside(part.left), inside(part.right))
    if isinstance(part, Relation):
        return Relation(part.symbol, inside(part.left), inside(part.right))
    if isinstance(part, And | Or):
        return part.__class__(inside(part.left), inside(part.right))
    if isinstance(part, Not):
        return Not(inside(part.formula))
    if isinstance(part, Cons) and part.open_tail is None:
        return make_list(map(inside, part))
    if is_dataclass(part) and not isinstance(part, Place | type):
        return replace(part, **{f.name: inside(getattr(part, f.name)) for f in fields(part)})
    return part
