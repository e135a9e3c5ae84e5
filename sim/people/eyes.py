"""Eyes: which machines somebody can see from where they are, as they look."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import shapely
from shapely.geometry import LineString, Point

from floorplan import Human, Obstacle

from ..core.body import Body
from ..core.machine import Machine
from ..core.noticing import NoticingEntry
from ..core.stage import Stage

EYE_LEVEL = 0.93
"""Share of the stature at which eyes are: 1.63 m of 1.75 m, the median of men in DIN 33402-2."""


class Eyes:
    """The eyes of one person, who notices machines as `noticing` says (with plain figures)."""

    def __init__(self, stage: Stage, body: Body, human: Human, noticing: NoticingEntry) -> None:
        degrees, delay = noticing.field_of_view, noticing.reaction_time
        assert isinstance(degrees, float | int | None) and isinstance(delay, float | int | None)
        self.reaction_time = 0.0 if delay is None else delay
        """Seconds from when they see something until they perceive it."""
        self._half = math.pi if degrees is None else math.radians(degrees) / 2
        self._stage = stage
        self._body = body
        self._height = EYE_LEVEL * human.height
        self._boundary = stage.floorplan.boundary if noticing.occlusion else None
        self._fixed = stage.floorplan.obstacles
        self._tree = shapely.STRtree([one.footprint for one in self._fixed])

    def see(self, machine: Machine) -> bool:
        """Return whether any of the points at which they look of `machine` can be seen now.

        These are its axis and its corners; where something may hide them, at its bottom, at its top
        and half-way.
        """
        if self._half >= math.pi and self._boundary is None:
            return True
        x, y, heading = self._body.state.position
        at = machine.body.state.position
        shape = machine.shape
        footprint = shape.footprint(at[:2], at[2])
        if footprint.covers(Point(x, y)):
            return True
        points = [at[:2], *footprint.exterior.coords[:-1]]
        heights = (shape.bottom, (shape.bottom + shape.top) / 2, shape.top)
        return any(
            self._in_view(point[0] - x, point[1] - y, heading)
            and self._clear((x, y), (point[0], point[1]), heights, machine)
            for point in points
        )

    def _in_view(self, dx: float, dy: float, heading: float) -> bool:
        turned = math.remainder(math.atan2(dy, dx) - heading, 2 * math.pi)
        return abs(turned) <= self._half

    def _clear(
        self,
        eye: tuple[float, float],
        point: tuple[float, float],
        heights: Iterable[float],
        machine: Machine,
    ) -> bool:
        """Return whether nothing hides a point of `machine` at all of `heights` (metres)."""
        if self._boundary is None or math.dist(eye, point) == 0.0:
            return True
        line = LineString([eye, point])
        # The floor's edge hides all heights; of a point beyond it, as of a gantry that overhangs,
        # nothing is asked.
        if self._boundary.covers(Point(point)) and not self._boundary.covers(line):
            return False
        hides = [
            (span, one.bottom, one.top)
            for one in self._around(line, machine)
            for span in _spans(line, one)
        ]
        return any(
            not any(_hidden(span, self._height, height, low, top) for span, low, top in hides)
            for height in heights
        )

    def _around(self, line: LineString, seen: Machine) -> Iterable[Obstacle]:
        """Yield what stands or hangs on the line: obstacles, and machines other than that."""
        for index in np.sort(self._tree.query(line, predicate="intersects")):
            yield self._fixed[int(index)]
        yield from self._stage.there.values()
        for machine in self._stage.machines.values():
            if machine is not seen:
                x, y, rotation = machine.body.state.position
                shape = machine.shape
                footprint = shape.footprint((x, y), rotation)
                yield Obstacle(machine.name, footprint, shape.bottom, shape.top)


def _spans(line: LineString, obstacle: Obstacle) -> list[tuple[float, float]]:
    """Return the parts of a line over an obstacle, as shares of its length."""
    shared = shapely.intersection(line, obstacle.footprint)
    spans = []
    for part in shapely.get_parts(shared):
        ends = [line.project(Point(at), normalized=True) for at in shapely.get_coordinates(part)]
        if ends and max(ends) > min(ends):
            spans.append((min(ends), max(ends)))
    return spans


def _hidden(
    span: tuple[float, float], eye: float, height: float, bottom: float, top: float
) -> bool:
    """Return whether a sight line that runs from `eye` to `height` meets what fills this part."""
    # The line falls or rises evenly, so over the obstacle it is between its heights at the two
    # ends.
    along = [eye + share * (height - eye) for share in span]
    return bottom < max(along) and min(along) < top
