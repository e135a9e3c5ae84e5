"""Page of a safety report: its sections, tables and charts, as HTML or PDF."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from ...core.output import replacing, require_place, writing
from ..browser import in_browser, open_page, require_browser
from ..report_page import write_report_page

if TYPE_CHECKING:
    from playwright.sync_api import Browser

Cell = str
"""A text; `markupsafe.Markup` where it has subscripts and the like."""


@dataclass(frozen=True)
class ReportTable:
    """A table under a title; `figures` are the numbers of the columns that hold figures."""

    kind: ClassVar[str] = "table"
    heads: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    title: str = ""
    words: str = ""
    figures: frozenset[int] = frozenset()


@dataclass(frozen=True)
class Facts:
    """Names with their values, one below the other."""

    kind: ClassVar[str] = "facts"
    rows: Sequence[tuple[str, Cell]]
    title: str = ""
    words: str = ""


@dataclass(frozen=True)
class Picture:
    """A picture as an element of a page; its `words` are below it."""

    kind: ClassVar[str] = "picture"
    title: str
    words: str
    element: str


@dataclass(frozen=True)
class Chart:
    """A chart in the page's own colours, below its `words`."""

    kind: ClassVar[str] = "chart"
    title: str
    words: str
    element: str


@dataclass(frozen=True)
class Points:
    """Sentences, one below the other."""

    kind: ClassVar[str] = "points"
    sentences: Sequence[str]
    title: str = ""


Part = ReportTable | Facts | Picture | Chart | Points


@dataclass(frozen=True)
class Section:
    """A section of a report."""

    title: str
    parts: Sequence[Part] = field(default_factory=list)
    words: str = ""

    @property
    def anchor(self) -> str:
        """Its name in links."""
        return re.sub(r"\W+", "-", self.title.lower()).strip("-")


def listed(names: Sequence[str]) -> str:
    """Return names in a row; of more than three the first and the last, and how many they are."""
    if len(names) <= 3:
        return ", ".join(names)
    return f"{names[0]} … {names[-1]} ({len(names)})"


def plain(value: float, digits: int = 6) -> str:
    """Return a figure as it was given."""
    return f"{value:.{digits}g}"


def metres(length: float) -> str:
    """Return a length or a margin to a millimetre."""
    return minus(f"{round(length, 3) + 0.0:.3f}")  # no negative zero


def place(x: float, y: float) -> str:
    """Return a place (metres) to a centimetre."""
    return minus(f"({x:.2f},\u00a0{y:.2f})")


def minus(figures: str) -> str:
    """Return figures with a minus sign where they have a hyphen."""
    return figures.replace("-", "−")


def clock(seconds: float) -> str:
    """Return a length of time as h:mm:ss."""
    whole = round(seconds)
    return f"{whole // 3600}:{whole % 3600 // 60:02}:{whole % 60:02}"


def print_page(page: Path, path: Path) -> None:
    """Print the HTML file `page` to the PDF `path`."""

    def printed(browser: Browser) -> None:
        open_page(browser, page).pdf(path=target, prefer_css_page_size=True, print_background=True)

    with writing(path), replacing(path) as target:
        in_browser("a PDF", printed)


ENDINGS = (".html", ".pdf")
"""Suffixes of files that a report can be written to."""


def require_writable(path: Path) -> None:
    """Raise, before any work is done for it, if a report can't be written to `path`.

    `ValueError` if it ends in neither .html nor .pdf, `OutputError` if there is no such folder,
    `MissingExtraError` if a PDF cannot be printed.
    """
    require_place(path, "report", ENDINGS)
    if path.suffix.lower() == ".pdf":
        require_browser("a PDF")


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
