"""Drawings: groups of layers, polylines, and the areas that lines enclose."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from typing import TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import Polygon

from ..checks import polygon_fault
from ..files.fields import LARGEST, are_figures, is_figure
from ..files.problems import Problem, metres, suggestion
from ..model import DEFAULT_HEIGHT, Obstacle, Point

BOUNDARY = "boundary"
"""Group with the outline of the floor. Without groups, the layer of that name."""


@dataclass(frozen=True)
class LayerGroup:
    """Layers by patterns (`A-WALL*`, ignoring case), and how their shapes are read.

    `z` (metres) replaces the heights of the shapes. With a `line_width` (metres) each line is a
    wall of this width. If `hollow`, outlines inside outlines are openings.
    """

    patterns: tuple[str, ...]
    z: tuple[float, float] | None = None
    line_width: float | None = None
    hollow: bool = False

    def has(self, layer: str) -> bool:
        """Return whether the group contains `layer`."""
        return any(fnmatchcase(layer.casefold(), one.casefold()) for one in self.patterns)


@dataclass(frozen=True)
class Drawn:
    """Options for reading a drawing.

    `metre` is its unit in metres, None for the unit in the drawing. Without `groups` every layer is
    a group. Ends of lines within `snap` metres of each other meet. By default these are ends that
    meet no other end, within `SNAP`. `leave_out` has the handles of ignored shapes. `boundary`
    (metres) replaces the drawn one.
    """

    metre: float | None = None
    groups: Mapping[str, LayerGroup] | None = None
    snap: float | None = None
    leave_out: frozenset[str] = frozenset()
    boundary: Polygon | None = None

    def group_of(self, layer: str) -> str | None:
        """Return the name of the first group with this layer, or None."""
        if self.groups is None:
            return BOUNDARY if layer.casefold() == BOUNDARY else layer
        return next((name for name, group in self.groups.items() if group.has(layer)), None)

    def group(self, name: str) -> LayerGroup:
        """Return the group of this name."""
        return LayerGroup(()) if self.groups is None else self.groups[name]

    def unmatched(self, layers: Collection[str]) -> Iterator[Problem]:
        """Yield a problem for each pattern that matches none of the `layers`."""
        for name, group in (self.groups or {}).items():
            for pattern in group.patterns:
                if not any(LayerGroup((pattern,)).has(layer) for layer in layers):
                    hint = suggestion(pattern, sorted(layers)) if layers else "it has none"
                    yield Problem(f"no layer of the drawing matches {pattern!r}; {hint}", name)


AS_IT_IS = Drawn()
"""Options for a drawing without a floor above it."""


Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Loose:
    """Line that bounds no area: its index, a loose end, and the distance to the nearest end.

    `gap` is None if its ends meet others, but the lines enclose no area. All in metres.
    """

    index: int
    end: Point
    gap: float | None


def polygons_of(outlines: Sequence[Floats]) -> NDArray[np.object_]:
    """Return the polygons with these outlines, each (N, 2) in metres with N of at least 3."""
    if not outlines:
        return np.empty(0, object)
    corners, of = _joined(outlines)
    polygons: NDArray[np.object_] = shapely.polygons(shapely.linearrings(corners, indices=of))
    return polygons


def _joined(lines: Sequence[Floats]) -> tuple[Floats, NDArray[np.intp]]:
    """Return the corners of all `lines` (N, 2), and the index of the line of each (N,)."""
    return np.concatenate(lines), np.repeat(np.arange(len(lines)), [len(line) for line in lines])


def enclosed(lines: Sequence[Floats], snap: float | None) -> tuple[list[Polygon], list[Loose]]:
    """Return the areas that `lines` (each (N, 2), metres) enclose, and the loose lines.

    Ends within `snap` metres count as one (see `Drawn`). Equal lines count once.
    """
    corners, of = _joined(lines)
    edges = np.searchsorted(of, np.arange(len(lines) + 1))
    ends = np.column_stack([edges[:-1], edges[1:] - 1]).ravel()
    once = _first_of_each(shapely.linestrings(corners, indices=of)).values()
    places = _met(corners[ends], snap, np.repeat(np.isin(np.arange(len(lines)), [*once]), 2))
    corners[ends] = places
    met = shapely.linestrings(corners, indices=of)
    first = _first_of_each(met)
    distinct = met[np.array([*first.values()], int)]
    # Cuts are lines with the same area on both sides, and dangles have a loose end. Both enclose no
    # area.
    faces, cuts, dangles, _ = shapely.polygonize_full(distinct)
    areas = shapely.polygons(shapely.get_exterior_ring(shapely.get_parts(faces)))
    order = np.lexsort(shapely.bounds(areas).T[::-1])  # by west, south, east and north
    loose = [first[key] for key in _keys(shapely.get_parts([cuts, dangles]))]
    return [*areas[order]], _loose(sorted(loose), [*first.values()], places)


def opened(areas: Sequence[Polygon]) -> list[Polygon]:
    """Return `areas` with inner ones as openings, and areas inside openings as areas.

    The results have no holes. An area with openings is cut into pieces through its openings.
    """
    if not areas:
        return []
    distinct = [*dict(zip(_keys(areas), areas, strict=True)).values()]
    tree = shapely.STRtree(distinct)
    # The depth of an area is the number of areas around it.
    inner, outer = tree.query(distinct, predicate="within")
    depth = np.bincount(inner[inner != outer], minlength=len(distinct))
    # By the even-odd rule, an area at an odd depth is an opening of the area around it.
    whole = []
    for k, area in enumerate(distinct):
        if depth[k] % 2 == 0:
            within = inner[(outer == k) & (inner != k)]
            holes = [distinct[i] for i in within if depth[i] == depth[k] + 1]
            whole.append(shapely.difference(area, shapely.union_all(holes)))
    return [*pieces_of(whole)[0]]


def pieces_of(areas: Sequence[shapely.Geometry]) -> tuple[NDArray[np.object_], NDArray[np.intp]]:
    """Return `areas` cut into polygons without holes, and the index of the area of each."""
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
        # A cut through a hole leaves one hole less in each half, so the loop ends.
        cut = (low + high) / 2
        below = shapely.box(west - 1, south - 1, east + 1, cut)
        above = shapely.box(west - 1, cut, east + 1, north + 1)
        # Replace each area with a hole by its two halves.
        copies = np.repeat(np.arange(len(pieces)), np.where(holed, 2, 1))
        halved = holed[copies]
        halves = np.column_stack([below, above]).ravel()
        pieces, of = pieces[copies], of[copies]
        pieces[halved] = shapely.intersection(pieces[halved], halves)


def _keys(geometries: Sequence[shapely.Geometry] | NDArray[np.object_]) -> list[bytes]:
    """Return a key for each of the `geometries`. Equal geometries have equal keys."""
    keys: list[bytes] = shapely.to_wkb(shapely.normalize(geometries)).tolist()
    return keys


def _first_of_each(lines: NDArray[np.object_]) -> dict[bytes, int]:
    """Return the index of the first of each set of equal `lines`, by their keys."""
    keys = _keys(lines)
    first: dict[bytes, int] = {}
    for k in np.flatnonzero(shapely.length(lines) > 0).tolist():
        first.setdefault(keys[k], k)
    return first


SNAP = 1e-3
"""Metres. Default distance of a loose end to the next one. Coordinates and angles often have 3
decimals."""

_SAME = 1e-6
"""Metres. Closer ends are the same point."""


def _met(ends: Floats, snap: float | None, counted: NDArray[np.bool_]) -> Floats:
    """Return the `ends` with meeting ends at one position.

    The `counted` ends that meet no other end are loose.
    """
    points = shapely.points(ends)
    tree = shapely.STRtree(points)
    one, other = tree.query(points, predicate="dwithin", distance=_SAME if snap is None else snap)
    first = _connected(len(ends), one, other)
    # Loose ends meet the nearest end in steps, so that a curve of many short lines stays a curve.
    for reach in (10 * _SAME, 100 * _SAME, SNAP) if snap is None else ():
        loose = np.flatnonzero(np.bincount(first, counted, len(ends))[first] == 1)
        if not len(loose):
            break
        index, near = tree.query(points[loose], predicate="dwithin", distance=reach)
        one, other = np.append(one, (loose[index], near)), np.append(other, (near, loose[index]))
        first = _connected(len(ends), one, other)
    places: Floats = ends[first]
    return places


def _connected(count: int, one: NDArray[np.intp], other: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return for each of `count` indices the first one connected with it by pairs of indices."""
    # Pointer jumping halves the rest of a long chain in each round: Y. Shiloach and U. Vishkin, An
    # O(log n) parallel connectivity algorithm, Journal of Algorithms 3, 1982.
    first = np.arange(count)
    while True:
        before = first.copy()
        np.minimum.at(first, one, first[other])
        first = first[first]
        if (first == before).all():
            return first


