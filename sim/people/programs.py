"""Programs of personalities: finding, loading and naming them."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from functools import cache, lru_cache
from pathlib import Path

import bdi
from floorplan import Problem, UserError, is_file, is_there, suggestion

from ..core.scenario import PersonEntry, Scenario, TrialError
from .own_actions import import_actions, modules_of, names_of, sources_of

EXTERNAL = "external"
"""The personality of a person who runs no program, but is commanded from outside; likewise the
controller of a gantry."""


def find_program(personality: str, folder: Path) -> str | Path:
    """Return the name of a built-in personality, or the path of an .asl file seen from `folder`.

    A folder NAME stands for the program NAME/NAME.asl.

    `TrialError` says what there is.
    """
    if personality in bdi.programs():
        return personality
    path = folder / personality
    if is_there(path) and path.is_dir():
        path = path / f"{path.name}.asl"
    if is_file(path):
        return path
    beside = sorted(path.parent.glob("*.asl")) if is_there(path.parent) else ()
    known = (*bdi.programs(), EXTERNAL, *(one.name for one in beside))
    message = f"no personality and no .asl file is called {personality!r};"
    raise TrialError("personality", [Problem(f"{message} {suggestion(path.name, known)}")])


def load_program(
    personality: str | bdi.Program,
    folder: Path,
    modules: Sequence[str] = (),
    *,
    own_code: bool = True,
) -> bdi.Program | None:
    """Return the program of a personality; None for somebody who runs none (`EXTERNAL`).

    It may use the internal actions in `modules`, of which nothing is imported here.
    Raises what `find_program` and `sources_of` do, and `bdi.ProgramError`.
    """
    if personality == EXTERNAL:
        return None
    if isinstance(personality, str):
        personality = bdi.load(find_program(personality, folder))
    _try_out(personality, names_of(sources_of(personality, modules, folder, own_code=own_code)))
    return personality


def in_group(program: bdi.Program) -> bdi.Program:
    """Return the program of somebody who walks with the leader of a group: that goes first."""
    group = bdi.load("group")
    return replace(
        program,
        beliefs=(*group.beliefs, *program.beliefs),
        plans=(*group.plans, *program.plans),
    )


class Programs:
    """Programs that the people of a scenario run: each is loaded once, whoever runs it.

    Its methods raise what `load_program` does, and `OwnCodeError` if actions can't be imported.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._scenario = scenario
        self._load = cache(self._loaded)

    def of(self, entry: PersonEntry) -> tuple[bdi.Program, bdi.InternalActions | None]:
        """Return the program of a person, and the actions of the user's own that it may use.

        `ValueError` for somebody who runs none.
        """
        is_led = self._scenario.leader(entry) is not None
        return self._load(entry.personality, entry.actions, is_led)

    def with_changes(self, entry: PersonEntry) -> PersonEntry:
        """Return the person with the programs themselves of the personalities that come later."""
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
        folder, own_code = self._scenario.folder, self._scenario.own_code
        modules = modules_of(actions, self._scenario.actions)
        program = load_program(personality, folder, modules, own_code=own_code)
        if program is None:
            raise UserError(f"who is {personality!r} runs no program")
        own = sources_of(program, modules, folder, own_code=own_code)
        return in_group(program) if is_led else program, import_actions(own) if own else None


def written_personality(personality: str | bdi.Program, folder: Path) -> str:
    """Return the name by which a personality is found again from `folder`.

    `ValueError` if it is a program of no file, or of one that has changed since.
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
    """Refuse what nobody can begin with, as internal actions that aren't there or among `own`.

    That takes as long as a person's mind at the start, and a study loads programs for each row.
    """
    actions = bdi.InternalActions({name: bdi.InternalAction(lambda call, *a: True) for name in own})
    actions.functions.update(dict.fromkeys(own, lambda *numbers: 0.0))
    bdi.Agent(program, actions=actions, strict=True)
