"""Terminal output, notices, the user's browser, and interrupts.

If it comes just then, some compiled packages print a traceback and say that another one is
missing.
"""

from __future__ import annotations

import re
import signal
import sys
import webbrowser
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from types import FrameType
from typing import TYPE_CHECKING, Any, TextIO

import typer

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress, ProgressColumn

    from floorplan import Floorplan, Problem

    from .. import Trial


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
    """Return a console that prints names with [brackets] or :colons: unchanged.

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


MOST_NOTICES = 20
"""Number of notices of one kind that are shown."""


def print_notices(trial: Trial) -> None:
    """Print the notices on entries that make no difference, or may be meant otherwise."""
    _print(trial.name, trial.notices)


def count_floor_notices(plan: Floorplan, source: str) -> None:
    """Print how many notices there are on the drawing of a floor, and how `source` shows them."""
    if plan.notices:
        count = len(plan.notices)
        notices = f"{count:,} notice{'' if count == 1 else 's'}"
        say(
            f"{plan.name}: {notices} about the drawing; `floorwalker check {source}` lists them",
            err=True,
        )


def print_floor_notices(plan: Floorplan) -> None:
    """Print what was left out of the drawing of a floor, or taken for granted there."""
    _print(plan.name, plan.notices)


def _print(name: str, notices: Sequence[Problem]) -> None:
    for notice in notices[:MOST_NOTICES]:
        say(f"{name}: {notice}", err=True)
    if len(notices) > MOST_NOTICES:
        say(f"{name}: … and {len(notices) - MOST_NOTICES} more notices", err=True)


def open_in_browser(address: str) -> bool:
    """Open a page there; return True if there is a browser."""
    try:
        return webbrowser.open(address)
    except webbrowser.Error:
        return False


def somebody_looks(stdout: TextIO | None, environment: Mapping[str, str]) -> bool:
    """Return True if a browser may come up unasked: somebody sits at a terminal with a screen.

    Not in continuous integration (`CI` is set), and not where only a browser in text could be
    opened, which would take the terminal away. `stdout` is None where it was closed.
    """
    if stdout is None or not stdout.isatty() or environment.get("CI"):
        return False
    screens = ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")
    return sys.platform in ("darwin", "win32") or any(environment.get(name) for name in screens)


AGAIN = 0.02
"""Seconds after which it is tried again."""

PATIENCE = 1.0
"""Seconds that code of the user's own has to come to its end."""


@contextmanager
def put_off_while_loading() -> Iterator[None]:
    """In this context Ctrl-C raises `KeyboardInterrupt` as ever, but never inside of an import.

    So does SIGTERM, which would leave files unfinished and worker processes alone otherwise.
    Where whoever started us wants it ignored, as shells do in the background, it stays ignored.
    """
    usual = signal.getsignal(signal.SIGINT)
    if usual is not signal.default_int_handler or not hasattr(signal, "setitimer"):
        yield
        return
    alarm = signal.signal(signal.SIGALRM, _as_interrupt)
    signal.signal(signal.SIGINT, _interrupt)
    terminate = signal.signal(signal.SIGTERM, _as_interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, usual)
        signal.signal(signal.SIGTERM, terminate)
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, alarm)


@contextmanager
def taken_by(stop: Callable[[], None]) -> Iterator[None]:
    """In this context the first Ctrl-C calls `stop`, in the middle of whatever happens.

    `KeyboardInterrupt` is raised by the second one, and where code of the user's own is under way
    that does not come to its end.
    """
    usual = signal.getsignal(signal.SIGINT)
    if usual not in (_interrupt, signal.default_int_handler):
        yield
        return
    alarm = signal.getsignal(signal.SIGALRM) if hasattr(signal, "SIGALRM") else None

    def first(_number: int, _frame: FrameType | None) -> None:
        signal.signal(signal.SIGINT, usual)
        stop()
        if alarm is not None:
            signal.signal(signal.SIGALRM, _interrupt_own)
            signal.setitimer(signal.ITIMER_REAL, PATIENCE, PATIENCE)

    signal.signal(signal.SIGINT, first)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, usual)
        if alarm is not None:
            signal.setitimer(signal.ITIMER_REAL, 0)
            signal.signal(signal.SIGALRM, alarm)


def leave_to_asyncio() -> None:
    """Let Ctrl-C come at once from now on: asyncio ends its tasks well only if nobody has it."""
    if signal.getsignal(signal.SIGINT) is _interrupt:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _interrupt(_number: int, frame: FrameType | None) -> None:
    if _is_loading(frame):
        signal.setitimer(signal.ITIMER_REAL, AGAIN)
    else:
        raise KeyboardInterrupt


def _interrupt_own(_number: int, frame: FrameType | None) -> None:
    from ..core.custom_code import is_under_way

    if is_under_way(frame):
        raise KeyboardInterrupt


def _as_interrupt(_number: int, _frame: FrameType | None) -> None:
    signal.raise_signal(signal.SIGINT)


def _is_loading(frame: FrameType | None) -> bool:
    while frame is not None:
        if frame.f_code.co_filename == "<frozen importlib._bootstrap>":
            return True
        frame = frame.f_back
    return False
