"""Runs in the formats of others: tables, robotics viewers, ROS, pedestrian dynamics."""

from .formats import FORMATS, Format, export

__all__ = ["FORMATS", "Format", "export"]
