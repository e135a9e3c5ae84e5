"""Floors from maps of ROS's map_server: a YAML file and a grey image.

Free cells are floor, all others (occupied, unknown, transparent) are not. The floor is the largest
connected free area. Cells that touch only at a corner are not connected. As in map_server, the
thresholds decide alone: the grey (205) of unknown cells is below a free_thresh of 0.25 and so
counts as free; 0.196 leaves it out. Masks of Nav2's costmap filters are zones.
"""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import shapely
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, Strict, model_validator
from shapely.geometry import Polygon

from ..building import MaskKeys
from ..files.documents import Document, read_yaml, yaml_text
from ..files.fields import SMALLEST, Angle, Number
from ..files.problems import FloorplanError, UserError, shown
from ..model import Floor, Zone
from ..plan import Floorplan
from .raster import MOST_CELLS, GreyImage, IntricateError, read_image, trace
from .wkt import walkable

TOLERANCE = 0.45
"""Cells. Tolerance of simplified outlines. Because it is less than half a cell, walls stay
closed, and a door of two cells stays wider than one cell."""

Share = Annotated[float, Strict(), Field(ge=0, le=1, allow_inf_nan=False)]
Resolution = Annotated[float, Strict(), Field(ge=1e-4, le=1000, allow_inf_nan=False)]


class RosMapSchema(BaseModel):
    """Keys of a map_server file. Other keys are ignored."""

    model_config = ConfigDict(extra="ignore", frozen=True, defer_build=True)

    image: Annotated[str, Field(min_length=1)]
    resolution: Resolution
    origin: tuple[Number, Number, Angle]
    negate: Literal[0, 1] | bool
    occupied_thresh: Share
    free_thresh: Share
    mode: Literal["trinary", "scale", "raw"] = "trinary"

    @model_validator(mode="after")
    def _thresholds_rise(self) -> "RosMapSchema":
        if self.free_thresh > self.occupied_thresh:
            raise UserError(
                f"free_thresh ({self.free_thresh:g}) must not be above"
                f" occupied_thresh ({self.occupied_thresh:g})"
            )
        return self


def build_ros_map(document: Document) -> Floorplan:
    """Return the floorplan of a map. `FloorplanError` if the map or its image is invalid."""
    schema = document.checked(RosMapSchema, FloorplanError)
    file = Path(document.file)
    try:
        free = _free_cells(read_image(file.parent / schema.image), schema)
    except FloorplanError as why:
        problems = [
            document.problem(f"{shown(schema.image)}: {one.message}", "image")
            for one in why.problems
        ]
        raise FloorplanError(document.file, problems) from why
    try:
        pieces = shapely.get_parts(trace(free, TOLERANCE))
    except IntricateError as why:
        message = (
            f"the free cells of {schema.image} have {why}: clear it of single cells (with a"
            " median filter, say), or give a map of a coarser resolution"
        )
        raise FloorplanError.of(document.file, message) from None
    if not shapely.area(pieces).any():
        message = f"no cell of {schema.image} is free: there is no floor"
        raise FloorplanError.of(document.file, message)
    largest = pieces[int(np.argmax(shapely.area(pieces)))]
    return Floorplan.of_area(
        file.stem, f"{file.name} (ROS map)", _in_metres(largest, len(free), schema)
    )


def _free_cells(image: GreyImage, schema: RosMapSchema) -> NDArray[np.bool_]:
    """Return a mask of the free cells, (rows, columns), the top row first."""
    levels = np.arange(image.top + 1)
    if schema.mode == "raw":
        # Values up to 100 are percentages of occupancy. Other values mean unknown.
        is_free = (levels <= 100) & (levels <= schema.free_thresh * 100)
    else:
        is_free = _darkness(image, schema) <= schema.free_thresh
    free: NDArray[np.bool_] = is_free[image.levels]
    return free if image.opaque is None else free & image.opaque


def _darkness(image: GreyImage, schema: RosMapSchema) -> NDArray[np.float64]:
    """Return the darkness of each level, from 0 to 1, as map_server computes it."""
    levels = np.arange(image.top + 1)
    return (levels if schema.negate else image.top - levels) / image.top


MOST_ZONES = 1_000


