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
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
import shapely
from numpy.typing import NDArray

from floorplan import Point

from .bodies import Body
from .corners import Bends, Corners, Floats, bends, corners, edges_of_room
from .freespace import STEP
from .gates import Gates
from .sight import Ints, Sight

HAIR = 1e-4
"""Metres. Clearance beyond its radius that a disc keeps where a path bends."""

MOST_DISTANCES = 800
"""A network of up to this many bends is made at once, with the distances between all of them.

In a larger one, bends are linked when a search comes to them.
"""

_AT_ONCE = 256
"""Number of bends that are linked at once."""

Link = tuple[int, float]
"""The number of a bend, and the distance to it (metres)."""


@dataclass(frozen=True, eq=False)
class BodyBends:
    """The bends around one body, and lines that may link them to those of the floor.

    Line number k goes from bend `of[k]` of the body to bend `to[k]` of the floor, `length[k]`
    metres, and only grazes both corners. What else is in its way is not known.
    """

    bends: Bends
    of: Ints
    to: Ints
    length: Floats


@dataclass(frozen=True, eq=False)
class Ends:
    """A start and a goal, and what may link them to the floor's network."""

    start: Point
    goal: Point
    from_start: list[Link]
    to_goal: dict[int, float]
    straight: bool
    """True if there may be a direct link."""


