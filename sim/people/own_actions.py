"""Internal actions of the user's own: Python functions that the programs of people may use."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import bdi
from floorplan import is_file

from ..core.own_code import import_own
from ..core.own_source import (
    REFUSED,
    Definition,
    Kind,
    OwnCodeError,
    Source,
    definitions_in,
    find_source,
)


def _registered(definition: Definition) -> list[str]:
    """Return the names under which the decorators of a function register it."""
    if not isinstance(definition, ast.FunctionDef):
        return []
    return [
        call.args[0].value
        for call in definition.decorator_list
        if isinstance(call, ast.Call)
        and isinstance(call.func, ast.Attribute)
        and call.func.attr in ("add", "function")
        and call.args
        and isinstance(call.args[0], ast.Constant)
        and isinstance(call.args[0].value, str)
        and "." in call.args[0].value
    ]


ACTIONS = Kind(
    words='function with @actions.add("name") or @actions.function("name"), as own actions are',
    written=lambda definition: bool(_registered(definition)),
    made=callable,
)
"""The kind of function that a program of a person may use."""


def modules_of(of_person: str | None, of_trial: str | None) -> tuple[str, ...]:
    """Return the modules with actions that a person and the trial name; the person's go before."""
    return tuple(dict.fromkeys(name for name in (of_trial, of_person) if name is not None))


def sources_of(
    personality: str | bdi.Program | Path, modules: Sequence[str], folder: Path, *, own_code: bool
) -> list[Source]:
    """Return the modules with the actions that a person's program may use; none is imported.

    They are `modules`, right in `folder`, and those beside a program `NAME/NAME.asl`. Of two
    actions of one name the later counts.
    `OwnCodeError` says what is missing, or that own code is refused.
    """
    found = [_first(module, folder) for module in modules]
    program = _file_of(personality, folder)
    if program is not None and program.parent.name == program.stem:
        beside = sorted(program.parent.glob("*.py"))
        found += [_first(file.stem, program.parent) for file in beside if _names_in(file)]
    if found and not own_code:
        raise OwnCodeError(f"the actions of {found[0].module!r}: {REFUSED}")
    return found


def names_of(sources: Sequence[Source]) -> frozenset[str]:
    """Return the names of the actions and functions in some modules."""
    return frozenset(name for source in sources for name in _names_in(source.file))


def import_actions(sources: Sequence[Source]) -> bdi.InternalActions:
    """Return the actions and functions in some modules, which are imported.

    `OwnCodeError` if that fails.
    """
    found = bdi.InternalActions()
    for source in sources:
        function: Any = import_own(source)
        for value in function.__globals__.values():
            if isinstance(value, bdi.InternalActions):
                found.update(value)
                found.functions.update(value.functions)
    return found


def _file_of(personality: str | bdi.Program | Path, folder: Path) -> Path | None:
    if isinstance(personality, bdi.Program):
        return Path(personality.source)
    path = folder / personality
    if path.suffix == ".asl":
        return path
    inside = path / f"{path.name}.asl"
    return inside if is_file(inside) else None


def _names_in(file: Path) -> list[str]:
    definitions = definitions_in(file.stem, file)
    return [name for one in definitions.values() for name in _registered(one)]


def _first(module: str, folder: Path) -> Source:
    """Return the first function in a module that is registered as an action."""
    path = folder.joinpath(*module.split("."))
    file = path.with_name(f"{path.name}.py")
    there = is_file(file)
    names = definitions_in(module, file) if there else {}
    first = next((name for name, one in names.items() if _registered(one)), None)
    if there and first is None:
        raise OwnCodeError(f"{module!r} has no {ACTIONS.words}")
    return find_source(f"{module}:{first or 'actions'}", folder, ACTIONS)
