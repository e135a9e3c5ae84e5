"""Retreats: walks of a person who steps aside, off the course of another, among all others.

Places are tried in a given order, as in the depth-first search of prioritised planning with pushes
(B. de Wilde, A. W. ter Mors and C. Witteveen, "Push and rotate: a complete multi-agent pathfinding
algorithm", Journal of Artificial Intelligence Research 51, 2014).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .committed import Movers
from .discs import Swath
from .edges import Legs
from .numbers import Place, flat

if not cython.compiled:
    from .cubics import *
    from .discs import covers, distance
    from .edges import legs_of, touches
    from .walks import draw_walk

_HAIR: float = 1e-6  # metres, for rounding
_JUST_NOW: float = 2e-3  # metres; at least the tolerance of `met` for an initial conflict


class Retreats:
    """Walks of a `person`, from rest at `start`, off the course of another person.

    They lead to one of the places `around` (x and y of each, relative to the start), or along a
    path and on to one of several places. They start with the drafts of `movers` and meet none of
    them, with `margin` metres in addition. The places are `width` metres off the course, and the
    last segment is free of walls by `legs`. Speeds are in m/s, at most `top_speed` and `max_speed`.
    A `lead` precedes the walks. At most `wide` walks are tried in total.
    """

    def __init__(
        self,
        movers: Movers,
        person: int,
        start: Place,
        around: Numbers,
        width: float,
        legs: Legs,
        top_speed: float,
        max_speed: float,
        acceleration: float,
        wide: int,
        lead: Swath | None = None,
        margin: float = 0.0,
    ) -> None:
        self.movers = movers
        self.person = person
        self.start = start
        self.around = around
        self.width = width
        self.legs = legs
        self.tops = room(1)
        at(self.tops)[0] = top_speed
        begin: float = movers.now if lead is None else lead.rests
        self.pace = SpeedLimits(begin, 0.0, max_speed, acceleration)
        self.wide = wide
        self.own = movers.own(person) + margin
        none: Numbers = room(0)
        self.lead = none if lead is None else lead.walk
        self.before = none if lead is None else lead.table
        self.box = none if lead is None else lead.box
        # The buffers of walks are reused.
        self.course = none
        self.corners = none
        self.sketch = Swath(room(0), room(4))
        self.places = none
        self.path = [start]
        self.checked = False
        self.index = -1
        self.last = -1
        self.stood = none
        self.hit = -1
        self.tried = 0

    def is_checked(self, path: list[Place]) -> bool:
        """Return whether walks along `path` and on to a place are checked by `fit`."""
        return False

    def fit(self, path: list[Place], walk: Swath) -> Swath | None:
        """Return a walk along `path`, another one in its place, or None to reject it."""
        return walk

    def ahead(self, course: list[Place]) -> Iterator[tuple[list[Place], Numbers]]:
        """Return further paths along `course`, and the places around the end of each."""
        return iter(())

    def leave(self, course: Numbers) -> None:
        """Start the search for walks off a `course`, a row of its segments."""
        self.course = course
        self.last = -1

    def look(self, path: list[Place], places: Numbers) -> None:
        """Start a search for walks along `path` and on to one of the `places`.

        `places` has x and y of each, relative to the end of the path (m). The person stands at the
        begin of all paths.
        """
        self.path = path
        self.checked = self.is_checked(path)
        self.corners = flat([*path, path[0]])  # the last one is set for each place
        self.places = places
        self.index = -1
        if self.last < 0:
            self._note_ends()
            self.last = 0

    def next(self, limit: cython.Py_ssize_t, refusing: bytearray) -> Swath | None:
        """Return the next possible walk, or None if there is none among the next `limit` walks.

        `hit` is the index of the first person without a draft in the way, or -1, and `tried` is the
        number of walks. Walks with an obstacle that is `refusing` count as trials only.
        """
        end: Position = positions_of(self.corners)[position_count(self.corners) - 2]
        self.tried = 0
        while self.tried < limit:
            walk: Swath | None = self._come(end)
            if walk is None:
                break
            if self.checked:
                walk = self.fit(self.retreat(), walk)
                if walk is None:
                    continue
            self.tried += 1
            self.hit = self.movers.first_other(self.person, walk)
            if self.hit < 0 or not refusing[self.hit]:
                return walk
        return None

    def retreat(self) -> list[Place]:
        """Return the path of the last walk."""
        end: Position = positions_of(self.corners)[position_count(self.corners) - 2]
        to: Position = positions_of(self.places)[self.index]
        return [*self.path, (end.x + to.x, end.y + to.y)]

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


class RetreatSearch:
    """Depth-first search of retreats of the people in the way of a mover, who may ask others.

    A chain has at most `longest` people, and at most about `most` people move. All try `left` walks
    in total.
    """

    def __init__(self, movers: Movers, longest: int, most: int, left: int) -> None:
        self.movers = movers
        self.longest = longest
        self.most = most
        self.left = left
        count: cython.Py_ssize_t = len(movers.floor.radii)
        nobody: list[Retreats | None] = [None] * count
        self.asked = nobody
        self.known = bytearray(count)
        self.refusing = bytearray(count)

    def ask(self, k: int) -> Retreats | None:
        """Return the retreats of the k-th person, or None if the person refuses."""
        return None

    def refuse(self, everybody: bool) -> None:
        """Restart without people who refuse, or with `everybody` refusing."""
        self.refusing = bytearray(len(self.known))
        k: cython.Py_ssize_t
        if everybody:
            for k in range(len(self.known)):
                self.refusing[k] = 1

    def clear(self, k: cython.Py_ssize_t, draft: Swath, course: list[Place]) -> bool:
        """Draft steps of all people in the way of the k-th person, who follows `draft`.

        Return whether they exist. The people leave `course`.
        """
        self.refuse(False)
        self.movers.keep(0)
        self.movers.move(k, draft)
        clear: bool = self._clear(0, course, 0, self.movers.first_hit(0))
        return clear

    def _clear(
        self,
        mover: cython.Py_ssize_t,
        course: list[Place],
        depth: cython.Py_ssize_t,
        hit: cython.Py_ssize_t,
    ) -> bool:
        """Draft steps of all people in the way of a mover, of whom `hit` is the first or -1."""
        # Drafts of a chain are checked against each other and against the committed motions of all
        # others, because all people of the chain are committed together.
        if hit < 0:
            return True
        legs: Numbers = legs_of(course)
        while hit >= 0:
            if self._is_enough(depth, len(self.movers.indices)):
                return False
            walks: Retreats | None = self._ask(hit)
            if walks is None or not self.step(walks, course, legs, depth):
                return False
            hit = self.movers.first_hit(mover)
        return True

    def _is_enough(self, depth: cython.Py_ssize_t, moving: cython.Py_ssize_t) -> bool:
        """Return whether a chain has its maximum length, or the request its maximum size."""
        enough: bool = depth >= self.longest or moving > self.most
        return enough

    def _ask(self, k: cython.Py_ssize_t) -> Retreats | None:
        """Return the retreats of a person, or None if the person refuses or has found no place."""
        if self.refusing[k]:
            return None
        if not self.known[k]:
            self.known[k] = 1
            self.asked[k] = self.ask(k)
        walks: Retreats | None = self.asked[k]
        if walks is None:
            self.refusing[k] = 1
        return walks

    def step(
        self, walks: Retreats, course: list[Place], legs: Numbers, depth: cython.Py_ssize_t
    ) -> bool:
        """Draft a step of a person off `course`, with the segments `legs`, if there are any.

        Return whether it exists.
        """
        # Depth first: a failed step removes all drafts made for it. A person without a place is not
        # asked again for this course, because the search would have the same result.
        movers: Movers = self.movers
        count: cython.Py_ssize_t = len(movers.indices)
        refusing: bytearray = self.refusing
        if self._is_enough(depth + 1, count + 1):
            refusing = bytearray(b"\1" * len(refusing))
        left: cython.Py_ssize_t = walks.wide
        path: list[Place] = [walks.start]
        places: Numbers = walks.around
        further: Iterator[tuple[list[Place], Numbers]] | None = None
        walks.leave(legs)
        while True:
            walks.look(path, places)
            while True:
                walk: Swath | None = walks.next(min(left, self.left), refusing)
                left -= walks.tried
                self.left -= walks.tried
                if walk is None:
                    break
                movers.move(walks.person, walk)
                if self._clear(count, walks.retreat(), depth + 1, walks.hit):
                    return True
                movers.keep(count)
            if left <= 0 or self.left <= 0:
                break
            if further is None:
                further = walks.ahead(course)
            following = next(further, None)
            if following is None:
                break
            path, places = following
        self.refusing[walks.person] = self.left > 0
        return False
