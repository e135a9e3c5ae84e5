"""Contacts of a person's disc with a field of a machine, and switches of its field sets.

A field is a polygon that moves and turns with the machine. In the frame of the machine, the
person's centre stays within a bound of second order of its tangent at the middle of an interval,
and the distances of a tangent from the edges of the polygon are exact. Undecided intervals are
halved, the earlier half first: see `encounter` for the method. Switches of sets are found in the
same way, with bounds of the velocity in the frame of the machine.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython

    from .encounter import Tabled
else:
    from . import uncompiled as cython

if not cython.compiled:
    from math import cos, sin

    from .cubics import *
    from .encounter import Encounter, Follower

_RESOLUTION: float = 1e-9  # seconds; a change within a shorter interval counts at its begin
_TOUCH: float = 1e-10  # metres; shallower contacts may be ignored
_POINT: float = 1e-9  # metres; minimum radius of a person
_ASIDE: float = 1e-3  # share of an interval on either side of a root when it is divided
_LEAST_SHARE: float = 0.02  # minimum share when an interval is divided
_NEVER: cython.int = 0
_PERHAPS: cython.int = 1
_ALWAYS: cython.int = 2


class FieldSwitches:
    """Choice of a field set by velocity: the first of `sets` (rows of `FieldSpeeds`) that fits."""

    def __init__(self, sets: Numbers) -> None:
        self.sets = sets

    def switches(self, machine: Tabled, begin: float, end: float) -> list[tuple[float, int]]:
        """Return the times (s) from `begin` to `end` at which a set begins to apply, and its index.

        The first time is `begin`. The index is -1 if no set applies.
        """
        changes: list[tuple[float, int]] = []
        bounds: Encounter = Encounter(machine, machine)
        bounds.come_to(begin)
        while bounds.next_interval(end):
            k: cython.Py_ssize_t = self.applying(bounds.machine, bounds.lower, bounds.upper)
            while k == -2:
                if bounds.upper - bounds.lower > _RESOLUTION and bounds.halve():
                    k = self.applying(bounds.machine, bounds.lower, bounds.upper)
                else:
                    middle: float = bounds.lower + (bounds.upper - bounds.lower) / 2
                    k = self.applying(bounds.machine, middle, middle)
            if not changes or changes[len(changes) - 1][1] != k:
                changes.append((bounds.lower, k))
        return changes

    def applying(self, machine: Follower, lower: float, upper: float) -> cython.Py_ssize_t:
        """Return the set that applies throughout an interval, -1 for none, -2 if undecided."""
        now: BodyVelocity = velocity_over(machine, lower, upper)
        k: cython.Py_ssize_t
        for k in range(field_count(self.sets)):
            fits: cython.int = fit(field_speeds(self.sets)[k], now)
            if fits != _NEVER:
                return k if fits == _ALWAYS else -2
        return -1


def within_reach(
    encounter: Encounter, reach: float, begin: float, end: float
) -> tuple[float, float]:
    """Return a time span outside of which two places are farther apart than `reach` (metres).

    It begins and ends with pieces of the motions. If it is empty, its end is before its begin.
    """
    since: float = end
    until: float = begin - 1.0
    encounter.come_to(begin)
    while encounter.next_interval(end):
        apart: Closest = encounter.closest(encounter.lower, encounter.upper, 0.0, 0.0)
        if apart.low <= reach:
            since = min(since, encounter.lower)
            until = encounter.upper
    return since, until


class FieldSearch:
    """Search for the contacts of discs with a polygon, by all its `edges` (metres)."""

    def __init__(self, edges: Numbers) -> None:
        self.edges = edges
        self.reach = 0.0
        k: cython.Py_ssize_t
        for k in range(edge_count(edges)):
            e: Edge = edges_of(edges)[k]
            self.reach = max(self.reach, norm(e.ax, e.ay))

    def spans(
        self, encounter: Encounter, radius: float, begin: float, end: float, first: bool
    ) -> list[tuple[float, float]]:
        """Return begin and end of each contact of a disc around the person (s).

        With `first`, the search ends at the first contact, whose end is then undefined.
        """
        spans: list[tuple[float, float]] = []
        inside: cython.bint = False
        since: float = begin
        # A point is treated as a disc of a radius above `_TOUCH`.
        radius = max(radius, _POINT)
        encounter.come_to(begin)
        while encounter.next_interval(end):
            touch: FieldTouch = self.touched(encounter, radius, inside)
            while touch.state == _PERHAPS:
                if encounter.upper - encounter.lower > _RESOLUTION and encounter.divide(touch.cut):
                    touch = self.touched(encounter, radius, inside)
                else:
                    middle: float = encounter.lower + (encounter.upper - encounter.lower) / 2
                    touch = self.nearby(path_over(encounter, middle, middle), radius, inside)
            if touch.state == _ALWAYS and not inside:
                since = encounter.lower
                inside = True
                if first:
                    break
            elif touch.state == _NEVER and inside:
                spans.append((since, encounter.lower))
                inside = False
        if inside:
            spans.append((since, end))
        return spans

    def touched(self, encounter: Encounter, radius: float, so_far: bool) -> FieldTouch:
        """Return whether the disc touches the polygon in the interval of an encounter."""
        apart: Closest = encounter.closest(encounter.lower, encounter.upper, 0.0, 0.0)
        if apart.low > self.reach + radius:
            return FieldTouch(_NEVER, 0.5)
        path: FramePath = path_over(encounter, encounter.lower, encounter.upper)
        return self.nearby(path, radius, so_far)

    def nearby(self, path: FramePath, radius: float, so_far: bool) -> FieldTouch:
        """Return whether a disc touches the polygon on a path. `so_far` decides a doubtful contact.

        The disc touches if its centre is within the polygon, or within its radius of an edge. The
        distance from an edge is convex along a line, so its maximum is at an end.
        """
        tangent: Edge = path.tangent
        bend: float = path.bend
        x: float = (tangent.ax + tangent.bx) / 2
        y: float = (tangent.ay + tangent.by) / 2
        half: float = norm(tangent.bx - tangent.ax, tangent.by - tangent.ay) / 2
        low: float = INFINITY
        high: float = INFINITY
        before: float = INFINITY
        after: float = INFINITY
        inside: cython.bint = False
        k: cython.Py_ssize_t
        for k in range(edge_count(self.edges)):
            e: Edge = edges_of(self.edges)[k]
            if edge_passes(x, y, e):
                inside = not inside
            about: float = distance_to_edge(x, y, e)
            if half == 0.0:
                low = min(low, about)
                high = low
            elif about - half > radius + bend:
                low = min(low, about - half)
            else:
                first: float = distance_to_edge(tangent.ax, tangent.ay, e)
                last: float = distance_to_edge(tangent.bx, tangent.by, e)
                high = min(high, max(first, last))
                low = min(low, 0.0 if cross(tangent, e) else min(first, last))
                low = min(low, distance_to_edge(e.ax, e.ay, tangent))
                low = min(low, distance_to_edge(e.bx, e.by, tangent))
                before = min(before, first)
                after = min(after, last)
        # The path stays within the bend. If no edge is nearer, the whole path is on one side.
        if (inside and low > bend) or high + bend <= radius + (_TOUCH if so_far else 0.0):
            return FieldTouch(_ALWAYS, 0.5)
        if half == 0.0 and bend == 0.0:
            return FieldTouch(_ALWAYS if inside else _NEVER, 0.5)
        if not inside and low - bend > radius - (0.0 if so_far else _TOUCH):
            return FieldTouch(_NEVER, 0.5)
        return FieldTouch(_PERHAPS, cut_beside(before - radius, after - radius, bend))


def velocity_over(body: Follower, begin: float, end: float) -> BodyVelocity:
    """Return the velocity in the frame of the body, with bounds, in an interval of its piece."""
    half: float = (end - begin) / 2
    u: float = begin - body.entered + half
    x: Cubic = shift(body.x, u)
    y: Cubic = shift(body.y, u)
    turn: Cubic = shift(body.rotation, u)
    c: float = cos(turn.p)
    s: float = sin(turn.p)
    ahead: float = c * x.v + s * y.v
    aside: float = c * y.v - s * x.v
    # The coefficients are half of the acceleration and a sixth of the jerk.
    jerk: float = 6 * norm(x.j, y.j)
    acceleration: float = 2 * norm(x.a, y.a) + half * jerk
    speed: float = norm(x.v, y.v) + half * acceleration
    spin_rate: float = 2 * abs(turn.a) + 6 * half * abs(turn.j)
    spin: float = abs(turn.v) + half * spin_rate
    # The second derivative of R(-θ) v, including the rotation of the frame.
    curve: float = jerk + 2 * spin * acceleration + (spin_rate + spin * spin) * speed
    return BodyVelocity(
        ahead,
        aside,
        2 * (c * x.a + s * y.a) + turn.v * aside,
        2 * (c * y.a - s * x.a) - turn.v * ahead,
        turn.v,
        half * (2 * abs(turn.a) + 3 * half * abs(turn.j)),
        half,
        half * half / 2 * curve,
    )


def within(value: float, slack: float, low: float, high: float) -> cython.int:
    """Return whether a number within `slack` of `value` is in a range, as a state."""
    if value + slack < low or value - slack > high:
        return _NEVER
    return _ALWAYS if value - slack >= low and value + slack <= high else _PERHAPS


def left_of_ray(now: BodyVelocity, x: float, y: float, tolerance: float) -> cython.int:
    """Return whether a velocity points to the left of the direction x, y (m/s)."""
    rate: float = x * now.aside_rate - y * now.ahead_rate
    slack: float = abs(rate) * now.half + now.bend
    return within(x * now.aside - y * now.ahead, slack, -tolerance, INFINITY)


def fit(speeds: FieldSpeeds, now: BodyVelocity) -> cython.int:
    """Return whether a set applies at a velocity."""
    moves: cython.int = _ALWAYS
    slack: float
    if speeds.directed == 0.0:
        slack = abs(now.ahead_rate) * now.half + now.bend
        moves = within(now.ahead, slack, speeds.low, speeds.high)
    else:
        slack = norm(now.ahead_rate, now.aside_rate) * now.half + now.bend
        moves = min(
            within(norm(now.ahead, now.aside), slack, speeds.low, speeds.high),
            fit_direction(speeds, now),
        )
    return min(moves, within(now.turn, now.turn_slack, speeds.turn_low, speeds.turn_high))


def fit_direction(speeds: FieldSpeeds, now: BodyVelocity) -> cython.int:
    """Return whether a velocity is in the directions of a set: between two rays."""
    after: cython.int = left_of_ray(now, speeds.ax, speeds.ay, speeds.tolerance)
    before: cython.int = left_of_ray(now, -speeds.bx, -speeds.by, speeds.tolerance)
    # Directions of more than half a turn are the complement of those between the opposite rays.
    return max(after, before) if speeds.directed == 2.0 else min(after, before)


def path_over(encounter: Encounter, begin: float, end: float) -> FramePath:
    """Return the path of the person in the frame of the machine, in an interval of the stretch."""
    half: float = (end - begin) / 2
    u: float = begin - encounter.begin + half
    x: Cubic = shift(encounter.x, u)
    y: Cubic = shift(encounter.y, u)
    turn: Cubic = shift(encounter.machine.rotation, u)
    c: float = cos(turn.p)
    s: float = sin(turn.p)
    # The encounter has the place of the machine relative to the person, so signs are reversed.
    px: float = -(c * x.p + s * y.p)
    py: float = s * x.p - c * y.p
    vx: float = -(c * x.v + s * y.v) + turn.v * py
    vy: float = s * x.v - c * y.v - turn.v * px
    jerk: float = 6 * norm(x.j, y.j)
    acceleration: float = 2 * norm(x.a, y.a) + half * jerk
    speed: float = norm(x.v, y.v) + half * acceleration
    away: float = norm(x.p, y.p) + half * speed
    spin_rate: float = 2 * abs(turn.a) + 6 * half * abs(turn.j)
    spin: float = abs(turn.v) + half * spin_rate
    curve: float = acceleration + 2 * spin * speed + (spin_rate + spin * spin) * away
    dx: float = vx * half
    dy: float = vy * half
    return FramePath(Edge(px - dx, py - dy, px + dx, py + dy), half * half / 2 * curve)


def distance_to_edge(x: float, y: float, e: Edge) -> float:
    """Return the distance of a place from a segment (metres)."""
    dx: float = e.bx - e.ax
    dy: float = e.by - e.ay
    along: float = (x - e.ax) * dx + (y - e.ay) * dy
    square: float = dx * dx + dy * dy
    if along <= 0.0:
        return norm(x - e.ax, y - e.ay)
    if along >= square:
        return norm(x - e.bx, y - e.by)
    return norm(x - (e.ax + dx * (along / square)), y - (e.ay + dy * (along / square)))


def side_of(x: float, y: float, e: Edge) -> float:
    """Return twice the signed area of the triangle of an edge and a place, positive on its left."""
    return (e.bx - e.ax) * (y - e.ay) - (e.by - e.ay) * (x - e.ax)


def cross(e: Edge, f: Edge) -> cython.bint:
    """Return whether two segments cross or touch. The result is undefined for collinear ones."""
    return (
        side_of(e.ax, e.ay, f) * side_of(e.bx, e.by, f) <= 0.0
        and side_of(f.ax, f.ay, e) * side_of(f.bx, f.by, e) <= 0.0
    )


def edge_passes(x: float, y: float, e: Edge) -> cython.bint:
    """Return whether the ray from a place along x crosses an edge (even-odd rule)."""
    return (e.ay > y) != (e.by > y) and (side_of(x, y, e) > 0.0) == (e.by > e.ay)


def cut_beside(before: float, after: float, bend: float) -> float:
    """Return the share at which to divide an interval: just before or after a root.

    The root is less than `bend` from that of the line through both values.
    """
    if (before > 0.0) == (after > 0.0) or before == INFINITY or after == INFINITY:
        return 0.5
    root: float = before / (before - after)
    aside: float = max(2 * bend / abs(before - after), _ASIDE)
    if root - aside > _LEAST_SHARE:
        return root - aside
    if root + aside < 1.0 - _LEAST_SHARE:
        return root + aside
    return 0.5
