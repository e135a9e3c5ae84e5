"""Where everything is, and when: clock, map and transforms."""

from __future__ import annotations

import array
from collections.abc import Iterable, Sequence

import numpy as np
import shapely

from floorplan import Floorplan

from ..cell import Cell
from ..cell.signals import POSES
from ..competition import Values
from ..competition.messages import header, seconds, transform
from ..exports.scene import ROOT_FRAME, frame
from .machines import Frame, VehicleTopics
from .node import CellNode

TF = "tf2_msgs/TFMessage"


def add_frames(ros: CellNode, cell: Cell, vehicles: Sequence[VehicleTopics]) -> None:
    """Publish `/clock`, `/tf` and `/tf_static`.

    Each body also has the frame in which its markers are drawn.
    """
    paths = ((name.split("/"), signal) for name, signal in cell.signals.items())
    poses = [(frame(path[1]), signal) for path, signal in paths if path[2:] == ["pose"]]

    def message(frames: Iterable[Frame]) -> Values:
        return {"transforms": [transform(cell.now, *one) for one in frames]}

    def moving() -> Values:
        return message(one for vehicle in vehicles for one in vehicle.moving_frames)

    def bodies() -> Values:
        here = ((name, signal.read()) for name, signal in poses)
        return message((ROOT_FRAME, name, pose) for name, pose in here if pose is not None)

    clock = "rosgraph_msgs/Clock"
    ros.advertise("/clock", clock, lambda: {"clock": seconds(cell.now)}, rate=POSES)
    ros.advertise("/tf", TF, moving, rate=POSES)
    ros.advertise("/tf", TF, bodies)
    fixed = ros.advertise("/tf_static", TF, latched=1)
    ros.publish(fixed, message(vehicle.fixed_frame for vehicle in vehicles))


RESOLUTION = 0.05
"""Side of a cell of the map, m, as in Nav2's tutorials."""

FREE, OCCUPIED = 0, 100
"""Values of cells of the map."""


def publish_map(ros: CellNode, plan: Floorplan) -> None:
    """Publish the floor once. A cell is occupied where its centre is within a wall or obstacle."""
    low_x, low_y, high_x, high_y = plan.boundary.buffer(RESOLUTION).bounds  # with walls around it
    x = np.arange(low_x, high_x, RESOLUTION) + RESOLUTION / 2
    y = np.arange(low_y, high_y, RESOLUTION) + RESOLUTION / 2
    free = plan.free(0.0, plan.human.height)
    shapely.prepare(free)
    cells = np.where(shapely.contains_xy(free, *np.meshgrid(x, y)), FREE, OCCUPIED)
    size = {"resolution": RESOLUTION, "width": len(x), "height": len(y)}
    info = {**size, "origin": {"position": {"x": low_x, "y": low_y}}}
    data = array.array("b", cells.astype(np.int8).tobytes())
    topic = ros.advertise("map", "nav_msgs/OccupancyGrid", latched=1)
    ros.publish(topic, {"header": header(0.0, ROOT_FRAME), "info": info, "data": data})
