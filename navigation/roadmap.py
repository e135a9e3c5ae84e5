"""Visibility graph of a disc among grown corners, on a constrained Delaunay triangulation.

GEOS takes quadratic time for the holes of a polygon, and rejects some in which holes touch each
other. So a floor of many holes is first cut into tiles. Where GEOS rejects one, it is cut again.

A shortest path among obstacles is taut: straight from corner to corner, and it only grazes those it
turns at. Grown by the disc's radius, corners are arcs, drawn here as short bends, so the network
of all free links that graze at both ends holds a shortest path between any two places, but for what
the bends are longer than the arcs (0.6 % of the arcs at steps of 15°).

See T. Lozano-Pérez and M. A. Wesley, "An algorithm for planning collision-free paths among
polyhedral obstacles", Communications of the ACM 22 (1979).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
import shapely
from numpy.typing import NDArray

from floorplan import Point

from .bodies import Bends, CollisionBody, Corners, Floats, bends, corners, edges_of_room
from .freespace import STEP, Gates
from .kernels.edges import Grid, Room
from .kernels.network import Network
from .kernels.search import Search

Ints = NDArray[np.intp]

_HOLES = 50
"""Maximum number of holes of a tile."""

_AT_ONCE = 500
"""Number of places that are looked up at once."""

_LINED_UP = 1e-12
"""Part of a coordinate by which the ends of a tile's sides may be off the line of a cut."""


