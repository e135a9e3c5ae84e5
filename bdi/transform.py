"""Rebuilding terms and programs with some of their parts changed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, is_dataclass, replace
from typing import Any

from .terms import (
    EMPTY,
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


def transformed(part: Any, change: Callable[[Any], Any]) -> Any:
    """`part` with `change` made wherever it answers something other than None."""

    def inside(inner: Any) -> Any:
        return transformed(inner, change)

    changed = change(part)
    if changed is not None:
        return changed
    if isinstance(part, tuple):
        return tuple(map(inside, part))
    if isinstance(part, Literal):
        return Literal(part.functor, inside(part.args), inside(part.annots), part.negated)
    if isinstance(part, Cons):
        rest = part.open_tail
        return make_list(map(inside, part), EMPTY if rest is None else rest)
    if isinstance(part, Arithmetic):
        return Arithmetic(part.operator, inside(part.left), inside(part.right))
    if isinstance(part, Function):
        return Function(part.name, inside(part.args), part.calculate)
    if isinstance(part, Relation):
        return Relation(part.symbol, inside(part.left), inside(part.right))
    if isinstance(part, And | Or):
        return part.__class__(inside(part.left), inside(part.right))
    if isinstance(part, Not):
        return Not(inside(part.formula))
    if isinstance(part, AnnotatedVar):
        return AnnotatedVar(part.name, inside(part.annots))
    if is_dataclass(part) and not isinstance(part, type):
        return replace(part, **{f.name: inside(getattr(part, f.name)) for f in fields(part)})
    return part
