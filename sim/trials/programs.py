"""Where the programs of personalities are."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import bdi
from floorplan import Problem, is_there, suggestion

from .errors import TrialError

EXTERNAL = "external"
"""The personality of a person who runs no program, but is told from outside what to do; likewise
the controller of a gantry."""


def find_program(personality: str, folder: Path) -> str | Path:
    """The built-in personality of that name, or the path of an .asl file seen from `folder`.

    `TrialError` says what there is.
    """
    if personality in bdi.programs():
        return personality
    path = folder / personality
    if is_there(path) and path.is_file():
        return path
    known = (*bdi.programs(), EXTERNAL)
    message = f"no personality and no .asl file is called {personality!r};"
    raise TrialError("personality", [Problem(f"{message} {suggestion(personality, known)}")])


def is_read_from(program: bdi.Program, personality: str, folder: Path) -> bool:
    """Whether `program` came from the file that `personality` names, seen from `folder`."""
    file = bdi.programs().get(personality, folder / personality)
    return Path(program.source).resolve() == file.resolve()


def load_program(personality: str, folder: Path) -> bdi.Program | None:
    """The program of a personality; None for somebody who runs none (`EXTERNAL`).

    Raises what `find_program` does, and `bdi.ProgramError`.
    """
    if personality == EXTERNAL:
        return None
    program = bdi.load(find_program(personality, folder))
    _try_out(program)
    return program


@lru_cache(maxsize=64)
def _try_out(program: bdi.Program) -> None:
    """Refuse what nobody can begin with, as internal actions that aren't there.

    That takes as long as a person's mind at the start, and a study loads programs for each row.
    """
    bdi.Agent(program)
