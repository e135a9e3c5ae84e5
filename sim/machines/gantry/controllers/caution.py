"""Motions of the gantry beside people from which it can always stop in time."""

from __future__ import annotations

import math
from collections.abc import Sequence

from simpy.events import Event

from navigation import Motion, State

from ....safety.foresight import Foresight, Pedestrian, Stoppable
from ..drive import Steps
from ..robot import GantryRobot, Sighting
from ..tasks import Pose

SHARES = (1.0, 0.5, 0.25, 0.1)
"""The shares of its top speeds that the gantry chooses from."""

LEAST = 0.2
"""Seconds for which a motion must be safe to be commanded."""

AGAIN = 2.0
"""Seconds after which it looks for a faster motion than that under way."""

ARRIVED = 1e-6
"""Metres and radians. Nearer than this is there."""

INSTANT = 1e-6
"""Seconds. Less than this is no time at all."""


class Caution:
    """Motion that keeps the protective separation distance, whatever people do.

    Every motion that it commands is safe until it looks again, and so is a stop from there.
    """

    def __init__(self, gantry: GantryRobot) -> None:
        self._gantry = gantry
        self._human_speed = gantry.human_speed
        top = math.hypot(gantry.gantry.x.max_speed, gantry.gantry.y.max_speed)
        self._foresight = Foresight(gantry.law, top)
        self._move: Event = gantry.stop()
        self._under_way: tuple[Motion, Pose, float] | None = None
        self._stuck: tuple[Motion, Pose, Sequence[Sighting]] | None = None
        """The standstill, and what it was before it, from which no motion was safe."""
        self._seen: tuple[Sighting, ...] = ()
        self._seen_at = -math.inf

    def look(self) -> Steps:
        """See the people around; those of this instant are seen once."""
        if self._seen_at != self._gantry.now:
            people: tuple[Sighting, ...] = yield self._gantry.look()
            self._take_note(people)
        return self._seen

    def go(self, pose: Pose, *, seconds: float = math.inf) -> Steps:
        """Go to `pose`, at any time as fast as is safe; the value is True once it is there.

        Where people leave no safe motion it stops, and waits until there is one. After `seconds`
        it returns all the same, with False, and leaves the motion under way as it is.
        """
        gantry = self._gantry
        end = gantry.now + seconds
        people = yield from self.look()
        while math.dist(gantry.position, pose) > ARRIVED or gantry.now < gantry.body.motion.end:
            # Less than this is what rounding leaves of the time it was given.
            if end - gantry.now < INSTANT:
                return False
            share = self._share_to(pose)
            found, safe = self._fastest(pose, people)
            if found == 0.0 and self._under_way is not None:
                gantry.stop()
                self._under_way = None
            elif found != share:
                self._move = gantry.move_to(*pose, speed_share=found, resume=False)
                self._under_way = (gantry.body.motion, pose, found)
            # For `safe` seconds nobody can matter, so it looks no sooner.
            look = gantry.look(min(safe, end - gantry.now))
            yield look | self._move if found > 0.0 else look
            if look.processed:
                self._take_note(look.value or ())
            people = yield from self.look()
        return True

    def preview(self, pose: Pose, share: float = 1.0) -> Motion:
        """Return the motion to `pose` at a share of the top speeds: the one under way if it is."""
        gantry = self._gantry
        under_way = share == self._share_to(pose)
        return gantry.body.motion if under_way else gantry.preview(*pose, speed_share=share)

    def safe_for(self, motion: Motion, people: Sequence[Sighting]) -> float:
        """Return the seconds from now for which `motion` is safe, and a stop after them; or 0."""
        gantry = self._gantry
        plan = Stoppable(motion, gantry.drive.stops)
        seen = [Pedestrian(person.name, person.at, self._human_speed) for person in people]
        until, who = self._foresight.safe_until(plan, seen, gantry.now, LEAST)
        return until - gantry.now if who is not None else max(until - gantry.now, LEAST)

    def room_to_move(self, speed: float) -> float:
        """Return the distance (metres) from people at which it may move on at this speed (m/s)."""
        moving = State(self._gantry.position, (speed, 0.0, 0.0), (0.0, 0.0, 0.0))
        # What the stop from that speed takes, in metres and in seconds, in which people come
        # nearer.
        stop = self._gantry.stopping(moving, 0.0)
        metres = math.dist(stop.state(0.0).at, stop.state(stop.end).at)
        return self.required(speed) + metres + self._human_speed * (stop.end + LEAST)

    def required(self, robot_speed: float) -> float:
        """Return the distance (metres) to keep from people at this speed of the gantry's (m/s).

        A law that looks ahead is asked for the gantry's top speed: it may be reached by then.
        """
        return self._foresight.required(self._human_speed, robot_speed)

    def _take_note(self, people: tuple[Sighting, ...]) -> None:
        self._seen, self._seen_at = people, self._gantry.now

    def _share_to(self, pose: Pose) -> float:
        """Return the share of its speeds at which it moves to `pose`; 0 if it does not."""
        if self._under_way is None:
            return 0.0
        motion, target, share = self._under_way
        return share if motion is self._gantry.body.motion and target == pose else 0.0

    def _fastest(self, pose: Pose, people: Sequence[Sighting]) -> tuple[float, float]:
        """Return the greatest safe share of the top speeds, and the seconds for which it is safe.

        If none is safe: 0, and the seconds until the next look.
        """
        gantry = self._gantry
        if not gantry.disabled:
            motion = gantry.body.motion
            now_at = (motion, pose, people) if motion.end <= gantry.now else None
            # What was not safe from a standstill is not while nobody has moved since.
            if now_at is None or self._stuck != now_at:
                # From the fastest on: the first that is safe is taken.
                for candidate in SHARES:
                    motion = self.preview(pose, candidate)
                    seconds = self.safe_for(motion, people)
                    if seconds > 0.0:
                        return candidate, seconds if candidate == 1.0 else min(seconds, AGAIN)
                self._stuck = now_at
        nearest = min((math.dist(p.at, gantry.position[:2]) for p in people), default=math.inf)
        lacking = self.required(0.0) - nearest
        return 0.0, max(LEAST, lacking / self._human_speed)
