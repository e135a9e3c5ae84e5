"""Edges of a floor: whether a disc that is swept along a segment touches one.

Edges are found in a uniform grid (J. Amanatides and A. Woo, "A fast voxel traversal algorithm for
ray tracing", Eurographics 1987), and a place is inside by the parity of a ray's crossings.
Edges are rows of `Edge`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .numbers import Place, flat

if not cython.compiled:
    from .convex import meets_edge
    from .cubics import *

_WIDER: float = 1.001  # factor of a radius, so that rounding skips no cell beside a sweep
_LATELY: cython.Py_ssize_t = 4  # number of cached edges
_LOOKED_AT: cython.Py_ssize_t = 4  # number of corners of a route that are tested
_LEVEL: float = 1e-3  # of a cell's width; segments that rise less count as level


class Grid:
    """Edges by the square cells of `width` metres that they enter."""

    def __init__(self, edges: Numbers, width: float) -> None:
        box: BoundingBox = box_around(edges, position_count(edges))
        self.width = width
        self.low_x = box.low_x
        self.low_y = box.low_y
        self.columns = 1 + int((box.high_x - self.low_x) / width)
        self.rows = 1 + int((box.high_y - self.low_y) / width)
        self.cells: list[Numbers] = [room(0) for _ in range(self.columns * self.rows)]
        self.lately = room(0)
        margin: float = 1e-6 * width
        k: cython.Py_ssize_t
        row: cython.Py_ssize_t
        column: cython.Py_ssize_t
        for k in range(edge_count(edges)):
            e: Edge = edges_of(edges)[k]
            for row in range(self._low_row(e, margin), self._high_row(e, margin) + 1):
                span: CellWindow = self._span(row, e, margin)
                for column in range(span.column, span.column + span.columns):
                    self.cells[row * self.columns + column].extend((e.ax, e.ay, e.bx, e.by))

    def touched(self, ax: float, ay: float, bx: float, by: float, radius: float) -> bool:
        """Return whether an edge is nearer than `radius` (metres) to the segment from a to b."""
        edge: Edge = Edge(ax, ay, bx, by)
        sweep: SweptSegment = sweep_along(edge)
        # The edges in the way of the last segments are often in the way of the next one.
        if _first_near(self.lately, sweep, radius) >= 0:
            return True
        margin: float = radius * _WIDER
        row: cython.Py_ssize_t
        column: cython.Py_ssize_t
        k: cython.Py_ssize_t
        for row in range(self._low_row(edge, margin), self._high_row(edge, margin) + 1):
            span: CellWindow = self._span(row, edge, margin)
            for column in range(span.column, span.column + span.columns):
                # An edge is in all cells that it enters, so it may be tested twice.
                edges: Numbers = self.cells[row * self.columns + column]
                if len(edges) > 0:
                    k = _first_near(edges, sweep, radius)
                    if k >= 0:
                        self._remember(edges_of(edges)[k])
                        return True
        return False

    def _remember(self, edge: Edge) -> cython.int:
        """Insert an edge before the cached ones."""
        last: Numbers = self.lately
        count: cython.Py_ssize_t = min(edge_count(last) + 1, _LATELY)
        self.lately = edge_room(count)
        latest: Edges = edges_of(self.lately)
        latest[0] = edge
        k: cython.Py_ssize_t
        for k in range(1, count):
            latest[k] = edges_of(last)[k - 1]
        return 0

    def meets(self, polygon: Numbers) -> bool:
        """Return whether an edge meets a convex polygon."""
        box: BoundingBox = box_around(polygon, position_count(polygon))
        row: cython.Py_ssize_t
        column: cython.Py_ssize_t
        k: cython.Py_ssize_t
        for row in range(self._row(box.low_y), self._row(box.high_y) + 1):
            for column in range(self._column(box.low_x), self._column(box.high_x) + 1):
                edges: Numbers = self.cells[row * self.columns + column]
                for k in range(edge_count(edges)):
                    e: Edge = edges_of(edges)[k]
                    near: bool = min(e.ax, e.bx) <= box.high_x and max(e.ax, e.bx) >= box.low_x
                    if near and meets_edge(polygon, e):
                        return True
        return False

    def inside(self, x: float, y: float) -> bool:
        """Return whether a place is within the edges: a ray crosses an odd number of them."""
        odd: bool = False
        row: cython.Py_ssize_t = self._row(y)
        column: cython.Py_ssize_t
        k: cython.Py_ssize_t
        for column in range(self._column(x), self.columns):
            edges: Numbers = self.cells[row * self.columns + column]
            for k in range(edge_count(edges)):
                e: Edge = edges_of(edges)[k]
                if (e.ay > y) != (e.by > y):
                    crossing: float = e.ax + (y - e.ay) / (e.by - e.ay) * (e.bx - e.ax)
                    # An edge is in all cells that it enters, and counts in the crossing's cell.
                    if crossing > x and self._column(crossing) == column:
                        odd = not odd
        return odd

    def _column(self, x: float) -> int:
        """Return the column of cells nearest to `x`."""
        return int(min(max((x - self.low_x) / self.width, 0.0), self.columns - 1.0))

    def _row(self, y: float) -> int:
        """Return the row of cells nearest to `y`."""
        return int(min(max((y - self.low_y) / self.width, 0.0), self.rows - 1.0))

    def _low_row(self, e: Edge, margin: float) -> int:
        """Return the lowest row of cells that an edge with a margin enters."""
        return self._row(min(e.ay, e.by) - margin)

    def _high_row(self, e: Edge, margin: float) -> int:
        """Return the highest row of cells that an edge with a margin enters."""
        return self._row(max(e.ay, e.by) + margin)

    def _span(self, row: cython.Py_ssize_t, e: Edge, margin: float) -> CellWindow:
        """Return the cells of a row that a sweep may enter.

        An edge in the row that is near the segment is near a point of it whose y is at most
        `margin` from the row, and in the columns within `margin` of that point.
        """
        low: float = e.ax
        high: float = e.bx
        if abs(e.by - e.ay) > _LEVEL * self.width:
            bottom: float = self.low_y + row * self.width - margin
            slope: float = (e.bx - e.ax) / (e.by - e.ay)
            low = e.ax + slope * (min(max(bottom, min(e.ay, e.by)), max(e.ay, e.by)) - e.ay)
            top: float = bottom + self.width + 2.0 * margin
            high = e.ax + slope * (min(max(top, min(e.ay, e.by)), max(e.ay, e.by)) - e.ay)
        if low > high:
            low, high = high, low
        limit: float = self.columns - 1.0
        first: cython.Py_ssize_t = int(
            min(max((low - margin - self.low_x) / self.width, 0.0), limit)
        )
        last: cython.Py_ssize_t = int(
            min(max((high + margin - self.low_x) / self.width, 0.0), limit)
        )
        return CellWindow(first, row, last - first + 1, 1)


class Room:
    """Free room for a disc of `radius` metres on a floor among bodies.

    `bodies` are pairs of edges and rounding, the width (m) of a margin around the edges. `gates`
    are lines that a segment must not cross backwards: see `back_through`.
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
        self.bodies = [edges for edges, _ in bodies]
        self.gates = gates
        self.bounds: Numbers = room(0)
        self.radii: Numbers = room(0)
        for edges, rounding in bodies:
            self.bounds.extend(row_of_box(box_around(edges, position_count(edges))))
            self.radii.append(radius + rounding)

    def holds(self, x: float, y: float) -> bool:
        """Return whether the disc is free at a place."""
        return self.floor.inside(x, y) and self.clear(x, y, x, y, True)

    def clear(self, ax: float, ay: float, bx: float, by: float, floor: bool) -> bool:
        """Return whether the disc is free on the segment from a, where it is free, to b.

        The floor and its gates count if `floor` is true.
        """
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
    """Test of segments on a floor for a disc of `radius` metres.

    The edges of `walls` decide. If a segment enters one of the `bounds` of other bodies (minimum x
    and y, maximum x and y of each), `ask(a, b)` decides.
    """

    def __init__(self, walls: Grid, radius: float, ask: Callable[[Place, Place], bool]) -> None:
        self.walls = walls
        self.radius = radius
        self.ask = ask
        self.bounds = room(0)

    def meets_wall(self, ax: float, ay: float, bx: float, by: float) -> bool:
        """Return whether a wall is in the way on the segment from a to b."""
        return self.walls.touched(ax, ay, bx, by, self.radius)

    def free(self, ax: float, ay: float, bx: float, by: float) -> bool:
        """Return whether the disc is free on the segment from a, where it is free, to b."""
        if self.meets_wall(ax, ay, bx, by):
            return False
        box: Boxes = boxes_of(self.bounds)
        k: cython.Py_ssize_t
        for k in range(box_count(self.bounds)):
            if _comes_into(box[k], ax, ay, bx, by, self.radius):
                return bool(self.ask((ax, ay), (bx, by)))
        return True

    def farthest(self, x: float, y: float, route: list[Place]) -> cython.Py_ssize_t:
        """Return the index of the farthest corner of a route that is visible from (x, y), or -1.

        Only the first corners are tested. A straight line replaces the bends before the corner.
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
        """Return the result of `farthest` if the path from there avoids `places`, otherwise -1.

        The distance is `width` metres. `places` has x and y of each in turn, twice.
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
    """Return which segments of a `route` enter which bounds with a disc of `radius` metres.

    `bounds` are minimum x and y, maximum x and y of each. The result has pairs of the index of the
    segment and that of the bounds.
    """
    pairs: list[tuple[int, int]] = []
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
                pairs.append((i, k))  # noqa: PERF401
    return pairs


