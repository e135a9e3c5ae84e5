"""Floors from DXF drawings, sorted by their layers.

Closed outlines bound areas, and so do lines, arcs and splines that meet. The area on the layer (or
in the group of layers) "boundary" bounds the floor, those on others are obstacles, called after
their layer or group. Elevation and thickness are their heights. Layers that are off or frozen, and
what is no shape (texts, dimensions, points), are left out.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import shapely
from shapely.geometry import Polygon

from .cad import Reader
from .checks import polygon_fault
from .dxf_file import DAMAGED, open_drawing
from .layers import BOUNDARY, Drawn
from .model import DEFAULT_HEIGHT, Obstacle
from .outlines import Loose, enclosed, opened, pieces_of, polygons_of
from .plan import Floorplan
from .problems import FloorplanError, Problem
from .reading import no_garbage
from .strokes import Shape, Unread

if TYPE_CHECKING:
    from ezdxf.document import Drawing

_Heights = tuple[float, float]


@dataclass(frozen=True)
class _Area:
    group: str
    polygon: Polygon
    bottom: float
    top: float


@no_garbage()
def load_dxf(path: Path, drawn: Drawn) -> Floorplan:
    """The floorplan in the DXF file at `path`; `FloorplanError` with all that is wrong with it."""
    file = str(path)
    drawing = open_drawing(path)
    notices: list[Problem] = []
    metre = _metre(drawing, drawn, file, notices)
    reader = Reader(drawing, metre, drawn)
    shapes: dict[str, list[Shape]] = {}
    problems: list[Problem] = []
    try:
        with np.errstate(all="ignore"):  # figures that nothing comes of are refused
            for found in reader.shapes():
                if isinstance(found, Shape):
                    shapes.setdefault(str(reader.group_of(found.layer)), []).append(found)
                else:
                    to = problems if found.wanted else notices
                    to.append(Problem(found.why, _place(found)))
    except DAMAGED as why:
        raise FloorplanError.of(path, f"has a damaged entity: {why}") from None
    areas: list[_Area] = []
    for name, held in shapes.items():
        for area in _areas(name, held, drawn):
            if isinstance(area, Problem):
                problems.append(area)
            else:
                areas.append(area)
    problems += drawn.unmatched(reader.layers)
    bounding = [area for area in areas if area.group == BOUNDARY]
    if drawn.boundary is None and len(bounding) != 1 and not problems:
        problems.append(_boundary_problem(len(bounding), areas, drawn))
    if problems:
        raise FloorplanError(file, problems)
    return Floorplan(
        name=path.stem,
        source=f"{path.name} (DXF)",
        boundary=bounding[0].polygon if drawn.boundary is None else drawn.boundary,
        obstacles=_obstacles([area for area in areas if area.group != BOUNDARY]),
        notices=tuple(notices),
    )


def _metre(drawing: Drawing, drawn: Drawn, file: str, notices: list[Problem]) -> float:
    """Return the length of a unit of the drawing in metres; notice where there is a doubt."""
    from ezdxf.enums import InsertUnits
    from ezdxf.units import conversion_factor

    try:
        unit = InsertUnits(drawing.units)
        named = unit != InsertUnits.Unitless
        own = float(conversion_factor(unit, InsertUnits.Meters)) if named else 1.0
    except (ValueError, TypeError):
        if drawn.metre is not None:
            return drawn.metre
        message = f"its unit ($INSUNITS = {drawing.units}) is not known; use metres"
        raise FloorplanError.of(file, message) from None
    if drawn.metre is None:
        if not named:
            message = "the drawing gives no unit ($INSUNITS), metres are assumed"
            notices.append(Problem(f"{message}; a floor on top of it can give `units`"))
        return own
    if named and abs(own - drawn.metre) > 1e-9:
        message = f"the drawing gives {unit.name.lower()} as its unit ($INSUNITS)"
        notices.append(Problem(f"{message}; the `units` of the floor on top of it count"))
    return drawn.metre


def _place(found: Shape | Unread) -> str:
    return f"layer {found.layer!r}, {found.name()}"


def _areas(name: str, shapes: list[Shape], drawn: Drawn) -> Iterator[_Area | Problem]:
    """Yield the areas of a group, closed outlines first, in the order of the drawing."""
    group = drawn.group(name)
    levels: dict[_Heights, list[Polygon]] = {}
    lines: dict[_Heights, list[Shape]] = {}
    filled: list[tuple[_Heights, shapely.Geometry]] = []
    closed = [shape for shape in shapes if shape.closed]
    polygons = polygons_of([shape.corners for shape in closed])
    sound = shapely.is_valid(polygons) & (shapely.area(polygons) > 0)
    bounded = zip(polygons, sound.tolist(), strict=True)
    for shape in shapes:
        at = group.z or _heights(shape)
        polygon, whole = next(bounded) if shape.closed else (None, False)
        if group.line_width is not None and not shape.filled:
            ring = shape.corners if polygon is None else polygon.exterior
            wall = shapely.LineString(ring).buffer(
                group.line_width / 2, cap_style="square", join_style="mitre"
            )
            filled.append((at, wall))
        elif polygon is None:
            lines.setdefault(at, []).append(shape)
        elif not whole:
            yield Problem(polygon_fault(polygon), _place(shape))
        elif shape.filled:
            hatched = polygon if shape.holes is None else polygon.difference(shape.holes)
            filled.append((at, hatched))
        elif group.hollow:
            levels.setdefault(at, []).append(polygon)
        else:
            yield _Area(name, polygon, *at)
    for at, loose_lines in lines.items():
        found, loose = enclosed([shape.corners for shape in loose_lines], drawn.snap)
        levels.setdefault(at, []).extend(found)
        for one in loose:
            yield Problem(_open(one, drawn), _place(loose_lines[one.index]))
    for at, found in levels.items():
        for polygon in opened(found) if group.hollow else found:
            yield _Area(name, polygon, *at)
    pieces, of = pieces_of([area for _, area in filled])
    for piece, k in zip(pieces, of.tolist(), strict=True):
        yield _Area(name, piece, *filled[k][0])


def _heights(shape: Shape) -> _Heights:
    low, high = sorted((shape.bottom, shape.bottom + (shape.thickness or DEFAULT_HEIGHT)))
    return low, high


def _open(loose: Loose, drawn: Drawn) -> str:
    x, y = loose.end
    if loose.gap is None:
        return "is open; it encloses nothing together with the lines that it meets"
    near = f"is open; close it: no line meets its end at ({x:.3f}, {y:.3f}) m"
    if loose.gap < 0.1:
        return f"{near}, the nearest is {loose.gap:.4f} m away; a `snap` of that closes it"
    return near


def _boundary_problem(count: int, areas: list[_Area], drawn: Drawn) -> Problem:
    groups = ", ".join(sorted({area.group for area in areas})) or "none"
    if drawn.groups is None:
        where = f"on the layer {BOUNDARY!r}, found {count} (layers with outlines: {groups})"
    else:
        where = f"in the group {BOUNDARY!r} of `layers`, found {count} (with outlines: {groups})"
    return Problem(f"expected one outline {where}")


def _obstacles(areas: list[_Area]) -> tuple[Obstacle, ...]:
    """Return the areas as obstacles, named by group and numbered where it has several.

    A number is left out where another group has that name.
    """
    several = Counter(area.group for area in areas)
    numbers = {group: itertools.count(1) for group in several}
    taken = {group for group, count in several.items() if count == 1}
    found = []
    for area in areas:
        name = area.group
        if several[area.group] > 1:
            numbered = (f"{area.group}{k}" for k in numbers[area.group])
            name = next(one for one in numbered if one not in taken)
            taken.add(name)
        found.append(Obstacle(name, area.polygon, area.bottom, area.top))
    return tuple(found)
