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


def polygons_of(outlines: Sequence[Floats]) -> NDArray[np.object_]:
    """Return the polygons with these outlines, each of (N, 2) with N of 3 or more, in metres."""
    if not outlines:
        return np.empty(0, object)
    corners, of = _joined(outlines)
    polygons: NDArray[np.object_] = shapely.polygons(shapely.linearrings(corners, indices=of))
    return polygons


def paths_of(lines: Sequence[Floats]) -> NDArray[np.object_]:
    """Return `lines`, each of (N, 2) with N of 2 or more, in metres, as line strings."""
    corners, of = _joined(lines)
    paths: NDArray[np.object_] = shapely.linestrings(corners, indices=of)
    return paths


def _joined(lines: Sequence[Floats]) -> tuple[Floats, NDArray[np.intp]]:
    """Return the corners of all `lines` (N, 2), and of which line each is (N,)."""
    return np.concatenate(lines), np.repeat(np.arange(len(lines)), [len(line) for line in lines])


def enclosed(lines: Sequence[Floats], snap: float) -> tuple[list[Polygon], list[Loose]]:
    """Return the areas that `lines` (each of (N, 2), metres) enclose, and the loose ones of them.

    Ends within `snap` metres of each other count as one. Of two lines that are the same, one
    counts.
    """
    corners, of = _joined(lines)
    edges = np.searchsorted(of, np.arange(len(lines) + 1))
    ends = np.column_stack([edges[:-1], edges[1:] - 1]).ravel()
    places = _met(corners[ends], snap)
    corners[ends] = places
    met = shapely.linestrings(corners, indices=of)
    keys = _keys(met)
    first: dict[bytes, int] = {}
    for k in np.flatnonzero(shapely.length(met) > 0).tolist():
        first.setdefault(keys[k], k)
    kept = met[np.array([*first.values()], int)]
    # Cuts are lines with the same area on both sides, dangles those with a loose end: both enclose
    # nothing.
    faces, cuts, dangles, _ = shapely.polygonize_full(kept)
    areas = shapely.polygons(shapely.get_exterior_ring(shapely.get_parts(faces)))
    order = np.lexsort(shapely.bounds(areas).T[::-1])  # by west, south, east and north
    loose = [first[key] for key in _keys(shapely.get_parts([cuts, dangles]))]
    return [*areas[order]], _loose(sorted(loose), [*first.values()], places)


def opened(areas: Sequence[Polygon]) -> list[Polygon]:
    """Return `areas` with those inside others as openings, and those inside openings as areas.

    None of them has a hole: an area with openings comes in pieces, cut through its openings.
    """
    if not areas:
        return []
    distinct = [*dict(zip(_keys(areas), areas, strict=True)).values()]
    tree = shapely.STRtree(distinct)
    # How many others each area is inside of is its depth; one just inside another is one deeper.
    inner, outer = tree.query(distinct, predicate="within")
    depth = np.bincount(inner[inner != outer], minlength=len(distinct))
    # The even-odd rule: inside an odd number of others it is an opening of the one just around it.
    whole = []
    for k, area in enumerate(distinct):
        if depth[k] % 2 == 0:
            within = inner[(outer == k) & (inner != k)]
            holes = [distinct[i] for i in within if depth[i] == depth[k] + 1]
            whole.append(shapely.difference(area, shapely.union_all(holes)))
    return [*pieces_of(whole)[0]]


def pieces_of(areas: Sequence[shapely.Geometry]) -> tuple[NDArray[np.object_], NDArray[np.intp]]:
    """Return `areas` as polygons without holes, cut across each hole, and which one each is of."""
    pieces, of = np.array(areas, object), np.arange(len(areas))
    while True:
        pieces, part_of = shapely.get_parts(pieces, return_index=True)
        solid = (shapely.get_type_id(pieces) == shapely.GeometryType.POLYGON) & (
            shapely.area(pieces) > 0
        )
        pieces, of = pieces[solid], of[part_of[solid]]
        holed = shapely.get_num_interior_rings(pieces) > 0
        if not holed.any():
            return pieces, of
        west, south, east, north = shapely.bounds(pieces[holed]).T
        _, low, _, high = shapely.bounds(shapely.get_interior_ring(pieces[holed], 0)).T
        # Through the middle of a hole: each half has a hole less, so this ends.
        cut = (low + high) / 2
        below = shapely.box(west - 1, south - 1, east + 1, cut)
        above = shapely.box(west - 1, cut, east + 1, north + 1)
        # Each with a hole makes room for its two halves, which stand in its place.
        copies = np.repeat(np.arange(len(pieces)), np.where(holed, 2, 1))
        halved = holed[copies]
        halves = np.column_stack([below, above]).ravel()
        pieces, of = pieces[copies], of[copies]
        pieces[halved] = shapely.intersection(pieces[halved], halves)


def _keys(geometries: Sequence[shapely.Geometry]) -> list[bytes]:
    """Return a key for each of `geometries`: those that are the same have the same."""
    keys: list[bytes] = shapely.to_wkb(shapely.normalize(geometries)).tolist()
    return keys


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
