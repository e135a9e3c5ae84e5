"""The user's browser."""

from __future__ import annotations

import sys
import webbrowser
from collections.abc import Mapping
from typing import TextIO


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
