"""Laser scans of machines: distances to the floor, other machines and people."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from floorplan import UserError
from navigation.motion import State

from .arguments import number

if TYPE_CHECKING:
    from ..core.body import Machine
    from ..core.stage import Stage

Array = NDArray[np.float64]

MOST_RAYS = 3600
"""Highest number of rays of a scan."""

EMPTY: Array = np.empty((0, 4))


class Scanner:
    """Scanner at the centre of a machine, which sees a horizontal plane.

    Parameters
    ----------
    stage : Stage
        State of the simulation.
    machine : Machine
        The machine, which the scanner does not see.
    """

    def __init__(self, stage: Stage, machine: Machine) -> None:
        self._stage = stage
        self._machine = machine
        self._walls: dict[float, Array] = {}
        self._outlines: dict[str, Array] = {}

    def ranges(self, rays: int, reach: float, height: float) -> Array:
        """Return the distances in metres, at most `reach`, as (rays,).

        The first ray points backwards, and the others follow counterclockwise.
        """
        if not 1 <= rays <= MOST_RAYS:
            raise UserError(f"scan(rays) must be 1 to {MOST_RAYS}, not {rays}")
        if not number("scan(reach)", reach) > 0:
            raise UserError(f"scan(reach) must be more than 0, not {reach:g}")
        x, y, rotation = self._machine.body.state.position
        angles = rotation + np.linspace(-math.pi, math.pi, rays, endpoint=False)
        directions = np.stack((np.cos(angles), np.sin(angles)), axis=1)
        here = np.array((x, y))
        segments = np.concatenate(
            (self._floor(height), *self._closures(height), *self._machines(height))
        )
        to_segments = _to_segments(here, directions, segments, reach)
        to_people = _to_discs(here, directions, self._people(height))
        return np.minimum(np.minimum(to_segments, to_people), reach)

    def _floor(self, height: float) -> Array:
        if height not in self._walls:
            free = self._stage.floorplan.free(height, height)
            self._walls[height] = np.concatenate((EMPTY, *map(np.array, _sides(free))))
        return self._walls[height]

    def _closures(self, height: float) -> Iterator[Array]:
        for closure in self._stage.active_closures.values():
            if closure.overlaps(height, height):
                yield from _sides(closure.footprint)

    def _machines(self, height: float) -> Iterator[Array]:
        for name, machine in self._stage.machines.items():
            shape = machine.shape
            if machine is self._machine or not shape.bottom <= height <= shape.top:
                continue
            if name not in self._outlines:
                self._outlines[name] = np.concatenate([*_sides(shape.footprint((0.0, 0.0), 0.0))])
            yield _moved(self._outlines[name], machine.body.state)

    def _people(self, height: float) -> Array:
        there = [
            (*person.body.at, person.radius)
            for person in self._stage.people
            if not person.away and height <= self._stage.floorplan.human.height
        ]
        return np.array(there).reshape(-1, 3)


def _sides(area: BaseGeometry) -> Iterator[Array]:
    """Yield the sides of polygons as rows (x, y, x, y), metres."""
    for part in getattr(area, "geoms", (area,)):
        for ring in (part.exterior, *part.interiors):
            points = np.array(ring.coords)[:, :2]
            yield np.concatenate((points[:-1], points[1:]), axis=1)


def _moved(sides: Array, state: State) -> Array:
    x, y, rotation = state.position
    c, s = math.cos(rotation), math.sin(rotation)
    turn = np.array(((c, s), (-s, c)))
    ends: Array = sides.reshape(-1, 2, 2) @ turn + (x, y)
    return ends.reshape(-1, 4)


def _to_segments(here: Array, directions: Array, segments: Array, reach: float) -> Array:
    """Return the distance from `here` to the first segment on each ray, or inf."""
    begin, end = segments[:, :2] - here, segments[:, 2:] - here
    low, high = np.minimum(begin, end), np.maximum(begin, end)
    near = ((low <= reach) & (high >= -reach)).all(axis=1)
    begin, along = begin[near], end[near] - begin[near]
    if not len(begin):
        return np.full(len(directions), math.inf)
    # Solve here + t * direction = begin + u * along for all rays and segments.
    dx, dy = directions[:, :1], directions[:, 1:]
    with np.errstate(divide="ignore", invalid="ignore"):
        crossed = dx * along[:, 1] - dy * along[:, 0]
        t = (begin[:, 0] * along[:, 1] - begin[:, 1] * along[:, 0]) / crossed
        u = (begin[:, 0] * dy - begin[:, 1] * dx) / crossed
    hits = (t >= 0) & (u >= 0) & (u <= 1)
    nearest: Array = np.where(hits, t, math.inf).min(axis=1)
    return nearest


def _to_discs(here: Array, directions: Array, discs: Array) -> Array:
    """Return the distance from `here` to the first disc on each ray, or inf."""
    if not len(discs):
        return np.full(len(directions), math.inf)
    offset = discs[:, :2] - here
    ahead = directions @ offset.T
    outside = np.square(offset).sum(axis=1) - np.square(discs[:, 2])
    root = np.square(ahead) - outside
    with np.errstate(invalid="ignore"):
        t = ahead - np.sqrt(root)
    inside = outside < 0
    t = np.where(inside, 0.0, np.where((root >= 0) & (t >= 0), t, math.inf))
    nearest: Array = t.min(axis=1)
    return nearest
