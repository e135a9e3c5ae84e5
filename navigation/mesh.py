"""Constrained Delaunay triangulation of a floor, and the passages through it.

GEOS needs quadratic time for the holes of a polygon, and rejects some holes that touch each other.
So a floor of many holes is first divided into tiles. If GEOS rejects a tile, it is divided again.

On the way around a corner of a triangle, from one side to the next, the centre of a disc crosses
each line of sight between that corner and a wall beyond. It cannot cross a line that is shorter
than the disc is wide. D. Demyen and M. Buro, "Efficient triangulation-based pathfinding", AAAI
2006, call the shortest of these lines the width of a triangle.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from floorplan import Point

from .bodies import Floats

Ints = NDArray[np.intp]


_HOLES = 50
"""Maximum number of holes of a tile."""


_NEAR = 10
"""Number of coordinates on either side of a tile's middle among which a cut is chosen."""


_AT_ONCE = 500
"""Number of places per query of the tree."""


_LINED_UP = 1e-12
"""Relative tolerance for sides of a tile on the line of a cut."""


class Mesh:
    """Triangles that cover a floor, and the portals between them.

    `corners` (T, 3, 2) has the corners of each, counterclockwise. `portals` (P, 6) has x and y of
    the right and of the left end, as seen from the first triangle, and the indices of both
    triangles, sorted by the first. Rows of triangle t begin at `first[t]` (T + 1,). Units are
    metres. No side between tiles passes through one of the `bends` (N, 2).
    """

    def __init__(self, floor: shapely.Geometry, bends: Floats) -> None:
        self._bends = bends
        self._cuts: tuple[set[float], set[float]] = (set(), set())
        parts = shapely.get_parts(floor)
        tiles = [tile for part in parts for tile in self._tiles(part, _HOLES)]
        triangles = self._triangulated(tiles)
        self._tree = shapely.STRtree(triangles)
        points = shapely.get_coordinates(triangles)
        self.corners = _counterclockwise(points.reshape(-1, 4, 2)[:, :3])
        portals = self._portals()
        self.portals = portals[np.argsort(portals[:, 4], kind="stable")]
        self.first = np.searchsorted(self.portals[:, 4], np.arange(len(self.corners) + 1))

    def __repr__(self) -> str:
        return f"<Mesh of {len(self.corners)} triangles>"

    def holding(self, places: Floats) -> Ints:
        """Return the index of the triangle that contains each of `places` (N, 2) on the floor."""
        matches = [np.empty((2, 0), dtype=np.intp)]
        # With many geometries at once, Python's garbage collection would take longer than the tree.
        for first in range(0, len(places), _AT_ONCE):
            points = shapely.points(places[first : first + _AT_ONCE])
            matches.append(self._tree.query(points) + np.array([[first], [0]]))
        of, triangle = np.concatenate(matches, axis=1)
        inside = np.full(len(of), np.inf)
        for side in range(3):
            begin, end = self.corners[triangle, side], self.corners[triangle, side - 2]
            np.minimum(inside, cross(end - begin, places[of] - begin), out=inside)
        # Choose the triangle in which a place is farthest inside, because rounding may exclude it
        # from all.
        order = np.argsort(inside, kind="stable")
        triangle_of = np.zeros(len(places), dtype=np.intp)
        triangle_of[of[order]] = triangle[order]
        return triangle_of

    def _tiles(self, polygon: shapely.Polygon, limit: int) -> list[shapely.Polygon]:
        """Return tiles of a polygon with at most `limit` holes, not counting those that are cut."""
        count = shapely.get_num_interior_rings(polygon)
        if count <= limit:
            return [polygon]
        holes = shapely.polygons(shapely.get_interior_ring(polygon, range(count)))
        outline = shapely.polygons(shapely.get_exterior_ring(polygon))
        boxes = self._boxes(polygon, holes, limit)
        tiles = np.array([shapely.clip_by_rect(outline, *box) for box in boxes])
        tile, hole = shapely.STRtree(holes).query(tiles)
        order = np.argsort(tile, kind="stable")
        near = np.full(len(tiles), shapely.MultiPolygon())
        shapely.multipolygons(holes[hole[order]], indices=tile[order], out=near)
        parts = shapely.get_parts(shapely.difference(tiles, near))
        return [*parts[shapely.area(parts) > 0]]

    def _boxes(self, polygon: shapely.Polygon, holes: Any, limit: int) -> Iterator[Floats]:
        """Yield boxes (low x and y, high x and y) that cover a polygon.

        No cut passes through a corner or a bend, so that each bend is in one triangle only.
        """
        places = np.concatenate([shapely.get_coordinates(polygon), self._bends])
        coordinates = [distinct(column)[0] for column in places.T]
        middle = shapely.bounds(holes).reshape(-1, 2, 2).mean(axis=1)
        left = [(shapely.bounds(polygon), np.arange(len(holes)))]
        while left:
            box, some = left.pop()
            if len(some) <= limit:
                yield box
                continue
            axis = int(np.argmax(box[2:] - box[:2]))
            halfway = np.sort(middle[some, axis])[len(some) // 2]
            at = int(np.searchsorted(coordinates[axis], halfway))
            around = coordinates[axis][max(at - _NEAR, 0) : at + _NEAR + 1]
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
        """Return the triangles of tiles."""
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
        corners = self.corners.reshape(-1, 2)
        points, right = distinct(corners.view(np.complex128).ravel())
        left = np.roll(right.reshape(-1, 3), -1, axis=1).ravel()
        of = np.arange(len(right)) // 3
        # Two sides between the same corners form a portal.
        key = np.minimum(right, left) * len(points) + np.maximum(right, left)
        order = np.argsort(key, kind="stable")
        same = np.flatnonzero(key[order][1:] == key[order][:-1])
        one, other = order[same], order[same + 1]
        sides = np.column_stack([corners, np.roll(corners.reshape(-1, 3, 2), -1, 1).reshape(-1, 2)])
        alone = np.ones(len(key), dtype=bool)
        alone[one] = alone[other] = False
        parts = [
            np.column_stack([sides[one], of[one], of[other]]),
            *self._borders(sides[alone], of[alone]),
        ]
        portals = np.concatenate(parts)
        # The right end from one triangle is the left end from the other.
        return np.concatenate([portals, portals[:, [2, 3, 0, 1, 5, 4]]])

    def _borders(self, sides: Floats, of: Ints) -> Iterator[Floats]:
        """Yield the portals through the cuts: pairs of overlapping sides of different tiles."""
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


def cross(one: Floats, other: Floats) -> Floats:
    """Return the cross products of vectors (..., 2)."""
    product: Floats = one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]
    return product