def _loose(loose: list[int], lines: list[int], places: Floats) -> list[Loose]:
    """Return each of the `loose` lines with its end that is farthest from other ends."""
    if not loose:
        return []
    ends = places.reshape(-1, 2, 2)[lines].reshape(-1, 2)
    distinct, which, count = np.unique(ends, axis=0, return_inverse=True, return_counts=True)
    row = {line: k for k, line in enumerate(lines)}
    which = which.reshape(-1, 2)
    loose_lines = []
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
        loose_lines.append(Loose(index, (end[0], end[1]), gap or None))
    return loose_lines


Name = Callable[[], str]
"""Function that returns the name of an entity, because few names are needed."""

OUTSIZED = f"has coordinates that are not numbers of at most {LARGEST:g} m"
"""Message about a shape with too large coordinates."""

TOUCHING = 1e-9
"""Metres. Closer ends of an outline are one corner, because arcs end with rounding errors."""


@dataclass(frozen=True, slots=True)
class Polyline:
    """Line of an entity on `layer`, in metres: `corners` is (N, 2).

    A `closed` line bounds an area. Hatched entities have an `area`. `covered` is the area of a line
    that is drawn with a width. `bottom` and `thickness` are heights.
    """

    layer: str
    name: Name
    corners: Floats
    closed: bool
    bottom: float
    thickness: float
    area: Polygon | None = None
    covered: shapely.Geometry | None = None


