"""Bends that may be visible from a place, found without looking at all of them.

On a big floor almost everything is hidden by nearer obstacles. So each narrow wedge of directions
is searched nearby first, and farther only where that leaves a gap. The result is a little more
than what is visible, never less; each line of it is then checked on its own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from .corners import Bends, Floats

Ints = NDArray[np.intp]

_BINS = 24
"""Number of bins of a wedge, each hidden from some distance on."""

_EDGES = 4
"""Number of edges of a screen: an obstacle with four corners is one."""

_NEAR = 4
"""Reach of the first search, in average distances between screens."""

_ALL_AROUND = 24
"""Number of wedges around a place that has no direction."""

_ROUNDING = 1e-7
"""Radians. Wedges are this much wider, lest a bend on an edge be missed."""


@dataclass(frozen=True)
class Wedges:
    """W wedges of directions, each from a place of its own.

    `source` (W,) is the number of what one looks from; `place` (W, 2) metres; `middle` (W,) the
    direction in radians; `half` (W,) half the angle between the sides, in radians.
    """

    source: Ints
    place: Floats
    middle: Floats
    half: Floats

    def __len__(self) -> int:
        return len(self.source)

    def take(self, keep: Ints | NDArray[np.bool_]) -> Wedges:
        """Those of the wedges that are marked in `keep` (W,), or that it has the numbers of."""
        return Wedges(self.source[keep], self.place[keep], self.middle[keep], self.half[keep])

    def halves(self) -> Wedges:
        """Return each of the wedges as two of half the angle."""
        return Wedges(
            np.tile(self.source, 2),
            np.tile(self.place, (2, 1)),
            np.concatenate([self.middle - self.half / 2, self.middle + self.half / 2]),
            np.tile(self.half / 2, 2),
        )

    def drawn(self, reach: float, margin: float) -> NDArray[np.object_]:
        """Lines whose bounds hold the wedges as far as `reach`, and `margin` around (metres)."""
        corners = [self.place]
        for side in (self.middle - self.half, self.middle, self.middle + self.half):
            along = np.column_stack([np.cos(side), np.sin(side)])
            # 1 / cos: the chord between two directions then lies outside of the arc.
            corners.append(self.place + reach / np.cos(self.half)[:, None] * along)
        around = np.stack(corners)
        ends = np.stack([around.min(axis=0) - margin, around.max(axis=0) + margin], axis=1)
        lines: NDArray[np.object_] = shapely.linestrings(ends)
        return lines


class Sight:
    """Visibility of the bends (metres) of a floor, for discs of `radius` metres.

    `edges` are the closed rings around the room there is, as (n + 1, 2) arrays in metres.
    """

    def __init__(self, edges: list[Floats], bends: Bends, radius: float) -> None:
        self._radius = radius
        corners = np.concatenate([ring[:-1] for ring in edges])
        size = corners.max(axis=0) - corners.min(axis=0)
        self._end = float(np.hypot(*size)) + radius
        spacing = math.sqrt(float(np.prod(size)) * _EDGES / len(corners))
        self._near = _NEAR * spacing
        self._screens = np.concatenate([_screens(ring, spacing) for ring in edges])
        lines = shapely.linestrings(self._screens)
        self._tree = shapely.STRtree(lines)
        low, high = self._screens.min(axis=1), self._screens.max(axis=1)
        self._centre = (low + high) / 2
        self._bends = bends.point
        beside = self._tree.nearest(shapely.points(bends.point))
        self._order = np.argsort(beside, kind="stable")
        self._count = np.bincount(beside, minlength=len(lines))
        self._first_bend = np.cumsum(self._count) - self._count
        # A circle around each screen and the bends beside it.
        self._wide = np.hypot(*((high - low) / 2).T)
        np.maximum.at(self._wide, beside, np.hypot(*(bends.point - self._centre[beside]).T))
        self._margin = float(self._wide.max())

    def around(self, places: Floats) -> tuple[Ints, Ints]:
        """Return pairs of one of `places` (N, 2) and a bend of the floor that may be visible.

        Every visible one is among them; some come twice.
        """
        return self._candidates(_all_around(places))

    def beyond(self, bends: Bends) -> tuple[Ints, Ints]:
        """Return pairs of one of `bends` and a bend of the floor that a path may go on to.

        Every visible one that such a path grazes the first corner to get to is among them; some
        come twice.
        """
        return self._candidates(_onward(bends))

    def _candidates(self, wedges: Wedges) -> tuple[Ints, Ints]:
        """Return pairs of the source of a wedge and a bend that may be visible in it."""
        found = []
        reach = self._near
        while len(wedges):
            of, screen = self._screens_in(wedges, reach)
            hidden = self._hidden(wedges, of, screen)
            # All bins are hidden from within what was searched: nothing farther off can be seen.
            done = (hidden.max(axis=1) <= reach) | (reach >= self._end)
            kept = done[of]
            found.append(self._in_front(wedges, hidden, of[kept], screen[kept]))
            # A gap is narrow: half the wedge, twice the reach, so that about as much is looked at
            # again.
            wedges = wedges.take(~done).halves()
            reach *= 2
        source, bend = np.concatenate(found, axis=1)
        return source, bend

    def _screens_in(self, wedges: Wedges, reach: float) -> tuple[Ints, Ints]:
        """Pairs of a wedge and a screen that it or its bends may reach into, `reach` metres far."""
        of, screen = self._tree.query(wedges.drawn(reach, self._margin))
        away = self._centre[screen] - wedges.place[of]
        distance, wide = np.hypot(away[:, 0], away[:, 1]), self._wide[screen]
        # The angle under which half of the screen's circle is seen; from inside it is everywhere.
        beside = np.arcsin(np.minimum(wide / np.maximum(distance, 1e-9), 1.0))
        beside[distance <= wide] = math.pi
        turned = np.abs(_turned(away, wedges.middle[of]))
        there = (distance <= reach + wide) & (turned <= wedges.half[of] + beside + _ROUNDING)
        return of[there], screen[there]

    def _hidden(self, wedges: Wedges, of: Ints, screen: Ints) -> Floats:
        """Return the distances (metres) beyond which screens hide everything: (W, bins)."""
        low, high, far = self._cover(wedges.take(of), self._screens[screen])
        bins = np.arange(_BINS)
        # Only bins that a screen hides from border to border: fewer than it does, never more.
        pair, place = np.nonzero((low[:, None] <= bins) & (bins + 1 <= high[:, None]))
        hidden = np.full((len(wedges), _BINS), self._end)
        np.minimum.at(hidden, (of[pair], place), far[pair])
        return hidden

    def _in_front(
        self, wedges: Wedges, hidden: Floats, of: Ints, screen: Ints
    ) -> tuple[Ints, Ints]:
        """Return pairs of the source of a wedge and a bend in it before all is hidden."""
        count = self._count[screen]
        pair = np.repeat(np.arange(len(of)), count)
        place = np.arange(len(pair)) - np.repeat(np.cumsum(count) - count, count)
        of, to = of[pair], self._order[self._first_bend[screen[pair]] + place]
        away = self._bends[to] - wedges.place[of]
        at = _bins(wedges.half[of], _turned(away, wedges.middle[of]))
        low, high = np.floor(at).astype(int), np.ceil(at).astype(int) - 1
        inside = (high >= 0) & (low < _BINS)
        of, to, away, low, high = of[inside], to[inside], away[inside], low[inside], high[inside]
        # On the border of two bins a bend may be seen beside either.
        reach = np.maximum(hidden[of, np.maximum(low, 0)], hidden[of, np.minimum(high, _BINS - 1)])
        near = np.hypot(away[:, 0], away[:, 1]) <= reach
        return wedges.source[of[near]], to[near]

    def _cover(self, wedges: Wedges, screens: Floats) -> tuple[Floats, Floats, Floats]:
        """The range of bins that screens grown by the radius hide, and from what distance on.

        One of `screens` (W, n, 2) for each wedge. A screen is connected: a straight line in any
        direction between its ends meets it.
        """
        away = screens - wedges.place[:, None]
        here, there = away[:, :-1], away[:, 1:]
        cross = here[..., 0] * there[..., 1] - here[..., 1] * there[..., 0]
        turns = np.arctan2(cross, (here * there).sum(axis=2))
        angle = _turned(away[:, 0], wedges.middle)[:, None] + np.column_stack(
            [np.zeros(len(turns)), np.cumsum(turns, axis=1)]
        )
        distance = np.hypot(away[..., 0], away[..., 1])
        # A disc's centre can't pass a point nearer than its radius: each end of a screen hides this
        # angle more, and the whole is behind its farthest end.
        beside = np.arcsin(self._radius / np.maximum(distance, self._radius))
        low, high = (angle - beside).min(axis=1), (angle + beside).max(axis=1)
        far = distance.max(axis=1) + self._radius
        return _bins(wedges.half, low), _bins(wedges.half, high), far


def _screens(ring: Floats, longest: float) -> Floats:
    """Return a closed `ring` ((n + 1, 2) metres) in lines of a few edges: (m, k, 2).

    No edge is longer than `longest` metres. The last line goes on over the first edges.
    """
    points = shapely.get_coordinates(shapely.segmentize(shapely.linestrings(ring), longest))
    count = len(points) - 1
    starts = np.arange(0, count, _EDGES)
    screens: Floats = points[(starts[:, None] + np.arange(_EDGES + 1)) % count]
    return screens


def _bins(half: Floats, angle: Floats) -> Floats:
    """Return the place in a wedge, in bins, of an angle from its middle (radians)."""
    wide = half + _ROUNDING
    place: Floats = (angle + wide) * _BINS / (2 * wide)
    return place


def _turned(away: Floats, middle: Floats) -> Floats:
    """Return the angles between `away` (N, 2) and the directions `middle` (N,), from -π to π."""
    angle: Floats = np.arctan2(away[:, 1], away[:, 0]) - middle
    return np.remainder(angle + math.pi, 2 * math.pi) - math.pi


def _all_around(places: Floats) -> Wedges:
    """All directions from each of `places`, in the same number of wedges one after another."""
    middle = np.arange(_ALL_AROUND) * 2 * math.pi / _ALL_AROUND
    return Wedges(
        np.repeat(np.arange(len(places)), _ALL_AROUND),
        np.repeat(places, _ALL_AROUND, axis=0),
        np.tile(middle, len(places)),
        np.full(_ALL_AROUND * len(places), math.pi / _ALL_AROUND),
    )


def _onward(bends: Bends) -> Wedges:
    """Return the directions in which paths go on from each of `bends`: two wedges each.

    The first is for the path that goes round the corner clockwise, the second for the other.
    """
    first = np.arctan2(bends.before[:, 1], bends.before[:, 0])
    last = np.arctan2(bends.after[:, 1], bends.after[:, 0])
    turn = np.remainder(first - last, 2 * math.pi)
    middle = first - turn / 2
    return Wedges(
        np.repeat(np.arange(len(bends)), 2),
        np.repeat(bends.point, 2, axis=0),
        np.column_stack([middle, middle + math.pi]).ravel(),
        np.repeat(turn / 2, 2),
    )
