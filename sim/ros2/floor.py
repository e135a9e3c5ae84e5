"""The floor as an occupancy grid."""

from __future__ import annotations

import array

import numpy as np
import shapely

from floorplan import Floorplan

from .messages import set_header
from .node import LATCHED, CellNode

RESOLUTION = 0.05
"""Side of a cell of the map, m, as in Nav2's tutorials."""

FREE, OCCUPIED = 0, 100
"""Values of cells of the map."""


def publish_map(ros: CellNode, plan: Floorplan) -> None:
    """Publish the floor once. A cell is occupied where its centre is within a wall or obstacle."""
    topic = ros.publish_on("map", "nav_msgs/msg/OccupancyGrid", LATCHED)
    low_x, low_y, high_x, high_y = plan.boundary.buffer(RESOLUTION).bounds  # with walls around it
    x = np.arange(low_x, high_x, RESOLUTION) + RESOLUTION / 2
    y = np.arange(low_y, high_y, RESOLUTION) + RESOLUTION / 2
    free = plan.free(0.0, plan.human.height)
    shapely.prepare(free)
    cells = np.where(shapely.contains_xy(free, *np.meshgrid(x, y)), FREE, OCCUPIED)
    message = topic.new()
    set_header(message.header, 0.0)
    message.info.resolution, message.info.width, message.info.height = RESOLUTION, len(x), len(y)
    message.info.origin.position.x, message.info.origin.position.y = low_x, low_y
    message.data = array.array("b", cells.astype(np.int8).tobytes())
    topic.publish(message)
