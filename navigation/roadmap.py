"""Visibility graph for a disc: straight links between the bends around grown corners.

A shortest path among obstacles is taut: straight from corner to corner, and it only grazes those it
turns at. Grown by the disc's radius, corners are arcs, drawn here as short bends, so the network
of all free links that graze at both ends holds a shortest path between any two places, but for what
the bends are longer than the arcs (0.6 % of the arcs at steps of 15°).

See T. Lozano-Pérez and M. A. Wesley, "An algorithm for planning collision-free paths among
polyhedral obstacles", Communications of the ACM 22 (1979).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from weakref import WeakKeyDictionary

import numpy as np
import shapely
from numpy.typing import NDArray

from floorplan import Point

from .bodies import Body
from .corners import Bends, Corners, Floats, bends, corners, edges_of_room
from .freespace import STEP
from .gates import Gates
from .kernels.edges import Room
from .kernels.heap import Heap
from .kernels.search import Link, Search
from .sight import Ints, Sight

HAIR = 1e-4
"""Metres. Clearance beyond its radius that a disc keeps where a path bends."""

SMALL = 800
"""All links of a network of up to this many bends are made with it.

In a larger one, bends are linked when a search comes to them.
"""

_AT_ONCE = 256
"""Number of bends that are linked at once."""

_SOON = 32
"""Number of places at the top of a search's queue that are linked at once with the first."""

_ROWS = 32
"""Number of bends that are looked at from at once, so that tables about them stay in the cache."""


