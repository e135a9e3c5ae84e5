"""The user's browser."""

from __future__ import annotations

import webbrowser


def open_in_browser(address: str) -> bool:
    """Open a page there; return True if there is a browser."""
    try:
        return webbrowser.open(address)
    except webbrowser.Error:
        return False
