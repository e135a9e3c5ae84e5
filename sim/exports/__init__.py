"""Exports of runs: tables, robotics viewers, ROS, pedestrian dynamics."""

from .formats import FORMATS, Export, Format, export

__all__ = ["FORMATS", "Export", "Format", "export"]
