"""`floorwalker new`: small commented files to start from."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .terminal import say

TEMPLATES = Path(__file__).parents[1] / "data" / "new"

KINDS = {
    "trial": ("trial.yaml", "new.trial.yaml"),
    "controller": ("controller.txt", "controller.py"),
    "personality": ("personality.asl", "personality.asl"),
}
"""Template and default name of the file, by kind."""


def new(
    kind: Annotated[
        str, typer.Argument(help="trial, controller or personality.", autocompletion=lambda: KINDS)
    ],
    file: Annotated[
        Path | None, typer.Argument(help="Name of the file.  [default: by kind]")
    ] = None,
) -> None:
    """Write a small commented trial, controller or personality to start from."""
    if kind not in KINDS:
        raise typer.BadParameter(f"must be one of {', '.join(KINDS)}, not {kind!r}")
    template, name = KINDS[kind]
    path = Path(name) if file is None else file
    text = (TEMPLATES / template).read_text(encoding="utf-8")
    for mark, value in (("{file}", path.name), ("{module}", path.stem), ("{{", "{"), ("}}", "}")):
        text = text.replace(mark, value)
    try:
        with path.open("x", encoding="utf-8") as opened:
            opened.write(text)
    except FileExistsError:
        say(f"floorwalker: {path} exists already; name another file", err=True)
        raise typer.Exit(1) from None
    say(f"Wrote {path}")
