"""Where commands print tables and what goes with them."""

from __future__ import annotations

from rich.console import Console


def plain_console(width: int | None = None) -> Console:
    """A console that prints names as they are, though they have [brackets] or :colons:.

    Where it is no terminal it is `width` characters wide, if that is given.
    """
    console = Console(markup=False, emoji=False)
    if width is not None and not console.is_terminal:
        console.width = width
    return console
