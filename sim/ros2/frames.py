"""Where everything is, and when: clock, map and transforms."""

from __future__ import annotations

import array
from collections.abc import Callable, Iterable

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


def add_frames(ros: CellNode, cell: Cell, vehicles: Iterable[VehicleTopics]) -> None:
    """Publish `/clock`, `/tf` and `/tf_static`.

    Each body also has the frame in which its markers are drawn.
    """

    def message(frames: Iterable[Frame]) -> Values:
        return {"transforms": [transform(cell.now, *one) for one in frames]}

    def of(vehicles: Iterable[VehicleTopics]) -> Callable[[], Values]:
        return lambda: message(frame for one in vehicles for frame in one.moving_frames)

    def bodies() -> Values:
        poses = ((name, signal.read()) for name, signal in signals)
        return message((ROOT_FRAME, frame(name), pose) for name, pose in poses if pose is not None)

    vehicles = tuple(vehicles)
    paths = ((name.split("/"), signal) for name, signal in cell.signals.items())
    signals = [(path[1], signal) for path, signal in paths if path[2:] == ["pose"]]
    ros.advertise("/clock", "rosgraph_msgs/Clock", lambda: {"clock": seconds(cell.now)}, rate=POSES)
    ros.advertise("/tf", TF, of(vehicles), rate=POSES)
    ros.advertise("/tf", TF, bodies)
    fixed = message(one.fixed_frame for one in vehicles)
    ros.publish(ros.advertise("/tf_static", TF, latched=1), fixed)


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
    grid = {
        "header": header(0.0, ROOT_FRAME),
        "info": {
            **{"resolution": RESOLUTION, "width": len(x), "height": len(y)},
            "origin": {"position": {"x": low_x, "y": low_y}},
        },
        "data": array.array("b", cells.astype(np.int8).tobytes()),
    }
    ros.publish(ros.advertise("map", "nav_msgs/OccupancyGrid", latched=1), grid)
