"""Retreats: walks of somebody who steps aside, off the course of another, among all others.

Places to retreat to are tried in a given order, as in the depth-first search of prioritised
planning with pushes (B. de Wilde, A. W. ter Mors and C. Witteveen, "Push and rotate: a complete
multi-agent pathfinding algorithm", Journal of Artificial Intelligence Research 51, 2014).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .committed import Movers
from .discs import Swath
from .edges import Legs, legs_of
from .numbers import Place, flat

if not cython.compiled:
    from .cubics import *
    from .discs import covers, distance
    from .edges import touches
    from .walks import draw_walk

_HAIR: float = 1e-6  # metres, for rounding
_JUST_NOW: float = 2e-3  # metres; at least what `met` takes for too close already


class Retreats:
    """Walks of the `me`-th on a floor, from rest, along a path and on to one of several places.

    They begin when the `movers` do, after a `lead` if there is one, meet none of these, even
    with `margin` metres more between them, are `width` metres off a `course`, at `top_speed` and
    never faster than `max_speed` (m/s), with this `acceleration` (m/s²), and from the end of the
    path on clear of the walls of `legs`.
    """

    def __init__(
        self,
        movers: Movers,
        me: int,
        course: list[Place],
        width: float,
        legs: Legs,
        top_speed: float,
        max_speed: float,
        acceleration: float,
        lead: Swath | None = None,
        margin: float = 0.0,
    ) -> None:
        self.movers = movers
        self.me = me
        self.course = legs_of(course)
        self.width = width
        self.legs = legs
        self.tops = room(1)
        at(self.tops)[0] = top_speed
        start: float = movers.now if lead is None else lead.rests
        self.pace = SpeedLimits(start, 0.0, max_speed, acceleration)
        self.own = movers.own(me) + margin
        none: Numbers = room(0)
        self.lead = none if lead is None else lead.walk
        self.before = none if lead is None else lead.table
        self.box = none if lead is None else lead.box
        # What is looked at is drawn up in the same room again and again.
        self.corners = none
        self.sketch = Swath(room(0), room(4))
        self.places = none
        self.k = -1
        self.last = -1
        self.stood = none

    def look(self, path: list[Place], places: Numbers) -> None:
        """Look from now on for walks along `path`, and on to one of the `places`.

        `places` has x and y of each in turn, from the end of the path (metres). Who steps aside
        stands where all paths begin.
        """
        self.corners = flat([*path, path[0]])  # the last one is to be set
        self.places = places
        self.k = -1
        if self.last < 0:
            self._note_ends()
            self.last = 0

    def next(
        self,
        most: cython.Py_ssize_t,
        fit: Callable[[float, float, Swath], Swath | None] | None,
        refusing: bytearray,
    ) -> tuple[Swath | None, int, int, int]:
        """Come to the next walk that may be taken, None if there is none.

        Return it, the number of its place, who is met first of those who don't move (-1 for
        nobody), and how many were tried, `most` at most. `fit`, if there is one, returns of a place
        and the walk to it the one that is taken instead, or None if one may not walk there. A walk
        that meets first who is `refusing` is tried, and not taken.
        """
        end: Position = positions_of(self.corners)[position_count(self.corners) - 2]
        tried: cython.Py_ssize_t = 0
        while tried < most:
            walk: Swath | None = self._come(end)
            if walk is None:
                break
            if fit is not None:
                to: Position = positions_of(self.places)[self.k]
                walk = fit(end.x + to.x, end.y + to.y, walk)
                if walk is None:
                    continue
            tried += 1
            hit: cython.Py_ssize_t = self.movers.first_other(self.me, walk)
            if hit < 0 or not refusing[hit]:
                return walk, self.k, hit, tried
        return None, -1, -1, tried

    def _note_ends(self) -> cython.int:
        """Note the circles in which those who are moving come to stand."""
        here: Numbers = self.before
        if len(here) == 0:
            start: Position = positions_of(self.corners)[0]
            here = planar_room(1)
            planar(here)[0] = rest_piece(self.pace.start, start.x, start.y)
        movers: Movers = self.movers
        self.stood = circle_room(len(movers.radii))
        i: cython.Py_ssize_t
        for i in range(len(movers.radii)):
            table: Numbers = movers.tables[i]
            end: PlanarPiece = planar(table)[planar_count(table) - 1]
            least: float = self.own + at(movers.radii)[i]
            # As `met`: who is too close already is met by coming closer still.
            apart: float = distance(here, table, movers.now)
            if apart < least + _JUST_NOW:
                least = min(least, apart)
            circles_of(self.stood)[i] = Circle(end.x.p, end.y.p, least - _HAIR)
        return 0

    def _come(self, end: Position) -> Swath | None:
        """Come to the next place whose walk meets no wall and nobody moving; None for none."""
        corner: Positions = positions_of(self.corners)
        count: cython.Py_ssize_t = position_count(self.corners)
        while self.k + 1 < position_count(self.places):
            self.k += 1
            to: Position = positions_of(self.places)[self.k]
            x: float = end.x + to.x
            y: float = end.y + to.y
            # No table is drawn up for what can't be fit: whoever stands there for good in the end
            # is met, at the latest then.
            if (
                touches(self.course, x, y, x, y, self.width)
                or covers(self.stood, x, y)
                or self.legs.meets_wall(end.x, end.y, x, y)
            ):
                continue
            corner[count - 1] = Position(x, y)
            box: BoundingBox = box_around(self.corners, count)
            if box_count(self.box) > 0:
                box = united(box, boxes_of(self.box)[0])
            boxes_of(self.sketch.box)[0] = box
            table: Numbers = self.sketch.table
            pieces: cython.Py_ssize_t = draw_walk(
                self.corners, count, self.tops, self.pace, self.pace.start, self.lead, table
            )
            # Whoever was in the way of the last one is likely to be in the way of this one.
            if pieces > 0 and not self._meets_any():
                return Swath(first_pieces(table, pieces), row_of_box(box))
        return None

    def _meets_any(self) -> bool:
        """Return whether the walk meets anybody who is moving: `last`, then, who is asked first."""
        count: cython.Py_ssize_t = circle_count(self.stood)
        if count == 0:
            return False
        if self.movers.meets(self.last, self.sketch, self.own):
            return True
        i: cython.Py_ssize_t
        for i in range(count):
            if i != self.last and self.movers.meets(i, self.sketch, self.own):
                self.last = i
                return True
        return False
