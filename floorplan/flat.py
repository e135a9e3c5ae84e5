"""Floors from formats that know no heights: an area to walk on, and holes in it."""

from __future__ import annotations

from shapely.geometry import Polygon

from .model import Floorplan, Obstacle

HEIGHT = 3.0
"""Metres. How high everything stands where the format does not say."""


def from_area(name: str, source: str, area: Polygon) -> Floorplan:
    """The floor that is bounded by `area` (metres), whose holes are its obstacles."""
    holes = enumerate(area.interiors, start=1)
    return Floorplan(
        name=name,
        source=source,
        boundary=Polygon(area.exterior),
        obstacles=tuple(Obstacle(f"obstacle{k}", Polygon(hole), 0.0, HEIGHT) for k, hole in holes),
    )
