"""The gantry's topics: how it is, and where a controller outside wants its joints."""

from __future__ import annotations

from typing import Any

from ..machines.gantry.robot import GantryRobot
from .client import Client
from .exchange import Exchange, RefusedError
from .gate import Gate
from .readings import joint_state
from .trajectory import TrajectoryError, target_of, trajectory_motion

TRAJECTORY = "/gantry_controller/joint_trajectory"
"""What a controller publishes on."""


class GantryTopics:
    """Publishes the joints of `gantry` and whether it may move.

    If it is `driven` from outside, it follows the trajectories that come in.
    """

    def __init__(
        self, gantry: GantryRobot, exchange: Exchange, gate: Gate, *, driven: bool
    ) -> None:
        self._gantry = gantry
        self._exchange = exchange
        self._gate = gate
        self._joints = exchange.advertise("/joint_states", "sensor_msgs/JointState")
        self._health = exchange.advertise("/ariac/robot_health", "ariac_msgs/Robots")
        if driven:
            exchange.listen(TRAJECTORY, "trajectory_msgs/JointTrajectory", self._follow)

    def publish(self, now: float) -> None:
        """Publish the state at `now` (seconds)."""
        gantry = self._gantry
        if self._joints.is_needed:
            self._exchange.publish(self._joints, joint_state(now, gantry.gantry, gantry.state))
        if self._health.is_needed:
            health = {"floor_robot": True, "ceiling_robot": not gantry.disabled}
            self._exchange.publish(self._health, health)

    def _follow(self, _: Client, message: dict[str, Any]) -> None:
        self._gate.enter(TRAJECTORY)
        gantry = self._gantry
        if gantry.disabled:
            raise RefusedError("the gantry is disabled")
        try:
            target = target_of(gantry.gantry, message)
            if target is not None:
                gantry.move_to(*target, resume=False)
            else:
                gantry.follow(trajectory_motion(gantry.gantry, gantry.state, gantry.now, message))
        except TrajectoryError as why:
            raise RefusedError(str(why)) from None
        except ValueError as why:
            raise RefusedError(f"out of range: {why}") from None
