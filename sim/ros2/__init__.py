"""A trial served to ROS 2: topics, actions and services of its cell, with the user's rclpy."""

import sys

try:
    import rclpy  # noqa: F401
except ImportError as why:
    raise ImportError(
        f"sim.ros2 needs rclpy for {sys.executable}: install ROS 2, run 'source"
        " /opt/ros/DISTRIBUTION/setup.bash', and install Floorwalker for the Python of ROS",
        name="rclpy",
    ) from why

from .serving import RosError, serve

__all__ = ["RosError", "serve"]
