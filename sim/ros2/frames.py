"""The clock, and transforms of machines and people."""

from __future__ import annotations

from collections.abc import Iterable

from ..cell import Cell
from ..exports.scene import ROOT_FRAME, frame
from .messages import set_header, set_time, set_turn
from .node import LATCHED, CellNode, RosTopic
from .vehicles import Frame, VehicleTopics


class Frames:
    """Publisher of `/clock`, `/tf` and `/tf_static`.

    Besides the frames of vehicles, each body has the frame in which its markers are drawn.
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
