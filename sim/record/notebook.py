"""Tables of values in notebooks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape


def html_table(rows: Iterable[Sequence[str]], head: Sequence[str] = ()) -> str:
    """Return a table in HTML. The first cell of each row is its heading."""
    left = 'style="text-align:left"'
    heading = "".join(f'<th scope="col" {left}>{escape(cell)}</th>' for cell in head)
    lines = "".join(
        f'<tr><th scope="row" {left}>{escape(name)}</th>'
        + "".join(f"<td {left}>{escape(cell)}</td>" for cell in cells)
        + "</tr>"
        for name, *cells in rows
    )
    top = f"<thead><tr>{heading}</tr></thead>" if head else ""
    return f"<table>{top}<tbody>{lines}</tbody></table>"
