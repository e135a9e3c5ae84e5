"""Worst-case test of a machine's motion: can it still stop, whatever people do?

Somebody of top speed v is within v t of where they were seen for t seconds, in whatever direction
they set out. A motion is safe if all along it, and along a stop from its end, the machine keeps
the distance that the law asks for from somebody of that speed, and v t in addition (speed and
separation monitoring, ISO/TS 15066:2016, clause 5.5.4). It is solved for, not sampled.
"""

# A machine that commands only motions that are safe until its next look is safe for good, by
# induction: if nothing is safe at that look, the stop that was tested with the motion is what it
# does. No forecast of people is needed but their top speed. The law's distance covers what follows
# the instant for which it is asked (the person's approach, the machine's reaction and its stop).

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from floorplan import Point
from navigation import (
    AnyLaw,
    Enclosure,
    Encounter,
    Motion,
    Odometer,
    State,
    first_violation,
    is_of_speeds,
    required_at_speeds,
    standing,
)

MARGIN = 0.01
"""Metres. Kept beyond the required distance, so that rounding can't decide."""


SLACK = 1e-6
"""Metres. More than rounding adds up to."""


class Stoppable(NamedTuple):
    """A motion, and the fastest `stop` from it at an instant (seconds)."""

    motion: Motion
    stop: Callable[[float], Motion]

    @property
    def end(self) -> float:
        """The end of the motion (seconds)."""
        return self.motion.end


class Pedestrian(NamedTuple):
    """Somebody seen at a place (x, y in metres) who walks at `top_speed` (m/s) at most."""

    name: str
    at: tuple[float, float]
    top_speed: float


@dataclass(frozen=True)
class Approach:
    """What `law` asks for if somebody walks straight at the machine at `speed` (m/s) since `since`.

    It is a law on the distance from where they stood at `since` (seconds). A law that looks ahead
    is asked for the machine's `top_speed` (m/s): it may be reached by then.
    """

    law: AnyLaw
    speed: float
    since: float
    top_speed: float

    def required(self, encounter: Encounter, begin: float, end: float) -> Enclosure:
        """See `navigation.MotionLaw`."""
        half = (end - begin) / 2
        walked = Enclosure(self.speed * (begin + half - self.since), self.speed)
        if not is_of_speeds(self.law):
            return walked + (required_at_speeds(self.law, self.speed, self.top_speed) + MARGIN)
        low, high = encounter.robot_speed(begin, end).range(half)
        least = self.law.distance(self.speed, max(low, 0.0))
        most = self.law.distance(self.speed, high)
        return walked + Enclosure.between(least, most) + MARGIN


class _Stretch(NamedTuple):
    """A motion between two instants (seconds): where it begins and ends, its top speed (m/s)."""

    motion: Motion
    begin: float
    end: float
    at_begin: Point
    at_end: State
    fastest: float

    @classmethod
    def of(cls, motion: Motion, begin: float, end: float) -> _Stretch:
        """Return a motion from `begin` to `end`."""
        fastest = Odometer(motion).speed(begin, end).range((end - begin) / 2)[1]
        return cls(motion, begin, end, motion.state(begin).at, motion.state(end), fastest)


@dataclass(frozen=True)
class Foresight:
    """The test for one machine, to which `law` applies and which is no faster than `top_speed`."""

    law: AnyLaw
    top_speed: float

    def required(self, human_speed: float, robot_speed: float) -> float:
        """Return the distance (metres) to keep from somebody at these speeds (m/s)."""
        speed = robot_speed if is_of_speeds(self.law) else self.top_speed
        return required_at_speeds(self.law, human_speed, speed) + MARGIN

    def safe_until(
        self, plan: Stoppable, people: Sequence[Pedestrian], now: float, least: float
    ) -> tuple[float, Pedestrian | None]:
        """Return an instant (seconds) until which `plan` may be followed, and who ends it.

        It is found by doubling the time, from `least` seconds on; `now` if not even those are safe.
        None if nobody ends it before the end of the motion.
        """
        if not people:
            return plan.end, None
        top_speed = max(person.top_speed for person in people)
        whole = _Stretch.of(plan.motion, now, plan.end)
        near = [person for person in people if self._in_reach(person, whole, now)]
        until, ahead = now, least
        while near and until < plan.end:
            then = min(now + ahead, plan.end)
            on, stop = _Stretch.of(plan.motion, until, then), plan.stop(then)
            stopping = _Stretch.of(stop, then, stop.end)
            # Beyond the reach of the fastest of them nobody hinders: laws grow with both speeds.
            farthest, last = (self._reach(top_speed, one, now) + SLACK for one in (on, stopping))
            for person in near:
                if (
                    math.dist(person.at, on.at_begin) > farthest
                    and math.dist(person.at, stopping.at_begin) > last
                ):
                    continue
                if self._hinders(person, on, now) or self._hinders(person, stopping, now):
                    return until, person
            until, ahead = then, 2 * ahead
        return plan.end, None

    def hindered_for(self, plan: Stoppable, person: Pedestrian, now: float, least: float) -> float:
        """Return seconds for which `person` hinders `plan` for certain, begun at rest.

        They need them to walk as far as the machine would come too close, at two instants: after
        `least` seconds of it, and at the end of the stop from there.
        """
        until = min(now + least, plan.end)
        stopping = plan.stop(until)
        lacking = [
            -self._room(person, plan.motion.state(until), until - now),
            -self._room(person, stopping.state(stopping.end), stopping.end - now),
        ]
        return max(lacking) / person.top_speed

    def _hinders(self, person: Pedestrian, on: _Stretch, since: float) -> bool:
        """Return True if `person`, seen at `since` (seconds), may come too close on a stretch."""
        if self._room(person, on.at_end, on.end - since) < 0.0:
            return True
        if not self._in_reach(person, on, since):
            return False
        law = Approach(self.law, person.top_speed, since, self.top_speed)
        return first_violation(standing(person.at), on.motion, law, on.begin, on.end) is not None

    def _in_reach(self, person: Pedestrian, on: _Stretch, since: float) -> bool:
        """Return False if the two are too far apart for that, whatever they do on the way."""
        return math.dist(person.at, on.at_begin) < self._reach(person.top_speed, on, since)

    def _reach(self, top_speed: float, on: _Stretch, since: float) -> float:
        """Return how near (metres) somebody of that speed has to be to the beginning of `on`."""
        walked = top_speed * (on.end - since)
        reach = on.fastest * (on.end - on.begin) + walked
        return reach + self.required(top_speed, on.fastest)

    def _room(self, person: Pedestrian, state: State, seconds: float) -> float:
        """Return the metres left beyond what is asked for in `state`, `seconds` from the sight."""
        required = self.required(person.top_speed, state.speed) + person.top_speed * seconds
        return math.dist(person.at, state.at) - required