class Mesh:
    """Triangles that cover a floor, and the portals through which one leads to another.

    `portals` (P, 6) has x and y of the right and of the left end, as seen from the first triangle
    (metres), and the numbers of both triangles, in the order of the first. Those of triangle t are
    from `first[t]` (T + 1,) on.
    """

    def __init__(self, floor: shapely.Geometry) -> None:
        self._cuts: tuple[set[float], set[float]] = (set(), set())
        parts = shapely.get_parts(floor)
        tiles = [tile for part in parts for tile in self._tiles(part, _HOLES)]
        self._triangles = np.array(self._triangulated(tiles))
        points = shapely.get_coordinates(shapely.get_exterior_ring(self._triangles))
        self._corners = _counterclockwise(points.reshape(-1, 4, 2)[:, :3])
        portals = self._portals()
        self.portals = portals[np.argsort(portals[:, 4], kind="stable")]
        self.first = np.searchsorted(self.portals[:, 4], np.arange(len(self._triangles) + 1))

    def __repr__(self) -> str:
        return f"<Mesh of {len(self._triangles)} triangles>"

    def holding(self, places: Floats) -> Ints:
        """Return the number of the triangle that each of `places` (N, 2) on the floor is in."""
        tree = shapely.STRtree(self._triangles)
        found = [np.empty((2, 0), dtype=np.intp)]
        # Of many geometries at once, Python's garbage collection would take longer than the tree.
        for first in range(0, len(places), _AT_ONCE):
            points = shapely.points(places[first : first + _AT_ONCE])
            found.append(tree.query(points) + np.array([[first], [0]]))
        of, triangle = np.concatenate(found, axis=1)
        here = self._corners[triangle]
        along, away = np.roll(here, -1, axis=1) - here, places[of][:, None] - here
        inside = (along[..., 0] * away[..., 1] - along[..., 1] * away[..., 0]).min(axis=1)
        # The one that a place is farthest in counts: rounding may leave it outside of both sides.
        order = np.argsort(inside, kind="stable")
        held = np.zeros(len(places), dtype=np.intp)
        held[of[order]] = triangle[order]
        return held

    def _tiles(self, polygon: shapely.Polygon, most: int) -> list[shapely.Polygon]:
        """Return a polygon in tiles of so many holes at most, but for those that a cut divides."""
        count = shapely.get_num_interior_rings(polygon)
        if count <= most:
            return [polygon]
        holes = shapely.polygons(shapely.get_interior_ring(polygon, range(count)))
        outline = shapely.polygons(shapely.get_exterior_ring(polygon))
        boxes = self._boxes(polygon, holes, most)
        tiles = np.array([shapely.clip_by_rect(outline, *box) for box in boxes])
        tile, hole = shapely.STRtree(holes).query(tiles)
        order = np.argsort(tile, kind="stable")
        near = np.full(len(tiles), shapely.MultiPolygon())
        shapely.multipolygons(holes[hole[order]], indices=tile[order], out=near)
        parts = shapely.get_parts(shapely.difference(tiles, near))
        return [*parts[shapely.area(parts) > 0]]

    def _boxes(self, polygon: shapely.Polygon, holes: Any, most: int) -> Iterator[Floats]:
        """Yield boxes (low x and y, high x and y) that cover a polygon, cut where no corner is."""
        known = [_distinct(column)[0] for column in shapely.get_coordinates(polygon).T]
        middle = shapely.bounds(holes).reshape(-1, 2, 2).mean(axis=1)
        left = [(shapely.bounds(polygon), np.arange(len(holes)))]
        while left:
            box, some = left.pop()
            if len(some) <= most:
                yield box
                continue
            axis = int(np.argmax(box[2:] - box[:2]))
            halfway = np.sort(middle[some, axis])[len(some) // 2]
            at = int(np.searchsorted(known[axis], halfway))
            around = known[axis][max(at - 3, 0) : at + 4]
            widest = int(np.argmax(np.diff(around)))
            cut = float(around[widest] + around[widest + 1]) / 2
            self._cuts[axis].add(cut)
            low, high = box.copy(), box.copy()
            low[2 + axis] = high[axis] = cut
            below = middle[some, axis] < cut
            if below.all() or not below.any():
                yield from (low, high)
            else:
                left += [(low, some[below]), (high, some[~below])]

    def _triangulated(self, tiles: list[shapely.Polygon]) -> list[shapely.Polygon]:
        """Return the triangles of some tiles."""
        try:
            return [*shapely.get_parts(shapely.constrained_delaunay_triangles(tiles))]
        except shapely.GEOSException:
            if len(tiles) > 1:
                return [part for tile in tiles for part in self._triangulated([tile])]
            holes = shapely.get_num_interior_rings(tiles[0])
            if not holes:
                raise
            return self._triangulated(self._tiles(tiles[0], holes - 1))

    def _portals(self) -> Floats:
        """Return the portals in any order."""
        corners = self._corners.reshape(-1, 2)
        points, right = _distinct(corners.view(np.complex128).ravel())
        left = np.roll(right.reshape(-1, 3), -1, axis=1).ravel()
        of = np.arange(len(right)) // 3
        # Two sides between the same corners are a portal.
        key = np.minimum(right, left) * len(points) + np.maximum(right, left)
        order = np.argsort(key, kind="stable")
        same = np.flatnonzero(key[order][1:] == key[order][:-1])
        one, other = order[same], order[same + 1]
        sides = np.column_stack([corners, np.roll(corners.reshape(-1, 3, 2), -1, 1).reshape(-1, 2)])
        alone = np.ones(len(key), dtype=bool)
        alone[one] = alone[other] = False
        found = [
            np.column_stack([sides[one], of[one], of[other]]),
            *self._borders(sides[alone], of[alone]),
        ]
        portals = np.concatenate(found)
        # What is on the right from one triangle is on the left from the other.
        return np.concatenate([portals, portals[:, [2, 3, 0, 1, 5, 4]]])

    def _borders(self, sides: Floats, of: Ints) -> Iterator[Floats]:
        """Yield the portals through the cuts: all pairs of sides on either side that overlap."""
        off = _LINED_UP * np.abs(sides).max(initial=0.0)
        for axis, along in ((0, 1), (1, 0)):
            cuts = np.array(sorted(self._cuts[axis]))
            place = np.searchsorted(cuts, sides[:, axis] - off)
            on = place < len(cuts)
            on[on] = (np.abs(sides[on][:, [axis, 2 + axis]].T - cuts[place[on]]) <= off).all(axis=0)
            for k in sorted(set(place[on].tolist())):
                here = np.flatnonzero(on & (place == k))
                begin, end = sides[here, along], sides[here, 2 + along]
                rising, falling = here[begin < end], here[begin >= end]
                falling = falling[np.argsort(sides[falling, along])]
                low, high = sides[rising, along], sides[rising, 2 + along]
                other_low, other_high = sides[falling, 2 + along], sides[falling, along]
                first = np.searchsorted(other_high, low, "right")
                count = np.maximum(np.searchsorted(other_low, high, "left") - first, 0)
                one = np.repeat(np.arange(len(rising)), count)
                other = np.arange(len(one)) - np.repeat(np.cumsum(count) - count - first, count)
                portals = np.empty((len(one), 6))
                portals[:, [axis, 2 + axis]] = cuts[k]
                portals[:, along] = np.maximum(low[one], other_low[other])
                portals[:, 2 + along] = np.minimum(high[one], other_high[other])
                portals[:, 4], portals[:, 5] = of[rising[one]], of[falling[other]]
                yield portals


def _distinct(values: NDArray[Any]) -> tuple[NDArray[Any], Ints]:
    """Return the values sorted, each once, and the index there of each.

    `np.unique` would import numpy.ma, which takes longer than most floors.
    """
    order = np.argsort(values, kind="stable")
    ranked = values[order]
    fresh = np.append(True, ranked[1:] != ranked[:-1])
    index = np.empty(len(values), dtype=np.intp)
    index[order] = np.cumsum(fresh) - 1
    return ranked[fresh], index


def _counterclockwise(corners: Floats) -> Floats:
    """Return triangles (T, 3, 2), each with its corners counterclockwise."""
    a, b, c = corners.swapaxes(0, 1)
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    turned = corners.copy()
    turned[area < 0] = corners[area < 0][:, ::-1]
    return turned


HAIR = 1e-4
"""Metres. Clearance beyond its radius that a disc keeps where a path bends."""


class Roadmap:
    """The network of a floor for discs of one radius (metres), bends at most `step` radians.

    Each bend is linked when a search first comes to it, and then takes about 0.2 kB for its links.
    The floor alone makes the network. Bodies are given with each question, and cost only where
    a path meets them. Where there are one-way `gates`, a link against the direction of one is not
    there: links then depend on the direction. No other places to bend
    at are needed: gates go from wall to wall, so that a taut path never goes round their ends.
    `walls` are the floor's edges.
    """

    def __init__(
        self, floor: shapely.Geometry, radius: float, step: float, gates: Gates, walls: Grid
    ) -> None:
        self.radius = radius
        self.step = step
        # Bends are `HAIR` farther out than the radius and links half of that: rounding blocks no
        # link along the side that both its bends belong to.
        keep = radius + HAIR / 2
        self._room = Room(walls, keep, [], [])
        self.bends = self._standing_bends(corners(edges_of_room(floor)))
        self._columns = self.bends.columns()
        self.places = frozenset(zip(*self.bends.point.T.tolist(), strict=True))
        self.asked: dict[tuple[Point, Point], bool] = {}
        """FCL's answers about links between the floor's bends, by their places."""
        mesh = Mesh(floor)
        held = mesh.holding(self.bends.point)
        self._network = Network(
            self._columns[:6].T, mesh.portals, mesh.first, held, walls, keep, gates.lines
        )
        self._bodies: WeakKeyDictionary[CollisionBody, Floats] = WeakKeyDictionary()
        self._searches: list[Search] = []

    def __repr__(self) -> str:
        return f"<Roadmap for a radius of {self.radius:g} m: {len(self.bends)} bends>"

    def path(
        self,
        start: Point,
        goal: Point,
        straight: bool,
        bodies: Sequence[CollisionBody],
        room: Room,
        refused: set[tuple[Point, Point]],
    ) -> list[Point] | None:
        """Return the shortest path round `bodies`, or None where there is none.

        `straight` is false where something fixed is in the way between start and goal, `room` what
        the floor and the bodies leave; `refused` links count for none.
        """
        around = [self.around(body) for body in bodies]
        try:
            search = self._searches.pop()  # one that nobody needs now
        except IndexError:
            search = Search(self._columns, self._network)  # takes longer than to use it
        points = search.path(start, goal, straight, around, room, refused)
        self._searches.append(search)
        return points

    def links_of(self, bend: int) -> list[tuple[int, float]]:
        """Return where the links of bend number `bend` lead, and their lengths in metres."""
        links = self._network.links_of(bend)
        return [(int(to), length) for to, length in zip(links[::2], links[1::2], strict=True)]

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
        columns = places.point.T.tolist()
        return np.array([self._room.holds(x, y) for x, y in zip(*columns, strict=True)], dtype=bool)

    def around(self, body: CollisionBody) -> Floats:
        """Return the columns of the bends around `body`, kept for as long as it stands there."""
        known = self._bodies.get(body)
        if known is None:
            known = self._bodies[body] = self._standing_bends(body.corners).columns()
        return known
