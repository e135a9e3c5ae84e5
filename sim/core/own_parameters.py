"""Parameters of a class of the user's own, as its source shows them."""

from __future__ import annotations

import ast
import re
from dataclasses import dataclass

from .own_source import is_plain, methods


@dataclass(frozen=True)
class Parameters:
    """The names by which a class takes values when it is made, and those it can't do without."""

    names: tuple[str, ...]
    needed: tuple[str, ...]
    any_name: bool = False


def parameters(definition: ast.ClassDef) -> Parameters | None:
    """Return the parameters of a class as its source shows them; None if only a run can."""
    for node in definition.body:
        if isinstance(node, ast.FunctionDef) and node.name == "__init__":
            return None if definition.decorator_list or node.decorator_list else _of_init(node)
    if is_plain(definition):
        return None if "__new__" in methods(definition) else Parameters((), ())
    decorators = [ast.unparse(one).partition("(")[0] for one in definition.decorator_list]
    if decorators in (["dataclass"], ["dataclasses.dataclass"]) and not definition.bases:
        return _of_fields(definition)
    return None


def _of_init(node: ast.FunctionDef) -> Parameters:
    given = node.args
    by_place = [one.arg for one in (*given.posonlyargs, *given.args)]
    needed = by_place[: len(by_place) - len(given.defaults)]
    named = [one.arg for one in given.kwonlyargs]
    needed += [one for one, usual in zip(named, given.kw_defaults, strict=True) if usual is None]
    return Parameters(
        (*by_place[1:], *named),
        tuple(name for name in needed if name not in by_place[:1]),
        given.kwarg is not None,
    )


def _of_fields(definition: ast.ClassDef) -> Parameters | None:
    """Return the fields of a dataclass; None where `field()` and the like say more than a value."""
    names, needed = [], []
    for node in definition.body:
        if not (isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)):
            continue
        if isinstance(node.value, ast.Call) or re.search(
            r"\b(ClassVar|InitVar|KW_ONLY)\b", ast.unparse(node.annotation)
        ):
            return None
        names.append(node.target.id)
        if node.value is None:
            needed.append(node.target.id)
    return Parameters(tuple(names), tuple(needed))
