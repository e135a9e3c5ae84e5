"""Ctrl-C, put off while packages are being loaded; and SIGTERM, which is taken for it.

If it comes just then, some compiled packages print a traceback and say that another one is
missing.
"""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

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
    from ..core.own_code import is_under_way

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
