"""Programs, internal actions and planners of people: finding, loading and naming them."""

from __future__ import annotations

import ast
import inspect
import os
from collections.abc import Sequence
from dataclasses import replace
from functools import cache, lru_cache
from pathlib import Path
from typing import TypeVar

import ompl.base as ob

import bdi
from bdi.actions import InternalAction
from floorplan import Problem, UserError
from floorplan.files.problems import suggestion
from floorplan.files.reading import is_file, is_there
from navigation import PlannerError
from navigation.catalog import PlannerChoice

from ..core.custom_code import (
    CodeFolder,
    CustomCode,
    Definition,
    Kind,
    OwnCodeError,
)
from ..core.scenario import PersonEntry, Scenario, TrialError


def _registered(definition: Definition) -> list[str]:
    """Return the names under which decorators register a function."""
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
    noun="actions of",
    words='function with @actions.add("name") or @actions.function("name"), as own actions are',
    accepts=callable,
)
"""Kind of modules with internal actions for programs of people."""


def modules_of(of_person: str | None, of_trial: str | None) -> tuple[str, ...]:
    """Return the modules with actions of a trial and a person, in this order."""
    return tuple(dict.fromkeys(name for name in (of_trial, of_person) if name is not None))


def sources_of(
    personality: str | bdi.Program | Path, modules: Sequence[str], folder: CodeFolder
) -> list[CustomCode]:
    """Return the modules with actions for the program of a person, without importing them.

    They are `modules` in `folder`, and the modules beside a program `NAME/NAME.asl`. If two actions
    have the same name, the later one counts. Raises `OwnCodeError` if a module is missing or custom
    code is not allowed.
    """
    sources = [folder.find_module(module, ACTIONS) for module in modules]
    for source in sources:
        if not _names_in(source):
            raise OwnCodeError(f"{source.name!r} has no {ACTIONS.words}")
    program = _file_of(personality, folder.path)
    if program is not None and program.parent.name == program.stem:
        place = program.parent
        for file in sorted(place.glob("*.py")):
            source = CustomCode(folder=place, module=file.stem, file=file, kind=ACTIONS)
            if _names_in(source):
                sources.append(replace(folder, path=place).find_module(file.stem, ACTIONS))
    return sources


def names_of(sources: Sequence[CustomCode]) -> frozenset[str]:
    """Return the names of the actions and functions in some modules."""
    return frozenset(name for source in sources for name in _names_in(source))


def import_actions(sources: Sequence[CustomCode]) -> bdi.InternalActions:
    """Import modules and return their actions and functions.

    Raises `OwnCodeError` if that fails.
    """
    actions = bdi.InternalActions()
    for source in sources:
        for value in vars(source.load()).values():
            if isinstance(value, bdi.InternalActions):
                actions.update(value)
                actions.functions.update(value.functions)
    return actions


def _file_of(personality: str | bdi.Program | Path, folder: Path) -> Path | None:
    if isinstance(personality, bdi.Program):
        return Path(personality.source)
    path = folder / personality
    if path.suffix == ".asl":
        return path
    inside = path / f"{path.name}.asl"
    return inside if is_file(inside) else None


def _names_in(source: CustomCode) -> list[str]:
    return [name for one in source.definitions().values() for name in _registered(one)]


EXTERNAL = "external"
"""Personality of a person, or controller of a gantry, commanded from outside."""


def find_program(personality: str, folder: Path) -> str | Path:
    """Return the name of a built-in personality, or the path of an .asl file in `folder`.

    A folder NAME contains the program NAME/NAME.asl. Raises `TrialError` with the existing names.
    """
    if personality in bdi.programs():
        return personality
    path = folder / personality
    if is_there(path) and path.is_dir():
        path = path / f"{path.name}.asl"
    if is_file(path):
        return path
    beside = sorted(path.parent.glob("*.asl")) if is_there(path.parent) else ()
    names = (*bdi.programs(), EXTERNAL, *(one.name for one in beside))
    message = f"no personality and no .asl file is called {personality!r};"
    raise TrialError("personality", [Problem(f"{message} {suggestion(path.name, names)}")])


def load_program(
    personality: str | bdi.Program,
    folder: CodeFolder,
    modules: Sequence[str] = (),
) -> bdi.Program | None:
    """Return the program of a personality, or None for `EXTERNAL`.

    It may use the internal actions in `modules`, which are not imported. Raises the errors of
    `find_program` and `sources_of`, and `bdi.ProgramError`.
    """
    if personality == EXTERNAL:
        return None
    if isinstance(personality, str):
        personality = bdi.load(find_program(personality, folder.path))
    _try_out(personality, names_of(sources_of(personality, modules, folder)))
    return personality


