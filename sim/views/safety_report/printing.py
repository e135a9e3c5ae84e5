"""Pages as PDF, printed by a browser on this machine."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path

from ...core.output import OutputError, replacing, writing
from ..chromium import QUIET, installed_chromium, unboxed

OPTIONS = ("--headless", "--no-pdf-header-footer", *QUIET)

PATIENCE = 120.0
"""Seconds of real time that a browser may take for a page."""


def require_printer(path: Path) -> None:
    """Raise `OutputError` if there is no browser that could print a page to `path`."""
    if installed_chromium() is None:
        raise OutputError(
            f"can't write {path}: a PDF is printed by Chromium or Chrome, and there is none here;"
            " write a .html instead and print that"
        )


def print_page(page: Path, path: Path) -> None:
    """Print the HTML file `page` to `path`; `OutputError` if that fails."""
    require_printer(path)
    browser = installed_chromium()
    assert browser is not None  # as required
    with (
        tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile,
        writing(path),
        replacing(path) as unfinished,
    ):
        target = Path(profile) / "printed.pdf"
        words = [
            *(browser, *OPTIONS, *unboxed(), f"--user-data-dir={profile}"),
            *(f"--print-to-pdf={target}", page.resolve().as_uri()),
        ]
        try:
            done = subprocess.run(words, capture_output=True, timeout=PATIENCE, check=False)
        except subprocess.TimeoutExpired:
            raise OutputError(f"can't write {path}: {browser} did not print it in time") from None
        if not target.is_file():
            said = done.stderr.decode(errors="replace").strip().splitlines()
            why = said[-1] if said else f"it ended with {done.returncode}"
            raise OutputError(f"can't write {path}: {browser} did not print it: {why}")
        shutil.copyfile(target, unfinished)
