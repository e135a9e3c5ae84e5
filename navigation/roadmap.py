"""Visibility graph of a disc among grown corners, on a constrained Delaunay triangulation.

A shortest path among obstacles is taut: straight from corner to corner, and it only grazes those it
turns at. Grown by the disc's radius, corners are arcs, drawn here as short bends, so the network
of all free links that graze at both ends holds a shortest path between any two places, but for what
the bends are longer than the arcs (0.6 % of the arcs at steps of 15°).

See T. Lozano-Pérez and M. A. Wesley, "An algorithm for planning collision-free paths among
polyhedral obstacles", Communications of the ACM 22 (1979).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
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
from .mesh import Mesh, Passages

HAIR = 1e-4
"""Metres. Clearance beyond its radius that a disc keeps where a path bends."""


class Roadmap:
    """The network of a floor for discs of one radius (metres), bends at most `step` radians.

    A bend is linked when a search first reaches it. Its links take about 0.2 kB.
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
        self._mesh = mesh = Mesh(floor, self.bends.point)
        held = mesh.holding(self.bends.point)
        self._network = Network(
            self._columns.T, mesh.portals, mesh.first, held, walls, keep, gates.lines
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
        points = search.path(start, goal, straight, around, room, refused, self.apart)
        self._searches.append(search)
        return points

    def apart(self, start: Point, goal: Point) -> bool:
        """Return True if it is proved that the floor alone keeps a disc from start to goal."""
        return self.passages.apart(start, goal)

    @cached_property
    def passages(self) -> Passages:
        """The ways through the mesh that may be wide enough, found when first needed."""
        return Passages(self._mesh, self.radius)

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
        """Return the columns of the bends around `body`, cached until it moves."""
        known = self._bodies.get(body)
        if known is None:
            known = self._bodies[body] = self._standing_bends(body.corners).columns()
        return known
