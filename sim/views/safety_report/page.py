"""Page of a safety report: its sections, tables and charts, as HTML or PDF."""

from __future__ import annotations

import math
import re
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...record.incidents import CELL, Incident
from ...record.output import replacing, writing
from ...record.sampling import MOMENT
from ..film import in_browser, open_page, require_browser
from ..report_page import figure, minus, require_place, signed, write_report_page

if TYPE_CHECKING:
    from playwright.sync_api import Browser


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


def clock(seconds: float) -> str:
    """Return a length of time as h:mm:ss."""
    whole = round(seconds)
    return f"{whole // 3600}:{whole % 3600 // 60:02}:{whole % 60:02}"


def counted(count: int, what: str) -> str:
    """Return how many there are of something."""
    if what == "person":
        return "1 person" if count == 1 else f"{count:,} people"
    plural = f"{what[:-1]}ies" if what.endswith("y") and what[-2] not in "aeiou" else f"{what}s"
    return f"{count:,} {what if count == 1 else plural}"


def incident_rows(found: Sequence[Incident], numbers: Sequence[int] | None) -> list[list[str]]:
    """Return a line for each violation, after the number of its run if there are several."""
    rows = [
        [
            *(f"{one.begin:.3f}", f"{one.seconds:.3f}", one.person, one.machine, one.cause or "–"),
            *(place(*one.at), ", ".join(one.zones) or "–", f"{one.distance:.3f}"),
            *(f"{one.required:.3f}", metres(one.margin), f"{one.worst_at:.3f}"),
            *(f"{one.severity:.2f}", "; ".join(one.led_to) or "nothing"),
        ]
        for one in found
    ]
    if numbers is None:
        return rows
    return [[str(number), *row] for number, row in zip(numbers, rows, strict=True)]


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


def write_safety_page(path: Path, template: str, **values: Any) -> None:
    """Write a report to `path`, as HTML or, with a browser's help, as PDF.

    `template` is one of `data/report`, which gets the `values`.
    """
    if path.suffix.lower() != ".pdf":
        _write(path, template, values)
        return
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "report.html"
        _write(page, template, values)
        print_page(page, path)


def _write(path: Path, template: str, values: Mapping[str, Any]) -> None:
    filters: dict[str, Callable[..., Any]] = {
        "anchor": _anchor,
        "clock": clock,
        "counted": counted,
        "css": _in_css,
        "figure": figure,
        "incident_rows": incident_rows,
        "kind": lambda law: type(law).__name__,
        "metres": metres,
        "signed": signed,
    }
    shared = {"titles": [], "infinity": math.inf, "moment": MOMENT, "cell": CELL}
    write_report_page(path, template, filters, **shared, **values)


def _anchor(title: str) -> str:
    """Return the name of a section in links."""
    return re.sub(r"\W+", "-", title.lower()).strip("-")


def _in_css(text: str) -> str:
    """Return a text as it stands in quotes in a style sheet."""
    return "".join(one if one.isalnum() or one in " -_.,:" else f"\\{ord(one):x} " for one in text)
