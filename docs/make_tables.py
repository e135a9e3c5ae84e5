"""Writes the tables of the reference that follow from the code: `python docs/make_tables.py`."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from sim.core.events import EVENT_KINDS, EventKind
from sim.record.figures import FIGURES, PEOPLE, SummaryFigure

DOCS = Path(__file__).parent


def events() -> str:
    """Return the table of all kinds of events."""
    own = (kind for kind in EVENT_KINDS.values() if kind.__module__ == EventKind.__module__)
    rows = ((f"`{kind.kind}`", _fields(kind), inspect.getdoc(kind) or "") for kind in own)
    return table(("kind", "fields", "meaning"), rows)


def _fields(kind: type[EventKind]) -> str:
    """Return the fields of a kind of event, those that may be missing in brackets."""
    return ", ".join(f"[`{name}`]" if name in kind.optional else f"`{name}`" for name in kind.forms)


def figures() -> str:
    """Return the table of the values of a summary, without those that are explained in the text.

    These are the time and the requirement of a distance, and what each person has as well as all.
    """
    rows = (
        (f"`{figure.path}`", ", ".join(filter(None, (figure.meaning, figure.unit))))
        for figure in FIGURES.values()
        if figure.meaning and not figure.path.endswith((".time", ".required"))
        if not _is_also_of_all(figure)
    )
    return table(("value", "meaning"), rows)


def _is_also_of_all(figure: SummaryFigure) -> bool:
    """Return whether a person's value has the same meaning as that of all people."""
    of_all = FIGURES.get(figure.path.removeprefix(PEOPLE))
    return (
        figure.path.startswith(PEOPLE) and of_all is not None and of_all.meaning == figure.meaning
    )


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return a table in Markdown."""
    head = tuple(head)
    lines = [head, ("---",) * len(head), *rows]
    return "\n".join("| " + " | ".join(" ".join(c.split()) for c in line) + " |" for line in lines)


TABLES = {"events": events, "figures": figures}
"""What makes each table, by the name that stands above it in a page."""

MARKED = re.compile(r"(<!-- table: (?P<name>\w+) -->\n).*?(<!-- end of table -->)", re.S)


def with_tables(page: str, tables: Mapping[str, Callable[[], str]] = TABLES) -> str:
    """Return the text of a page with those of its tables made again that are among `tables`."""

    def made(found: re.Match[str]) -> str:
        make = tables.get(found["name"])
        return found[0] if make is None else f"{found[1]}{make()}\n{found[3]}"

    return MARKED.sub(made, page)


if __name__ == "__main__":
    for path in sorted(DOCS.glob("*.md")):
        text = path.read_text(encoding="utf-8")
        if (made := with_tables(text)) != text:
            path.write_text(made, encoding="utf-8")