class Roadmap:
    """The network of a floor for discs of one radius (metres), bends at most `step` radians.

    The floor alone makes the network. Bodies are given with each question, and cost only where
    a path meets them. Where there are one-way `gates`, a link against the direction of one is not
    there: links then depend on the direction. No other places to bend
    at are needed: gates go from wall to wall, so that a taut path never goes round their ends.
    """

    def __init__(
        self, floor: shapely.Geometry, radius: float, step: float, gates: Gates | None = None
    ) -> None:
        self._gates = Gates() if gates is None else gates
        self.radius = radius
        self.step = step
        self._floor = floor
        self._edges = floor.boundary
        shapely.prepare(self._floor)
        shapely.prepare(self._edges)
        edges = edges_of_room(floor)
        self.bends = self._standing_bends(corners(edges))
        self._columns = self.bends.columns()
        self._points: list[Point] = [(x, y) for x, y in self.bends.point.tolist()]
        self.places = frozenset(self._points)
        self.asked: dict[tuple[Point, Point], bool] = {}
        """FCL's answers about links between the floor's bends, by their places."""
        self.links: list[list[Link] | None] = [None] * len(self.bends)
        """The links of each bend that are known."""
        self._sight: Sight | None = None
        if len(self.bends) <= SMALL:
            self.links = [*self._network()]
        else:
            self._sight = Sight(edges, self.bends, radius)
        self._bodies: WeakKeyDictionary[Body, Floats] = WeakKeyDictionary()
        self._searches: list[Search] = []

    def __repr__(self) -> str:
        return f"<Roadmap for a radius of {self.radius:g} m: {len(self.bends)} bends>"

    @property
    def large(self) -> bool:
        """True if bends are linked only when a search comes to them."""
        return self._sight is not None

    def path(
        self,
        start: Point,
        goal: Point,
        straight: bool,
        bodies: Sequence[Body],
        room: Room,
        refused: set[tuple[Point, Point]],
        hopeless: Callable[[], bool],
    ) -> list[Point] | None:
        """Return the shortest path round `bodies`, or None where there is none.

        `straight` is false where something fixed is in the way between start and goal, `room` what
        the floor and the bodies leave; `refused` links count for none. `hopeless()` is asked once
        if the search takes long, and ends it if it is true.
        """
        around = [self.around(body) for body in bodies]
        try:
            search = self._searches.pop()  # one that nobody needs now
        except IndexError:
            search = Search(self._columns, self.links)  # takes longer than to use it
        points = search.path(
            start, goal, straight, around, room, refused, self._link_soon, hopeless
        )
        self._searches.append(search)
        return points

    def visible(self, a: Floats, b: Floats) -> NDArray[np.bool_]:
        """Return whether the disc can go straight from a to b (N, 2), without regard to bodies."""
        # Bends are `HAIR` farther out than the radius and links half of that: rounding blocks no
        # link along the side that both its bends belong to.
        lines = shapely.linestrings(np.stack([a, b], axis=1))
        near: NDArray[np.bool_] = shapely.dwithin(self._edges, lines, self.radius + HAIR / 2)
        return ~near

    def link_all(self, most: int) -> None:
        """Link all bends now, if they are no more than `most`."""
        if len(self.bends) <= most:
            left = [bend for bend in range(len(self.bends)) if self.links[bend] is None]
            for k in range(0, len(left), _AT_ONCE):
                self.links_of(left[k], left[k : k + _AT_ONCE])

    def point(self, bend: int) -> Point:
        """Return the place of bend number `bend`."""
        return self._points[bend]

    def links_of(self, bend: int, soon: Iterable[int] = ()) -> list[Link]:
        """Return the links of bend number `bend`.

        Bends that will `soon` be asked for, too, are linked in one go with it.
        """
        known = self.links[bend]
        if known is None:
            fresh = [bend, *{k for k in soon if self.links[k] is None and k != bend}]
            found = self._links_of_some(np.array(fresh))
            for k, links in zip(fresh, found, strict=True):
                self.links[k] = links
            known = found[0]
        return known

    def _link_soon(self, bend: int, queue: Heap) -> None:
        """Link a bend that a search has come to, and those that it will soon come to."""
        # A heap has the bends that will be taken soon not far from its top.
        count = len(self.links)
        self.links_of(bend, (to for to in queue.first(_SOON) if to < count))

    def _standing_bends(self, around: Corners) -> Bends:
        """Return the bends around corners that are clear of the floor's edges.

        Where some are not, a corner is close to another thing, and is drawn more finely: wide
        bends would close a narrow gap.
        """
        wide = bends(around, self.radius + HAIR, self.step)
        clear = self._standing(wide)
        if clear.all():
            return wide
        close = np.bincount(wide.corner[~clear], minlength=len(around.turn)) > 0
        fine = bends(around.take(close), self.radius + HAIR, STEP)
        return Bends.join([wide.take(~close[wide.corner]), fine.take(self._standing(fine))])

    def _standing(self, places: Bends) -> NDArray[np.bool_]:
        """Return a mask of the bends that are clear of the floor's edges."""
        inside = shapely.contains_xy(self._floor, places.point)
        clear = ~shapely.dwithin(self._edges, shapely.points(places.point), self.radius + HAIR / 2)
        both: NDArray[np.bool_] = inside & clear
        return both

    def _network(self) -> list[list[Link]]:
        """Return the links of all bends."""
        place = self.bends.point
        blocks = np.array_split(place, len(place) // _ROWS + 1)
        there = np.concatenate([self.bends.graze(*self.bends.beyond(some)) for some in blocks])
        # `there` is whether the line from i only grazes the corner at j; it must do so at both
        # ends.
        one, other = np.nonzero(np.triu(there & there.T, 1))
        seen = self.visible(place[one], place[other])
        links: list[list[Link]] = [[] for _ in place]
        for i, j in zip(one[seen].tolist(), other[seen].tolist(), strict=True):
            length = math.dist(self._points[i], self._points[j])
            for a, b in ((i, j), (j, i)):
                if not self._gates or self._gates.allow(self._points[a], self._points[b]):
                    links[a].append((b, length))
        return links

    def _links_of_some(self, bends: Ints) -> list[list[Link]]:
        """Return the links of the bends of these numbers."""
        here, place = self.bends.take(bends), self.bends.point
        assert self._sight is not None
        of, to = self._sight.beyond(here)
        one, other = bends[of], to
        worth = (one != other) & self._graze_both(here, of, to)
        of, one, other = of[worth], one[worth], other[worth]
        # A line is looked at in the same direction from either end: links go both ways.
        seen = self.visible(place[np.minimum(one, other)], place[np.maximum(one, other)])
        links: list[list[Link]] = [[] for _ in bends]
        for k, i, j in zip(
            of[seen].tolist(), one[seen].tolist(), other[seen].tolist(), strict=True
        ):
            if not self._gates or self._gates.allow(self._points[i], self._points[j]):
                links[k].append((j, math.dist(self._points[i], self._points[j])))
        return links

    def _graze_both(self, bends: Bends, of: Ints, to: Ints) -> NDArray[np.bool_]:
        """Return whether lines from some of `bends` to some of the floor's graze both corners."""
        along = self.bends.point[to] - bends.point[of]
        here, there = bends.take(of), self.bends.take(to)
        both: NDArray[np.bool_] = here.graze(*along.T) & there.graze(*along.T)
        return both

    def around(self, body: Body) -> Floats:
        """Return the columns of the bends around `body`, kept for as long as it stands there."""
        known = self._bodies.get(body)
        if known is None:
            known = self._bodies[body] = self._standing_bends(body.corners).columns()
        return known