@dataclass(frozen=True, slots=True)
class Unread:
    """Entity that is no shape, the reason, and whether this is a problem or a notice."""

    layer: str
    name: Name
    why: str
    is_problem: bool = True


Shape: TypeAlias = Polyline | Unread


def line(
    layer: str,
    name: Name,
    corners: Floats,
    closed: bool,
    thickness: float,
    covered: shapely.Geometry | None = None,
) -> Shape:
    """Return an entity with these corners (N, 3) in metres. It is closed if its ends meet."""
    if not (are_figures(corners).all() and is_figure(thickness)):
        return Unread(layer, name, OUTSIZED)
    if len(corners) > 3:
        apart = np.abs(corners[0, :2] - corners[-1, :2])
        closed = closed or not apart.any()
        if closed and (apart < TOUCHING).all():
            corners = corners[:-1]
    if closed and len(corners) < 3:
        if covered is None:
            return Unread(layer, name, "has fewer than three corners")
        closed = False
    bottom = float(corners[:, 2].min())
    return Polyline(layer, name, corners[:, :2], closed, bottom, thickness, None, covered)


def wall(corners: Floats, closed: bool, width: float, ends: str) -> shapely.Geometry:
    """Return the area of a line (N, 2) of this width, with "flat" or "square" ends."""
    line = shapely.linestrings(np.append(corners, corners[:1], axis=0) if closed else corners)
    return line.buffer(width / 2, cap_style=ends, join_style="mitre")


def hatched(layer: str, name: Name, outlines: Sequence[Floats]) -> Iterator[Shape]:
    """Yield the areas of a hatch with `outlines` of (N, 3) corners in metres.

    By the even-odd rule, an outline inside an odd number of others is an opening.
    """
    area: shapely.Geometry = Polygon()
    for polygon in shapely.make_valid(polygons_of([outline[:, :2] for outline in outlines])):
        area = area.symmetric_difference(polygon)
    parts = [part for part in shapely.get_parts(area) if part.geom_type == "Polygon"]
    for part in parts:
        ring = shapely.get_coordinates(part.exterior)
        yield Polyline(layer, name, ring, True, float(outlines[-1][:, 2].min()), 0.0, part)
    if not parts:
        yield Unread(layer, name, "encloses no area")


Heights = tuple[float, float]


def place_of(shape: Shape) -> str:
    """Return the place of a shape in the drawing."""
    return f"layer {shape.layer!r}, {shape.name()}"


_FILLED = "its inside is filled, too, unless its group is `hollow`"


def areas_in(
    name: str, shapes: list[Polyline], drawn: Drawn
) -> Iterator[Obstacle | Problem | Unread]:
    """Yield the areas of a group, closed outlines first, in the order of the drawing."""

    def area(polygon: Polygon, at: Heights) -> Obstacle:
        return Obstacle(name=name, footprint=polygon, bottom=at[0], top=at[1])

    group = drawn.group(name)
    levels: dict[Heights, list[Polygon]] = {}
    lines: dict[Heights, list[Polyline]] = {}
    filled: list[tuple[Heights, shapely.Geometry]] = []
    closed = [shape for shape in shapes if shape.closed and shape.area is None]
    polygons = polygons_of([shape.corners for shape in closed])
    sound = shapely.is_valid(polygons) & (shapely.area(polygons) > 0)
    bounded = zip(polygons, sound.tolist(), strict=True)
    for shape in shapes:
        at = group.z or _heights(shape)
        if shape.area is not None:
            filled.append((at, shape.area))
            continue
        polygon, whole = next(bounded) if shape.closed else (None, False)
        if group.line_width is not None:
            filled.append((at, wall(shape.corners, shape.closed, group.line_width, "square")))
        elif shape.covered is not None and (polygon is None or group.hollow):
            filled.append((at, shape.covered))
        elif shape.covered is not None and polygon is not None and whole:
            inside = polygon.difference(shape.covered)
            bounds = name == BOUNDARY
            filled.append((at, inside if bounds else polygon.union(shape.covered)))
            if inside.area:
                reads = "the floor ends at its inner edge" if bounds else _FILLED
                why = f"is drawn {metres(shape.covered.area / polygon.length)} m wide: {reads}"
                yield Unread(shape.layer, shape.name, why, False)
        elif polygon is None:
            lines.setdefault(at, []).append(shape)
        elif not whole:
            yield Problem(polygon_fault(polygon), place_of(shape))
        elif group.hollow:
            levels.setdefault(at, []).append(polygon)
        else:
            yield area(polygon, at)
    for at, loose_lines in lines.items():
        areas, loose = enclosed([shape.corners for shape in loose_lines], drawn.snap)
        levels.setdefault(at, []).extend(areas)
        for one in loose:
            yield Problem(_open(one), place_of(loose_lines[one.index]))
    for at, areas in levels.items():
        for polygon in opened(areas) if group.hollow else areas:
            yield area(polygon, at)
    pieces, of = pieces_of([area for _, area in filled])
    for piece, k in zip(pieces, of.tolist(), strict=True):
        yield area(piece, filled[k][0])


