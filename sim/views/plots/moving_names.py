"""Names that move with what they name, and cover as little as can be of what is there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes

from floorplan import Point

from .names import stand_beside

Place = tuple[Point, Point]
"""A point of the floor (metres), and how far from there a name stands (points)."""


class MovingNames:
    """Where the names of a picture stand that move over what is written on `axes` and stays."""

    def __init__(self, axes: Axes) -> None:
        still = [text for text in axes.texts if not text.get_animated()]
        self._still = [text.get_window_extent().extents for text in still]
        self._taken = list(self._still)

    def clear(self) -> None:
        """Forget what moves, for the next picture."""
        self._taken = list(self._still)

    def keep_off(self, artist: Artist) -> None:
        """Let no name that is put from now on cover this one, if it can stand elsewhere."""
        self._taken.append(artist.get_window_extent().extents)

    def put(self, name: Any, places: Sequence[Place]) -> None:
        """Put an annotation at the first of its places where it covers nothing, or the least."""
        left, low, right, high = np.array(self._taken).reshape(-1, 4).T

        def covered(place: Place) -> float:
            """Put the name there; return how much it covers (square pixels)."""
            name.xy, side = place
            stand_beside(name, side)
            x, y, x_end, y_end = name.get_window_extent().extents
            wide = np.minimum(x_end, right) - np.maximum(x, left)
            deep = np.minimum(y_end, high) - np.maximum(y, low)
            return float(np.sum(wide.clip(0.0) * deep.clip(0.0)))

        if not any(covered(place) == 0.0 for place in places):
            covered(min(places, key=covered))
        self.keep_off(name)
