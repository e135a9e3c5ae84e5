"""Retreats: walks of somebody who steps aside, off the course of another, among all others.

For the tables see `discs`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .discs import ROW
from .edges import Grid, legs_of
from .movers import Movers
from .numbers import Place, flat

if not cython.compiled:
    from math import inf

    from .candidates import bound
    from .discs import distance, stand
    from .edges import touches
    from .numbers import Doubles, Numbers, at, grow, part, put, room
    from .pacing import draw

    INFINITY = inf
else:
    from cython.cimports.libc.math import INFINITY
    from cython.cimports.navigation.kernels.candidates import bound
    from cython.cimports.navigation.kernels.discs import distance, stand
    from cython.cimports.navigation.kernels.edges import touches
    from cython.cimports.navigation.kernels.numbers import (
        Doubles,
        Numbers,
        at,
        grow,
        part,
        put,
        room,
    )
    from cython.cimports.navigation.kernels.pacing import draw

_R: cython.Py_ssize_t = ROW
_HAIR: float = 1e-6  # metres, for rounding
_JUST_NOW: float = 2e-3  # metres; at least what `met` takes for too close already


class Retreats:
    """Walks of the `me`-th of a throng, from rest, along a path and on to one of several places.

    They begin when the `movers` do, of whom they meet nobody, are `width` metres off a `course`, at
    `top_speed` and never faster than `max_speed` (m/s), with this `acceleration` (m/s²), and from
    the end of the path on `radius` metres from `walls`.
    """

    def __init__(
        self,
        movers: Movers,
        me: int,
        course: list[Place],
        width: float,
        top_speed: float,
        max_speed: float,
        acceleration: float,
        walls: Grid,
        radius: float,
    ) -> None:
        self.movers = movers
        self.me = me
        self.width = width
        self.start = movers.now
        self.tops = room(1)
        at(self.tops)[0] = top_speed
        self.max_speed = max_speed
        self.acceleration = acceleration
        self.own = at(movers.throng.radii)[me] + movers.throng.gap
        self.walls = walls
        self.radius = radius
        self.legs = legs_of(course)
        none: Numbers = room(0)
        self.none = none
        self.path = none
        # What is looked at is drawn up in the same room again and again.
        self.corners = room(0)
        self.sketch = room(0)
        self.bounds = room(4)
        self.places = none
        self.k = -1
        self.last = -1
        self.stood = none
        self.table = none
        self.box = none
        self.hit = -1
        self.tried = 0

    def look(self, path: list[Place], places: Numbers) -> None:
        """Look from now on for walks along `path`, and on to one of the `places`.

        `places` has x and y of each in turn, from the end of the path (metres). Who steps aside
        stands where all paths begin.
        """
        self.path = flat(path)
        self._set_out()
        self.places = places
        self.k = -1
        if self.last < 0:
            self._note_ends()
            self.last = 0

    def next(
        self,
        most: cython.Py_ssize_t,
        fit: Callable[[float, float], bool] | None,
        refusing: bytearray,
    ) -> int:
        """Come to the next walk that may be taken: return the number of its place; -1 for none.

        Its `table` and `box` are there then, and who is met first of those who don't move: `hit`,
        -1 for nobody. `fit`, if there is one, says of a place whether one may walk there from the
        end of the path. A walk that meets first who is `refusing` is not taken; it is one of those
        `tried`, as is the one that is returned. At most so many are tried.
        """
        path: Doubles = at(self.path)
        x: float = path[len(self.path) - 2]
        y: float = path[len(self.path) - 1]
        self.tried = 0
        while self.tried < most and self._come(x, y):
            px: float = x + at(self.places)[2 * self.k]
            py: float = y + at(self.places)[2 * self.k + 1]
            if fit is not None and not fit(px, py):
                continue
            self.tried += 1
            self.hit = self.movers.first_other(self.me, self.table, self.box)
            if self.hit < 0 or not refusing[self.hit]:
                found: int = self.k
                return found
        return -1

    def _note_ends(self) -> cython.int:
        """Note where those who are moving come to stand: x, y, and how near is too near."""
        here: Numbers = room(_R)
        path: Doubles = at(self.path)
        stand(at(here), 0, self.start, INFINITY, path[0], path[1])
        movers: Movers = self.movers
        radii: Doubles = at(movers.radii)
        self.stood = room(3 * len(movers.radii))
        disc: Doubles = at(self.stood)
        i: cython.Py_ssize_t
        for i in range(len(movers.radii)):
            table: Numbers = movers.tables[i]
            row: Doubles = at(table)
            last: cython.Py_ssize_t = len(table) - _R
            least: float = self.own + radii[i]
            # As `met`: who is too close already is met by coming closer still.
            apart: float = distance(here, table, self.start)
            if apart < least + _JUST_NOW:
                least = min(least, apart)
            disc[3 * i] = row[last + 2]
            disc[3 * i + 1] = row[last + 6]
            disc[3 * i + 2] = least - _HAIR
        return 0

    def _come(self, x: float, y: float) -> bool:
        """Come to the next place whose walk meets no wall and nobody moving; False for none."""
        places: Doubles = at(self.places)
        while self.k + 1 < len(self.places) // 2:
            self.k += 1
            px: float = x + places[2 * self.k]
            py: float = y + places[2 * self.k + 1]
            # No table is drawn up for what can't be fit: whoever stands there for good in the end
            # is met, at the latest then.
            if (
                touches(self.legs, px, py, px, py, self.width)
                or self._is_taken(px, py)
                or self.walls.touched(x, y, px, py, self.radius)
            ):
                continue
            count: cython.Py_ssize_t = len(self.path) + 2
            corner: Doubles = at(self.corners)
            corner[count - 2] = px
            corner[count - 1] = py
            bound(self.corners, count, self.none, self.bounds)
            end: cython.Py_ssize_t = draw(
                self.corners,
                count,
                self.tops,
                self.start,
                self.start,
                0.0,
                self.max_speed,
                self.acceleration,
                self.none,
                self.sketch,
            )
            if end == 0:
                continue
            # Whoever was in the way of the last one is likely to be in the way of this one.
            if len(self.stood) == 0 or (not self._meets(self.last) and not self._meets_any()):
                self.table = part(self.sketch, 0, end)
                self.box = part(self.bounds, 0, 4)
                return True
        return False

    def _set_out(self) -> cython.int:
        """Begin the corners with those of the path, with room for one after them."""
        grow(self.corners, len(self.path) + 2)
        put(at(self.corners), 0, at(self.path), 0, len(self.path))
        return 0

    def _is_taken(self, x: float, y: float) -> bool:
        """Return whether somebody who is moving comes to stand at a place, or too near to it."""
        disc: Doubles = at(self.stood)
        i: cython.Py_ssize_t
        for i in range(0, len(self.stood), 3):
            dx: float = disc[i] - x
            dy: float = disc[i + 1] - y
            least: float = disc[i + 2]
            if least > 0.0 and dx * dx + dy * dy < least * least:
                return True
        return False

    def _meets_any(self) -> bool:
        """Return whether the walk meets anybody who is moving: `last`, then."""
        i: cython.Py_ssize_t
        for i in range(len(self.stood) // 3):
            if i != self.last and self._meets(i):
                self.last = i
                return True
        return False

    def _meets(self, i: cython.Py_ssize_t) -> bool:
        """Return whether the walk meets one who is moving."""
        return self.movers.met(i, self.sketch, self.bounds, self.own) < INFINITY