def distinct(values: NDArray[Any]) -> tuple[NDArray[Any], Ints]:
    """Return the sorted distinct values, and the index of each value among them.

    `np.unique` imports numpy.ma, which takes longer than most floors.
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
    area = cross(b - a, c - a)
    turned = corners.copy()
    turned[area < 0] = corners[area < 0][:, ::-1]
    return turned


class Passages:
    """Passages through the portals of a `mesh` that may be wide enough for discs of `radius` m."""

    def __init__(self, mesh: Mesh, radius: float) -> None:
        self._mesh = mesh
        self._width = 2 * radius
        self._right, self._left = mesh.portals[:, :2], mesh.portals[:, 2:4]
        self._off, self._onto = mesh.portals[:, 4].astype(int), mesh.portals[:, 5].astype(int)
        # Side k of a triangle leads from its corner k to the next.
        self._side, entered = self._sides(self._off), self._sides(self._onto)
        self._wall = np.ones((len(mesh.corners), 3), dtype=bool)
        self._wall[self._off, self._side] = False
        self._solid = self._standing()
        self._open = self._wide()
        closed = self._closed_corners()
        one, other = self._next(self._onto)
        # A passage that turns back in a triangle goes around nothing.
        on = self._onto[other] != self._off[one]
        one, other = one[on], other[on]
        turned = (self._side[other] - entered[one]) % 3
        corner = np.where(turned == 1, self._side[other], entered[one])
        through = (turned == 0) | ~closed[self._onto[one], corner]
        through &= self._open[one] & self._open[other]
        self._part = _connected(len(self._off), one[through], other[through])
        self._by_end = np.argsort(self._onto, kind="stable")
        self._last = np.searchsorted(self._onto[self._by_end], np.arange(len(mesh.first)))

    def apart(self, start: Point, goal: Point) -> bool:
        """Return whether a proof exists that no path leads from `start` to `goal`."""
        one, other = self._mesh.holding(np.array([start, goal])).tolist()
        if one == other:
            return False
        leaving = np.arange(self._mesh.first[one], self._mesh.first[one + 1])
        arriving = self._by_end[self._last[other] : self._last[other + 1]]
        leaving_parts, arriving_parts = (
            set(self._part[portals[self._open[portals]]].tolist())
            for portals in (leaving, arriving)
        )
        return leaving_parts.isdisjoint(arriving_parts)

    def _sides(self, triangle: Ints) -> Ints:
        """Return the side of a triangle (P,) that each portal is on."""
        corners = self._mesh.corners[triangle]
        away = (self._right + self._left)[:, None] / 2 - corners
        off_line = np.abs(cross(np.roll(corners, -1, axis=1) - corners, away))
        side: Ints = np.argmin(off_line, axis=1)
        return side

    def _standing(self) -> NDArray[np.bool_]:
        """Return a mask of the corners (T, 3) that are on a wall. Others are corners of tiles."""
        places, which = distinct(self._mesh.corners.reshape(-1, 2).view(np.complex128).ravel())
        on_wall = np.zeros(len(places), dtype=bool)
        on_wall[which[(self._wall | np.roll(self._wall, 1, axis=1)).ravel()]] = True
        solid: NDArray[np.bool_] = on_wall[which].reshape(-1, 3)
        return solid

    def _wide(self) -> NDArray[np.bool_]:
        """Return a mask of the portals that are wide enough, or have no wall at an end."""
        after = (self._side + 1) % 3
        corners = self._mesh.corners[self._off]
        every = np.arange(len(self._off))
        whole = (self._right == corners[every, self._side]).all(axis=1)
        whole &= (self._left == corners[every, after]).all(axis=1)
        whole &= self._solid[self._off, self._side] & self._solid[self._off, after]
        wide: NDArray[np.bool_] = ~whole | (_length(self._left - self._right) >= self._width)
        return wide

    def _closed_corners(self) -> NDArray[np.bool_]:
        """Return a mask of the corners (T, 3) of triangles that a disc cannot pass around."""
        walled = self._wall | np.roll(self._wall, 1, axis=1)
        triangle, corner = np.nonzero(self._solid & ~walled)
        place = self._mesh.corners[triangle, corner]
        opposite = (corner + 1) % 3
        closed = self._wall[triangle, opposite] & self._faces(place, triangle, opposite)[0]
        of, portal = self._next(triangle)
        ahead = self._side[portal] == opposite[of]
        of, portal = of[ahead], portal[ahead]
        right, left = self._right[portal] - place[of], self._left[portal] - place[of]
        while True:
            near = ~closed[of] & self._reaches(place[of], portal)
            near &= cross(right, left) > 0
            of, portal, right, left = of[near], portal[near], right[near], left[near]
            if not len(of):
                break
            beyond = self._onto[portal]
            for side in range(3):
                solid = self._solid[beyond, side] & self._sees(of, place, beyond, side, right, left)
                closed[of[solid]] = True
                faces, foot = self._faces(place[of], beyond, np.full(len(of), side))
                faces &= self._wall[beyond, side] & _within(foot, right, left)
                closed[of[faces]] = True
            k, further = self._next(beyond)
            on = self._onto[further] != self._off[portal[k]]
            k, further = k[on], further[on]
            of, right, left = of[k], right[k], left[k]
            portal = further
            here = self._right[portal] - place[of], self._left[portal] - place[of]
            right = np.where((cross(right, here[0]) > 0)[:, None], here[0], right)
            left = np.where((cross(left, here[1]) < 0)[:, None], here[1], left)
        mask = np.zeros(self._solid.shape, dtype=bool)
        mask[triangle[closed], corner[closed]] = True
        return mask

    def _next(self, triangle: Ints) -> tuple[Ints, Ints]:
        """Return all portals of given triangles, with the position of each triangle."""
        first, count = self._mesh.first[triangle], np.diff(self._mesh.first)[triangle]
        of = np.repeat(np.arange(len(triangle)), count)
        return of, np.arange(len(of)) - np.repeat(np.cumsum(count) - count - first, count)

    def _faces(self, place: Floats, triangle: Ints, side: Ints) -> tuple[NDArray[np.bool_], Floats]:
        """Return whether the foot of a place on a side is near and on it, and the vector to it."""
        begin = self._mesh.corners[triangle, side]
        along = self._mesh.corners[triangle, (side + 1) % 3] - begin
        share = ((place - begin) * along).sum(axis=1) / (along**2).sum(axis=1)
        foot = begin + share[:, None] * along - place
        return (share >= 0) & (share <= 1) & (_length(foot) < self._width), foot

    def _sees(
        self, of: Ints, place: Floats, triangle: Ints, side: int, right: Floats, left: Floats
    ) -> NDArray[np.bool_]:
        """Return whether a corner of a triangle is near and between two directions."""
        ahead = self._mesh.corners[triangle, side] - place[of]
        return _within(ahead, right, left) & (_length(ahead) < self._width)

    def _reaches(self, place: Floats, portal: Ints) -> NDArray[np.bool_]:
        """Return whether the distance of each place to a portal is less than a disc's width."""
        along = self._left[portal] - self._right[portal]
        away = place - self._right[portal]
        share = np.clip((away * along).sum(axis=1) / (along**2).sum(axis=1), 0, 1)
        return _length(share[:, None] * along - away) < self._width


def _connected(count: int, one: Ints, other: Ints) -> Ints:
    """Return for each of `count` nodes the first node that `one` and `other` connect it to."""
    # Y. Shiloach and U. Vishkin, "An O(log n) parallel connectivity algorithm", Journal of
    # Algorithms 3, 1982.
    first = np.arange(count)
    while True:
        before = first.copy()
        least = np.minimum(first[one], first[other])
        np.minimum.at(first, first[one], least)
        np.minimum.at(first, first[other], least)
        first = first[first]
        if (first == before).all():
            return first


def _within(ahead: Floats, right: Floats, left: Floats) -> NDArray[np.bool_]:
    """Return whether directions are between two others."""
    return (cross(right, ahead) >= 0) & (cross(left, ahead) <= 0)


def _length(vector: Floats) -> Floats:
    return np.hypot(vector[..., 0], vector[..., 1])
