"""Areas from the lines of a drawing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import Polygon

from .model import Point

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Loose:
    """A line that bounds no area: its index, a loose end of it, and the distance to the next end.

    `gap` is None where its ends meet others, but the lines lead nowhere. All in metres.
    """

    index: int
    end: Point
    gap: float | None


def enclosed(lines: Sequence[Floats], snap: float) -> tuple[list[Polygon], list[Loose]]:
    """Return the areas that `lines` (each of (N, 2), metres) enclose, and the loose ones of them.

    Ends within `snap` metres of each other count as one. Of two lines that are the same, one
    counts.
    """
    ends = np.array([end for line in lines for end in (line[0], line[-1])])
    places = _met(ends, snap)
    met = []
    for k, line in enumerate(lines):
        corners = line.copy()
        corners[0], corners[-1] = places[2 * k], places[2 * k + 1]
        met.append(shapely.LineString(corners))
    first: dict[bytes, int] = {}
    for k, line in enumerate(met):
        if line.length > 0:
            first.setdefault(shapely.normalize(line).wkb, k)
    kept = [met[k] for k in first.values()]
    # Cuts are lines with the same area on both sides, dangles those with a loose end: both enclose
    # nothing.
    faces, cuts, dangles, _ = shapely.polygonize_full(kept)
    areas = sorted((Polygon(face.exterior) for face in faces.geoms), key=lambda area: area.bounds)
    loose = [first[shapely.normalize(line).wkb] for line in (*cuts.geoms, *dangles.geoms)]
    return areas, _loose(sorted(loose), [*first.values()], places)


def opened(areas: Sequence[Polygon]) -> list[Polygon]:
    """Return `areas` with those inside others as openings, and those inside openings as areas.

    None of them has a hole: an area with openings comes in pieces, cut through its openings.
    """
    distinct = [*{shapely.normalize(area).wkb: area for area in areas}.values()]
    tree = shapely.STRtree(distinct)
    # How many others each area is inside of is its depth; one just inside another is one deeper.
    inner, outer = tree.query(distinct, predicate="within")
    depth = np.bincount(inner[inner != outer], minlength=len(distinct))
    # The even-odd rule: inside an odd number of others it is an opening of the one just around it.
    pieces: list[Polygon] = []
    for k, area in enumerate(distinct):
        if depth[k] % 2 == 0:
            within = inner[(outer == k) & (inner != k)]
            holes = [distinct[i] for i in within if depth[i] == depth[k] + 1]
            pieces += pieces_of(shapely.difference(area, shapely.union_all(holes)))
    return pieces


def pieces_of(area: shapely.Geometry) -> list[Polygon]:
    """Return `area` as polygons without holes: it is cut across each of them."""
    pieces: list[Polygon] = []
    for part in shapely.get_parts(area):
        if part.geom_type != "Polygon" or not part.area:
            continue
        if not part.interiors:
            pieces.append(part)
            continue
        west, south, east, north = part.bounds
        _, low, _, high = part.interiors[0].bounds
        # Through the middle of a hole: each half has a hole less, so this ends.
        cut = (low + high) / 2
        for half in (
            shapely.box(west - 1, south - 1, east + 1, cut),
            shapely.box(west - 1, cut, east + 1, north + 1),
        ):
            pieces += pieces_of(shapely.intersection(part, half))
    return pieces


def _met(ends: Floats, snap: float) -> Floats:
    """Return the `ends` with those that are within `snap` of each other in one place."""
    points = shapely.points(ends)
    one, other = shapely.STRtree(points).query(points, predicate="dwithin", distance=snap)
    # Each takes the place of the first that it can be reached from, step by step. Following the
    # first of one's first halves what is left of a long chain in each round: Y. Shiloach and
    # U. Vishkin, An O(log n) parallel connectivity algorithm, Journal of Algorithms 3, 1982.
    first = np.arange(len(ends))
    while True:
        before = first.copy()
        np.minimum.at(first, one, first[other])
        first = first[first]
        if (first == before).all():
            places: Floats = ends[first]
            return places


def _loose(loose: list[int], lines: list[int], places: Floats) -> list[Loose]:
    """Return each of the `loose` lines with the end of it that is farthest from those of others."""
    if not loose:
        return []
    ends = places.reshape(-1, 2, 2)[lines].reshape(-1, 2)
    distinct, which, count = np.unique(ends, axis=0, return_inverse=True, return_counts=True)
    row = {line: k for k, line in enumerate(lines)}
    which = which.reshape(-1, 2)
    found = []
    gaps = np.zeros(len(distinct))
    alone = np.flatnonzero(count == 1)
    if len(alone) and len(distinct) > 1:
        points = shapely.points(distinct)
        nearest = shapely.STRtree(points).query_nearest(
            points[alone], exclusive=True, return_distance=True, all_matches=False
        )
        gaps[alone] = nearest[1]
    for index in loose:
        place = max(which[row[index]], key=lambda place: gaps[place])
        end, gap = distinct[place].tolist(), float(gaps[place])
        found.append(Loose(index, (end[0], end[1]), gap or None))
    return found
