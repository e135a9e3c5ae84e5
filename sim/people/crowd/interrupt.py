"""Interruptions: motions that change because a place closes, or a recorded person comes."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

import numpy as np

from floorplan import Point
from navigation import Motion, join, stop_walking
from navigation.kernels.discs import Swath
from navigation.walking import first_conflict, motion_along, swath

from ...core.events import GaveWay
from ...core.stage import Stage
from .commitments import GAP, Commitments
from .ground import Ground
from .make_room import Request
from .parameters import PARAMETERS
from .traveller import Traveller

Drafts = dict[Traveller, tuple[Motion, Swath]]
"""Motion of each person, and its swath."""


class Commit(Protocol):
    """Callback that commits a person to a motion that was found free."""

    def __call__(self, me: Traveller, motion: Motion, ahead: Swath) -> None:
        """Commit `me` to `motion`, with the swath `ahead`."""
        ...


class Interruptions:
    """Changes of motion that people do not decide on themselves.

    `decide(me)` makes a person decide again.
    """

    def __init__(
        self,
        stage: Stage,
        commitments: Commitments,
        ground_of: Callable[[Traveller], Ground],
        decide: Callable[[Traveller], None],
        commit: Commit,
    ) -> None:
        self._stage = stage
        self._clock = stage.clock
        self._commitments = commitments
        self._ground_of = ground_of
        self._decide = decide
        self._commit = commit

    def make_way_for(self, me: Traveller) -> None:
        """Make people in the way of a recorded person decide again or step aside."""
        now, ahead = self._clock.now, me.swath

        def in_the_way(other: Traveller) -> bool:
            return not self._commitments.only(me, other, now).free(ahead)

        others = self._commitments.others(me, ahead.box, now)
        for other in others:
            if other.goal is not None and in_the_way(other):
                self._decide(other)
        if not any(map(in_the_way, others)):
            return
        request = Request(me, now, self._commitments, self._ground_of)
        request.make_way(course_of(me, now))
        for who, draft in request.drafts.items():
            if who is not me:
                self._stage.record(GaveWay(person=who.name, to=me.name))
                self._commit(who, motion_along(draft, who.body.state.position[2]), draft)

    def halt(self, me: Traveller, is_clear: Callable[[Motion], bool]) -> None:
        """Stop before a closed place. See `Crowd.halt`."""
        now, motion = self._clock.now, me.body.motion
        t = now
        while t < motion.end:
            stop = self.stop(me, t)
            if t > now and not is_clear(stop):
                break
            drafts = self.all_stop(me, stop)
            if drafts is not None:
                for who, (slower, ahead) in drafts.items():
                    self._commit(who, slower, ahead)
                return
            t += PARAMETERS.clear_time
        me.body.follow(self.braking(me))

    def stop(self, me: Traveller, t: float) -> Motion:
        """Return the motion of a person who continues until `t` (s), and then stops."""
        now, motion = self._clock.now, me.body.motion
        stop = stop_walking(motion, t, max_acceleration=me.human.max_acceleration)
        return join([motion.cut(now, t), stop]) if t > now else stop

    def all_stop(
        self, me: Traveller, stop: Motion, *, among_vehicles: bool = False
    ) -> Drafts | None:
        """Return the stops of `me` and of all people in its way, or None if one cannot stop.

        `among_vehicles`, they may stop in the way of a vehicle, and step aside later.
        """
        now = self._clock.now
        drafts = {me: (stop, swath(stop, now))}
        left = [me]
        while left:
            person = left.pop()
            mine = drafts[person][1]
            for other in self._commitments.others(person, mine.box, now):
                if among_vehicles and other.is_vehicle:
                    continue
                drafted = drafts.get(other)
                theirs = other.swath if drafted is None else drafted[1]
                if meeting(person, mine, other, theirs, now) is None:
                    continue
                if drafted is not None or other.recorded or other.body.motion.end <= now:
                    return None
                slower = self.stop(other, now)
                drafts[other] = (slower, swath(slower, now))
                left.append(other)
        return drafts

    def braking(self, me: Traveller, *, alone: bool = False) -> Motion:
        """Return the earliest stop on the person's own course that is free."""
        now, motion = self._clock.now, me.body.motion
        if alone:
            return stop_walking(motion, now, max_acceleration=me.human.max_acceleration)
        others = self._commitments.others(me, me.swath.box, now)
        t = now
        while t < motion.end:
            stop = self.stop(me, t)
            # An immediate stop may conflict with another motion. A later stop on the committed
            # motion does not, or its end.
            if others.free(swath(stop, now)):
                return stop
            t += PARAMETERS.early
        return motion


def course_of(who: Traveller, now: float) -> list[Point]:
    """Return positions along the committed motion from `now` (s) on."""
    motion = who.body.motion
    steps = math.ceil((motion.end - now) / PARAMETERS.foresees)
    places = motion.position(now + np.arange(steps + 1) * PARAMETERS.foresees)
    return [*map(tuple, places.tolist())]


def meeting(
    me: Traveller, mine: Swath, other: Traveller, theirs: Swath, now: float
) -> float | None:
    """Return the first conflict of two drafts of two people (s), or None."""
    least = me.radius + other.radius + GAP
    apart = math.dist(me.body.motion.state(now).at, other.body.motion.state(now).at)
    return first_conflict(mine, theirs, min(least, apart - 1e-9), now)
