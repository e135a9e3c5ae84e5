"""Results that depend on a floor alone, kept for the next world on the same floor.

All of it is a pure function of the floor's geometry, so that nothing depends on whether it was
kept. The few floors used last are kept, for each thread its own: GEOS's prepared geometries are
not made to be shared between threads.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, wraps
from threading import get_ident
from typing import Any, ParamSpec, TypeVar

import shapely

from .bodies import region
from .freespace import FreeSpace, shrunk
from .narrows import narrows
from .roadmap import Roadmap

MOST_KEPT = 8
"""Number of floors, and of radii on them, that are kept."""

_AROUND = 10.0
"""Metres. How thick the solid rim around a floor is drawn."""

Bounds = tuple[float, float, float, float]
"""Least x and y, greatest x and y, in metres."""


_P = ParamSpec("_P")
_R = TypeVar("_R")


def _kept(make: Callable[_P, _R]) -> Callable[_P, _R]:
    """Return `make` with its last results kept, for each thread its own."""

    plain: Callable[..., _R] = make
    known: Any = lru_cache(MOST_KEPT)(lambda _, *given: plain(*given))

    @wraps(make)
    def kept(*given: _P.args, **named: _P.kwargs) -> _R:
        found: _R = known(get_ident(), *given, **named)
        return found

    return kept


@_kept
def solid(floor: shapely.Geometry, bounds: Bounds) -> Any:
    """Return the FCL object of all that is not `floor`, with a rim around its `bounds`."""
    rim = shapely.box(*bounds).buffer(_AROUND, join_style="mitre")
    return region(rim.difference(floor))


@_kept
def fixed_space(floor: shapely.Geometry, radius: float) -> FreeSpace:
    """Return the free space of the centre of a disc of `radius` metres on `floor`."""
    return FreeSpace(shrunk(floor, radius))


@_kept
def roadmap(floor: shapely.Geometry, radius: float, step: float) -> Roadmap:
    """Return the network of `floor` for discs of `radius` metres, bends at most `step` radians."""
    return Roadmap(floor, radius, step)


@_kept
def narrow_places(floor: shapely.Geometry, radius: float) -> shapely.Geometry:
    """Return where discs of `radius` metres can't pass each other on `floor`, and around it."""
    return narrows(fixed_space(floor, radius), radius)
