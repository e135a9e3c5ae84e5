"""How all pictures look: sizes of a printed column, colours that everybody can tell apart."""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

from floorplan import Obstacle

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Width = Literal["single", "double"]
"""How many columns of a paper a picture takes."""

WIDTHS: dict[Width, float] = {"single": 3.5, "double": 7.16}
"""Inches: the columns of the IEEE's journals, close to everybody else's."""

BLACK = "#222222"
GREY = "#8a8a8a"
PALE = "#d9d9d9"
BLUE = "#0072b2"
ORANGE = "#e69f00"
VERMILION = "#d55e00"
GREEN = "#009e73"
PURPLE = "#cc79a7"
SKY = "#56b4e9"
# M. Okabe and K. Ito, "Color universal design", 2008.

PEOPLE = (BLUE, GREEN, PURPLE, SKY)
"""People's colours, in their order; again from the first where there are more."""

MACHINES = {"gantry": ORANGE, "agv": BLACK}

TALL = 2.5
"""Metres. What is as high as this is drawn darkest."""

_NOTEBOOK_DPI = 110

_SETTINGS: dict[str, Any] = {
    "font.family": "sans-serif",
    "font.size": 8,
    "axes.titlesize": 8,
    "axes.labelsize": 8,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "legend.fontsize": 7,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "lines.linewidth": 1.0,
    "lines.solid_capstyle": "round",
    "hatch.linewidth": 0.4,
    "figure.dpi": 150,
    "savefig.dpi": 300,
    "path.simplify": True,
    "path.simplify_threshold": 0.05,
    "svg.fonttype": "none",
    "svg.hashsalt": "floorwalker",
    "pdf.fonttype": 42,
}


class MissingExtraError(ValueError):
    """A package that Floorwalker can do without, but not here; the message says how to get it."""


@contextmanager
def styled() -> Iterator[None]:
    """Everything that is drawn or saved within looks the same, whatever the user's settings.

    `MissingExtraError` without matplotlib.
    """
    try:
        import matplotlib
    except ImportError:
        raise MissingExtraError(
            "pictures need matplotlib, which is missing: pip install 'floorwalker[plot]'"
        ) from None
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        for name, value in _SETTINGS.items():
            matplotlib.rcParams[name] = value  # type: ignore[index]
        yield


def new_figure(width: Width, height: float) -> Figure:
    """An empty figure, `height` inches high; its axes find their places themselves."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(inches(width), height), layout="constrained")
    # A notebook shows figures by themselves only where pyplot has been imported.
    figure._repr_png_ = partial(_as_png, figure)  # type: ignore[attr-defined]
    return figure


def _as_png(figure: Figure) -> bytes:
    with styled():
        picture = io.BytesIO()
        figure.savefig(picture, format="png", dpi=_NOTEBOOK_DPI)
        return picture.getvalue()


def inches(width: Width) -> float:
    """How wide a picture is; `ValueError` if it is not as wide as a column or two."""
    if width not in WIDTHS:
        raise ValueError(f"a picture is {' or '.join(WIDTHS)} column wide, not {width!r}")
    return WIDTHS[width]


def explain(figure: Figure, axes: Iterable[Axes], width: Width) -> None:
    """A legend above the picture of everything in `axes` that has a label; none if nothing has."""
    known: dict[str, Any] = {}
    for one in axes:
        handles, labels = one.get_legend_handles_labels()
        known |= dict(zip(labels, handles, strict=True))
    if known:
        columns = min(len(known), 6 if width == "double" else 2)
        figure.legend(known.values(), known.keys(), loc="outside upper center", ncols=columns)


def person_colour(index: int) -> str:
    """The colour of the person at a place in the order of people."""
    return PEOPLE[index % len(PEOPLE)]


def obstacle_shade(obstacle: Obstacle) -> float:
    """How light an obstacle is, from 0 to 1: the higher the darker."""
    return 0.86 - 0.42 * min(obstacle.top / TALL, 1.0)
