"""Shapes from the corners of a drawing's lines and hatched areas, of all of them at once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from .outlines import polygons_of
from .reading import LARGEST, are_figures

Floats = NDArray[np.float64]

Name = Callable[[], str]
"""Gives the name of an entity: few are ever told."""

OUTSIZED = f"has coordinates that are not numbers of at most {LARGEST:g} m"
"""Why an entity is not read with which nothing can be worked out."""

TOUCHING = 1e-9
"""Metres. Ends of an outline that are nearer to each other are one corner: arcs end by rounding."""


@dataclass(frozen=True)
class Shape:
    """A line of a drawing in metres, of the layer `layer`; `name` that of its entity.

    `corners` is (N, 2). A `closed` one bounds an area; a `filled` one is a hatched area, with
    `holes` in it. `bottom` and `thickness` are heights.
    """

    layer: str
    name: Name
    corners: Floats
    closed: bool
    bottom: float
    thickness: float
    filled: bool = False
    holes: shapely.Geometry = None


@dataclass(frozen=True)
class Unread:
    """An entity that is no shape: `why` it is not, and whether it is on a layer that is read."""

    layer: str
    name: Name
    why: str
    wanted: bool


class Stroke(NamedTuple):
    """A line as it is drawn, in units of the drawing: corners (N, 3), closed or maybe not."""

    layer: str
    name: Name
    corners: Floats
    closed: bool
    thickness: float


class Hatched(NamedTuple):
    """The outlines of a hatched area, each of (N, 3) corners, in units of the drawing."""

    layer: str
    name: Name
    outlines: list[Floats]


Traced = Stroke | Hatched | Unread


def shapes(found: Sequence[Traced], metre: float) -> Iterator[Shape | Unread]:
    """Yield what was `found` in a drawing with a unit of `metre` metres as shapes, in its order."""
    lines = _lines([one for one in found if isinstance(one, Stroke)], metre)
    areas = _areas([one for one in found if isinstance(one, Hatched)], metre)
    for one in found:
        if isinstance(one, Unread):
            yield one
        elif isinstance(one, Stroke):
            yield next(lines)
        else:
            yield from next(areas)


def _lines(strokes: Sequence[Stroke], metre: float) -> Iterator[Shape | Unread]:
    """Yield one for each of `strokes`; one whose ends meet is closed, without the last of them."""
    if not strokes:
        return
    count = np.array([len(stroke.corners) for stroke in strokes])
    corners = np.concatenate([stroke.corners for stroke in strokes]) * metre
    begin = np.cumsum(count) - count
    last = begin + count - 1
    thick = np.array([stroke.thickness for stroke in strokes]) * metre
    fit = np.logical_and.reduceat(are_figures(corners).all(axis=1), begin) & are_figures(thick)
    with np.errstate(invalid="ignore"):
        apart = np.abs(corners[begin, :2] - corners[last, :2])
    long = count > 3
    closed = np.array([stroke.closed for stroke in strokes]) | (long & ~apart.any(axis=1))
    # A closed line whose ends are one corner has it once. The second of them is left out of the
    # heights below, too: they are worked out of all that a line had.
    twice = closed & long & (apart < TOUCHING).all(axis=1)
    count[twice] -= 1
    corners[last[twice], 2] = np.inf
    bottom = np.minimum.reduceat(corners[:, 2], begin).tolist()
    parts = zip(begin.tolist(), (begin + count).tolist(), strict=True)
    closed, fit = closed.tolist(), fit.tolist()
    for k, (stroke, (start, stop)) in enumerate(zip(strokes, parts, strict=True)):
        layer, name = stroke.layer, stroke.name
        if not fit[k]:
            yield Unread(layer, name, OUTSIZED, True)
        elif closed[k] and stop - start < 3:
            yield Unread(layer, name, "has fewer than three corners", True)
        else:
            at, thickness = bottom[k], float(thick[k])
            yield Shape(layer, name, corners[start:stop, :2], closed[k], at, thickness)


def _areas(hatches: Sequence[Hatched], metre: float) -> Iterator[list[Shape | Unread]]:
    """Yield the areas of each hatch: an outline inside an odd number of others is an opening."""
    scaled = [[outline * metre for outline in hatch.outlines] for hatch in hatches]
    areas = np.full(len(hatches), shapely.Polygon())
    for k in range(max(map(len, scaled), default=0)):
        rows = [row for row, outlines in enumerate(scaled) if k < len(outlines)]
        polygons = polygons_of([scaled[row][k][:, :2] for row in rows])
        # Exclusive or of all boundaries is the even-odd rule, in whatever order they come.
        areas[rows] = shapely.symmetric_difference(areas[rows], shapely.make_valid(polygons))
    for hatch, outlines, area in zip(hatches, scaled, areas, strict=True):
        parts = [part for part in shapely.get_parts(area) if part.geom_type == "Polygon"]
        found: list[Shape | Unread] = []
        for part in parts:
            ring = shapely.get_coordinates(part.exterior)
            holes = shapely.union_all([shapely.Polygon(hole) for hole in part.interiors])
            bottom = float(outlines[-1][:, 2].min())
            found.append(
                Shape(hatch.layer, hatch.name, ring, True, bottom, 0.0, filled=True, holes=holes)
            )
        yield found or [Unread(hatch.layer, hatch.name, "encloses no area", True)]
