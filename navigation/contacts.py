"""Contacts of bodies with exact outlines, concave ones included, in continuous time."""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import pairwise

import shapely
from shapely.geometry.base import BaseGeometry

from .kernels.contacts import OutlineSearch, places
from .kernels.encounter import Encounter
from .kernels.numbers import numbers
from .motion import Motion, Table

Bounds = tuple[float, float, float, float]
"""Minimum x and y, maximum x and y, metres."""


@lru_cache(maxsize=1024)
def edges_of(area: BaseGeometry) -> Table:
    """Return a row of the edges of all rings of polygons: both ends of each, metres."""
    rings = shapely.get_rings(shapely.get_parts(area))
    found = []
    for ring in rings:
        corners = shapely.get_coordinates(ring).tolist()
        found += [c for a, b in pairwise(corners) for c in (*a, *b)]
    return numbers(found)


@lru_cache(maxsize=1024)
def shrunk(area: BaseGeometry, depth: float) -> BaseGeometry:
    """Return polygons whose sides are `depth` metres farther inside."""
    return shapely.buffer(area, -depth, join_style="mitre", mitre_limit=100.0)


def bounds_from(motion: Motion, begin: float) -> Bounds:
    """Return the bounds of the places on a motion from `begin` (seconds) on."""
    return places(motion.table, begin)


def are_apart(one: Motion, other: Motion, begin: float, gap: float) -> bool:
    """Return whether from `begin` (s) on, the places on motions are `gap` m apart along x or y."""
    x, y, most_x, most_y = places(one.table, begin)
    u, v, most_u, most_v = places(other.table, begin)
    return x - most_u > gap or u - most_x > gap or y - most_v > gap or v - most_y > gap


class Outlines:
    """Outlines of a machine and of another body, each in the frame of its body (metres).

    With `outside`, the other body covers all that is not within its outline.
    """

    def __init__(self, area: BaseGeometry, other: BaseGeometry, *, outside: bool = False) -> None:
        self._search = OutlineSearch(edges_of(area), edges_of(other), outside)

    def first_contact(
        self, machine: Motion, other: Motion, begin: float, end: float
    ) -> float | None:
        """Return when the outlines first touch (seconds), None if they do not.

        Bodies that are within each other, without a contact of their outlines, do not touch.
        """
        t = self._search.first(Encounter(other, machine), begin, end)
        return None if t == math.inf else t

    def first_parting(
        self, machine: Motion, other: Motion, begin: float, end: float, gap: float
    ) -> float | None:
        """Return when the bodies are first `gap` metres apart (seconds), None if they are not."""
        t = self._search.parting(Encounter(other, machine), begin, end, gap)
        return None if t == math.inf else t

    def overlap(self, machine: Motion, other: Motion, t: float) -> bool:
        """Return whether the bodies touch or overlap at `t` (seconds)."""
        return self._search.overlap(Encounter(other, machine), t)
