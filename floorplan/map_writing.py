"""Floors as maps of ROS's map_server: a grey image, and a YAML file that says where it lies."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray

from .image import MOST_CELLS
from .model import Floor
from .problems import UserError
from .writing import walkable
from .yaml_writing import yaml_text

USUAL = 0.05
"""Metres. Length of a cell where nothing else is asked for."""

FINEST = 1e-4
"""Metres. Least length of a cell."""

FREE, OCCUPIED = 254, 0
"""Grey of cells, as map_server writes them."""

_MARGIN = 1
"""Cells around the floor, so that its edge is drawn."""


def write_map(plan: Floor, path: Path, resolution: float) -> None:
    """Write `plan` as a map in cells of `resolution` metres: `path` and the other of its two files.

    `ValueError` if it would have more cells than can be read.
    """
    area = walkable(plan)
    west, south, east, north = area.bounds
    columns = math.ceil((east - west) / resolution) + 2 * _MARGIN
    rows = math.ceil((north - south) / resolution) + 2 * _MARGIN
    if columns * rows > MOST_CELLS:
        raise UserError(
            f"{path}: a map of {columns:,} × {rows:,} cells is too large (at most {MOST_CELLS:,}"
            " cells); give a coarser resolution"
        )
    corner = (west - _MARGIN * resolution, south - _MARGIN * resolution)
    free = free_cells(area, corner, resolution, rows, columns)
    text, image = map_files(path)
    settings = {
        "image": image.name,
        "resolution": float(resolution),
        "origin": [float(corner[0]), float(corner[1]), 0.0],
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": 0.196,
    }
    grey = np.where(free[::-1], FREE, OCCUPIED).astype(np.uint8)
    image.write_bytes(b"P5\n%d %d\n255\n" % (columns, rows) + grey.tobytes())
    text.write_text(yaml_text(settings), encoding="utf-8", newline="\n")


def map_files(path: Path) -> tuple[Path, Path]:
    """Return the two files of a ROS map, of which one is `path`: its settings and its image."""
    is_text = path.suffix.lower() in (".yaml", ".yml")
    return path if is_text else path.with_suffix(".yaml"), path.with_suffix(".pgm")


def free_cells(
    area: shapely.Geometry, corner: tuple[float, float], size: float, rows: int, columns: int
) -> NDArray[np.bool_]:
    """Return the cells that are wholly in `area`: (rows, columns), the lowest row first.

    Cells are `size` metres long, the first one has its lower left corner at `corner`. Squares of
    cells that the edge of `area` does not cross are decided as a whole.
    """
    free = np.zeros((rows, columns), bool)
    shapely.prepare(area)
    whole = 1 << (max(rows, columns) - 1).bit_length()
    squares = np.array([[0, 0]])
    while len(squares):
        low = squares * size + (corner[1], corner[0])
        high = np.minimum(squares + whole, (rows, columns)) * size + (corner[1], corner[0])
        boxes = shapely.box(low[:, 1], low[:, 0], high[:, 1], high[:, 0])
        inside = shapely.covers(area, boxes)
        for row, column in squares[inside]:
            free[row : row + whole, column : column + whole] = True
        if whole == 1:
            break
        # Only what is partly in the area is looked at more closely.
        crossed = squares[~inside & shapely.intersects(area, boxes)]
        whole //= 2
        quarters = np.array([[0, 0], [0, whole], [whole, 0], [whole, whole]])
        squares = (crossed[:, None, :] + quarters).reshape(-1, 2)
        squares = squares[(squares < (rows, columns)).all(axis=1)]
    return free
