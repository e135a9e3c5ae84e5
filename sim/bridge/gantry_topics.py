"""The gantry's topics: how it is, and where a controller outside wants its joints."""

from __future__ import annotations

from ..gantry import GantryRobot
from .exchange import Exchange
from .gate import Gate
from .readings import joint_state

TRAJECTORY = "/gantry_controller/joint_trajectory"
"""What a controller publishes on."""


class GantryTopics:
    """Publishes the joints of `gantry` and whether it may move."""

    def __init__(self, gantry: GantryRobot, exchange: Exchange, gate: Gate) -> None:
        self._gantry = gantry
        self._exchange = exchange
        self._gate = gate
        self._joints = exchange.advertise("/joint_states", "sensor_msgs/JointState")
        self._health = exchange.advertise("/ariac/robot_health", "ariac_msgs/Robots")

    def publish(self, now: float) -> None:
        """Publish the state at `now` (seconds)."""
        gantry = self._gantry
        if self._joints.is_needed:
            self._exchange.publish(self._joints, joint_state(now, gantry.gantry, gantry.state))
        if self._health.is_needed:
            health = {"floor_robot": True, "ceiling_robot": not gantry.disabled}
            self._exchange.publish(self._health, health)
