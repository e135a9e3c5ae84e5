"""Style of figures, sample times of curves, marks of violations, and embedding in pages.

Curves are smooth between changes of a motion, so that a few samples per second suffice. Changes are
sampled on both sides, and lines are broken at jumps.
"""

from __future__ import annotations

import html
import io
import itertools
import math
import warnings
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, Literal

import matplotlib.style
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator
from numpy.typing import NDArray

from floorplan import Obstacle, Point, UserError
from navigation import Motion

from ...core.body import Category
from ...machines.gantry.robot import GANTRY
from ...record.outcome import Outcome
from ...record.output import replacing, writing
from ...record.sampling import Span
from ..report_page import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    as_element,
    require_place,
    svg_of,
)

Width = Literal["single", "double"]
"""The number of columns of a paper that a picture takes."""

WIDTHS: dict[Width, float] = {"single": 3.5, "double": 7.16}
"""Inches. Column widths of IEEE journals, similar to those of others."""

PEOPLE = (BLUE, GREEN, PURPLE, SKY)
"""Colours of people in order, repeated if there are more."""

MACHINES: dict[Category, str] = {"robot": ORANGE, "vehicle": BLACK}

LONG = 3600.0
"""Seconds from which times are written as hours and minutes."""

HANDY = (600.0, 900.0, 1800.0, 3600.0, 7200.0, 14400.0, 43200.0, 86400.0)
"""Seconds between two marks of such an axis."""

MOST_NAMED = 12
"""Maximum number of people in a legend."""

OF_MANY = 0.5
"""Points. Line width of people who are not in the legend."""

_LINE = 0.15
"""Inches. Height of a line of a legend."""

TALL = 2.5
"""Metres. Height of obstacles from which they are drawn darkest."""

_NOTEBOOK_DPI = 110

_METADATA: dict[str, dict[str, Any]] = {
    ".png": {},
    ".svg": {"Date": None},
    ".pdf": {"CreationDate": None},
}
"""Fields that are omitted from each kind of file, because they contain the time."""

FORMATS = tuple(_METADATA)

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


@contextmanager
def styled(**more: Any) -> Iterator[None]:
    """Apply the style of Floorwalker in this context or function, whatever the user's settings.

    `more` are further settings of Matplotlib. Its repeated warnings about characters that the font
    lacks are hidden. These characters are drawn as boxes.
    """
    looks = matplotlib.style.context({**_SETTINGS, **more}, after_reset=True)
    with warnings.catch_warnings(), looks:
        warnings.filterwarnings("ignore", r"Glyph \d+ ", UserWarning)
        yield


def new_figure(width: Width, height: float) -> Figure:
    """Return an empty figure, `height` inches high, with constrained layout."""
    figure = Figure(figsize=(inches(width), height), layout="constrained")
    # Notebooks show figures themselves only if pyplot has been imported.
    figure._repr_png_ = partial(_as_png, figure)  # type: ignore[attr-defined]
    return figure


@styled()
def _as_png(figure: Figure) -> bytes:
    picture = io.BytesIO()
    figure.savefig(picture, format="png", dpi=_NOTEBOOK_DPI)
    return picture.getvalue()


def settle(figure: Figure) -> Figure:
    """Execute the layout of a figure once before it is drawn, and return the figure.

    Beside a colour bar, axes with equal scales end up narrower than the layout assumes. The next
    execution takes their width into account.
    """
    engine = figure.get_layout_engine()
    assert engine is not None  # as of `new_figure`
    engine.execute(figure)
    return figure


@styled()
def save(figure: Figure, path: str | Path) -> None:
    """Write a figure to a PNG, SVG or PDF file.

    Text remains text in SVG and PDF files. The same figure has the same bytes.

    Parameters
    ----------
    figure : Figure
        Figure.
    path : str or Path
        File.

    Raises
    ------
    ValueError
        If the suffix is unknown.
    OutputError
        If the file cannot be written.
    """
    path = Path(path)
    require_savable(path)
    with writing(path), replacing(path) as unfinished:
        figure.savefig(unfinished, metadata=_METADATA[path.suffix.lower()])


def require_savable(path: str | Path) -> None:
    """Raise the errors of `save` that can be found before the figure is drawn.

    Parameters
    ----------
    path : str or Path
        File.

    Raises
    ------
    ValueError
        If the suffix is unknown.
    OutputError
        If the folder does not exist.
    """
    require_place(path, "picture", FORMATS)


def inches(width: Width) -> float:
    """Return the width (inches) of a picture. `ValueError` if `width` is unknown."""
    if width not in WIDTHS:
        raise UserError(f"a picture is {' or '.join(WIDTHS)} column wide, not {width!r}")
    return WIDTHS[width]


def explain(figure: Figure, axes: Iterable[Axes], width: Width) -> None:
    """Put a legend of all labels in `axes` above the picture.

    The height of the picture grows with the number of lines.
    """
    labelled: dict[str, Any] = {}
    for one in axes:
        handles, labels = one.get_legend_handles_labels()
        labelled |= dict(zip(labels, handles, strict=True))
    if labelled:
        columns = min(len(labelled), 6 if width == "double" else 2)
        figure.legend(labelled.values(), labelled.keys(), loc="outside upper center", ncols=columns)
        lines = math.ceil(len(labelled) / columns)
        figure.set_figheight(figure.get_figheight() + (lines - 1) * _LINE)


