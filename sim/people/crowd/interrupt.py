"""Interruptions: motions that change because a place closes, or a vehicle comes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Protocol

import numpy as np

from floorplan import Point
from navigation import Motion, join, stop_walking
from navigation.kernels.discs import Swath
from navigation.walking import first_conflict, motion_along, swath

from ...core.clock import Alarm, Turn
from ...core.events import GaveWay
from ...core.stage import Stage
from .commitments import GAP, Commitments, Others
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

    `people` are all people of the crowd, `decide(me)` lets a person decide again.
    """

    def __init__(
        self,
        stage: Stage,
        commitments: Commitments,
        people: Mapping[Traveller, None],
        ground_of: Callable[[Traveller], Ground],
        decide: Callable[[Traveller], None],
        commit: Commit,
    ) -> None:
        self._stage = stage
        self._clock = stage.clock
        self._commitments = commitments
        self._people = people
        self._ground_of = ground_of
        self._decide = decide
        self._commit = commit
        self._coming: dict[Traveller, None] = {}
        """Discs of vehicles that have just changed their motion."""
        self._avoiding = Alarm(stage.clock, self._avoid_vehicles, Turn.MOTION_ENDS)

    def make_way_for(self, me: Traveller) -> None:
        """Let people in the way of a recorded person decide again or step aside."""
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
        request.make_way(_course_of(me, now))
        for who, draft in request.drafts.items():
            if who is not me:
                self._stage.record(GaveWay(person=who.name, to=me.name))
                self._commit(who, motion_along(draft, who.body.state.position[2]), draft)

    def notice(self, discs: Sequence[Traveller]) -> None:
        """Schedule the reaction to a vehicle that has changed its motion."""
        if self._people:
            if len(self._people) == 1:
                for me in self._people:
                    self._commitments.put(me)
            self._coming.update(dict.fromkeys(discs))
            self._avoiding.set(self._clock.now)

    def _avoid_vehicles(self) -> None:
        """Let people in the way of a vehicle decide again, brake, or step off its course."""
        now, coming = self._clock.now, [*self._coming]
        self._coming.clear()

        def is_in_the_way(me: Traveller) -> bool:
            near = self._commitments.others(me, me.swath.box, now).of(coming)
            return not near.free(me.swath)

        for me in self._people:
            if me.recorded or not is_in_the_way(me):
                continue
            if me.body.motion.end <= now:
                self._step_off(me, coming)
                continue
            self._decide(me)
            if is_in_the_way(me):
                braking = self.braking(me)
                if braking is not me.body.motion:
                    self._commit(me, braking, swath(braking, now))
                else:
                    self._stop_in_the_way(me, coming)

    def _stop_in_the_way(self, me: Traveller, coming: Sequence[Traveller]) -> None:
        """Stop a person in the way of a vehicle, who then steps off its course."""
        now = self._clock.now
        stop = self._stop(me, now)
        ahead = swath(stop, now)
        if not self._commitments.others(me, ahead.box, now).without(coming).free(ahead):
            drafts = self._all_stop(me, stop, among_vehicles=True)
            if drafts is None:
                stop = self._latest_met(me)
                ahead = swath(stop, now)
            else:
                del drafts[me]
                self._commit_all(drafts)
        if stop is not me.body.motion:
            self._commit(me, stop, ahead)
            me.deciding.set(stop.end + PARAMETERS.early)
            steps = partial(self._step_off, me, coming)
            self._clock.call_at(max(stop.end, now), steps, Turn.MOTION_ENDS)

    def _latest_met(self, me: Traveller) -> Motion:
        """Return the motion or stop of a person between vehicles which these meet latest."""
        now, motion = self._clock.now, me.body.motion
        others = self._commitments.others(me, me.swath.box, now)
        people = others.without([one for one in others if one.is_vehicle])
        best, latest = motion, _met_at(others, me.swath)
        t = now
        while t < motion.end:
            stop = self._stop(me, t)
            ahead = swath(stop, now)
            if _met_at(others, ahead) > latest and people.free(ahead):
                best, latest = stop, _met_at(others, ahead)
            t += PARAMETERS.early
        return best

    def _step_off(self, me: Traveller, coming: Sequence[Traveller]) -> None:
        """Let a stationary person step off the course of a vehicle, if possible."""
        now = self._clock.now
        if me.body.motion.end > now:
            return
        for disc in coming:
            if self._commitments.only(me, disc, now).free(me.swath):
                continue
            request = Request(disc, now, self._commitments, self._ground_of)
            request.make_way(_course_of(disc, now))
            if me in request.drafts:
                for who, draft in request.drafts.items():
                    if not who.is_vehicle:
                        self._commit(who, motion_along(draft, who.body.state.position[2]), draft)
                return

    def halt(self, me: Traveller, is_clear: Callable[[Motion], bool]) -> None:
        """Stop before a closed place. See `Crowd.halt`."""
        now, motion = self._clock.now, me.body.motion
        t = now
        while t < motion.end:
            stop = self._stop(me, t)
            if t > now and not is_clear(stop):
                break
            drafts = self._all_stop(me, stop)
            if drafts is not None:
                self._commit_all(drafts)
                return
            t += PARAMETERS.clear_time
        me.body.follow(self.braking(me))

    def _stop(self, me: Traveller, t: float) -> Motion:
        """Return the motion of a person who continues until `t` (s), and then stops."""
        now, motion = self._clock.now, me.body.motion
        stop = stop_walking(motion, t, max_acceleration=me.human.max_acceleration)
        return join([motion.cut(now, t), stop]) if t > now else stop

    def _commit_all(self, drafts: Drafts) -> None:
        """Commit people to their stops."""
        for who, (stop, ahead) in drafts.items():
            self._commit(who, stop, ahead)

    def _all_stop(
        self, me: Traveller, stop: Motion, *, among_vehicles: bool = False
    ) -> Drafts | None:
        """Return the stops of `me` and of all people in its way, or None if one cannot stop.

        `among_vehicles`, they may stand in the way of a vehicle, and step off it later.
        """
        now = self._clock.now
        drafts = {me: (stop, swath(stop, now))}
        left = [me]
        while left:
            one = left.pop()
            mine = drafts[one][1]
            for other in self._commitments.others(one, mine.box, now):
                if among_vehicles and other.is_vehicle:
                    continue
                known = drafts.get(other)
                theirs = other.swath if known is None else known[1]
                if not conflict(one, mine, other, theirs, now):
                    continue
                if known is not None or other.recorded or other.body.motion.end <= now:
                    return None
                slower = self._stop(other, now)
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
            stop = self._stop(me, t)
            # An immediate stop may be in the way of another motion. The committed motion is free,
            # so a later stop on it is found, or its end.
            if others.free(swath(stop, now)):
                return stop
            t += PARAMETERS.early
        return motion


def _met_at(others: Others, ahead: Swath) -> float:
    """Return when the first of some others is met (s), or infinity."""
    hit = others.first_hit(ahead)
    return math.inf if hit is None else hit.t


def _course_of(who: Traveller, now: float) -> list[Point]:
    """Return positions along the committed motion from `now` (s) on."""
    motion = who.body.motion
    steps = math.ceil((motion.end - now) / PARAMETERS.foresees)
    places = motion.position(now + np.arange(steps + 1) * PARAMETERS.foresees)
    return [*map(tuple, places.tolist())]


def conflict(me: Traveller, mine: Swath, other: Traveller, theirs: Swath, now: float) -> bool:
    """Return whether two drafts of two people conflict."""
    least = me.radius + other.radius + GAP
    apart = math.dist(me.body.motion.state(now).at, other.body.motion.state(now).at)
    return first_conflict(mine, theirs, min(least, apart - 1e-9), now) is not None
