"""Where everything is, and when: clock, map and transforms."""

from __future__ import annotations

import array
from collections.abc import Iterable

import numpy as np
import shapely

from floorplan import Floorplan

from ..cell import Cell
from ..exports.scene import ROOT_FRAME, frame
from .machines import Frame, VehicleTopics
from .messages import set_header, set_time, set_turn
from .node import LATCHED, CellNode, RosTopic


class Frames:
    """Publisher of `/clock`, `/tf` and `/tf_static`.

    Each body also has the frame in which its markers are drawn.
    """

    def __init__(self, ros: CellNode, cell: Cell, vehicles: Iterable[VehicleTopics]) -> None:
        self._cell = cell
        self._vehicles = tuple(vehicles)
        self._clock = ros.publish_on("/clock", "rosgraph_msgs/msg/Clock")
        self._moving = ros.publish_on("/tf", "tf2_msgs/msg/TFMessage")
        self._fixed = ros.publish_on("/tf_static", "tf2_msgs/msg/TFMessage", LATCHED)
        self._transform = ros.find("geometry_msgs/msg/TransformStamped", "/tf")
        poses = ((name.split("/"), signal) for name, signal in cell.signals.items())
        self._bodies = [(path[1], signal) for path, signal in poses if path[2:] == ["pose"]]
        self._publish(self._fixed, [f for one in self._vehicles for f in one.fixed_frames])

    def publish_clock(self) -> None:
        """Publish the simulated time."""
        message = self._clock.new()
        set_time(message.clock, self._cell.now)
        self._clock.publish(message)

    def publish_vehicles(self) -> None:
        """Publish the frames of vehicles."""
        if self._moving.is_needed:
            self._publish(self._moving, [f for one in self._vehicles for f in one.moving_frames])

    def publish_bodies(self) -> None:
        """Publish the frames in which markers are drawn, of bodies that are on the floor."""
        if self._moving.is_needed:
            poses = ((name, signal.read()) for name, signal in self._bodies)
            there = [(ROOT_FRAME, frame(name), pose) for name, pose in poses if pose is not None]
            self._publish(self._moving, there)

    def _publish(self, topic: RosTopic, frames: Iterable[Frame]) -> None:
        transforms = []
        for parent, child, pose in frames:
            one = self._transform(child_frame_id=child)
            set_header(one.header, self._cell.now, parent)
            one.transform.translation.x, one.transform.translation.y = pose.x, pose.y
            set_turn(one.transform.rotation, pose.heading)
            transforms.append(one)
        if transforms:
            topic.publish(topic.new(transforms=transforms))


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
