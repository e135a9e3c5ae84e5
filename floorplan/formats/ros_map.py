"""Floors from maps of ROS's map_server: a YAML file and a grey image.

Free cells are floor, all others (occupied, unknown, transparent) are not. The floor is the largest
connected free area; cells that touch only at a corner are not connected. As in
map_server, the thresholds decide alone: the grey (205) of unknown cells is below a free_thresh of
0.25 and so counts as free; 0.196 leaves it out.
"""

import math
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import shapely
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, Strict, model_validator
from shapely.geometry import Polygon

from ..files.documents import Document
from ..files.fields import Angle, Number
from ..files.problems import FloorplanError, UserError, shown
from ..plan import Floorplan
from .raster import GreyImage, IntricateError, read_image, trace

TOLERANCE = 0.45
"""Cells. How far outlines may move when they are simplified: less than half a cell from either
side leaves every wall closed, and a door of two cells more than one cell wide."""

# Old versions of pydantic take fields for optional whose limits stand in two places.
Share = Annotated[float, Strict(), Field(ge=0, le=1, allow_inf_nan=False)]
Resolution = Annotated[float, Strict(), Field(ge=1e-4, le=1000, allow_inf_nan=False)]


class RosMapSchema(BaseModel):
    """Keys of a map_server file; it may have others, which say nothing about the floor."""

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
    """Return the floorplan of a map; `FloorplanError` with what is wrong with it or its image."""
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
        # Values up to 100 are percentages of being occupied, others mean unknown.
        is_free = (levels <= 100) & (levels < schema.free_thresh * 100)
    else:
        # Dark is occupied, unless negated: map_server's own formula.
        occupied = (levels if schema.negate else image.top - levels) / image.top
        is_free = occupied < schema.free_thresh
    free: NDArray[np.bool_] = is_free[image.levels]
    return free if image.opaque is None else free & image.opaque


def _in_metres(area: Polygon, rows: int, schema: RosMapSchema) -> Polygon:
    """Convert cells to metres; the origin is the lower left corner of the image, with its yaw."""
    x, y, yaw = schema.origin
    c, s = math.cos(yaw), math.sin(yaw)

    def place(cells: NDArray[np.float64]) -> NDArray[np.float64]:
        # Rows count from the top, metres from the bottom.
        right = cells[:, 0] * schema.resolution
        up = (rows - cells[:, 1]) * schema.resolution
        return np.column_stack([x + c * right - s * up, y + s * right + c * up])

    return shapely.orient_polygons(shapely.transform(area, place))
