"""Footprint, load and limits of a vehicle."""

from __future__ import annotations

from functools import cached_property

import shapely
from shapely.geometry import Polygon

from floorplan.files.dataclass import dataclass
from navigation import VehicleLimits

from ...core.body import MachineShape


@dataclass(frozen=True, kw_only=True)
class Chassis:
    """Body of a vehicle with its load.

    It covers its `footprint` (m), at the origin with the heading 0, up to its `top` (m). It turns
    about the origin. It is `loaded` all the time or never.
    """

    footprint: Polygon
    top: float
    limits: VehicleLimits
    loaded: bool = False

    @cached_property
    def half_size(self) -> tuple[float, float]:
        """Half the length and width of the smallest box around the axis that contains it."""
        x, y = abs(shapely.get_coordinates(self.footprint)).max(axis=0).tolist()
        return x, y

    def shape(self, name: str) -> MachineShape:
        """Return its shape, with the smallest box around its axis."""
        x, y = self.half_size
        return MachineShape(
            name=name,
            kind="amr",
            category="vehicle",
            length=2 * x,
            width=2 * y,
            top=self.top,
            top_speed=self.limits.top_speed,
            outline=self._outline(),
            loaded=self.loaded,
        )

    def _outline(self) -> tuple[tuple[float, float], ...]:
        """Return the corners of the footprint unless it is the box."""
        x, y = self.half_size
        if self.footprint.equals(shapely.box(-x, -y, x, y)):
            return ()
        return tuple((float(x), float(y)) for x, y in self.footprint.exterior.coords[:-1])
