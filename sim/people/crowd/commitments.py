"""Committed motions of all people and vehicles on a floor, in one table."""

from __future__ import annotations

import math
from collections.abc import Container, MutableSequence, Sequence
from typing import NamedTuple, overload

from floorplan import Point
from navigation.kernels.committed import CommittedMotions
from navigation.kernels.discs import Swath
from navigation.kernels.numbers import numbers

from .parameters import PARAMETERS
from .traveller import Traveller

GAP = PARAMETERS.gap


class Hit(NamedTuple):
    """First conflict of a motion: time (s), the other person, and whether they are at rest then."""

    t: float
    other: Traveller
    at_rest: bool


class Commitments(CommittedMotions):
    """Table of committed motions, one row for each person and each disc of a vehicle.

    A decision compares bounds with all rows, some nanoseconds each, and looks only at the motions
    of people within them.
    """

    def __init__(self) -> None:
        super().__init__(GAP)
        self.people: list[Traveller] = []
        self.indices: dict[Traveller, int] = {}
        self.rest_times: list[float] = []
        """Time from which each row is at rest, s."""

    def put(self, who: Traveller) -> None:
        """Replace the motion of a person by the one that the body follows."""
        swath = who.swath
        k = self.indices.get(who)
        if k is None:
            self.indices[who] = len(self.people)
            self.people.append(who)
            # People step aside for vehicles in time, so later meetings do not count.
            self.add(swath, who.radius, PARAMETERS.stays if who.is_vehicle else math.inf)
            self.rest_times.append(swath.rests)
        else:
            self.change(k, swath)
            self.rest_times[k] = swath.rests

    def take_away(self, who: Traveller) -> None:
        """Remove a person from the floor, and keep the row."""
        k = self.indices.get(who)
        if k is not None and self.is_there(who):
            # Bounds that overlap with none.
            box = numbers((math.inf, math.inf, -math.inf, -math.inf))
            self.change(k, Swath(self.tables[k], box))

    def is_there(self, who: Traveller) -> bool:
        """Return whether a person or a disc of a vehicle has not been taken away."""
        return self.boxes[4 * self.indices[who]] < math.inf

    def set_goal(self, who: Traveller, goal: Point | None, route: list[Point]) -> None:
        """Set the goal and the route of a person, or clear them."""
        who.goal, who.route = goal, route
        if route:
            who.routed_from = who.body.at
        x, y = route[0] if route else (math.inf, math.inf)
        self.send(self.indices[who], goal is not None, x, y)

    def cosine_between(self, one: Traveller, other: Traveller, t: float) -> float:
        """Return the cosine between the directions of two people at `t` (s); 0 if one rests."""
        return self.between(self.indices[one], self.indices[other], t)

    def hit(self, k: int, t: float) -> Hit:
        """Return the conflict with row `k` at `t` (s)."""
        return Hit(t, self.people[k], t >= self.rest_times[k])

    def others(self, me: Traveller, box: MutableSequence[float], now: float) -> Others:
        """Return the others who may come near the bounds of a motion from now on."""
        near = self.near(box, me.radius + me.manners.comfort, self.indices[me])
        return Others(self, me, near, now)

    def only(self, me: Traveller, other: Traveller, now: float) -> Others:
        """Return one other person."""
        return Others(self, me, [self.indices[other]], now)


class Others(Sequence[Traveller]):
    """People whom one person may meet, in the order of their rows `near` (indices)."""

    def __init__(self, table: Commitments, me: Traveller, near: list[int], now: float) -> None:
        self.table = table
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
        people = self.table.people
        if isinstance(index, slice):
            return [people[k] for k in self.near[index]]
        return people[self.near[index]]

    def of(self, some: Container[Traveller]) -> Others:
        """Return the people of this sequence who are among `some`."""
        people = self.table.people
        return Others(self.table, self._me, [k for k in self.near if people[k] in some], self._now)

    def first_hit(self, ahead: Swath) -> Hit | None:
        """Return the first conflict of a motion of the person from now on.

        Two bodies keep the gap. Bodies that are closer already must not come closer.
        """
        index, t = self.table.first_met(self.near, ahead, self._own, self._now)
        return None if index < 0 else self.table.hit(index, t)

    def free(self, ahead: Swath) -> bool:
        """Return whether a motion of the person from now on has no conflict."""
        return self.table.free(self.near, ahead, self._own, self._now)