class Roadmap:
    """The network of a floor for discs of one radius (metres), bends at most `step` radians.

    The floor alone makes the network. Bodies are given with each question, and cost only where
    a path meets them. Where there are one-way `gates`, a link against the direction of one is not
    there: links and distances between bends then depend on the direction. No other places to bend
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
        self._points: list[Point] = [(x, y) for x, y in self.bends.point.tolist()]
        self.asked: dict[int, bool] = {}
        """FCL's answers about links between bends, by the `number` of the link."""
        self.links: list[list[Link] | None] = [None] * len(self.bends)
        """The links of each bend that are known."""
        self.between: Floats | None = None
        """Distances (N, N) between all bends in metres, if they are known."""
        self._sight: Sight | None = None
        if len(self.bends) <= MOST_DISTANCES:
            network = self._network()
            self.links = [*network]
            self.between = _all_distances(network)
        else:
            self._sight = Sight(edges, self.bends, radius)
        self._bodies: WeakKeyDictionary[Body, BodyBends] = WeakKeyDictionary()

    def __repr__(self) -> str:
        return f"<Roadmap for a radius of {self.radius:g} m: {len(self.bends)} bends>"

    def ends(self, start: Point, goal: Point) -> Ends:
        """Link `start` and `goal` to the network, for one or more searches."""
        places = np.array([start, goal], dtype=float)
        from_start, to_goal = self._links_from(places)
        straight = bool(self.visible(places[:1], places[1:])[0])
        if self._gates:
            allow = self._gates.allow
            from_start = [link for link in from_start if allow(start, self.point(link[0]))]
            to_goal = [link for link in to_goal if allow(self.point(link[0]), goal)]
            straight = straight and allow(start, goal)
        return Ends(start, goal, from_start, dict(to_goal), straight)

    def visible(self, a: Floats, b: Floats) -> NDArray[np.bool_]:
        """Return whether the disc can go straight from a to b (N, 2), without regard to bodies."""
        lines = shapely.linestrings(np.stack([a, b], axis=1))
        near: NDArray[np.bool_] = shapely.dwithin(self._edges, lines, self.radius + HAIR / 2)
        return ~near

    def distances_to(self, goal: Point, last: Floats) -> Floats:
        """Return a lower bound of the path length (metres) from each bend to `goal`.

        `last` (N,) are lower bounds for a path that leaves the network from there; infinite where
        it does not.
        """
        if self.between is None:
            away = self.bends.point - np.array(goal)
            straight: Floats = np.hypot(away[:, 0], away[:, 1])
            return straight
        (ends,) = np.nonzero(last < math.inf)
        if not len(ends):
            return last
        nearest: Floats = (self.between[:, ends] + last[ends]).min(axis=1)
        return nearest

    def link_all(self, most: int) -> None:
        """Link all bends now, if they are no more than `most`."""
        if len(self.bends) <= most:
            left = [bend for bend in range(len(self.bends)) if self.links[bend] is None]
            for k in range(0, len(left), _AT_ONCE):
                self.links_of(left[k], left[k : k + _AT_ONCE])

    def point(self, bend: int) -> Point:
        """Return the place of bend number `bend`."""
        return self._points[bend]

    def passable_from(self, *places: Point) -> Iterator[tuple[Ints, Floats]]:
        """Yield the bends that a path could go on from after coming from each of `places`.

        With them, their distances in metres. What is in the way does not matter.
        """
        dx, dy = self.bends.beyond(np.array(places))
        length = np.hypot(dx, dy)
        # From between the arc and the bends drawn around it, a bend is seen but not grazed.
        passable = self.bends.graze(dx, dy) | (length <= self.bends.reach * 1.01)
        for some, far in zip(passable, length, strict=True):
            (bends,) = np.nonzero(some)
            yield bends, far[bends]

    def between_bends(self, first: int, last: int) -> list[int]:
        """Return the bends of the shortest path from one bend to another, with both."""
        assert self.between is not None
        chain = [first]
        while chain[-1] != last:
            left = self.between[:, last]
            links = self.links_of(chain[-1])
            chain.append(min(links, key=lambda link: link[1] + left[link[0]])[0])
        return chain

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

    def number(self, one: int, other: int) -> int:
        """Return the number of the link between two bends."""
        return min(one, other) * len(self.bends) + max(one, other)

    def _links_from(self, places: Floats) -> list[list[Link]]:
        """Return the links of each of `places` (N, 2) to bends that a path could go on from."""
        of, to = self._sight.around(places) if self._sight else self._every_pair(len(places))
        along = self.bends.point[to] - places[of]
        length = np.hypot(along[:, 0], along[:, 1])
        there = self.bends.take(to)
        # From between the arc and the bends drawn around it, a bend is seen but not grazed.
        passable = there.graze(*along.T) | (length <= there.reach * 1.01)
        of, to, length = of[passable], to[passable], length[passable]
        seen = self.visible(places[of], self.bends.point[to])
        links: list[list[Link]] = [[] for _ in places]
        for i, j, far in zip(
            of[seen].tolist(), to[seen].tolist(), length[seen].tolist(), strict=True
        ):
            links[i].append((j, far))
        return links

    def _beyond(self, bends: Bends) -> tuple[Ints, Ints]:
        """Return pairs of one of `bends` and a bend of the floor that may be visible from it."""
        return self._sight.beyond(bends) if self._sight else self._every_pair(len(bends))

    def _every_pair(self, count: int) -> tuple[Ints, Ints]:
        """Return all pairs of `count` places and a bend: on a small floor any may be visible."""
        number = len(self.bends)
        return np.repeat(np.arange(count), number), np.tile(np.arange(number), count)

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
        there = self.bends.graze(*self.bends.beyond(place))
        one, other = np.nonzero(np.triu(there & there.T, 1))
        seen = self.visible(place[one], place[other])
        links: list[list[Link]] = [[] for _ in place]
        for i, j in zip(one[seen].tolist(), other[seen].tolist(), strict=True):
            length = math.dist(place[i], place[j])
            for a, b in ((i, j), (j, i)):
                if not self._gates or self._gates.allow(self._points[a], self._points[b]):
                    links[a].append((b, length))
        return links

    def _links_of_some(self, bends: Ints) -> list[list[Link]]:
        """Return the links of the bends of these numbers."""
        here, place = self.bends.take(bends), self.bends.point
        of, to = self._beyond(here)
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
                links[k].append((j, math.dist(place[i], place[j])))
        return links

    def _graze_both(self, bends: Bends, of: Ints, to: Ints) -> NDArray[np.bool_]:
        """Return whether lines from some of `bends` to some of the floor's graze both corners."""
        along = self.bends.point[to] - bends.point[of]
        here, there = bends.take(of), self.bends.take(to)
        both: NDArray[np.bool_] = here.graze(*along.T) & there.graze(*along.T)
        return both

    def around(self, body: Body) -> BodyBends:
        """Return the bends around `body`, kept for as long as it stands where it does."""
        known = self._bodies.get(body)
        if known is not None:
            return known
        around = self._standing_bends(body.corners)
        if self._sight:
            of, to = self._sight.beyond(around)
            grazing = self._graze_both(around, of, to)
            of, to = of[grazing], to[grazing]
        else:
            dx, dy = self.bends.beyond(around.point)
            of, to = np.nonzero(self.bends.graze(dx, dy) & around.graze(dx.T, dy.T).T)
        along = self.bends.point[to] - around.point[of]
        fresh = BodyBends(around, of, to, np.hypot(along[:, 0], along[:, 1]))
        self._bodies[body] = fresh
        return fresh


def _all_distances(links: list[list[Link]]) -> Floats:
    """The shortest distances in the network by Floyd and Warshall's algorithm, (N, N) metres."""
    far = np.full((len(links), len(links)), math.inf)
    np.fill_diagonal(far, 0.0)
    for here, to in enumerate(links):
        for there, length in to:
            far[here, there] = length
    for k in range(len(links)):
        np.minimum(far, far[:, k, None] + far[k], out=far)
    return far
