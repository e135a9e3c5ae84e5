"""Whereabouts: what all people on a floor have committed themselves to, in tables side by side."""

from __future__ import annotations

import math
from collections.abc import Container, MutableSequence, Sequence
from typing import NamedTuple, overload

from floorplan import Point
from navigation.kernels.discs import first_met
from navigation.kernels.numbers import numbers
from navigation.kernels.throng import Throng
from navigation.walking import Swath

from .traveller import Traveller

GAP = 0.006
"""Metres. Kept between two bodies in any case, so that rounding can't let them touch."""


class Hit(NamedTuple):
    """The first conflict of a motion: when (seconds), with whom, and whether they stand by then."""

    t: float
    other: Traveller
    at_rest: bool


class Whereabouts:
    """The people on a floor, in the order in which they came: where they go, and its bounds.

    Whoever decides passes over the bounds of all others, some nanoseconds each, and looks at those
    alone who may come near.
    """

    def __init__(self) -> None:
        self.people: list[Traveller] = []
        self.throng = throng = Throng(GAP)
        self.tables, self.boxes, self.radii = throng.tables, throng.boxes, throng.radii
        self.rests: list[float] = []
        self.indices: dict[Traveller, int] = {}

    def put(self, who: Traveller) -> None:
        """Take note of what somebody has committed themselves to."""
        table, rests, box = who.swath
        k = self.indices.get(who)
        if k is None:
            self.indices[who] = len(self.people)
            self.people.append(who)
            self.throng.add(table, box, who.radius)
            self.rests.append(rests)
        else:
            self.throng.commit(k, table, box)
            self.rests[k] = rests

    def take_away(self, who: Traveller) -> None:
        """Take note that somebody is in nobody's way for now."""
        k = self.indices.get(who)
        if k is not None and self.boxes[4 * k] < math.inf:
            # Bounds that nothing comes into; the row stays, as indices are kept.
            box = numbers((math.inf, math.inf, -math.inf, -math.inf))
            self.throng.commit(k, self.tables[k], box)

    def send(self, who: Traveller, goal: Point | None, route: list[Point]) -> None:
        """Let somebody be bound for a goal, by a route, or for none."""
        who.goal, who.route = goal, route
        x, y = route[0] if route else (math.inf, math.inf)
        self.throng.send(self.indices[who], goal is not None, x, y)

    def cosine(self, one: Traveller, other: Traveller, t: float) -> float:
        """Return the cosine between where two walk at `t` (seconds), or would walk on.

        0 if either rests.
        """
        return self.throng.between(self.indices[one], self.indices[other], t)

    def hit(self, k: int, t: float) -> Hit:
        """Return the conflict with the k-th at `t` (seconds)."""
        return Hit(t, self.people[k], t >= self.rests[k])

    def others(self, me: Traveller, box: MutableSequence[float], now: float) -> Others:
        """Return the others who may come near bounds that somebody moves in from now on."""
        near = self.throng.near(box, me.radius + me.manners.comfort, self.indices[me])
        return Others(self, me, near, now)

    def only(self, me: Traveller, other: Traveller, now: float) -> Others:
        """Return one other, as somebody may meet them."""
        return Others(self, me, [self.indices[other]], now)


class Others(Sequence[Traveller]):
    """People that somebody may meet, with what they have committed themselves to.

    In the order in which they came: those `near` (indices) of all who are on the `floor`.
    """

    def __init__(self, floor: Whereabouts, me: Traveller, near: list[int], now: float) -> None:
        self.floor = floor
        self._me = me
        self.near = near
        self._now = now
        self._own = me.radius + GAP

    def __len__(self) -> int:
        return len(self.near)

    @overload
    def __getitem__(self, index: int) -> Traveller: ...

    @overload
    def __getitem__(self, index: slice) -> Sequence[Traveller]: ...

    def __getitem__(self, index: int | slice) -> Traveller | Sequence[Traveller]:
        people = self.floor.people
        if isinstance(index, slice):
            return [people[k] for k in self.near[index]]
        return people[self.near[index]]

    def without(self, some: Container[Traveller]) -> Others:
        """Return these without some of them."""
        people = self.floor.people
        near = [k for k in self.near if people[k] not in some]
        return Others(self.floor, self._me, near, self._now)

    def of(self, some: Container[Traveller]) -> Others:
        """Return those of these who are among some."""
        people = self.floor.people
        return Others(self.floor, self._me, [k for k in self.near if people[k] in some], self._now)

    def first_hit(self, ahead: Swath) -> Hit | None:
        """Return the first conflict of a motion of theirs from now on with any of these.

        Two bodies keep `GAP` between them; those who are closer already come no closer.
        """
        when = numbers((math.inf,))
        found = self._first_met(ahead, when)
        return None if found < 0 else self.floor.hit(found, when[0])

    def free(self, ahead: Swath) -> bool:
        """Return whether a motion of theirs from now on conflicts with none of these."""
        return self._first_met(ahead, numbers((math.inf,))) < 0

    def _first_met(self, ahead: Swath, when: MutableSequence[float]) -> int:
        floor = self.floor
        found: int = first_met(
            ahead.table,
            ahead.box,
            self.near,
            floor.tables,
            floor.boxes,
            floor.radii,
            self._own,
            self._now,
            when,
        )
        return found
