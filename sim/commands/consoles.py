"""Output of commands: all text goes through here, so that none of it drives the terminal."""

from __future__ import annotations

import re
import sys
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress, ProgressColumn

_CONTROL = re.compile("[\0-\x08\x0b-\x1f\x7f-\x9f]")


def visible(text: str) -> str:
    r"""Return `text` with its control characters as JSON writes them, `\u001b` for an escape.

    Names, messages and recordings come from files: a terminal would obey what is in them.
    """
    return _CONTROL.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


def say(text: str, *, err: bool = False) -> None:
    """Print a line on stdout, or on stderr if `err`."""
    # Left to itself, typer writes UTF-8 to terminals that have ASCII alone.
    typer.echo(visible(text), file=None if err else sys.stdout, err=err)


def plain_console(width: int | None = None) -> Console:
    """A console that prints names as they are, though they have [brackets] or :colons:.

    Where it is no terminal it is `width` characters wide, if that is given.
    """
    from rich.console import Console
    from rich.text import Text

    class PlainConsole(Console):
        def render_str(self, text: str, **how: Any) -> Text:
            """Every text of a table comes through here."""
            return super().render_str(visible(text), **how)

    console = PlainConsole(markup=False, emoji=False)
    if width is not None and not console.is_terminal:
        console.width = width
    return console


def progress_bars(*columns: str | ProgressColumn) -> Progress:
    """Return bars on stderr that are gone when they are done, or none if it is no terminal."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    # Before version 15 rich ends even bars that are disabled with an empty line.
    console.quiet = not console.is_terminal
    return Progress(*columns, console=console, transient=True, disable=console.quiet)
