"""HTML reports: colours, charts as SVG elements, and the writer of a page."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floorplan import UserError

from ..record.output import OutputError, write_whole

if TYPE_CHECKING:
    from jinja2 import Environment
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class MissingExtraError(ImportError, UserError):
    """Error of an optional package that is missing. The message contains the remedy."""


def require_place(path: str | Path, what: str, endings: tuple[str, ...]) -> None:
    """Raise if `path` has none of the `endings` or its folder is missing. `what` names the file."""
    path = Path(path)
    if path.suffix.lower() not in endings:
        raise UserError(f"{path}: the name of a {what} ends in one of {', '.join(endings)}")
    if not path.parent.is_dir():
        raise OutputError(f"can't write {path}: there is no folder {path.parent}")


# M. Okabe and K. Ito, "Color universal design", 2008.
BLUE = "#0072b2"
ORANGE = "#e69f00"
VERMILION = "#d55e00"
GREEN = "#009e73"
PURPLE = "#cc79a7"
SKY = "#56b4e9"

# Further colours, which do not distinguish things.
BLACK = "#222222"
GREY = "#8a8a8a"
PALE = "#d9d9d9"
PALE_ORANGE = "#fbe6bd"
BROWN = "#8a6d3b"


INK = "#123456"
"""Placeholder of the page's colour of text."""

_SVG_DPI = 72
"""Dots per inch of SVG files, as Matplotlib assumes them."""

COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BROWN)
"""Colours of rows and lines, in order."""


def page_chart(name: str, size: tuple[float, float], draw: Callable[[Figure], None]) -> str | None:
    """Return the drawing of `draw`, `size` inches wide and high, as an SVG element.

    `name` is unique on the page. The result is None without matplotlib.
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
        drawn = svg_of(figure, transparent=True)
    return as_element(drawn).replace(INK, "currentColor")


def svg_of(figure: Figure, *, transparent: bool = False) -> str:
    """Return a figure with constrained layout as the text of an SVG file.

    Matplotlib would draw the whole figure an additional time to execute its layout.
    """
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    FigureCanvasSVG(figure)  # measures text as it is written
    figure.set_dpi(_SVG_DPI)
    engine = figure.get_layout_engine()
    assert engine is not None
    engine.execute(figure)
    figure.set_layout_engine(None)
    text = io.StringIO()
    figure.savefig(text, format="svg", transparent=transparent, metadata={"Date": None})
    return text.getvalue()


def name_rows(axes: Axes, names: Sequence[str]) -> None:
    """Name the rows of a chart, the first on top, and remove everything but a grid around them."""
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.5, -0.5)
    axes.tick_params(axis="y", length=0)
    axes.spines[["left", "right", "top"]].set_visible(False)
    draw_grid(axes, "x")


class BoxLine(NamedTuple):
    """Ends of the line of a box, and the median between them."""

    least: float
    median: float
    most: float


def draw_box(
    axes: Axes, place: float, values: NDArray[np.float64], colour: str, height: float = 0.55
) -> BoxLine:
    """Draw the middle half of the values of a row as a box, nine tenths as a line."""
    least, low, middle, high, most = np.quantile(values, [0.05, 0.25, 0.5, 0.75, 0.95]).tolist()
    axes.plot([least, most], [place, place], color=colour, linewidth=1.2)
    axes.barh(place, high - low, left=low, height=height, color=colour, alpha=0.45, linewidth=0)
    return BoxLine(least, middle, most)


def draw_interval(
    axes: Axes, x: tuple[float, float], y: tuple[float, float], mean: tuple[float, float]
) -> None:
    """Draw the interval of a mean as a line from one point to another, and the mean as a dot."""
    axes.plot(x, y, color=INK, linewidth=2.2)
    axes.plot(*mean, "o", color=INK, markersize=4.5)


def draw_grid(axes: Axes, which: Literal["both", "x", "y"]) -> None:
    """Draw the grid of a chart below its contents."""
    axes.grid(axis=which, alpha=0.2, color=INK)
    axes.set_axisbelow(True)


def as_element(drawn: str) -> str:
    """Return the SVG element of a drawn file without metadata."""
    return re.sub(r"(?s)^.*?(?=<svg)|<metadata>.*?</metadata>", "", drawn)


def write_report_page(
    path: Path, template: str, filters: Mapping[str, Callable[..., Any]], **values: Any
) -> None:
    """Write the page that a template of `data/report` makes of `values` to `path`.

    `filters` are functions that the template names.
    """
    environment = _environment(frozenset(filters.items()))
    write_whole(path, environment.get_template(template).render(**values))


@cache
def _environment(filters: frozenset[tuple[str, Callable[..., Any]]]) -> Environment:
    """Return the environment of templates with these filters, which caches compiled templates."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("sim", "data/report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= dict(filters)
    return environment
