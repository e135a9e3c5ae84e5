"""Cache of results that depend on shapes alone, for other worlds on the same floor.

All results are pure functions of the geometry, so nothing depends on the cache. Each thread has its
own cache of the latest results, because prepared geometries of GEOS cannot be shared.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, wraps
from threading import get_ident
from typing import Any, ParamSpec, TypeVar

import shapely

from floorplan import Gate
from floorplan.model import free_area

from .bodies import CollisionBody, region
from .freespace import FreeSpace, Gates, Narrows, Walls, narrows, shrunk, without
from .roadmap import Roadmap

MOST_KEPT = 8
"""Number of floors, and of radii on them, that are kept."""

MOST_SPACES = 32
"""Number of free spaces among bodies that are kept."""

MOST_BODIES = 64
"""Number of bodies where they stand that are kept."""

_AROUND = 10.0
"""Metres. How thick the solid rim around a floor is drawn."""

_SIDE = 4.0
"""Metres. Longer sides of a floor are split for FCL: it looks at slim triangles longer."""

Bounds = tuple[float, float, float, float]
"""Least x and y, greatest x and y, in metres."""


_P = ParamSpec("_P")
_R = TypeVar("_R")


def _kept(most: int) -> Callable[[Callable[_P, _R]], Callable[_P, _R]]:
    """Return a decorator that keeps a function's last `most` results, for each thread its own."""

    def keeping(make: Callable[_P, _R]) -> Callable[_P, _R]:
        plain: Callable[..., _R] = make
        # The thread is part of the key, and no argument of the function.
        known: Any = lru_cache(most)(lambda _, *given: plain(*given))

        @wraps(make)
        def kept(*given: _P.args, **named: _P.kwargs) -> _R:
            found: _R = known(get_ident(), *given, **named)
            return found

        return kept

    return keeping


@_kept(MOST_KEPT)
def floor(
    boundary: shapely.Polygon, blocked: tuple[shapely.Polygon, ...]
) -> tuple[shapely.Geometry, shapely.Geometry]:
    """Return what `blocked` leaves free of the floor, and its edges, both prepared."""
    free = free_area(boundary, blocked)
    edges = free.boundary
    shapely.prepare([free, edges])
    return free, edges


@_kept(MOST_KEPT)
def solid(floor: shapely.Geometry, bounds: Bounds) -> Any:
    """Return the FCL object of all that is not `floor`, with a rim around its `bounds`."""
    rim = shapely.box(*bounds).buffer(_AROUND, join_style="mitre")
    return region(rim.difference(floor).segmentize(_SIDE))


@_kept(MOST_KEPT)
def fixed_space(floor: shapely.Geometry, radius: float) -> FreeSpace:
    """Return the free space of the centre of a disc of `radius` metres on `floor`."""
    return FreeSpace(shrunk(floor, radius))


@_kept(MOST_SPACES)
def free_space(
    floor: shapely.Geometry, radius: float, bodies: tuple[CollisionBody, ...]
) -> FreeSpace:
    """Return the free space of the centre of a disc of `radius` metres among `bodies`."""
    return without(fixed_space(floor, radius), bodies, radius)


@_kept(MOST_BODIES)
def body(name: str, shape: shapely.Polygon) -> CollisionBody:
    """Return the body `name` with this footprint; `ValueError` if it is not a simple polygon."""
    return CollisionBody.of(name, shape)


@_kept(MOST_KEPT)
def roadmap(
    floor: shapely.Geometry, radius: float, step: float, gates: tuple[Gate, ...]
) -> Roadmap:
    """Return the network of `floor` for discs of `radius` metres, bends at most `step` radians.

    Its links cross none of the `gates` against its direction.
    """
    return Roadmap(floor, radius, step, Gates(gates), walls(floor, radius).grid)


@_kept(MOST_KEPT)
def narrow_places(floor: shapely.Geometry, radius: float, abreast: int) -> Narrows:
    """Return where discs of `radius` metres can't go so many `abreast`, and around it."""
    return narrows(fixed_space(floor, radius), radius, abreast)


@_kept(MOST_KEPT)
def walls(floor: shapely.Geometry, radius: float) -> Walls:
    """Return the walls of `floor` as discs of `radius` metres see them."""
    return Walls(floor, radius)