def _heights(shape: Polyline) -> Heights:
    low, high = sorted((shape.bottom, shape.bottom + (shape.thickness or DEFAULT_HEIGHT)))
    return low, high


def _open(loose: Loose) -> str:
    x, y = loose.end
    if loose.gap is None:
        return "is open; it encloses nothing together with the lines that it meets"
    near = f"is open; close it: no line meets its end at ({x:.3f}, {y:.3f}) m"
    if loose.gap < 0.1:
        # rounded up to a length that suffices
        digits = 1 - math.floor(math.log10(loose.gap))
        snap = metres(math.ceil(loose.gap * 10**digits - 1e-6) / 10**digits)
        return f"{near}, the nearest is {metres(loose.gap)} m away; `snap: {snap}` closes it"
    return near


MOST_DETAILS = 5
"""Maximum number of problems of a drawing without a boundary. Most vanish once it has one."""


def boundary_problems(
    areas: Collection[Obstacle], layers: Collection[str], drawn: Drawn, problems: list[Problem]
) -> list[Problem]:
    """Return the `problems` of a drawing with a missing boundary, or with two.

    `layers` are those with shapes on them.
    """
    count = sum(area.name == BOUNDARY for area in areas)
    if drawn.boundary is not None or count == 1:
        return problems
    if BOUNDARY in map(drawn.group_of, layers):
        if problems:
            return problems
        groups = ", ".join(sorted({area.name for area in areas})) or "none"
        of = "on the layer" if drawn.groups is None else "in the group of `layers`"
        message = f"expected one outline {of} {BOUNDARY!r}, found {count} (layers with outlines:"
        return [Problem(f"{message} {groups})")]
    names = ", ".join(map(repr, sorted(layers))) or "none"
    if drawn.groups is None:
        message = f"no layer is called {BOUNDARY!r}; the layers are {names}; choose from them with"
        message = f"{message} `layers` in a YAML floor that has this drawing as its `base`"
    else:
        message = f"no layer is in a group {BOUNDARY!r} of `layers`; the layers are {names};"
        message = f"{message} add this group or a `boundary`"
    if len(problems) > MOST_DETAILS:
        message = f"{message}. There are {len(problems):,} more problems, such as:"
    return [Problem(message), *problems[:MOST_DETAILS]]


def notices_of(unread: Iterable[Unread]) -> Iterator[Problem]:
    """Yield a notice for all entities of a layer that are ignored for the same reason."""
    reasons: dict[tuple[str, str], list[Unread]] = {}
    for one in unread:
        reasons.setdefault((one.layer, one.why), []).append(one)
    for (layer, why), alike in reasons.items():
        if len(alike) == 1:
            yield Problem(why, place_of(alike[0]))
        else:
            are = f"are {why[3:]}" if why.startswith("is ") else f": each {why}"
            yield Problem(f"{len(alike):,} shapes {are}", f"layer {layer!r}")


def numbered(areas: list[Obstacle]) -> tuple[Obstacle, ...]:
    """Return the areas as obstacles, named by group, and numbered if there are several.

    Numbers that are part of names of other groups are skipped.
    """
    several = Counter(area.name for area in areas)
    numbers = {group: itertools.count(1) for group in several}
    taken = {group for group, count in several.items() if count == 1}
    obstacles = []
    for area in areas:
        if several[area.name] > 1:
            names = (f"{area.name}{k}" for k in numbers[area.name])
            area = replace(area, name=next(one for one in names if one not in taken))
            taken.add(area.name)
        obstacles.append(area)
    return tuple(obstacles)
