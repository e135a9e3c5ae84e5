"""Headless Chromium, driven by Playwright, for films of the replay page and PDFs of reports."""

from __future__ import annotations

import asyncio
import os
import shutil
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from floorplan import UserError

from .report_page import MissingExtraError

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

NAMES = (
    *("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"),
    *("microsoft-edge", "msedge"),
)
"""Commands of browsers that are looked for."""

PLACES = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    r"C:\Program Files\Google\Chrome\Application\chrome.exe",
    r"C:\Program Files (x86)\Microsoft\Edge\Application\msedge.exe",
)
"""Files that are looked for if there is no such command."""

ARGUMENTS = (
    "--disable-gpu",
    # WebGL in software looks the same on every machine.
    *("--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
)

PATIENCE = 60_000.0
"""Milliseconds that the browser may take for one action."""

Result = TypeVar("Result")


class BrowserError(UserError):
    """The browser failed, or did not answer in time."""


def installed_chromium() -> str | None:
    """Return the path of an installed browser of Chromium's kind, or None.

    The environment variable CHROMIUM takes precedence.
    """
    named = [os.environ.get("CHROMIUM", ""), *NAMES]
    found = next(filter(None, map(shutil.which, filter(None, named))), None)
    return found or next((place for place in PLACES if Path(place).is_file()), None)


def require_browser(what: str) -> str:
    """Return the path of the browser; `MissingExtraError` if it or Playwright is missing.

    `what` is the output that needs it, as the subject of the message.
    """
    try:
        import playwright as playwright
    except ImportError:
        raise MissingExtraError(
            f"{what} needs the package playwright, which is missing:"
            " pip install 'floorwalker[film]'"
        ) from None
    found = installed_chromium()
    if found is None:
        raise MissingExtraError(
            f"{what} needs Chromium or Chrome, and none is found: install one, or name it in the"
            " environment variable CHROMIUM"
        )
    return found


def in_browser(what: str, work: Callable[[Browser], Result]) -> Result:
    """Return the result of `work` with a browser, which is closed afterwards.

    `MissingExtraError` as in `require_browser`, `BrowserError` if the browser fails.
    """
    command = require_browser(what)
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return _opened(command, work)
    # Playwright's blocking interface rejects a thread with an event loop, as in a notebook.
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(_opened, command, work).result()


def _opened(command: str, work: Callable[[Browser], Result]) -> Result:
    from playwright.sync_api import Error, sync_playwright

    try:
        with sync_playwright() as driver:
            browser = driver.chromium.launch(
                executable_path=command,
                args=ARGUMENTS,
                # The administrator, as whom containers run, cannot use the sandbox.
                chromium_sandbox=sys.platform == "win32" or os.geteuid() != 0,
                timeout=PATIENCE,
            )
            return work(browser)
    except Error as why:
        raise BrowserError(f"{command} failed: {why.message.splitlines()[0]}") from None


def open_page(
    browser: Browser, file: Path, *, size: tuple[int, int] = (1000, 640), dark: bool = False
) -> Page:
    """Return the page of an HTML file, `size` pixels wide and high, when it is loaded."""
    width, height = size
    page = browser.new_page(
        viewport={"width": width, "height": height}, color_scheme="dark" if dark else "light"
    )
    page.set_default_timeout(PATIENCE)
    page.goto(file.resolve().as_uri())
    page.wait_for_selector("body:not([aria-busy=true])")
    return page
