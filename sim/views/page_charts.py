"""Matplotlib's figures as elements of a page: SVG in the page's colour of text."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Literal

from .colours import BLUE, BROWN, GREEN, ORANGE, PURPLE, SKY, VERMILION

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK = "#123456"
"""Stands for the page's colour of text, and is replaced by it."""

COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BROWN)
"""Colours of rows and lines, in their order."""


def page_chart(name: str, size: tuple[float, float], draw: Callable[[Figure], None]) -> str | None:
    """Return what `draw` draws, `size` inches wide and high, as an SVG element.

    `name` is that of no other chart on the page. None if matplotlib is not there.
    """
    try:
        import matplotlib as mpl
        from matplotlib.figure import Figure
    except ImportError:
        return None
    settings: Any = {"svg.fonttype": "none", "svg.hashsalt": name, "font.size": 10}
    settings |= dict.fromkeys(("text.color", "axes.edgecolor", "axes.labelcolor"), INK)
    settings |= {"xtick.color": INK, "ytick.color": INK, "font.family": "sans-serif"}
    with mpl.rc_context(settings):
        figure = Figure(figsize=size, layout="constrained")
        draw(figure)
        text = io.StringIO()
        figure.savefig(text, format="svg", transparent=True, metadata={"Date": None})
    return _for_a_page(text.getvalue())


def name_rows(axes: Axes, names: Sequence[str]) -> None:
    """Name the rows of a chart, the first on top, and leave nothing but a grid around them."""
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.5, -0.5)
    axes.tick_params(axis="y", length=0)
    axes.spines[["left", "right", "top"]].set_visible(False)
    draw_grid(axes, "x")


def draw_grid(axes: Axes, which: Literal["both", "x", "y"]) -> None:
    """Draw the grid of a chart, below what it shows."""
    axes.grid(axis=which, alpha=0.2, color=INK)
    axes.set_axisbelow(True)


def _for_a_page(drawn: str) -> str:
    """The SVG element alone, in the page's colour of text."""
    return as_element(drawn).replace(INK, "currentColor")


def as_element(drawn: str) -> str:
    """Return the SVG element of a drawn file alone, without what is said about it."""
    return re.sub(r"(?s)^.*?(?=<svg)|<metadata>.*?</metadata>", "", drawn)
