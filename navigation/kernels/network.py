"""Links between the bends of a floor, found by triangular expansion.

A straight line leaves a triangle through one of its sides. The region that is visible from a place
within a wedge of directions is thus found triangle by triangle. Each side that the wedge meets
narrows it, and leads to the next triangle. See F. Bungiu, M. Hemmer, J. Hershberger, K. Huang and
A. Kröller, "Efficient computation of visibility polygons", EuroCG 2014.
"""

from __future__ import annotations

from math import dist
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .numbers import numbers_of

if not cython.compiled:
    from .cubics import *
    from .edges import Grid, back_through

_SLACK: float = 1e-9  # of a metre and of a line's length; depth to which a line may enter a corner
_WIDER: float = 1e-7  # radians; margin of wedges, so that no link is missed
_ROUNDING: float = 1e-8  # metres; additional margin for near places


class Network:
    """Links between the `bends` of a floor (rows of `Bend`) for discs of `radius` metres.

    `portals` are rows of `Portal`, sorted by the triangles that they leave. Rows of triangle t
    begin at `first_portal[t]`. Bend k is in `triangle[k]`. A link is at least `radius` metres from
    the `walls`, and does not cross `gates` backwards (see `back_through`). Links are found on
    demand, and need 16 bytes each and 64 per bend.
    """

    def __init__(
        self,
        bends: NDArray[np.float64],
        portals: NDArray[np.float64],
        first_portal: NDArray[np.intp],
        triangle: NDArray[np.intp],
        walls: Grid,
        radius: float,
        gates: list[Numbers],
    ) -> None:
        self.count = len(bends)
        self.links: list[Numbers | None] = [None] * self.count
        order = np.argsort(triangle, kind="stable")
        first_bend = np.searchsorted(triangle[order], np.arange(len(first_portal)))
        self.bends = numbers_of(bends)
        self.within = numbers_of(bends[order])
        self.portals = numbers_of(portals)
        self.first_portal = first_portal.tolist()
        self.triangle = triangle.tolist()
        self.first_bend = first_bend.tolist()
        self.order = order.tolist()
        self.walls = walls
        self.radius = radius
        self.gates = gates
        self.waiting = room(0)
        self.depth = 0

    def links_of(self, bend: cython.Py_ssize_t) -> Numbers:
        """Return the bends to which a bend has links, and the lengths of these (m), in turn."""
        links: Numbers | None = self.links[bend]
        if links is None:
            links = self.links[bend] = self._linked(bend)
        return links

    def _linked(self, here: cython.Py_ssize_t) -> Numbers:
        """Find the links of a bend, sorted by the bends to which they lead."""
        visible: list[cython.Py_ssize_t] = self._seen(here)
        links: Numbers = link_room(len(visible))
        bend: Bends = bends_of(self.bends)
        a: Bend = bend[here]
        count: cython.Py_ssize_t = 0
        to: cython.Py_ssize_t
        for to in sorted(set(visible)):
            b: Bend = bend[to]
            if self._clear(here, to) and self._allowed(a, b):
                link_rows(links)[count] = Link(to, dist((a.x, a.y), (b.x, b.y)))
                count += 1
        link_cut(links, count)
        return links

    def _clear(self, here: cython.Py_ssize_t, to: cython.Py_ssize_t) -> bool:
        """Return whether the line between two bends is free of walls."""
        back: Numbers | None = self.links[to]
        if back is not None and len(self.gates) == 0:
            return _leads(back, here)
        # Links go both ways, so test the line in the same direction from either end.
        bend: Bends = bends_of(self.bends)
        a: Bend = bend[min(here, to)]
        b: Bend = bend[max(here, to)]
        return not self.walls.touched(a.x, a.y, b.x, b.y, self.radius)

    def _allowed(self, a: Bend, b: Bend) -> bool:
        """Return whether no gate blocks a path from a to b."""
        k: cython.Py_ssize_t
        for k in range(len(self.gates)):
            if back_through(self.gates[k], a.x, a.y, b.x, b.y):
                return False
        return True

    def _seen(self, here: cython.Py_ssize_t) -> list[cython.Py_ssize_t]:
        """Return the bends to which a taut path through a bend may continue, and some others.

        Some occur twice.
        """
        visible: list[cython.Py_ssize_t] = []
        bend: Bend = bends_of(self.bends)[here]
        # A taut path continues between the directions before and after the bend, or opposite ones.
        clockwise: Wedge = Wedge(bend.after_x, bend.after_y, bend.before_x, bend.before_y)
        self._expand(here, clockwise, visible)
        other: Wedge = Wedge(-bend.after_x, -bend.after_y, -bend.before_x, -bend.before_y)
        self._expand(here, other, visible)
        return visible

    def _expand(
        self, here: cython.Py_ssize_t, wedge: Wedge, visible: list[cython.Py_ssize_t]
    ) -> cython.int:
        """Add the bends that are visible from a bend within a wedge."""
        bend: Bend = bends_of(self.bends)[here]
        triangle: cython.Py_ssize_t = self.triangle[here]
        came: cython.Py_ssize_t = -1
        self.depth = 0
        while True:
            self._take(triangle, wedge, bend, visible)
            self._leave(triangle, came, wedge, bend)
            if self.depth == 0:
                return 0
            self.depth -= 1
            waiting: WaitingPortal = waiting_of(self.waiting)[self.depth]
            wedge = waiting.wedge
            portal: Portal = portals_of(self.portals)[int(waiting.portal)]
            came = int(portal.off)
            triangle = int(portal.onto)

    def _take(
        self,
        triangle: cython.Py_ssize_t,
        wedge: Wedge,
        here: Bend,
        visible: list[cython.Py_ssize_t],
    ) -> cython.int:
        """Add the bends in a triangle for which a line from a bend grazes both corners."""
        bend: Bends = bends_of(self.within)
        k: cython.Py_ssize_t
        for k in range(self.first_bend[triangle], self.first_bend[triangle + 1]):
            to: Bend = bend[k]
            dx: float = to.x - here.x
            dy: float = to.y - here.y
            if (
                fits(to, dx, dy)
                and fits(here, dx, dy)
                and _has(wedge, dx, dy)
                and (dx != 0.0 or dy != 0.0)
            ):
                visible.append(self.order[k])
        return 0

    def _leave(
        self, triangle: cython.Py_ssize_t, came: cython.Py_ssize_t, wedge: Wedge, here: Bend
    ) -> cython.int:
        """Queue the portals of a triangle that a wedge meets, except that of the arrival."""
        portal: Portals = portals_of(self.portals)
        k: cython.Py_ssize_t
        for k in range(self.first_portal[triangle], self.first_portal[triangle + 1]):
            if portal[k].onto != came:
                seen: Wedge = _from(here, portal[k])
                # Portals that are visible from behind would lead around a corner, and never end.
                ahead: cython.bint = came < 0 or _faces(seen)
                if ahead and _meet(wedge, seen):
                    self._push(k, _both(wedge, seen))
        return 0

    def _push(self, portal: cython.Py_ssize_t, wedge: Wedge) -> cython.int:
        """Queue a portal with the wedge that leads through it."""
        waiting_grow(self.waiting, self.depth + 1)
        waiting_of(self.waiting)[self.depth] = WaitingPortal(portal, wedge)
        self.depth += 1
        return 0


