"""Terminal output, notices, the user's browser, and interrupts.

An interrupt during an import makes some compiled packages print a traceback and report a missing
package.
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
    r"""Return `text` with control characters escaped as in JSON, such as `\u001b`.

    Names, messages and recordings come from files, and terminals would obey their control
    characters.
    """
    return _CONTROL.sub(lambda match: f"\\u{ord(match[0]):04x}", text)


def say(text: str, *, err: bool = False) -> None:
    """Print a line on stdout, or on stderr if `err`."""
    # By default typer writes UTF-8 to terminals that support only ASCII.
    typer.echo(visible(text), file=None if err else sys.stdout, err=err)


def plain_console(width: int | None = None) -> Console:
    """Return a console that prints names with [brackets] or :colons: unchanged.

    If it is no terminal, it is `width` characters wide if that is given.
    """
    from rich.console import Console
    from rich.text import Text

    class PlainConsole(Console):
        def render_str(self, text: str, **how: Any) -> Text:
            """Render every text of a table without markup."""
            return super().render_str(visible(text), **how)

    console = PlainConsole(markup=False, emoji=False)
    if width is not None and not console.is_terminal:
        console.width = width
    return console


def progress_bars(*columns: str | ProgressColumn) -> Progress:
    """Return bars on stderr that disappear at the end, or none if it is no terminal."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    # Before version 15 rich ends even bars that are disabled with an empty line.
    console.quiet = not console.is_terminal
    return Progress(*columns, console=console, transient=True, disable=console.quiet)


MOST_NOTICES = 20
"""Maximum number of notices of one kind that are shown."""


def print_notices(trial: Trial) -> None:
    """Print the notices about entries that have no effect or may be mistakes."""
    _print(trial.name, trial.notices)


def count_floor_notices(plan: Floorplan, source: str) -> None:
    """Print the number of notices about the drawing of a floor, and how `source` shows them."""
    if plan.notices:
        count = len(plan.notices)
        notices = f"{count:,} notice{'' if count == 1 else 's'}"
        say(
            f"{plan.name}: {notices} about the drawing; `floorwalker check {source}` lists them",
            err=True,
        )


def print_floor_notices(plan: Floorplan) -> None:
    """Print the omissions and assumptions about the drawing of a floor."""
    _print(plan.name, plan.notices)


def _print(name: str, notices: Sequence[Problem]) -> None:
    for notice in notices[:MOST_NOTICES]:
        say(f"{name}: {notice}", err=True)
    if len(notices) > MOST_NOTICES:
        say(f"{name}: … and {len(notices) - MOST_NOTICES} more notices", err=True)


def open_in_browser(address: str) -> bool:
    """Open a page. Return True if there is a browser."""
    try:
        return webbrowser.open(address)
    except webbrowser.Error:
        return False


def somebody_looks(stdout: TextIO | None, environment: Mapping[str, str]) -> bool:
    """Return True if a browser may open unasked, because there is a terminal with a screen.

    That is not the case in continuous integration (`CI` is set), or if the only browser is a text
    browser, which would take over the terminal. `stdout` is None if it was closed.
    """
    if stdout is None or not stdout.isatty() or environment.get("CI"):
        return False
    screens = ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")
    return sys.platform in ("darwin", "win32") or any(environment.get(name) for name in screens)


AGAIN = 0.02
"""Seconds between attempts."""

PATIENCE = 1.0
"""Seconds within which custom code must end."""


@contextmanager
def put_off_while_loading() -> Iterator[None]:
    """Raise `KeyboardInterrupt` on Ctrl-C in this context, but never during an import.

    The same holds for SIGTERM, which would otherwise leave unfinished files and worker processes.
    Signals stay ignored if the parent process ignores them, as shells do in the background.
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
    """Call `stop` on the first Ctrl-C in this context, at any point of the program.

    `KeyboardInterrupt` is raised by the second Ctrl-C, or if custom code does not end.
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
    """Handle Ctrl-C immediately from now on, because asyncio ends its tasks only then."""
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
