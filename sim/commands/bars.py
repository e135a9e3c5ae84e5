"""Progress bars: on a terminal, and nowhere else."""

from __future__ import annotations

from rich.console import Console
from rich.progress import Progress, ProgressColumn


def progress_bars(*columns: str | ProgressColumn) -> Progress:
    """Bars on stderr that are gone when they are done; nothing at all if it is no terminal."""
    console = Console(stderr=True)
    # Before version 15 rich ends even bars that are disabled with an empty line.
    console.quiet = not console.is_terminal
    return Progress(*columns, console=console, transient=True, disable=console.quiet)
