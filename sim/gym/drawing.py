"""Pictures of a running simulation from above, drawn with Pillow."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from floorplan import Point

if TYPE_CHECKING:
    from ..simulation import Simulation

SIZE = 640
"""Pixels of the longer side."""

FREE, WALL, MACHINE, PERSON, GOAL = "#ffffff", "#9aa3ad", "#2f6fbf", "#d9822b", "#2e9e5b"


class Picture:
    """Draws a simulation. The floor is drawn once."""

    def __init__(self, simulation: Simulation) -> None:
        from PIL import Image, ImageDraw

        self._drawing = ImageDraw.Draw
        self._simulation = simulation
        plan = simulation.trial.floorplan
        self._west, south, east, self._north = plan.boundary.bounds
        self._scale = SIZE / max(east - self._west, self._north - south)
        size = [round(side * self._scale) for side in (east - self._west, self._north - south)]
        self._floor = Image.new("RGB", (size[0], size[1]), WALL)
        self._fill(self._drawing(self._floor), plan.free(0.0, plan.human.height), FREE, WALL)

    def frame(self, goal: Sequence[float] | None) -> NDArray[np.uint8]:
        """Return people, machines and the goal of the policy now, as (height, width, 3)."""
        picture = self._floor.copy()
        draw = self._drawing(picture)
        for one in self._simulation.machines.values():
            x, y, rotation = one.body.state.position
            self._fill(draw, one.shape.footprint((x, y), rotation), MACHINE, FREE)
        for person in self._simulation.people:
            if not person.away:
                draw.ellipse(self._around(person.body.at, person.radius), fill=PERSON)
        if goal is not None:
            draw.ellipse(self._around((goal[0], goal[1]), 0.2), outline=GOAL, width=3)
        return np.asarray(picture, np.uint8)

    def _around(self, at: Point, radius: float) -> tuple[float, float, float, float]:
        (x, y), r = self._pixel(at), radius * self._scale
        return x - r, y - r, x + r, y + r

    def _pixel(self, at: Sequence[float]) -> tuple[float, float]:
        return (at[0] - self._west) * self._scale, (self._north - at[1]) * self._scale

    def _fill(self, draw: Any, area: BaseGeometry, inside: str, holes: str) -> None:
        for part in getattr(area, "geoms", (area,)):
            draw.polygon([*map(self._pixel, part.exterior.coords)], fill=inside)
            for hole in part.interiors:
                draw.polygon([*map(self._pixel, hole.coords)], fill=holes)