def mask_zones(path: Path, name: str, rule: MaskKeys) -> Iterator[Zone]:
    """Yield the zones of a mask of Nav2's keepout or speed filter, in metres.

    Several zones are numbered after `name`. `FloorplanError` if there are none.
    """
    document = read_yaml(path, FloorplanError)
    schema = document.checked(RosMapSchema, FloorplanError)
    image = read_image(path.parent / schema.image)
    values = _values(image, schema)[image.levels]
    if image.opaque is not None:
        values[~image.opaque] = -1
    limits = {100: rule.rule["max_speed"]}
    if rule.multiplier is not None:
        limits = {k: rule.base + rule.multiplier * k for k in np.unique(values).tolist() if k > 0}
    areas: list[tuple[float | None, Polygon]] = []
    for value, limit in limits.items():
        if limit is not None and limit < SMALLEST:
            message = (
                f"the limit of cells of value {value} is {limit:g} m/s: check base, multiplier"
            )
            raise FloorplanError.of(path, message)
        pieces = shapely.get_parts(trace(values == value, TOLERANCE))
        areas += [(limit, _in_metres(piece, len(values), schema)) for piece in pieces]
    if not 0 < len(areas) <= MOST_ZONES:
        message = f"{schema.image} has {len(areas):,} zones, expected 1 to {MOST_ZONES:,}"
        raise FloorplanError.of(path, message)
    for k, (limit, area) in enumerate(areas, start=1):
        own = {"max_speed": limit, "forbidden": limit is None}
        called = name if len(areas) == 1 else f"{name}{k}"
        yield Zone(name=called, area=area, **rule.rule | own)


def _values(image: GreyImage, schema: RosMapSchema) -> NDArray[np.int_]:
    """Return the value of each level in an occupancy grid: 0 to 100, -1 for unknown."""
    levels = np.arange(image.top + 1)
    if schema.mode == "raw":
        return np.where(levels <= 100, levels, -1)
    low, high = schema.free_thresh, schema.occupied_thresh
    dark = _darkness(image, schema)
    between = np.full(len(levels), -1)
    if schema.mode == "scale" and low < high:
        between = np.rint((dark - low) / (high - low) * 100).astype(int)
    return np.where(dark >= high, 100, np.where(dark <= low, 0, between))


def _in_metres(area: Polygon, rows: int, schema: RosMapSchema) -> Polygon:
    """Convert cells to metres. The origin is the lower left corner of the image, with its yaw."""
    x, y, yaw = schema.origin
    c, s = math.cos(yaw), math.sin(yaw)

    def place(cells: NDArray[np.float64]) -> NDArray[np.float64]:
        # Rows count from the top, metres from the bottom.
        right = cells[:, 0] * schema.resolution
        up = (rows - cells[:, 1]) * schema.resolution
        return np.column_stack([x + c * right - s * up, y + s * right + c * up])

    return shapely.orient_polygons(shapely.transform(area, place))


FREE, OCCUPIED = 254, 0
"""Grey of cells, as map_server writes them."""

_MARGIN = 1
"""Cells around the floor, so that its edge is drawn."""


def write_map(plan: Floor, path: Path, resolution: float) -> None:
    """Write `plan` as a map with cells of `resolution` metres, into `path` and its other file.

    `UserError` if it has more cells than can be read.
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
    """Return the settings file and the image of a ROS map, given either of them as `path`."""
    is_text = path.suffix.lower() in (".yaml", ".yml")
    return path if is_text else path.with_suffix(".yaml"), path.with_suffix(".pgm")


def free_cells(
    area: shapely.Geometry, corner: tuple[float, float], size: float, rows: int, columns: int
) -> NDArray[np.bool_]:
    """Return a mask of the cells inside `area`: (rows, columns), the lowest row first.

    Cells have sides of `size` metres. The lower left corner of the first one is `corner`. Squares
    of cells that the edge of `area` does not cross are decided at once.
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
        # Only squares partly inside the area are divided.
        crossed = squares[~inside & shapely.intersects(area, boxes)]
        whole //= 2
        quarters = np.array([[0, 0], [0, whole], [whole, 0], [whole, whole]])
        squares = (crossed[:, None, :] + quarters).reshape(-1, 2)
        squares = squares[(squares < (rows, columns)).all(axis=1)]
    return free
