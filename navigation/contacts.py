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

Extent = tuple[float, float, float, float]
"""Minimum x and y, maximum x and y, metres."""


@lru_cache(maxsize=1024)
def edges_of(area: BaseGeometry) -> Table:
    """Return a row of the edges of all rings of polygons: both ends of each, metres."""
    ends: list[float] = []
    for ring in shapely.get_rings(shapely.get_parts(area)):
        corners = shapely.get_coordinates(ring).tolist()
        ends += [c for a, b in pairwise(corners) for c in (*a, *b)]
    return numbers(ends)


@lru_cache(maxsize=1024)
def shrunk(area: BaseGeometry, depth: float) -> BaseGeometry:
    """Return polygons with all sides moved inwards by `depth` metres."""
    return shapely.buffer(area, -depth, join_style="mitre", mitre_limit=100.0)


def bounds_from(motion: Motion, begin: float) -> Extent:
    """Return the bounds of a motion from `begin` (seconds) on."""
    return places(motion.table, begin)


def are_apart(one: Motion, other: Motion, begin: float, gap: float) -> bool:
    """Return whether the bounds of two motions from `begin` (s) on are `gap` metres apart."""
    x, y, most_x, most_y = places(one.table, begin)
    u, v, most_u, most_v = places(other.table, begin)
    return x - most_u > gap or u - most_x > gap or y - most_v > gap or v - most_y > gap


class Outlines:
    """Outlines of a machine and of another body, each in the frame of its body (metres).

    With `outside`, the other body covers everything outside of its outline.
    """

    def __init__(self, area: BaseGeometry, other: BaseGeometry, *, outside: bool = False) -> None:
        self._search = OutlineSearch(edges_of(area), edges_of(other), outside)

    def first_contact(
        self, machine: Motion, other: Motion, begin: float, end: float
    ) -> float | None:
        """Return the time of the first contact of the outlines (s), or None.

        Bodies that are within each other, without a contact of their outlines, do not touch.
        """
        t = self._search.first(Encounter(other, machine), begin, end)
        return None if t == math.inf else t

    def first_parting(
        self, machine: Motion, other: Motion, begin: float, end: float, gap: float
    ) -> float | None:
        """Return the first time at which the bodies are `gap` metres apart (s), or None."""
        t = self._search.parting(Encounter(other, machine), begin, end, gap)
        return None if t == math.inf else t

    def overlap(self, machine: Motion, other: Motion, t: float) -> bool:
        """Return whether the bodies touch or overlap at `t` (seconds)."""
        return self._search.overlap(Encounter(other, machine), t)
