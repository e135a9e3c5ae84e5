"""First contact and parting of two outlines that move and turn with their bodies.

An outline is a row of edges. In the frame of the other body, an edge stays during an interval
within the hull of its ends at both times, apart from a drift of second order. Convex sets are apart
if the normal of one of their sides separates them. Undecided intervals are halved, the earlier half
first: see `encounter` for the method.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

if not cython.compiled:
    from math import cos, sin

    from .cubics import *
    from .encounter import Encounter
    from .fields import distance_to_edge, edge_passes, side_of

_RESOLUTION: float = 1e-9  # seconds; shorter undecided intervals count as a contact
_STEP: float = 1e-5  # seconds; minimum time between two evaluations of a distance
_NEARLY: float = 0.999  # share of the distance at which two bodies have parted


def extent_from(table: Numbers, begin: float) -> BoundingBox:
    """Return the bounds of the places on a motion from `begin` (seconds) on."""
    rows: cython.Py_ssize_t = pose_count(table)
    k: cython.Py_ssize_t = min(pose_at(table, begin), rows - 1)
    extent: BoundingBox = BoundingBox(INFINITY, INFINITY, -INFINITY, -INFINITY)
    while k < rows:
        piece: PosePiece = poses(table)[k]
        u: float = min(max(begin - piece.begin, 0.0), piece.end - piece.begin)
        left: float = piece.end - piece.begin - u
        x: Range = range_of(shift(piece.x, u), left)
        y: Range = range_of(shift(piece.y, u), left)
        extent = united(extent, BoundingBox(x.low, y.low, x.high, y.high))
        k += 1
    return extent


def places(table: Numbers, begin: float) -> tuple[float, float, float, float]:
    """Return the bounds of the places on a motion: minimum x and y, maximum x and y (metres)."""
    extent: BoundingBox = extent_from(table, begin)
    return extent.low_x, extent.low_y, extent.high_x, extent.high_y


class OutlineSearch:
    """Search for contacts of the outline of a machine with that of another body.

    Both are rows of edges (metres). With `outside`, the other body covers everything outside of its
    outline. The other body is the person of the encounters.
    """

    def __init__(self, edges: Numbers, others: Numbers, outside: bool) -> None:
        self.edges = edges
        self.others = others
        self.outside = outside
        self.chords = edge_room(2 * edge_count(edges))
        self.reach = 0.0
        k: cython.Py_ssize_t
        for k in range(edge_count(edges)):
            e: Edge = edges_of(edges)[k]
            self.reach = max(self.reach, norm(e.ax, e.ay), norm(e.bx, e.by))

    def first(self, encounter: Encounter, begin: float, end: float) -> float:
        """Return the time of the first contact of the outlines (s), or infinity."""
        encounter.come_to(begin)
        while encounter.next_interval(end):
            while self.may_touch(encounter, encounter.lower, encounter.upper):
                if encounter.upper - encounter.lower <= _RESOLUTION or not encounter.halve():
                    return encounter.lower
        return INFINITY

    def parting(self, encounter: Encounter, begin: float, end: float, gap: float) -> float:
        """Return the first time at which the bodies are `gap` metres apart (s), or infinity."""
        encounter.come_to(begin)
        while encounter.next_stretch(end):
            t: float = encounter.begin
            rate: float = self.rate(encounter)
            while True:
                apart: float = self.apart(encounter, t)
                if apart >= gap * _NEARLY:
                    return t
                if rate == 0.0 or t >= encounter.end:
                    break
                # A distance grows no faster than the bodies move.
                t = min(t + max((gap - apart) / rate, _STEP), encounter.end)
        return INFINITY

    def overlap(self, encounter: Encounter, t: float) -> bool:
        """Return whether the bodies touch or overlap at `t` (seconds)."""
        encounter.come_to(t)
        encounter.next_stretch(t)
        return self.apart(encounter, t) == 0.0

    def rate(self, encounter: Encounter) -> float:
        """Bound the speed of two points of the bodies (m/s) in the stretch of an encounter."""
        half: float = (encounter.end - encounter.begin) / 2
        x: Cubic = shift(encounter.x, half)
        y: Cubic = shift(encounter.y, half)
        pull: float = 2 * norm(x.a, y.a) + half * 6 * norm(x.j, y.j)
        speed: float = norm(x.v, y.v) + half * pull
        away: float = norm(x.p, y.p) + half * speed
        turning: float = encounter.machine.turning(encounter.begin, encounter.end).high
        around: float = encounter.person.turning(encounter.begin, encounter.end).high
        return speed + self.reach * turning + (self.reach + away) * around

    def apart(self, encounter: Encounter, t: float) -> float:
        """Return the distance of the bodies at `t` (seconds), 0 if they overlap."""
        self.sweep(encounter, t, t)
        chord: Edges = edges_of(self.chords)
        least: float = INFINITY
        inside: cython.bint
        i: cython.Py_ssize_t
        k: cython.Py_ssize_t
        for k in range(edge_count(self.edges)):
            own: Edge = Edge(
                chord[2 * k].ax, chord[2 * k].ay, chord[2 * k + 1].ax, chord[2 * k + 1].ay
            )
            inside = self.outside
            for i in range(edge_count(self.others)):
                e: Edge = edges_of(self.others)[i]
                if edge_passes(own.ax, own.ay, e):
                    inside = not inside
                least = min(
                    least,
                    0.0 if crosses(own, e) else INFINITY,
                    distance_to_edge(own.ax, own.ay, e),
                    distance_to_edge(e.ax, e.ay, own),
                )
            if inside:
                return 0.0
        for i in range(edge_count(self.others)):
            other: Edge = edges_of(self.others)[i]
            inside = False
            for k in range(edge_count(self.edges)):
                side: Edge = Edge(
                    chord[2 * k].ax, chord[2 * k].ay, chord[2 * k + 1].ax, chord[2 * k + 1].ay
                )
                if edge_passes(other.ax, other.ay, side):
                    inside = not inside
            if inside:
                return 0.0
        return least

    def may_touch(self, encounter: Encounter, begin: float, end: float) -> bool:
        """Return whether the outlines may touch in an interval of the stretch."""
        drift: SweepDrift = self.sweep(encounter, begin, end)
        chord: Edges = edges_of(self.chords)
        around: BoundingBox = box_around(self.chords, position_count(self.chords))
        margin: float = drift.bend + max(norm(drift.ax, drift.ay), norm(drift.bx, drift.by))
        i: cython.Py_ssize_t
        k: cython.Py_ssize_t
        for i in range(edge_count(self.others)):
            e: Edge = edges_of(self.others)[i]
            if (
                min(e.ax, e.bx) - around.high_x > margin
                or around.low_x - max(e.ax, e.bx) > margin
                or min(e.ay, e.by) - around.high_y > margin
                or around.low_y - max(e.ay, e.by) > margin
            ):
                continue
            for k in range(edge_count(self.edges)):
                if not is_apart(chord[2 * k], chord[2 * k + 1], e, drift):
                    return True
        return False

    def sweep(self, encounter: Encounter, begin: float, end: float) -> SweepDrift:
        """Set `chords` to those of the ends of all edges, and return the drift from them.

        Both are in the frame of the other body, for an interval of the stretch.
        """
        h: float = end - begin
        u: float = begin - encounter.begin
        x: Cubic = shift(encounter.x, u)
        y: Cubic = shift(encounter.y, u)
        turn: Cubic = shift(encounter.machine.rotation, u)
        frame: Cubic = shift(encounter.person.rotation, u)
        c: float = cos(frame.p)
        s: float = sin(frame.p)
        cw: float = cos(value(frame, h))
        sw: float = sin(value(frame, h))
        px: float = c * x.p + s * y.p
        py: float = c * y.p - s * x.p
        wx: float = value(x, h)
        wy: float = value(y, h)
        qx: float = cw * wx + sw * wy
        qy: float = cw * wy - sw * wx
        before: Position = Position(cos(turn.p - frame.p), sin(turn.p - frame.p))
        heading: float = value(turn, h) - value(frame, h)
        after: Position = Position(cos(heading), sin(heading))
        chord: Edges = edges_of(self.chords)
        corner: Positions = positions_of(self.edges)
        k: cython.Py_ssize_t
        for k in range(position_count(self.edges)):
            ahead: float = corner[k].x
            aside: float = corner[k].y
            chord[k] = Edge(
                px + before.x * ahead - before.y * aside,
                py + before.y * ahead + before.x * aside,
                qx + after.x * ahead - after.y * aside,
                qy + after.y * ahead + after.x * aside,
            )
        # The deviation of a path from its chord is h² / 8 times its second derivative.
        spin_rate: float = abs(2 * turn.a) + 6 * h * abs(turn.j)
        spin: float = abs(turn.v) + h * spin_rate
        bend: float = self.reach * (spin_rate + spin * spin)
        if frame.v == 0.0 and frame.a == 0.0 and frame.j == 0.0:
            # The deviation of a cubic is 3/4 of that of its control points, so a straight path has
            # none to the side.
            first: Position = Position(-(x.a + x.j * h) * h * h / 4, -(y.a + y.j * h) * h * h / 4)
            last: Position = Position(first.x - x.j * h * h * h / 4, first.y - y.j * h * h * h / 4)
            return SweepDrift(
                c * first.x + s * first.y,
                c * first.y - s * first.x,
                c * last.x + s * last.y,
                c * last.y - s * last.x,
                bend * h * h / 8,
            )
        pull: float = 2 * norm(x.a, y.a) + 6 * h * norm(x.j, y.j)
        speed: float = norm(x.v, y.v) + h * pull
        away: float = norm(x.p, y.p) + h * speed + self.reach
        frame_rate: float = abs(2 * frame.a) + 6 * h * abs(frame.j)
        around: float = abs(frame.v) + h * frame_rate
        bend += pull + 2 * around * (speed + self.reach * spin)
        bend += (frame_rate + around * around) * away
        return SweepDrift(0.0, 0.0, 0.0, 0.0, bend * h * h / 8)


def crosses(e: Edge, f: Edge) -> bool:
    """Return whether two edges cross. Edges that only touch do not."""
    return (
        side_of(e.ax, e.ay, f) * side_of(e.bx, e.by, f) < 0.0
        and side_of(f.ax, f.ay, e) * side_of(f.bx, f.by, e) < 0.0
    )


def is_apart(one: Edge, other: Edge, e: Edge, drift: SweepDrift) -> bool:
    """Return whether an edge is apart from the hull of two chords with their drift."""
    return (
        separates(1.0, 0.0, one, other, e, drift)
        or separates(0.0, 1.0, one, other, e, drift)
        or separates(e.by - e.ay, e.ax - e.bx, one, other, e, drift)
        or separates(one.by - one.ay, one.ax - one.bx, one, other, e, drift)
        or separates(other.by - other.ay, other.ax - other.bx, one, other, e, drift)
        or separates(other.ay - one.ay, one.ax - other.ax, one, other, e, drift)
        or separates(other.by - one.by, one.bx - other.bx, one, other, e, drift)
        or separates(other.by - one.ay, one.ax - other.bx, one, other, e, drift)
        or separates(other.ay - one.by, one.bx - other.ax, one, other, e, drift)
    )


def separates(x: float, y: float, one: Edge, other: Edge, e: Edge, drift: SweepDrift) -> bool:
    """Return whether an edge is apart from a hull along an axis."""
    first: float = x * one.ax + y * one.ay
    second: float = x * one.bx + y * one.by
    third: float = x * other.ax + y * other.ay
    fourth: float = x * other.bx + y * other.by
    begin: float = x * drift.ax + y * drift.ay
    end: float = x * drift.bx + y * drift.by
    low: float = min(first, second, third, fourth) + min(0.0, begin, end)
    high: float = max(first, second, third, fourth) + max(0.0, begin, end)
    a: float = x * e.ax + y * e.ay
    b: float = x * e.bx + y * e.by
    return max(min(a, b) - high, low - max(a, b)) > drift.bend * norm(x, y)
