"""A floor in square cells: how many there are, and those that a body covers."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from floorplan import Floorplan

Array = NDArray[np.float64]

_HAIR = 1e-9
"""Metres. Cells that are beyond a radius by no more than this still count."""


def cells_of(plan: Floorplan, side: float) -> tuple[int, int]:
    """Return how many rows and columns of cells with this side (metres) the floor's bounds take."""
    west, south, east, north = plan.boundary.bounds
    return (math.ceil((north - south) / side), math.ceil((east - west) / side))


def spread(
    cells: Array, side: float, radius: float, join: Callable[..., Array], nothing: float
) -> Array:
    """Return each cell (of this side) joined with all within `radius` metres of it.

    `nothing` is what stands beyond the floor.
    """
    reach = math.ceil(radius / side)
    rows, columns = cells.shape
    padded = np.pad(cells, reach, constant_values=nothing)
    joined = np.full_like(cells, nothing)
    for i in range(-reach, reach + 1):
        for j in range(-reach, reach + 1):
            # One shift of the whole array for each cell of the disc: a dilation, or a sum, by its
            # mask.
            if math.hypot(i, j) * side < radius + _HAIR:
                joined = join(joined, padded[reach + i :, reach + j :][:rows, :columns])
    return joined