def _comes_into(
    box: BoundingBox, ax: float, ay: float, bx: float, by: float, radius: float
) -> bool:
    """Return whether a disc enters a box on the segment from a to b.

    If both ends of a segment are beyond the same side of the box, the whole segment is.
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
    """Return whether the segment from a to b crosses a line backwards.

    `line` has x and y of both ends, and of the direction in which crossing is allowed.
    """
    gate: GateLine = gates_of(line)[0]
    here: float = (ax - gate.ax) * gate.nx + (ay - gate.ay) * gate.ny
    there: float = (bx - gate.ax) * gate.nx + (by - gate.ay) * gate.ny
    # A position on the line is on the far side, as in `Gates`.
    if here < 0.0 or there >= 0.0:
        return False
    share: float = here / (here - there)
    x: float = ax + share * (bx - ax) - gate.ax
    y: float = ay + share * (by - ay) - gate.ay
    dx: float = gate.bx - gate.ax
    dy: float = gate.by - gate.ay
    along: float = x * dx + y * dy
    return 0.0 <= along <= dx * dx + dy * dy


def legs_of(course: list[Place]) -> Numbers:
    """Return the segments of a `course` as edges."""
    legs: Numbers = edge_room(max(len(course) - 1, 0))
    corners: Numbers = flat(course)
    corner: Positions = positions_of(corners)
    k: cython.Py_ssize_t
    for k in range(len(course) - 1):
        edges_of(legs)[k] = Edge(corner[k].x, corner[k].y, corner[k + 1].x, corner[k + 1].y)
    return legs


def touches(edges: Numbers, ax: float, ay: float, bx: float, by: float, radius: float) -> bool:
    """Return whether one of `edges` is nearer than `radius` (metres) to the segment from a to b."""
    near: bool = _first_near(edges, sweep_along(Edge(ax, ay, bx, by)), radius) >= 0
    return near


def _first_near(edges: Numbers, sweep: SweptSegment, radius: float) -> cython.Py_ssize_t:
    """Return the first edge that is nearer than `radius` to a segment, or -1."""
    length: float = sweep.length
    least: float = radius * radius
    edge: Edges = edges_of(edges)
    k: cython.Py_ssize_t
    for k in range(edge_count(edges)):
        # Coordinates along and across the segment, from a.
        px: float = edge[k].ax - sweep.x
        py: float = edge[k].ay - sweep.y
        qx: float = edge[k].bx - sweep.x
        qy: float = edge[k].by - sweep.y
        p: float = px * sweep.c + py * sweep.s
        q: float = qx * sweep.c + qy * sweep.s
        if (p <= -radius and q <= -radius) or (p >= length + radius and q >= length + radius):
            continue
        h: float = py * sweep.c - px * sweep.s
        i: float = qy * sweep.c - qx * sweep.s
        # If both ends are too far from the line on the same side, so is the whole edge.
        if length > 0.0 and ((h >= radius and i >= radius) or (h <= -radius and i <= -radius)):
            continue
        # The nearest points include an end of one of them, unless the two cross.
        if h * i < 0.0:
            # The position along the segment at which the edge crosses its line.
            crossing: float = p + (q - p) * h / (h - i)
            if 0.0 <= crossing <= length:
                return k
        if (
            _square(px, py, sweep) < least
            or _square(qx, qy, sweep) < least
            or _square_to(px, py, qx, qy, 0.0, 0.0) < least
            or _square_to(px, py, qx, qy, sweep.dx, sweep.dy) < least
        ):
            return k
    return -1


def _square(px: float, py: float, sweep: SweptSegment) -> float:
    """Return the squared distance of p, relative to a, from a segment."""
    u: float = 0.0
    if sweep.length > 0.0:
        u = (px * sweep.dx + py * sweep.dy) / (sweep.length * sweep.length)
        u = min(max(u, 0.0), 1.0)
    x: float = px - u * sweep.dx
    y: float = py - u * sweep.dy
    return x * x + y * y


def _square_to(px: float, py: float, qx: float, qy: float, x: float, y: float) -> float:
    """Return the squared distance of a point from the edge from p to q."""
    dx: float = qx - px
    dy: float = qy - py
    square: float = dx * dx + dy * dy
    u: float = 0.0
    if square > 0.0:
        u = min(max(((x - px) * dx + (y - py) * dy) / square, 0.0), 1.0)
    x -= px + u * dx
    y -= py + u * dy
    return x * x + y * y
