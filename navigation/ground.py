"""Cache of results that depend on shapes alone, for other worlds on the same floor.

All results are pure functions of the geometry, so nothing depends on the cache. Each thread has its
own cache of the latest results, because prepared geometries of GEOS cannot be shared.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial, wraps
from threading import get_ident
from typing import Any, ParamSpec, TypeVar

import shapely

from floorplan import Gate
from floorplan.model import free_area

from . import freespace
from .bodies import CollisionBody, region
from .contacts import Extent
from .freespace import FreeSpace, Gates, Narrows, narrows, shrunk, without
from .kernels.edges import Grid
from .roadmap import Roadmap

MOST_KEPT = 8
"""Number of cached floors, and of radii on them."""

MOST_SPACES = 32
"""Number of cached free spaces among bodies."""

MOST_BODIES = 64
"""Number of cached bodies."""

_AROUND = 10.0
"""Metres. Width of the solid rim around a floor."""

_SIDE = 4.0
"""Metres. Longer sides of a floor are split for FCL, because slim triangles are slow."""

_P = ParamSpec("_P")
_R = TypeVar("_R")


def _cached(limit: int) -> Callable[[Callable[_P, _R]], Callable[_P, _R]]:
    """Return a decorator that caches a function's last results separately for each thread."""

    def decorate(make: Callable[_P, _R]) -> Callable[_P, _R]:
        plain: Callable[..., _R] = make
        # The thread is part of the key, and no argument of the function.
        cache: Any = lru_cache(limit)(lambda _, *args: plain(*args))

        @wraps(make)
        def cached(*args: _P.args, **kwargs: _P.kwargs) -> _R:
            result: _R = cache(get_ident(), *args, **kwargs)
            return result

        return cached

    return decorate


@_cached(MOST_KEPT)
def floor(
    boundary: shapely.Polygon, blocked: tuple[shapely.Polygon, ...]
) -> tuple[shapely.Geometry, shapely.Geometry]:
    """Return the floor without `blocked`, and its edges, both prepared."""
    free = free_area(boundary, blocked)
    edges = free.boundary
    shapely.prepare([free, edges])
    return free, edges


@_cached(MOST_KEPT)
def solid(floor: shapely.Geometry, bounds: Extent) -> Any:
    """Return the FCL object of the complement of `floor`, with a rim around its `bounds`."""
    rim = shapely.box(*bounds).buffer(_AROUND, join_style="mitre")
    return region(rim.difference(floor).segmentize(_SIDE))


@_cached(MOST_KEPT)
def fixed_space(floor: shapely.Geometry, radius: float) -> FreeSpace:
    """Return the free space of the centre of a disc of `radius` metres on `floor`."""
    return FreeSpace(shrunk(floor, radius))


@_cached(MOST_SPACES)
def free_space(
    floor: shapely.Geometry, radius: float, bodies: tuple[CollisionBody, ...]
) -> FreeSpace:
    """Return the free space of the centre of a disc of `radius` metres among `bodies`."""
    return without(fixed_space(floor, radius), bodies, radius)


@_cached(MOST_BODIES)
def body(name: str, shape: shapely.Polygon) -> CollisionBody:
    """Return the body `name` with this footprint. `ValueError` if it is not a simple polygon."""
    return CollisionBody.of(name, shape)


@_cached(MOST_KEPT)
def roadmap(
    floor: shapely.Geometry, radius: float, step: float, gates: tuple[Gate, ...]
) -> Roadmap:
    """Return the network of `floor` for discs of `radius` metres, with bends of at most `step`.

    No link crosses one of the `gates` against its direction.
    """
    return Roadmap(floor, radius, step, Gates(gates), walls(floor))


@_cached(MOST_KEPT)
def narrow_places(floor: shapely.Geometry, radius: float, abreast: int) -> Narrows:
    """Return the places that discs of `radius` metres cannot pass `abreast`, with a margin."""
    return Narrows(partial(narrows, fixed_space(floor, radius), radius, abreast))


@_cached(MOST_KEPT)
def walls(floor: shapely.Geometry) -> Grid:
    """Return the grid of the edges of a floor."""
    return freespace.walls(floor)
