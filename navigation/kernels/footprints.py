"""Drives and turns of a footprint among the edges of a floor and bodies.

A drive covers one box. For a rectangle along its heading, the box is exact. A turn on the spot
covers a disc, or the larger boxes at intermediate angles.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .edges import Room, back_through, touches
from .numbers import Place

if not cython.compiled:
    from math import asin, atan2, ceil, copysign, cos, isnan, pi, remainder, sin

    from .convex import meets_edge
    from .cubics import *
    from .fields import edge_passes

    NAN = float("nan")

Pose = tuple[float, float, float]

_NO_TURN: float = 1e-9  # radians


class FootprintRoom:
    """Room on a floor for a footprint with these `corners` (metres), and its convex `parts`.

    `room` is that of a point, and `disc` that of a disc around the footprint. Drives and turns keep
    `slack` metres from everything, and boxes of a turn are larger by `sag`. `sideways` is true if
    the vehicle can drive in its present heading, and `alike` if its footprint is the same
    backwards.
    """

    def __init__(
        self,
        corners: Numbers,
        parts: list[Numbers],
        outer: float,
        slack: float,
        sag: float,
        sideways: bool,
        alike: bool,
    ) -> None:
        self.room: Room
        self.disc: Room
        self.corners = corners
        self.parts = parts
        self.slack = slack
        self.sag = sag
        self.sideways = sideways
        self.alike = alike
        self.step = 2 * asin(min(sag / outer, 1.0))
        """Angle between boxes of a turn (radians). Half of it moves a corner by `sag` at most."""

    def fits(self, x: float, y: float, rotation: float) -> bool:
        """Return whether the footprint is free in a pose."""
        c: float = cos(rotation)
        s: float = sin(rotation)
        part: Numbers
        k: cython.Py_ssize_t
        if not self.room.floor.inside(x, y):
            return False
        for part in self.parts:
            placed: Numbers = position_room(position_count(part))
            for k in range(position_count(part)):
                p: Position = positions_of(part)[k]
                positions_of(placed)[k] = Position(x + c * p.x - s * p.y, y + s * p.x + c * p.y)
            if not self._clear(placed):
                return False
        return True

    def drive_free(self, ax: float, ay: float, bx: float, by: float, rotation: float) -> bool:
        """Return whether a straight drive from a pose that fits is free."""
        gate: Numbers
        for gate in self.room.gates:
            if back_through(gate, ax, ay, bx, by):
                return False
        return self._clear(self.drive_box(ax, ay, bx, by, rotation))

    def drive_box(self, ax: float, ay: float, bx: float, by: float, rotation: float) -> Numbers:
        """Return the corners of the box of a drive, counterclockwise."""
        length: float = norm(bx - ax, by - ay)
        c: float = (bx - ax) / length
        s: float = (by - ay) / length
        return self._box(ax, ay, c, s, atan2(s, c) - rotation, length, self.slack)

    def turn_box(self, x: float, y: float, rotation: float) -> Numbers:
        """Return the corners of a box of a turn, counterclockwise."""
        return self._box(x, y, cos(rotation), sin(rotation), 0.0, 0.0, self.sag + self.slack)

    def turn_angles(self, begin: float, end: float) -> list[float]:
        """Return the rotations of the boxes of a turn.

        Neighbours mostly meet the same obstacle, so the order bisects the turn.
        """
        count: cython.Py_ssize_t = max(int(ceil(abs(end - begin) / self.step)), 1)
        angles: list[float] = []
        stride: cython.Py_ssize_t = 1
        k: cython.Py_ssize_t
        while stride < count:
            stride *= 2
        angles.append(begin + (end - begin) * 0.5 / count)
        while stride > 0:
            k = stride
            while k < count:
                angles.append(begin + (end - begin) * (k + 0.5) / count)
                k += 2 * stride
            stride //= 2
        return angles

    def _box(
        self, x: float, y: float, c: float, s: float, turned: float, length: float, margin: float
    ) -> Numbers:
        """Return the box around the footprint along (c, s), `length` longer ahead."""
        cosine: float = cos(turned)
        sine: float = sin(turned)
        box: BoundingBox = BoundingBox(INFINITY, INFINITY, -INFINITY, -INFINITY)
        k: cython.Py_ssize_t
        for k in range(position_count(self.corners)):
            p: Position = positions_of(self.corners)[k]
            along: float = p.x * cosine + p.y * sine
            across: float = p.y * cosine - p.x * sine
            box = united(box, BoundingBox(along, across, along, across))
        low: float = box.low_x - margin
        high: float = box.high_x + margin + length
        right: float = box.low_y - margin
        left: float = box.high_y + margin
        corners: Numbers = position_room(4)
        corner: Positions = positions_of(corners)
        corner[0] = Position(x + low * c - right * s, y + low * s + right * c)
        corner[1] = Position(x + high * c - right * s, y + high * s + right * c)
        corner[2] = Position(x + high * c - left * s, y + high * s + left * c)
        corner[3] = Position(x + low * c - left * s, y + low * s + left * c)
        return corners

    def turn_free(self, x: float, y: float, begin: float, end: float) -> bool:
        """Return whether a turn on the spot is free, at a place where the footprint fits."""
        if self.disc.clear(x, y, x, y, True):
            return True
        angle: float
        for angle in self.turn_angles(begin, end):
            if not self._clear(self.turn_box(x, y, angle)):
                return False
        return True

    def _turned(self, x: float, y: float, begin: float, end: float) -> float:
        """Return the rotation after a turn, in the shorter direction if that is free, or NaN."""
        short: float = remainder(end - begin, 2 * pi)
        if abs(short) < _NO_TURN:
            return begin
        if self.turn_free(x, y, begin, begin + short):
            return begin + short
        short -= copysign(2 * pi, short)
        if abs(short) < _NO_TURN or self.turn_free(x, y, begin, begin + short):
            return begin + short
        return NAN

    def between(self, one: Pose, to: Place, end: float) -> list[Pose] | None:
        """Return the poses of turn, drive and turn from one pose on, or None if not free.

        The rotation at the end is `end`, or any if that is NaN.
        """
        ax: float
        ay: float
        bx: float
        by: float
        rotation: float
        ax, ay, rotation = one
        bx, by = to
        last: float
        if norm(bx - ax, by - ay) < self.slack:
            last = rotation if isnan(end) else self._turned(ax, ay, rotation, end)
            return None if isnan(last) else [(ax, ay, last)]
        ahead: float = atan2(by - ay, bx - ax)
        k: cython.Py_ssize_t
        for k in range(0 if self.sideways else 1, 3):
            heading: float = rotation if k == 0 else ahead if k == 1 else ahead + pi
            # The drive first, because it is one box.
            if not self.drive_free(ax, ay, bx, by, heading):
                if self.alike:
                    return None
                continue
            first: float = self._turned(ax, ay, rotation, heading)
            if isnan(first):
                continue
            last = first if isnan(end) else self._turned(bx, by, first, end)
            if not isnan(last):
                return [(ax, ay, first), (bx, by, first), (bx, by, last)]
        return None

    def _clear(self, polygon: Numbers) -> bool:
        """Return whether a convex polygon meets no edge, and is in no body."""
        if self.room.floor.meets(polygon):
            return False
        box: BoundingBox = box_around(polygon, position_count(polygon))
        k: cython.Py_ssize_t
        for k in range(len(self.room.bodies)):
            rounding: float = at(self.room.radii)[k]
            near: bool = are_within(box, boxes_of(self.room.bounds)[k], rounding + self.slack)
            if near and _meets_body(polygon, self.room.bodies[k], rounding):
                return False
        return True


def _meets_body(polygon: Numbers, edges: Numbers, rounding: float) -> bool:
    """Return whether a convex polygon meets a body with rounded edges, or is inside."""
    count: cython.Py_ssize_t = position_count(polygon)
    p: Positions = positions_of(polygon)
    k: cython.Py_ssize_t
    for k in range(edge_count(edges)):
        e: Edge = edges_of(edges)[k]
        if meets_edge(polygon, e):
            return True
    for k in range(count if rounding > 0.0 else 0):
        after: Position = p[k + 1 if k + 1 < count else 0]
        if touches(edges, p[k].x, p[k].y, after.x, after.y, rounding):
            return True
    return _is_inside(edges, p[0].x, p[0].y)


def _is_inside(edges: Numbers, x: float, y: float) -> bool:
    """Return whether a place is within edges (even-odd rule)."""
    inside: bool = False
    k: cython.Py_ssize_t
    for k in range(edge_count(edges)):
        if edge_passes(x, y, edges_of(edges)[k]):
            inside = not inside
    return inside
