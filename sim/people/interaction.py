"""Interaction with another person: letting pass, following, walking together, approaching."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from typing import NamedTuple

from floorplan import Point
from floorplan.files.problems import suggestion
from navigation import Approaching, PlanningError, first_time

from ..core.clock import Alarm, Turn
from ..core.events import WalksWith
from ..core.stage import Stage
from .crowd.crowd import Crowd
from .crowd.traveller import Traveller
from .errand import Errand
from .walker import Walker

AT_LEAST = 0.5
"""Minimum time between two changes of course for another person, and of letting pass (s)."""

BETWEEN = 0.4
"""Distance between the bodies of two people who walk together (m)."""

TALKING = 0.7
"""Distance between the bodies after an approach (m), within Hall's personal space of 1.2 m from
centre to centre."""

BEHIND = 0.6
"""Distance between the bodies of a person and a follower (m)."""

NEARLY = 0.3
"""Metres. Smaller changes of the target place do not change the course."""

SLOTS = ((0.0, -1.0), (0.0, 1.0), (-1.0, -0.5), (-1.0, 0.5))
"""Places of companions: rows ahead, and places to the left. Up to three people walk abreast, as
groups do if there is room (M. Moussaïd et al., "The walking behaviour of pedestrian
social groups and its impact on crowd dynamics", PLoS ONE 5, 2010)."""

Aim = Callable[[Traveller], Point | None]


class NobodyError(LookupError):
    """Error for the name of an unknown person."""


class _Passing(NamedTuple):
    """Person let pass, the goal afterwards, and the earliest and latest time to continue (s)."""

    other: Traveller
    goal: Point
    earliest: float
    latest: float


class Interaction:
    """Interaction of a person with another one, until the next action.

    `slot` is the place of the person in a group, or None outside groups.
    """

    def __init__(
        self,
        stage: Stage,
        walker: Walker,
        errand: Errand,
        crowd: Crowd,
        slot: int | None = None,
    ) -> None:
        self._stage = stage
        self._clock = stage.clock
        self._walker = walker
        self._errand = errand
        self._crowd = crowd
        self._slot = slot
        self._other: Traveller | None = None
        self._aim: Aim | None = None
        self._watched: set[Traveller] = set()
        self._moved_at = -math.inf
        self._passing: _Passing | None = None
        self._turning = Alarm(stage.clock, self._turn, Turn.NOTICE)
        self._going_on = Alarm(stage.clock, self._go_on, Turn.NOTICE)

    def find(self, who: str) -> Traveller | None:
        """Return the other person called `who`, or None while that person is not on the floor.

        Raises `NobodyError` if there is no such person.
        """
        others = [one for one in self._stage.people if one.body is not self._walker.body]
        if not any(one.name == who for one in others):
            hint = (
                suggestion(who, [one.name for one in others])
                if others
                else "there are no other people"
            )
            raise NobodyError(f"no other person is called {who!r}; {hint}")
        other = self._crowd.find(who)
        return None if other is None or self._is_away(other) else other

    def _is_away(self, other: Traveller) -> bool:
        return any(one.away for one in self._stage.people if one.body is other.body)

    def give_up(self) -> None:
        """End the interaction."""
        if self._other is None and self._passing is None:
            return
        self._other = self._aim = self._passing = None
        self._errand.escorts = None
        self._turning.set(None)
        self._going_on.set(None)

    def let_pass(self, other: Traveller) -> bool:
        """Stop until `other` no longer approaches, at most for the patience of the person.

        A person without a goal stays.
        """
        goal = self._errand.interrupt()
        if goal is None:
            return True
        now = self._clock.now
        patience = self._walker.traveller.manners.patience
        self._passing = _Passing(other, goal, now + AT_LEAST, now + max(patience, AT_LEAST))
        self._watch(other)
        self._wait_for_passing()
        return True

    def follow(self, other: Traveller) -> bool:
        """Walk behind `other` from now on."""
        return self._attend(other, self._behind)

    def walk_with(self, other: Traveller) -> bool:
        """Walk beside `other` from now on, or behind them where there is no room."""
        if not self._attend(other, self._beside):
            return False
        self._stage.record(WalksWith(person=self._walker.body.name, other=other.name))
        return True

    def approach(self, other: Traveller) -> bool:
        """Walk up to `other`. The arrival counts when `other` is stationary."""
        return self._attend(other, self._up_to)

    # Letting another person pass

    def _wait_for_passing(self) -> None:
        if self._passing is None:
            return
        other, _, earliest, latest = self._passing
        mine, theirs = self._walker.body.motion, other.body.motion
        begin = max(self._clock.now, earliest)
        passed = first_time(~Approaching(), mine, theirs, begin, max(begin, theirs.end))
        self._going_on.set(max(begin, min(latest, latest if passed is None else passed)))

    def _go_on(self) -> None:
        if self._passing is not None:
            goal, self._passing = self._passing.goal, None
            self._errand.go_on(goal)

    # Walking with or to another person

    def _attend(self, other: Traveller, aim: Aim) -> bool:
        self._other, self._aim = other, aim
        self._errand.escorts = self._has_caught_up
        self._watch(other)
        self._moved_at = self._clock.now
        place = aim(other)
        if place is None or not self._errand.go(place):
            self.give_up()
            return False
        return True

    def _watch(self, other: Traveller) -> None:
        if other not in self._watched:
            self._watched.add(other)
            other.body.on_change.append(lambda: self._changed(other))

    def _changed(self, other: Traveller) -> None:
        """Schedule the reaction to a change of course of `other`."""
        if self._passing is not None and other is self._passing.other:
            self._wait_for_passing()
        if other is self._other and self._is_away(other):
            self.give_up()
            self._walker.stop()
        elif other is self._other:
            before = max(self._moved_at, self._walker.traveller.decided)
            self._turning.set(max(self._clock.now, before + AT_LEAST))

    def _has_caught_up(self) -> bool:
        """Return whether an arrival ends the interaction: beside a stationary person."""
        other = self._other
        if other is None or self._aim != self._up_to:
            return other is None
        apart = math.dist(self._walker.body.at, other.body.at)
        if other.body.state.speed == 0.0 and apart < self._reach(other, TALKING) + NEARLY:
            self.give_up()
            return True
        self._turning.set(max(self._clock.now + AT_LEAST, other.body.motion.end))
        return False

    def _turn(self) -> None:
        """Follow a change of course of the other person."""
        other, aim = self._other, self._aim
        if other is None or aim is None or self._passing is not None:
            return
        self._moved_at = self._clock.now
        place, bound = aim(other), self._walker.goal
        if place is None:
            return
        if math.dist(place, bound or self._walker.body.at) > NEARLY:
            self._stage.place_machines()
            with suppress(PlanningError):
                self._walker.go(place)
        elif bound is None:
            rests = self._walker.body.motion.end
            if rests > self._clock.now:  # a person who gives way arrives on stopping
                self._turning.set(rests)
            elif self._has_caught_up():
                self._errand.arrived(self._walker.body.at)

    # Places relative to another person

    def _reach(self, other: Traveller, between: float) -> float:
        return self._walker.human.radius + other.radius + between

    def _behind(self, other: Traveller) -> Point | None:
        return self._place(other, -self._reach(other, BEHIND), 0.0)

    def _beside(self, other: Traveller) -> Point | None:
        step = self._reach(other, BETWEEN)
        slot = self._slot
        if slot is None:
            (x, y), (ox, oy), heading = self._walker.body.at, *_bound(other)
            left = (y - oy) * math.cos(heading) - (x - ox) * math.sin(heading)
            slot = 1 if left > 0 else 0
        ahead, left = SLOTS[slot % len(SLOTS)]
        row = -(slot + 1) * step
        return self._place(other, ahead * step, left * step, row)

    def _up_to(self, other: Traveller) -> Point | None:
        (x, y), (ox, oy), heading = self._walker.body.at, *_bound(other)
        away, reach = math.dist((x, y), (ox, oy)), self._reach(other, TALKING)
        if away <= reach:
            return (x, y)
        c, s = ((x - ox) / away, (y - oy) / away)
        ahead = reach * (c * math.cos(heading) + s * math.sin(heading))
        left = reach * (s * math.cos(heading) - c * math.sin(heading))
        return self._place(other, ahead, left)

    def _place(
        self, other: Traveller, ahead: float, left: float, row: float | None = None
    ) -> Point | None:
        """Return the place `ahead` and to the `left` (m) of the position where `other` will stop.

        If a wall is between them, return the place on the path behind `other` (`row`, m), or the
        nearest free place.
        """
        (x, y), heading = _bound(other)
        c, s = math.cos(heading), math.sin(heading)
        world, radius = self._walker.world, self._walker.human.radius
        for along, beside in ((ahead, left), *(() if row is None else ((row, 0.0),))):
            at = (x + along * c - beside * s, y + along * s + beside * c)
            if world.segment_free((x, y), at, radius):
                return at
        return world.nearest_free((x, y), radius)


def _bound(other: Traveller) -> tuple[Point, float]:
    """Return the position and heading (rad) at the end of the current motion of a person."""
    motion = other.body.motion
    state = motion.state(motion.end)
    return state.at, state.position[2]