def in_group(program: bdi.Program) -> bdi.Program:
    """Return a program preceded by the program of groups."""
    group = bdi.load("group")
    return replace(
        program,
        beliefs=(*group.beliefs, *program.beliefs),
        plans=(*group.plans, *program.plans),
    )


class Programs:
    """Programs of the people of a scenario, each loaded once.

    The methods raise the errors of `load_program`, and `OwnCodeError` if the import of actions
    fails.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._scenario = scenario
        self._load = cache(self._loaded)

    def of(self, entry: PersonEntry) -> tuple[bdi.Program, bdi.InternalActions | None]:
        """Return the program of a person and its custom actions.

        Raises `ValueError` for a person without a program.
        """
        is_led = self._scenario.leader(entry) is not None
        return self._load(entry.personality, entry.actions, is_led)

    def with_changes(self, entry: PersonEntry) -> PersonEntry:
        """Return the person with programs in place of the names of later personalities."""
        if not entry.changes:
            return entry
        changes = [
            replace(change, personality=self._load(change.personality, entry.actions, False)[0])
            for change in entry.changes
        ]
        return replace(entry, changes=tuple(changes))

    def _loaded(
        self, personality: str | bdi.Program, actions: str | None, is_led: bool
    ) -> tuple[bdi.Program, bdi.InternalActions | None]:
        folder = self._scenario.code_folder
        modules = modules_of(actions, self._scenario.actions)
        program = load_program(personality, folder, modules)
        if program is None:
            raise UserError(f"who is {personality!r} runs no program")
        own = sources_of(program, modules, folder)
        return in_group(program) if is_led else program, import_actions(own) if own else None


def written_personality(personality: str | bdi.Program, folder: Path) -> str:
    """Return the name of a personality relative to `folder`.

    Raises `ValueError` if it is a program without a file, or if the file has changed since.
    """
    if isinstance(personality, str):
        return personality
    path = Path(personality.source)
    if not (is_file(path) and bdi.parse_file(path) == personality):
        raise UserError("is in no file; save it, and give the file as personality")
    builtin = [name for name, file in bdi.programs().items() if file.resolve() == path.resolve()]
    return builtin[0] if builtin else Path(os.path.relpath(path, folder)).as_posix()


@lru_cache(maxsize=1024)
def _try_out(program: bdi.Program, own: frozenset[str]) -> None:
    """Reject a program that cannot start, for example because of unknown internal actions.

    `own` are the names of custom actions. The check is cached, because it takes as long as the
    construction of an agent.
    """
    actions = bdi.InternalActions({name: InternalAction(lambda call, *a: True) for name in own})
    actions.functions.update(dict.fromkeys(own, lambda *numbers: 0.0))
    bdi.Agent(program, actions=actions, settings=bdi.AgentSettings(strict=True))


_Made = TypeVar("_Made", bound=Scenario)


PLANNER = Kind(
    noun="planner",
    words="planner: a planner is a subclass of ompl.base.Planner",
    accepts=lambda value: inspect.isclass(value) and issubclass(value, ob.Planner),
    error=PlannerError,
)
"""Kind of classes of custom planners."""


def planner_of(entry: PersonEntry, scenario: Scenario) -> PlannerChoice:
    """Return the planner of a person, by default that of the trial."""
    return scenario.planner if entry.planner is None else entry.planner


def with_planner(scenario: _Made, planner: PlannerChoice | str) -> _Made:
    """Return the scenario with this planner for all people."""
    choice = PlannerChoice.of(planner)
    planner_source(choice, scenario.code_folder)
    return replace(scenario, planner=choice).with_people(lambda one: replace(one, planner=None))


def find_planner(choice: PlannerChoice, folder: CodeFolder) -> PlannerChoice:
    """Return `choice` with the class of a custom planner, imported from `folder`.

    Raises `PlannerError` if it is missing.
    """
    source = planner_source(choice, folder)
    return choice if source is None else _checked(replace(choice, kind=source.load()))


def planner_source(choice: PlannerChoice, folder: CodeFolder) -> CustomCode | None:
    """Return the source of a custom planner without importing it, or None for other planners.

    Raises `PlannerError` if it is missing, or if it has parameters that planners do not have.
    """
    _checked(choice)
    if not choice.is_own or choice.kind is not None:
        return None
    return folder.find(choice.name, PLANNER)


def _checked(choice: PlannerChoice) -> PlannerChoice:
    try:
        choice.check()
    except UserError as why:
        raise PlannerError(str(why)) from why
    return choice
