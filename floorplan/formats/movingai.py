"""Floors from the grid maps of the MovingAI benchmarks (`.map`).

A header (type, height, width) stands above one line of characters for each row of cells, the top
row first. N. R. Sturtevant, Benchmarks for grid-based pathfinding, IEEE Transactions on
Computational Intelligence and AI in Games 4, 2012.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import box

from ..files.problems import FloorplanError, Problem, UserError, shown
from ..files.reading import read_text
from ..model import DEFAULT_HEIGHT, Obstacle
from ..plan import Floorplan
from .drawings import Drawn
from .raster import IntricateError, trace

CELL = 1.0
"""Metres. Default side of a cell, which the maps do not contain."""

FLOOR = ".GS"
"""Characters of walkable cells: ground and swamp."""

BLOCKED = "@OTW"
"""Characters of other cells: out of bounds, trees, and water."""

_MOST_CELLS = 16_000_000

_HEADER = (
    (r"type\s+octile", "type octile"),
    (r"height\s+(\d{1,9})", "height and a number"),
    (r"width\s+(\d{1,9})", "width and a number"),
    (r"map", "map"),
)


def load_movingai(path: Path, cell: float = CELL) -> Floorplan:
    """Read a map of the MovingAI benchmarks.

    The floor is the whole rectangle, with obstacles where people cannot walk, because a map may
    have separate areas. The lower left corner is at (0, 0), and y points up. Cells that touch only
    at a corner are not connected.

    Parameters
    ----------
    path : pathlib.Path
        File that ends in `.map`.
    cell : float, optional
        Side of a cell in metres, from 0.001 to 1000.

    Returns
    -------
    Floorplan
        Floorplan without stations.

    Raises
    ------
    FloorplanError
        With all problems of the file.
    UserError
        If `cell` is out of range.
    """
    if not 1e-3 <= cell <= 1000:
        raise UserError(f"a cell must be from 0.001 to 1000 m wide, found {cell:g}")
    free = _cells(read_text(path, FloorplanError), str(path))
    height, width = free.shape
    whole = box(0, 0, width, height)
    try:
        floor = trace(free, 0.0)
    except IntricateError as why:
        raise FloorplanError.of(path, f"its cells have {why}") from None
    if floor.is_empty:
        raise FloorplanError.of(path, "no cell can be walked on: there is no floor")

    def in_metres(cells: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.column_stack([cells[:, 0], height - cells[:, 1]]) * cell

    pieces = shapely.transform(_whole_cells(whole.difference(floor)), in_metres)
    return Floorplan(
        name=path.stem,
        source=f"{path.name} (MovingAI map, cells of {cell:g} m)",
        boundary=shapely.transform(whole, in_metres),
        obstacles=[
            Obstacle(name=f"obstacle{k}", footprint=piece, bottom=0.0, top=DEFAULT_HEIGHT)
            for k, piece in enumerate(shapely.orient_polygons(pieces), start=1)
        ],
    )


def _whole_cells(taken: shapely.Geometry) -> list[shapely.Polygon]:
    """Return the pieces of `taken` (cells), with all corners at corners of cells.

    The outline keeps an eighth of a cell from corners where two walkable cells touch, which joins
    the area there. Moved to the corner, it touches itself or another piece in a point, through
    which no body passes. A piece with a hole is cut through it.
    """
    pieces = shapely.get_parts(shapely.transform(taken, np.round))
    touching = ~shapely.is_valid(pieces)
    pieces[touching] = shapely.make_valid(pieces[touching], method="structure")
    parts = shapely.get_parts(pieces)
    holed = (shapely.get_num_interior_rings(parts) > 0).tolist()
    solid: list[shapely.Polygon] = []
    for part, has_hole in zip(parts, holed, strict=True):
        solid += _solid(part) if has_hole else [part]
    return solid


def _solid(piece: shapely.Polygon) -> Iterator[shapely.Polygon]:
    """Yield parts of `piece` (cells) without holes."""
    if not piece.interiors:
        yield piece
        return
    # A cut through the middle of a cell crosses almost only horizontal edges, so it is exact.
    west, south, east, north = piece.bounds
    middle = math.floor(piece.interiors[0].bounds[0]) + 0.5
    for side in (box(west, south, middle, north), box(middle, south, east, north)):
        for part in shapely.get_parts(piece.intersection(side)):
            if part.geom_type == "Polygon":
                yield from _solid(part)


def load_drawn_map(path: Path, drawn: Drawn) -> Floorplan:
    """Return the floorplan in the map at `path`, with the unit of a drawing as its cells."""
    return load_movingai(path, drawn.metre or CELL)


def _cells(text: str, file: str) -> NDArray[np.bool_]:
    """Return a mask of the walkable cells, (rows, columns), the top row first."""
    lines = text.split("\n")
    height, width = _size(lines, file)
    rows = lines[len(_HEADER) :]
    while rows and not rows[-1].strip():
        rows.pop()
    problems = []
    if len(rows) != height:
        problems.append(Problem(f"has {len(rows):,} rows of cells; its height is {height:,}"))
    unknown = re.compile(f"[^{FLOOR}{BLOCKED}]")
    for number, row in enumerate(rows[:height], start=len(_HEADER) + 1):
        if len(row) != width:
            message = f"has {len(row):,} cells; the width is {width:,}"
            problems.append(Problem(message, line=number))
        elif odd := unknown.search(row):
            message = f"{shown(odd[0])} is no cell (floor: {' '.join(FLOOR)}; not: @ O T W)"
            problems.append(Problem(message, line=number))
    if problems:
        raise FloorplanError(file, problems)
    grid = np.frombuffer("".join(rows).encode("ascii"), "S1").reshape(height, width)
    return np.isin(grid, [character.encode() for character in FLOOR])


def _size(lines: Sequence[str], file: str) -> tuple[int, int]:
    """Return height and width in cells from the header."""
    figures: list[str] = []
    for number, (pattern, words) in enumerate(_HEADER, start=1):
        line = lines[number - 1].strip() if number <= len(lines) else ""
        match = re.fullmatch(pattern, line)
        if match is None:
            raise FloorplanError.of(file, f"expected {words}, found {shown(line)}", line=number)
        figures += match.groups()
    height, width = (int(figure) for figure in figures)
    if not height or not width:
        raise FloorplanError.of(file, f"has no cells: it is {width} wide and {height} high")
    if height * width > _MOST_CELLS:
        message = f"has {height * width:,} cells, of at most {_MOST_CELLS:,}"
        raise FloorplanError.of(file, message)
    return height, width
