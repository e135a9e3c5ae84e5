"""Retreats: walks of a person who steps aside, off the course of another, among all others.

Places are tried in a given order, as in the depth-first search of prioritised planning with pushes
(B. de Wilde, A. W. ter Mors and C. Witteveen, "Push and rotate: a complete multi-agent pathfinding
algorithm", Journal of Artificial Intelligence Research 51, 2014).
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
from .results import Retreat

if not cython.compiled:
    from .cubics import *
    from .discs import covers, distance
    from .edges import touches
    from .walks import draw_walk

_HAIR: float = 1e-6  # metres, for rounding
_JUST_NOW: float = 2e-3  # metres; at least the tolerance of `met` for an initial conflict


class Retreats:
    """Walks of a person, from rest, along a path and on to one of several places.

    They start with the drafts of `movers` and meet none of them, with `margin` metres in addition.
    The places are `width` metres off the polyline `course`, and the last segment is free of walls
    by `legs`. Speeds are in m/s, at most `top_speed` and `max_speed`. A `lead` precedes the walks.
    """

    def __init__(
        self,
        movers: Movers,
        person: int,
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
        self.person = person
        self.course = legs_of(course)
        self.width = width
        self.legs = legs
        self.tops = room(1)
        at(self.tops)[0] = top_speed
        start: float = movers.now if lead is None else lead.rests
        self.pace = SpeedLimits(start, 0.0, max_speed, acceleration)
        self.own = movers.own(person) + margin
        none: Numbers = room(0)
        self.lead = none if lead is None else lead.walk
        self.before = none if lead is None else lead.table
        self.box = none if lead is None else lead.box
        # The buffers of walks are reused.
        self.corners = none
        self.sketch = Swath(room(0), room(4))
        self.places = none
        self.index = -1
        self.last = -1
        self.stood = none

    def look(self, path: list[Place], places: Numbers) -> None:
        """Start a search for walks along `path` and on to one of the `places`.

        `places` has x and y of each, relative to the end of the path (m). The person stands at the
        begin of all paths.
        """
        self.corners = flat([*path, path[0]])  # the last one is set for each place
        self.places = places
        self.index = -1
        if self.last < 0:
            self._note_ends()
            self.last = 0

    def next(
        self,
        limit: cython.Py_ssize_t,
        fit: Callable[[float, float, Swath], Swath | None] | None,
        refusing: bytearray,
    ) -> Retreat:
        """Return the next possible walk.

        The walk is None, and the index -1, if there is none among the next `limit` walks. The
        obstacle is the index of the first person without a draft in the way, or -1. Walks with an
        obstacle that is `refusing` count as trials only. `fit(x, y, walk)`, if there is one,
        replaces the walk to a place, or rejects it by None.
        """
        end: Position = positions_of(self.corners)[position_count(self.corners) - 2]
        tried: cython.Py_ssize_t = 0
        while tried < limit:
            walk: Swath | None = self._come(end)
            if walk is None:
                break
            if fit is not None:
                to: Position = positions_of(self.places)[self.index]
                walk = fit(end.x + to.x, end.y + to.y, walk)
                if walk is None:
                    continue
            tried += 1
            hit: cython.Py_ssize_t = self.movers.first_other(self.person, walk)
            if hit < 0 or not refusing[hit]:
                return Retreat(walk, self.index, hit, tried)
        return Retreat(None, -1, -1, tried)

    def _note_ends(self) -> cython.int:
        """Set `stood` to the circles in which the movers stop."""
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
            # As in `met`: a person who is too close already must not come closer.
            apart: float = distance(here, table, movers.now)
            if apart < least + _JUST_NOW:
                least = min(least, apart)
            circles_of(self.stood)[i] = Circle(end.x.p, end.y.p, least - _HAIR)
        return 0

    def _come(self, end: Position) -> Swath | None:
        """Advance to the next retreat whose walk is free of walls and movers, or return None."""
        corner: Positions = positions_of(self.corners)
        count: cython.Py_ssize_t = position_count(self.corners)
        while self.index + 1 < position_count(self.places):
            self.index += 1
            to: Position = positions_of(self.places)[self.index]
            x: float = end.x + to.x
            y: float = end.y + to.y
            # A place where a mover stops is never free, so its walk needs no table.
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
            # Try the previous obstacle first, because successive walks often meet the same person.
            if pieces > 0 and not self._meets_any():
                return Swath(first_pieces(table, pieces), row_of_box(box))
        return None

    def _meets_any(self) -> bool:
        """Return whether the walk meets a mover. `last` is the mover to try first."""
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
