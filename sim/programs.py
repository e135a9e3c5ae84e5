"""Where the programs of personalities are."""

from __future__ import annotations

from pathlib import Path

import bdi

from .rules import suggestion


def find_program(personality: str, folder: Path) -> str | Path:
    """The built-in personality of that name, or the path of an .asl file seen from `folder`.

    `FileNotFoundError` says what there is.
    """
    if personality in bdi.programs():
        return personality
    path = folder / personality
    if path.is_file():
        return path
    raise FileNotFoundError(
        f"no personality and no .asl file is called {personality!r};"
        f" {suggestion(personality, bdi.programs())}"
    )
