"""Edges of a floor: whether a disc that is swept along a segment touches one.

Edges are found in a uniform grid (J. Amanatides and A. Woo, "A fast voxel traversal algorithm for
ray tracing", Eurographics 1987), and a place is inside by the parity of a ray's crossings.
Edges are rows of numbers (see `numbers`): x and y of both ends of each in turn (metres).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .numbers import Place

if not cython.compiled:
    from math import sqrt

    from .cubics import *
    from .numbers import *

_WIDER: float = 1.001  # of a radius: rounding hides no cell beside a sweep
_LATELY: cython.Py_ssize_t = 16  # numbers of the edges that are remembered
_LOOKED_AT: cython.Py_ssize_t = 4  # corners of a route that are looked at
_LEVEL: float = 1e-3  # of a cell's width; segments that rise less are taken as level


class Grid:
    """Edges by the square cells of `width` metres that they come into."""

    def __init__(self, edges: Numbers, width: float) -> None:
        self.width = width
        self.low_x = min(edges[0::2])
        self.low_y = min(edges[1::2])
        self.columns = 1 + int((max(edges[0::2]) - self.low_x) / width)
        self.rows = 1 + int((max(edges[1::2]) - self.low_y) / width)
        self.first = self.last = 0
        self.cells: list[Numbers] = [room(0) for _ in range(self.columns * self.rows)]
        self.lately = room(0)
        edge: Doubles = at(edges)
        margin: float = 1e-6 * width
        k: cython.Py_ssize_t
        row: cython.Py_ssize_t
        column: cython.Py_ssize_t
        for k in range(0, len(edges), 4):
            ax: float = edge[k]
            ay: float = edge[k + 1]
            bx: float = edge[k + 2]
            by: float = edge[k + 3]
            for row in range(self._row(min(ay, by) - margin), self._row(max(ay, by) + margin) + 1):
                self._span(row, ax, ay, bx, by, margin)
                for column in range(self.first, self.last + 1):
                    self.cells[row * self.columns + column].extend((ax, ay, bx, by))

    def touched(self, ax: float, ay: float, bx: float, by: float, radius: float) -> bool:
        """Return whether an edge is nearer than `radius` (metres) to the segment from a to b."""
        dx: float = bx - ax
        dy: float = by - ay
        length: float = sqrt(dx * dx + dy * dy)
        # What was in the way of the last segments is often in the way of the next, too.
        if _first_near(self.lately, ax, ay, dx, dy, length, radius) >= 0:
            return True
        margin: float = radius * _WIDER
        edges: Numbers
        row: cython.Py_ssize_t
        column: cython.Py_ssize_t
        k: cython.Py_ssize_t
        for row in range(self._row(min(ay, by) - margin), self._row(max(ay, by) + margin) + 1):
            self._span(row, ax, ay, bx, by, margin)
            for column in range(self.first, self.last + 1):
                # An edge stands in all the cells that it comes into: to look at one twice does no
                # harm.
                edges = self.cells[row * self.columns + column]
                if len(edges) > 0:
                    k = _first_near(edges, ax, ay, dx, dy, length, radius)
                    if k >= 0:
                        self._remember(edges, k)
                        return True
        return False

    def _remember(self, edges: Numbers, k: cython.Py_ssize_t) -> cython.int:
        """Put an edge before those that are remembered."""
        last: Numbers = self.lately
        count: cython.Py_ssize_t = min(len(last) + 4, _LATELY)
        self.lately = room(count)
        put(at(self.lately), 0, at(edges), k, 4)
        put(at(self.lately), 4, at(last), 0, count - 4)
        return 0

    def inside(self, x: float, y: float) -> bool:
        """Return whether a place is within the edges: a ray from there crosses an odd number."""
        odd: bool = False
        row: cython.Py_ssize_t = self._row(y)
        edges: Numbers
        edge: Doubles
        column: cython.Py_ssize_t
        k: cython.Py_ssize_t
        for column in range(self._column(x), self.columns):
            edges = self.cells[row * self.columns + column]
            edge = at(edges)
            for k in range(0, len(edges), 4):
                ay: float = edge[k + 1]
                by: float = edge[k + 3]
                if (ay > y) != (by > y):
                    ax: float = edge[k]
                    crossing: float = ax + (y - ay) / (by - ay) * (edge[k + 2] - ax)
                    # An edge is in all cells that it comes into, and counts in that one.
                    if crossing > x and self._column(crossing) == column:
                        odd = not odd
        return odd

    def _column(self, x: float) -> int:
        """Return the column of cells that `x` is in, or the one nearest to it."""
        return int(min(max((x - self.low_x) / self.width, 0.0), self.columns - 1.0))

    def _row(self, y: float) -> int:
        """Return the row of cells that `y` is in, or the one nearest to it."""
        return int(min(max((y - self.low_y) / self.width, 0.0), self.rows - 1.0))

    def _span(
        self, row: cython.Py_ssize_t, ax: float, ay: float, bx: float, by: float, margin: float
    ) -> None:
        """Find the `first` and the `last` column of a row that a sweep may come into.

        An edge in the row that is near the segment is near a point of it whose y is no farther
        than `margin` from the row, and in the columns within `margin` of that point.
        """
        low: float = ax
        high: float = bx
        if abs(by - ay) > _LEVEL * self.width:
            bottom: float = self.low_y + row * self.width - margin
            slope: float = (bx - ax) / (by - ay)
            low = ax + slope * (min(max(bottom, min(ay, by)), max(ay, by)) - ay)
            top: float = bottom + self.width + 2.0 * margin
            high = ax + slope * (min(max(top, min(ay, by)), max(ay, by)) - ay)
        if low > high:
            low, high = high, low
        most: float = self.columns - 1.0
        self.first = int(min(max((low - margin - self.low_x) / self.width, 0.0), most))
        self.last = int(min(max((high + margin - self.low_x) / self.width, 0.0), most))


class Room:
    """The room that a floor and bodies leave for a disc of `radius` metres.

    Each of `bodies` are the edges of one, and its rounding: metres by which it is larger all round.
    `gates` are lines as for `back_through`, which a segment must not go back through.
    """

    def __init__(
        self,
        floor: Grid,
        radius: float,
        bodies: list[tuple[Numbers, float]],
        gates: list[Numbers],
    ) -> None:
        self.floor = floor
        self.radius = radius
        self.asked = 0
        self.bodies = [edges for edges, _ in bodies]
        self.gates = gates
        self.bounds: Numbers = room(0)
        self.radii: Numbers = room(0)
        for edges, rounding in bodies:
            self.bounds.extend((min(edges[0::2]), min(edges[1::2])))
            self.bounds.extend((max(edges[0::2]), max(edges[1::2])))
            self.radii.append(radius + rounding)

    def holds(self, x: float, y: float) -> bool:
        """Return whether there is room for the disc at a place."""
        return self.floor.inside(x, y) and self.clear(x, y, x, y, True)

    def clear(self, ax: float, ay: float, bx: float, by: float, floor: bool) -> bool:
        """Return whether there is room on the segment from a, where there is, to b.

        The floor and its gates count if `floor` is true. How often this was asked is in `asked`.
        """
        self.asked += 1
        gate: Numbers
        if floor:
            for gate in self.gates:
                if back_through(gate, ax, ay, bx, by):
                    return False
            if self.floor.touched(ax, ay, bx, by, self.radius):
                return False
        box: Boxes = boxes_of(self.bounds)
        k: cython.Py_ssize_t
        for k in range(len(self.bodies)):
            keep: float = at(self.radii)[k]
            if _comes_into(box[k], ax, ay, bx, by, keep) and touches(
                self.bodies[k], ax, ay, bx, by, keep
            ):
                return False
        return True


class Legs:
    """Segments on a floor along which there is room for a disc of `radius` metres, or is none.

    That is decided by the edges of its `walls`, but where a segment comes into the `bounds` of
    something else, least x and y and greatest x and y of each: then `ask(a, b)` decides.
    """

    def __init__(self, walls: Grid, radius: float, ask: Callable[[Place, Place], bool]) -> None:
        self.walls = walls
        self.radius = radius
        self.ask = ask
        self.bounds = room(0)

    def free(self, ax: float, ay: float, bx: float, by: float) -> bool:
        """Return whether there is room on the segment from a, where there is, to b."""
        if self.walls.touched(ax, ay, bx, by, self.radius):
            return False
        box: Boxes = boxes_of(self.bounds)
        k: cython.Py_ssize_t
        for k in range(box_count(self.bounds)):
            if _comes_into(box[k], ax, ay, bx, by, self.radius):
                return bool(self.ask((ax, ay), (bx, by)))
        return True

    def farthest(self, x: float, y: float, route: list[Place]) -> cython.Py_ssize_t:
        """Return the index of the farthest corner of a route that is seen from x, y; -1 for none.

        Of the first few: a straight line to it is shorter than the bends before it.
        """
        k: cython.Py_ssize_t
        for k in range(min(len(route), _LOOKED_AT) - 1, -1, -1):
            bx, by = route[k]
            if self.free(x, y, bx, by):
                return k
        return -1

    def farthest_round(
        self, x: float, y: float, route: list[Place], places: Numbers, width: float
    ) -> cython.Py_ssize_t:
        """Return what `farthest` does where all of the way from there keeps off some `places`.

        By `width` metres; x and y of each in turn, twice. -1 where it doesn't.
        """
        k: cython.Py_ssize_t
        i: cython.Py_ssize_t
        for k in range(min(len(route), _LOOKED_AT) - 1, -1, -1):
            bx, by = route[k]
            if self._keeps_off(x, y, bx, by, places, width):
                for i in range(k + 1, len(route)):
                    x, y = bx, by
                    bx, by = route[i]
                    if not self._keeps_off(x, y, bx, by, places, width):
                        return -1
                return k
        return -1

    def _keeps_off(
        self, ax: float, ay: float, bx: float, by: float, places: Numbers, width: float
    ) -> bool:
        return not touches(places, ax, ay, bx, by, width) and self.free(ax, ay, bx, by)


def come_into(bounds: Numbers, route: list[Place], radius: float) -> list[tuple[int, int]]:
    """Return which bounds a disc of `radius` metres comes into on which segments of a `route`.

    `bounds` are least x and y and greatest x and y of each; the result has the index of the
    segment and that of the bounds.
    """
    found: list[tuple[int, int]] = []
    count: cython.Py_ssize_t = box_count(bounds)
    box: Boxes = boxes_of(bounds)
    ax: float
    ay: float
    bx: float
    by: float
    k: cython.Py_ssize_t
    i: cython.Py_ssize_t
    for i in range(len(route) - 1 if count > 0 else 0):
        ax, ay = route[i]
        bx, by = route[i + 1]
        for k in range(count):
            if _comes_into(box[k], ax, ay, bx, by, radius):
                found.append((i, k))  # noqa: PERF401
    return found


def _comes_into(
    box: BoundingBox, ax: float, ay: float, bx: float, by: float, radius: float
) -> bool:
    """Return whether a disc comes into a box on the segment from a to b.

    A segment whose ends are both beyond one side of the box is beyond it as a whole.
    """
    low_x: float = box.low_x - radius
    low_y: float = box.low_y - radius
    high_x: float = box.high_x + radius
    high_y: float = box.high_y + radius
    return (
        (ax > low_x or bx > low_x)
        and (ay > low_y or by > low_y)
        and (ax < high_x or bx < high_x)
        and (ay < high_y or by < high_y)
    )


def back_through(line: Numbers, ax: float, ay: float, bx: float, by: float) -> bool:
    """Return whether the segment from a to b crosses a line from its far side back.

    `line` has x and y of both ends, and of the direction in which it may be crossed.
    """
    end: Doubles = at(line)
    nx: float = end[4]
    ny: float = end[5]
    here: float = (ax - end[0]) * nx + (ay - end[1]) * ny
    there: float = (bx - end[0]) * nx + (by - end[1]) * ny
    # The line itself is its far side, as `Gates` has it: to end on it is to have passed.
    if here < 0.0 or there >= 0.0:
        return False
    share: float = here / (here - there)
    x: float = ax + share * (bx - ax) - end[0]
    y: float = ay + share * (by - ay) - end[1]
    dx: float = end[2] - end[0]
    dy: float = end[3] - end[1]
    along: float = x * dx + y * dy
    return 0.0 <= along <= dx * dx + dy * dy


def legs_of(course: list[Place]) -> Numbers:
    """Return the legs of a `course` as edges."""
    found: Numbers = room(max(4 * len(course) - 4, 0))
    edge: Doubles = at(found)
    k: cython.Py_ssize_t
    for k in range(len(course) - 1):
        edge[4 * k], edge[4 * k + 1] = course[k]
        edge[4 * k + 2], edge[4 * k + 3] = course[k + 1]
    return found


def touches(edges: Numbers, ax: float, ay: float, bx: float, by: float, radius: float) -> bool:
    """Return whether one of `edges` is nearer than `radius` (metres) to a segment.

    It leads from `ax`, `ay` to `bx`, `by`.
    """
    dx: float = bx - ax
    dy: float = by - ay
    near: bool = _first_near(edges, ax, ay, dx, dy, sqrt(dx * dx + dy * dy), radius) >= 0
    return near


def _first_near(
    edges: Numbers, ax: float, ay: float, dx: float, dy: float, length: float, radius: float
) -> cython.Py_ssize_t:
    """Return where the first edge is that is nearer than `radius` to the segment from a along d.

    -1 if there is none.
    """
    c: float = 0.0
    s: float = 0.0
    if length > 0.0:
        c = dx / length
        s = dy / length
    least: float = radius * radius
    edge: Doubles = at(edges)
    k: cython.Py_ssize_t
    for k in range(0, len(edges), 4):
        # Along and across the segment, from a:
        px: float = edge[k] - ax
        py: float = edge[k + 1] - ay
        qx: float = edge[k + 2] - ax
        qy: float = edge[k + 3] - ay
        p: float = px * c + py * s
        q: float = qx * c + qy * s
        if (p <= -radius and q <= -radius) or (p >= length + radius and q >= length + radius):
            continue
        h: float = py * c - px * s
        i: float = qy * c - qx * s
        # Both ends are on the same side, and too far from the line: so is all that is between them.
        if length > 0.0 and ((h >= radius and i >= radius) or (h <= -radius and i <= -radius)):
            continue
        # The nearest two points are an end of one of them and a point of the other, but where the
        # two cross.
        if h * i < 0.0:
            # Where the edge crosses the line on which the segment lies, in metres along it.
            crossing: float = p + (q - p) * h / (h - i)
            if 0.0 <= crossing <= length:
                return k
        if (
            _square(px, py, dx, dy, length) < least
            or _square(qx, qy, dx, dy, length) < least
            or _square_to(px, py, qx, qy, 0.0, 0.0) < least
            or _square_to(px, py, qx, qy, dx, dy) < least
        ):
            return k
    return -1


def _square(px: float, py: float, dx: float, dy: float, length: float) -> float:
    """Return the square of the distance of p from the segment from 0 to d of this `length`."""
    u: float = 0.0
    if length > 0.0:
        u = min(max((px * dx + py * dy) / (length * length), 0.0), 1.0)
    x: float = px - u * dx
    y: float = py - u * dy
    return x * x + y * y


def _square_to(px: float, py: float, qx: float, qy: float, x: float, y: float) -> float:
    """Return the square of the distance of a point from the edge from p to q."""
    dx: float = qx - px
    dy: float = qy - py
    square: float = dx * dx + dy * dy
    u: float = 0.0
    if square > 0.0:
        u = min(max(((x - px) * dx + (y - py) * dy) / square, 0.0), 1.0)
    x -= px + u * dx
    y -= py + u * dy
    return x * x + y * y
