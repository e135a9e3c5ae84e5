"""Drawings: groups of layers, polylines, and the areas that lines enclose."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import Polygon

from ..files.fields import LARGEST, are_figures
from ..files.problems import Problem, suggestion
from ..model import Point

BOUNDARY = "boundary"
"""The group of the outline of the floor; without groups, the layer of that name."""


@dataclass(frozen=True)
class LayerGroup:
    """Layers by patterns (`A-WALL*`), in capitals or not, and how their shapes are read.

    `z` are the heights of the shapes (metres) instead of the drawn ones. With a `line_width`
    (metres) every line stands for a wall this wide. Where it is `hollow`, outlines inside outlines
    are openings.
    """

    patterns: tuple[str, ...]
    z: tuple[float, float] | None = None
    line_width: float | None = None
    hollow: bool = False

    def has(self, layer: str) -> bool:
        """Return whether `layer` is one of them."""
        return any(fnmatchcase(layer.casefold(), one.casefold()) for one in self.patterns)


@dataclass(frozen=True)
class Drawn:
    """How a drawing is read, where the drawing itself leaves it open.

    `metre` is the length of its unit (metres), None for the unit that it gives itself. Without
    `groups` every layer is one. Ends of lines within `snap` metres of each other meet. Shapes are
    left out by their handles. A `boundary` (metres) takes the place of the drawn one.
    """

    metre: float | None = None
    groups: Mapping[str, LayerGroup] | None = None
    snap: float = 1e-6
    leave_out: frozenset[str] = frozenset()
    boundary: Polygon | None = None

    def group_of(self, layer: str) -> str | None:
        """Return the name of the first group with this layer, None if it is in none."""
        if self.groups is None:
            return BOUNDARY if layer.casefold() == BOUNDARY else layer
        return next((name for name, group in self.groups.items() if group.has(layer)), None)

    def group(self, name: str) -> LayerGroup:
        """Return the group of this name."""
        return LayerGroup(()) if self.groups is None else self.groups[name]

    def unmatched(self, layers: Collection[str]) -> Iterator[Problem]:
        """Yield a problem for each pattern that none of `layers` matches."""
        for name, group in (self.groups or {}).items():
            for pattern in group.patterns:
                if not any(LayerGroup((pattern,)).has(layer) for layer in layers):
                    hint = suggestion(pattern, sorted(layers)) if layers else "it has none"
                    yield Problem(f"no layer of the drawing matches {pattern!r}; {hint}", name)


AS_IT_IS = Drawn()
"""Reading of a drawing on its own."""


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


Corners = NDArray[np.float64]

Name = Callable[[], str]
"""Gives the name of an entity: few are ever told."""

OUTSIZED = f"has coordinates that are not numbers of at most {LARGEST:g} m"
"""Why an entity is not read with which nothing can be worked out."""

TOUCHING = 1e-9
"""Metres. Ends of an outline that are nearer to each other are one corner: arcs end by rounding."""


@dataclass(frozen=True)
class Polyline:
    """A line of a drawing in metres, of the layer `layer`; `name` that of its entity.

    `corners` is (N, 2). A `closed` one bounds an area; a `filled` one is a hatched area, with
    `holes` in it. `bottom` and `thickness` are heights.
    """

    layer: str
    name: Name
    corners: Corners
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
    corners: Corners
    closed: bool
    thickness: float


class Hatched(NamedTuple):
    """The outlines of a hatched area, each of (N, 3) corners, in units of the drawing."""

    layer: str
    name: Name
    outlines: list[Corners]


Traced = Stroke | Hatched | Unread


def shapes(found: Sequence[Traced], metre: float) -> Iterator[Polyline | Unread]:
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


def _lines(strokes: Sequence[Stroke], metre: float) -> Iterator[Polyline | Unread]:
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
            yield Polyline(layer, name, corners[start:stop, :2], closed[k], at, thickness)


def _areas(hatches: Sequence[Hatched], metre: float) -> Iterator[list[Polyline | Unread]]:
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
        found: list[Polyline | Unread] = []
        for part in parts:
            ring = shapely.get_coordinates(part.exterior)
            holes = shapely.union_all([shapely.Polygon(hole) for hole in part.interiors])
            bottom = float(outlines[-1][:, 2].min())
            found.append(
                Polyline(hatch.layer, hatch.name, ring, True, bottom, 0.0, filled=True, holes=holes)
            )
        yield found or [Unread(hatch.layer, hatch.name, "encloses no area", True)]
