"""Parts of a report: sections of text, tables and pictures."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

Cell = str
"""A text; `markupsafe.Markup` where it has subscripts and the like."""


@dataclass(frozen=True)
class Table:
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


Part = Table | Facts | Picture | Chart | Points


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