def _leads(links: Numbers, to: cython.Py_ssize_t) -> bool:
    """Return whether one of the links leads to a bend."""
    k: cython.Py_ssize_t = 0
    while k < link_count(links) and link_rows(links)[k].to != to:
        k += 1
    leads: bool = k < link_count(links)
    return leads


def _from(place: Bend, portal: Portal) -> Wedge:
    """Return the wedge in which a portal is visible from a place."""
    return Wedge(
        portal.right_x - place.x,
        portal.right_y - place.y,
        portal.left_x - place.x,
        portal.left_y - place.y,
    )


def _faces(seen: Wedge) -> bool:
    """Return whether a portal is visible from its front, and not edge-on."""
    return seen.right_x * seen.left_y - seen.right_y * seen.left_x > 0.0


def _meet(wedge: Wedge, other: Wedge) -> bool:
    """Return whether two wedges, each narrower than half a turn, share a direction."""
    # If they do, one contains the right side of the other.
    return _has(wedge, other.right_x, other.right_y) or _has(other, wedge.right_x, wedge.right_y)


def _has(wedge: Wedge, dx: float, dy: float) -> bool:
    """Return whether a wedge contains a direction, with a margin."""
    return (
        # Both sides have the opposite directions of a narrow wedge between them, too.
        (
            wedge.right_x * dx + wedge.right_y * dy >= 0.0
            or wedge.left_x * dx + wedge.left_y * dy >= 0.0
        )
        and wedge.right_x * dy - wedge.right_y * dx >= -_slack(wedge.right_x, wedge.right_y, dx, dy)
        and wedge.left_x * dy - wedge.left_y * dx <= _slack(wedge.left_x, wedge.left_y, dx, dy)
    )


def _slack(dx: float, dy: float, px: float, py: float) -> float:
    """Return the maximum cross product of d and p for directions that agree."""
    d: float = abs(dx) + abs(dy)
    p: float = abs(px) + abs(py)
    return _WIDER * d * p + _ROUNDING * (d + p)


def _both(wedge: Wedge, other: Wedge) -> Wedge:
    """Return the directions that two wedges share."""
    right_x: float = wedge.right_x
    right_y: float = wedge.right_y
    left_x: float = wedge.left_x
    left_y: float = wedge.left_y
    if right_x * other.right_y - right_y * other.right_x > 0.0:
        right_x = other.right_x
        right_y = other.right_y
    if left_x * other.left_y - left_y * other.left_x < 0.0:
        left_x = other.left_x
        left_y = other.left_y
    return Wedge(right_x, right_y, left_x, left_y)


def fits(bend: Bend, dx: float, dy: float) -> bool:
    """Return whether a line along d only grazes the corner at a bend.

    Shortest paths bend only where they graze. All other lines would enter the grown corner.
    """
    slack: float = _SLACK * (1.0 + abs(dx) + abs(dy))
    entering: float = bend.before_x * dy - bend.before_y * dx
    leaving: float = bend.after_x * dy - bend.after_y * dx
    return (entering <= slack and leaving >= -slack) or (entering >= -slack and leaving <= slack)