def label_time(axes: Axes, span: float) -> None:
    """Label the x axis of `span` seconds of time, in seconds or as h:mm."""
    if span < LONG:
        axes.set_xlabel("time (s)")
        return
    step = next(s for s in (*HANDY, span) if span / s <= 10)
    axes.xaxis.set_major_locator(MultipleLocator(step))
    axes.xaxis.set_major_formatter(lambda t, _: f"{t // 3600:.0f}:{t % 3600 // 60:02.0f}")
    axes.set_xlabel("time (h:mm)")


def person_colour(index: int) -> str:
    """Return the colour of the person with this index."""
    return PEOPLE[index % len(PEOPLE)]


def person_label(name: str, count: int) -> str:
    """Return the label of one of `count` people, hidden from the legend if there are many."""
    return name if are_few(count) else f"_{name}"


def are_few(count: int) -> bool:
    """Return True if this number of people can be distinguished in a picture."""
    return count <= MOST_NAMED


def obstacle_shade(obstacle: Obstacle) -> float:
    """Return the lightness of an obstacle from 0 to 1. Higher obstacles are darker."""
    return 0.86 - 0.42 * min(obstacle.top / TALL, 1.0)


Array = NDArray[np.float64]

STEP = 0.1
"""Seconds. Maximum interval between samples of a curve."""


def while_present(run: Outcome, body: str, span: Span) -> Span | None:
    """Return the part of `span` in which a body is on the floor, or None if it never is."""
    begin, end = run.presence[body]
    begin, end = max(span[0], begin), min(span[1], end)
    return (begin, end) if begin < end else None


def instants(motions: Sequence[Motion], begin: float, end: float) -> Array:
    """Return times (N,) to draw motions from `begin` to just before `end` (s).

    Every change has two samples, one just before it. NaN separates them at a teleport, so that the
    line is broken. Straight stretches of a single motion have only their ends.
    """
    changes = {begin, end}
    for motion in motions:
        edges = [t for piece in motion.pieces for t in (piece.begin, piece.end)]
        changes.update(t for t in edges if begin < t < end)
    jumps = {t for motion in motions for t in motion.jumps}
    cuts = sorted(changes)
    stretches: list[Array] = []
    for since, until in itertools.pairwise(cuts):
        if since in jumps and stretches:
            stretches.append(np.array([np.nan]))
        straight = len(motions) == 1 and _is_straight(motions[0], since)
        steps = 1 if straight else math.ceil((until - since) / STEP)
        stretches.append(np.linspace(since, np.nextafter(until, since), steps + 1))
    return np.concatenate(stretches)


def _is_straight(motion: Motion, t: float) -> bool:
    """Return whether the motion is linear from `t` (s) to the next change."""
    piece = motion.pieces_from(t)[0]
    return t >= motion.end or not any((*piece.x[2:], *piece.y[2:], *piece.rotation[1:]))


def speeds(motion: Motion, t: Array) -> Array:
    """Return the speed over the floor: (N,) m/s, NaN where `t` is NaN."""
    vx, vy = motion.velocity(t).T
    return np.where(np.isnan(t), np.nan, np.hypot(vx, vy))


def breaches(run: Outcome, span: Span) -> list[tuple[float, Point]]:
    """Return time (s) and position of the person for every violation within `span`."""
    begin, end = span
    return sorted(
        (t, run.motions[person].state_before(t).at)
        for (person, _), intervals in run.violations.items()
        for t, _ in intervals
        if begin <= t <= end
    )


def mark_breaches(axes: Axes, places: Sequence[Point]) -> None:
    """Mark the positions of violations."""
    if places:
        axes.plot(
            *zip(*places, strict=True),
            "v",
            color=VERMILION,
            markersize=4.5,
            markeredgecolor="white",
            markeredgewidth=0.4,
            label="too close",
            zorder=5,
        )


def disabled_spans(run: Outcome, machine: str) -> list[Span]:
    """Return begin and end (s) of the intervals in which a machine was disabled."""
    spans: list[Span] = []
    since: float | None = None
    for event in run.events:
        if event.get("machine", GANTRY) != machine:
            continue
        if event["kind"] in ("gantry_disabled", "robot_malfunction") and since is None:
            since = event["t"]
        elif event["kind"] == "gantry_enabled" and since is not None:
            spans.append((since, event["t"]))
            since = None
    return spans if since is None else [*spans, (since, run.duration)]


def figure_element(figure: Figure, name: str, words: str) -> str:
    """Return a figure as an SVG element. Its `name` is unique on the page."""
    with styled(**{"svg.hashsalt": name}):
        drawn = as_element(svg_of(figure))
    return drawn.replace("<svg", f'<svg role="img" aria-label="{html.escape(words)}"', 1)
