"""What a floor alone decides, worked out once and kept for the next world on the same floor.

All of it is a pure function of the floor's geometry, so that nothing depends on whether it was
kept. The few floors used last are kept, for each thread its own: GEOS's prepared geometries are
not made to be shared between threads.
"""

from __future__ import annotations

from functools import lru_cache
from threading import get_ident
from typing import Any

import shapely

from . import shapes
from .freespace import FreeSpace, shrunk
from .roadmap import Roadmap

MOST_KEPT = 8
"""So many floors, and so many radii on them, are kept."""

_AROUND = 10.0
"""Metres. How thick the solid rim around a floor is drawn."""

Bounds = tuple[float, float, float, float]
"""Least x and y, greatest x and y, in metres."""


def solid(floor: shapely.Geometry, bounds: Bounds) -> Any:
    """The FCL object of all that is not `floor`, with a rim around its `bounds`."""
    return _solid(floor, bounds, get_ident())


def fixed_space(floor: shapely.Geometry, radius: float) -> FreeSpace:
    """Where the centre of a disc of `radius` metres can be on `floor`."""
    return _fixed_space(floor, radius, get_ident())


def roadmap(floor: shapely.Geometry, radius: float, step: float) -> Roadmap:
    """The network of `floor` for discs of `radius` metres, bends at most `step` radians."""
    return _roadmap(floor, radius, step, get_ident())


@lru_cache(MOST_KEPT)
def _solid(floor: shapely.Geometry, bounds: Bounds, thread: int) -> Any:
    rim = shapely.box(*bounds).buffer(_AROUND, join_style="mitre")
    return shapes.region(rim.difference(floor))


@lru_cache(MOST_KEPT)
def _fixed_space(floor: shapely.Geometry, radius: float, thread: int) -> FreeSpace:
    return FreeSpace(shrunk(floor, radius))


@lru_cache(MOST_KEPT)
def _roadmap(floor: shapely.Geometry, radius: float, step: float, thread: int) -> Roadmap:
    return Roadmap(floor, radius, step)
