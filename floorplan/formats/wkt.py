"""Floors in well-known text: a walkable polygon with obstacles as holes, as for JuPedSim.

The text is a POLYGON in metres, or a MULTIPOLYGON or GEOMETRYCOLLECTION of polygons that form one
area.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import shapely
from shapely.geometry import Polygon

from ..checks import polygon_fault
from ..files.fields import are_figures
from ..files.problems import FloorplanError, Problem, UserError
from ..files.reading import read_text
from ..model import Floor
from ..plan import Floorplan
from .drawings import OUTSIZED, Drawn


def load_wkt(path: Path, drawn: Drawn) -> Floorplan:
    """Return the floorplan in the WKT file at `path`. `FloorplanError` lists all problems."""
    return parse_wkt(read_text(path, FloorplanError), file=str(path), metre=drawn.metre or 1.0)


def parse_wkt(text: str, *, file: str = "<text>", metre: float = 1.0) -> Floorplan:
    """Return the floorplan in `text`, in a unit of `metre` metres. Errors call it `file`."""
    try:
        with np.errstate(invalid="ignore", over="ignore"):  # too large numbers are rejected below
            geometry = shapely.from_wkt(text.strip())
    except shapely.GEOSException as why:
        reason = re.sub(r"^ParseException: ", "", str(why)).strip()
        raise FloorplanError.of(file, f"is not well-known text: {reason}") from None
    except UnicodeDecodeError:  # GEOS may cut the reason within a character
        raise FloorplanError.of(file, "is not well-known text: it is not all ASCII") from None
    geometry = shapely.transform(shapely.force_2d(geometry), lambda at: at * metre)
    area = joined(geometry, file)
    return Floorplan.of_area(Path(file).stem, f"{Path(file).name} (WKT)", area)


def joined(geometry: shapely.Geometry, file: str) -> Polygon:
    """Return the area of the polygons of `geometry`. `FloorplanError` if it is not one."""
    problems = list(_problems(geometry))
    if problems:
        raise FloorplanError(file, problems)
    area = shapely.union_all(list(_polygons(geometry)))
    if area.geom_type != "Polygon":
        count = len(area.geoms)
        message = f"its polygons make up {count} separate areas; a floor is one: join or split them"
        raise FloorplanError.of(file, message)
    return area


def _polygons(geometry: shapely.Geometry) -> Iterator[shapely.Geometry]:
    if geometry.geom_type in ("MultiPolygon", "GeometryCollection"):
        for part in geometry.geoms:
            yield from _polygons(part)
    else:
        yield geometry


def _problems(geometry: shapely.Geometry) -> Iterator[Problem]:
    if geometry is None or geometry.is_empty:
        yield Problem("is empty: there is no area to walk on")
        return
    parts = list(_polygons(geometry))
    for index, part in enumerate(parts):
        place = f"polygon {index + 1} of {len(parts)}" if len(parts) > 1 else ""
        if part.geom_type != "Polygon":
            kind = part.geom_type.upper()
            yield Problem(f"expected a POLYGON, found a {kind}; only areas can be walked on", place)
        elif part.is_empty:
            yield Problem("is empty", place)
        elif not are_figures(shapely.get_coordinates(part)).all():
            yield Problem(OUTSIZED, place)
        elif fault := polygon_fault(part):
            yield Problem(fault, place)


def walkable(plan: Floor) -> shapely.Geometry:
    """Return the walkable area. `UserError` if there is none."""
    area = shapely.force_2d(plan.free(0.0, plan.human.height))
    if area.is_empty:
        raise UserError(f"people can walk nowhere on the floor {plan.name!r}")
    return area


def write_wkt(plan: Floor, path: Path) -> None:
    """Write the walkable area of `plan`. `UserError` if it is not one area."""
    area = walkable(plan)
    if area.geom_type != "Polygon":
        count = len(area.geoms)
        raise UserError(
            f"people on the floor {plan.name!r} walk on {count} separate areas; a WKT file has one"
        )
    text = f"{shapely.to_wkt(area, rounding_precision=-1)}\n"
    path.write_text(text, encoding="utf-8", newline="\n")
