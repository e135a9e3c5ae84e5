"""Visibility graph of a disc among grown corners, on a constrained Delaunay triangulation.

A shortest path among obstacles is taut: straight from corner to corner, and grazing each corner at
which it turns. Corners grown by the disc's radius are arcs, which are approximated by short bends.
So the network of all free links that graze at both ends contains a shortest path between any two
places, except that bends are longer than arcs (0.6 % at steps of 15°).

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
"""Metres. Clearance of a path beyond the radius of the disc where it bends."""


class Roadmap:
    """Network of a floor for discs of one radius (metres), with bends of at most `step` radians.

    A bend is linked when a search first reaches it. Its links take about 0.2 kB. The network is
    that of the floor alone. Each query adds bodies, which cost only if a path meets them. No link
    crosses one of the one-way `gates` backwards, so links may have one direction only. Gates add
    no bends, because they reach from wall to wall, and no taut path bends around their ends.
    `walls` are the floor's edges.
    """

    def __init__(
        self, floor: shapely.Geometry, radius: float, step: float, gates: Gates, walls: Grid
    ) -> None:
        self.radius = radius
        self.step = step
        # Bends are `HAIR` farther out than the radius and links half of that, so that rounding
        # blocks no link along a side between two bends.
        keep = radius + HAIR / 2
        self._room = Room(walls, keep, [], [])
        self.bends = self._standing_bends(corners(edges_of_room(floor)))
        self._columns = self.bends.columns()
        self.places = frozenset(zip(*self.bends.point.T.tolist(), strict=True))
        self.verdicts: dict[tuple[Point, Point], bool] = {}
        """FCL's results for links between the floor's bends, by their places."""
        self._mesh = mesh = Mesh(floor, self.bends.point)
        triangle = mesh.holding(self.bends.point)
        self._network = Network(
            self._columns.T, mesh.portals, mesh.first, triangle, walls, keep, gates.lines
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
        """Return the shortest path around `bodies`, or None.

        `straight` is false if a fixed obstacle is between start and goal. `room` tests links among
        the floor and the bodies. `refused` links are excluded.
        """
        around = [self.around(body) for body in bodies]
        try:
            search = self._searches.pop()
        except IndexError:
            search = Search(self._columns, self._network)  # slower than a search itself
        points = search.path(start, goal, straight, around, room, refused, self.apart)
        self._searches.append(search)
        return points

    def apart(self, start: Point, goal: Point) -> bool:
        """Return whether a proof exists that the floor alone separates start and goal."""
        return self.passages.apart(start, goal)

    @cached_property
    def passages(self) -> Passages:
        """Passages through the mesh that may be wide enough, computed on demand."""
        return Passages(self._mesh, self.radius)

    def links_of(self, bend: int) -> list[tuple[int, float]]:
        """Return the bends to which bend number `bend` has links, with their lengths in metres."""
        links = self._network.links_of(bend)
        return [(int(to), length) for to, length in zip(links[::2], links[1::2], strict=True)]

    def _standing_bends(self, around: Corners) -> Bends:
        """Return the bends around corners that are clear of the floor's edges.

        Corners with blocked bends are close to another obstacle. They get finer bends, because wide
        ones would close a narrow gap.
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
        columns = self._bodies.get(body)
        if columns is None:
            columns = self._bodies[body] = self._standing_bends(body.corners).columns()
        return columns
