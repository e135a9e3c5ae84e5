"""The page of a safety report, and the same in print."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

from floorplan import UserError

from ...core.output import OutputError
from ..report_page import write_report_page
from .parts import Section
from .printing import print_page, require_printer

ENDINGS = (".html", ".pdf")
"""Suffixes of files that a report can be written to."""


def require_writable(path: Path) -> None:
    """Raise, before any work is done for it, if a report can't be written to `path`.

    `ValueError` if it ends in neither .html nor .pdf, `OutputError` if there is no such folder or,
    for a PDF, no browser to print it.
    """
    if path.suffix.lower() not in ENDINGS:
        raise UserError(f"{path}: the name of a report ends in {' or '.join(ENDINGS)}")
    if not path.parent.is_dir():
        raise OutputError(f"can't write {path}: there is no folder {path.parent}")
    if path.suffix.lower() == ".pdf":
        require_printer(path)


def write_safety_page(
    path: Path, *, title: str, subtitle: str, sections: Sequence[Section]
) -> None:
    """Write a report to `path`, as HTML or, with a browser's help, as PDF."""
    if path.suffix.lower() != ".pdf":
        _write(path, title, subtitle, sections)
        return
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "report.html"
        _write(page, title, subtitle, sections)
        print_page(page, path)


def _write(path: Path, title: str, subtitle: str, sections: Sequence[Section]) -> None:
    write_report_page(
        path, "safety.html", {"css": _in_css}, title=title, subtitle=subtitle, sections=sections
    )


def _in_css(text: str) -> str:
    """Return a text as it stands in quotes in a style sheet."""
    return "".join(one if one.isalnum() or one in " -_.,:" else f"\\{ord(one):x} " for one in text)
