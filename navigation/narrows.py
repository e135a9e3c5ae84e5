"""Narrow places of a floor: where discs can't pass each other, or only so many abreast."""

from __future__ import annotations

import shapely

from .freespace import FreeSpace

SPARE = 0.03
"""Metres. Room beyond their diameters that a passage needs for each disc that passes another."""

APRON = 0.35
"""Metres. So far from a narrow place somebody who stands is still in its way."""

_NICHE = 0.3
"""Square metres. A narrow place that leads nowhere counts from this size on; corners don't."""


def narrows(space: FreeSpace, radius: float, abreast: int) -> shapely.Geometry:
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
    around = shapely.union_all(found).buffer(APRON)
    shapely.prepare(around)
    return around
