"""Narrow places of a floor: where discs can't pass each other, or only so many abreast."""

from __future__ import annotations

from functools import partial

import shapely

from floorplan import Point

from .freespace import FreeSpace
from .kernels.grid import SOME, Cells

SPARE = 0.03
"""Metres. Room beyond their diameters that a passage needs for each disc that passes another."""

APRON = 0.35
"""Metres. So far from a narrow place somebody who stands is still in its way."""

CELL = 0.5
"""Metres. The width of the cells by which it is known what is narrow."""

_NICHE = 0.3
"""Square metres. A narrow place that leads nowhere counts from this size on; corners don't."""


class Narrows:
    """Narrow places of a floor, and just before them: where nobody should stop."""

    def __init__(self, area: shapely.Geometry) -> None:
        self._area = area
        self.cells = Cells(CELL, self._whole, partial(shapely.intersects_xy, area))
        """What is known of the area."""
        shapely.prepare(area)

    def has(self, place: Point) -> bool:
        """Return whether a place (x, y in metres) is one of them."""
        return self.cells.has(*place)

    def _whole(self, column: int, row: int) -> int:
        """Return whether all of a cell is narrow (1), or none of it (0), or some."""
        x, y = column * CELL, row * CELL
        cell = shapely.box(x, y, x + CELL, y + CELL)
        if not shapely.intersects(self._area, cell):
            return 0
        return 1 if shapely.contains_properly(self._area, cell) else SOME


def narrows(space: FreeSpace, radius: float, abreast: int) -> Narrows:
    """Return where nobody should stop: the narrow places of a free space, and their aprons.

    The narrow places for discs of `radius` metres are the free space of their centres less its
    opening by a disc as wide as so many `abreast` need: a passage, or a dead end of some size.
    """
    found = []
    half = (abreast - 1) * (radius + SPARE / 2)
    for piece in space.pieces:
        # The opening of mathematical morphology (J. Serra, "Image Analysis and Mathematical
        # Morphology", 1982): what a disc of this width can cover. A millimetre more hides what
        # rounding leaves.
        wide = piece.buffer(-half).buffer(half + 1e-3)
        for part in shapely.get_parts(piece.difference(wide)):
            mouths = part.buffer(2e-3).intersection(wide)
            # What is left of every corner has one mouth as well, but is small.
            if part.area > _NICHE or len(shapely.get_parts(mouths)) > 1:
                found.append(part)
    return Narrows(shapely.union_all(found).buffer(APRON))
