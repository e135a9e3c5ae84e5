"""Motions of the gantry beside people from which it can always stop in time."""

from __future__ import annotations

import math
from collections.abc import Sequence

from simpy.events import Event

from navigation import Motion, State, is_of_speeds, required_at_speeds

from ..drive import Steps
from ..robot import GantryRobot, Sighting
from ..tasks import Pose

SHARES = (1.0, 0.5, 0.25, 0.1)
"""The shares of its top speeds that the gantry chooses from."""

HORIZONS = (0.2, 1.0, 2.0)
"""Seconds for which it may go on without looking again."""

STRIDE = 0.2
"""Seconds between the instants at which the motion ahead is tested."""

ARRIVED = 1e-6
"""Metres and radians. Nearer than this is there."""

INSTANT = 1e-6
"""Seconds. Less than this is no time at all."""

MARGIN = 0.05
"""Metres. More than the distance can fall short between two tests of the motion ahead."""


class Caution:
    """Motion that keeps the protective separation distance, whatever people do.

    A motion is safe for a while if all through it, and through a stop at its end, nobody who
    walks towards the gantry as fast as people can comes nearer than the law asks for. The law is
    asked for that speed, and for the gantry's own of the instant (speed and separation
    monitoring, ISO/TS 15066:2016, clause 5.5.4).
    """

    # Each motion that it commands is safe until the next look, and so is a stop from there. If
    # nothing is safe at that look, the stop is what it does; so safety holds from look to look by
    # induction, and needs no forecast of people but their top speed. The law's distance covers what
    # follows the instant for which it is asked (in the clause: the person's approach, the robot's
    # reaction and its stop); what a person may have walked since they were seen is added to it.

    def __init__(self, gantry: GantryRobot) -> None:
        self._gantry = gantry
        self._law = gantry.law
        self._human_speed = gantry.human_speed
        top = math.hypot(gantry.gantry.x.max_speed, gantry.gantry.y.max_speed)
        self._at_top_speed = required_at_speeds(self._law, self._human_speed, top)
        self._move: Event = gantry.stop()
        self._under_way: tuple[Motion, Pose, float] | None = None

    def go(self, pose: Pose, *, seconds: float = math.inf) -> Steps:
        """Go to `pose`, at any time as fast as is safe; the value is True once it is there.

        Where people leave no safe motion it stops, and waits until there is one. After `seconds`
        it returns all the same, with False, and leaves the motion under way as it is.
        """
        gantry = self._gantry
        end = gantry.now + seconds
        people = yield gantry.look()
        while math.dist(gantry.position, pose) > ARRIVED or gantry.state.speed > 0:
            if end - gantry.now < INSTANT:
                return False
            share = self._share_to(pose)
            found, safe = self._fastest(pose, share, people)
            if found == 0.0 and self._under_way is not None:
                gantry.stop()
                self._under_way = None
            elif found != share:
                self._move = gantry.move_to(*pose, speed_share=found, resume=False)
                self._under_way = (gantry.body.motion, pose, found)
            look = gantry.look(min(safe, end - gantry.now))
            yield look | self._move if found > 0.0 else look
            people = look.value if look.processed else (yield gantry.look())
        return True

    def safe_for(self, motion: Motion, people: Sequence[Sighting]) -> float:
        """Return the seconds from now for which `motion` is safe: one of `HORIZONS`, or 0."""
        safe = 0.0
        for horizon in HORIZONS:
            if not self._is_safe_until(self._gantry.now + horizon, motion, people):
                break
            safe = horizon
        return safe

    def room_to_move(self, speed: float) -> float:
        """Return the distance (metres) from people at which it may move on at this speed (m/s)."""
        state = State((0.0, 0.0, 0.0), (speed, 0.0, 0.0), (0.0, 0.0, 0.0))
        seconds, metres = self._longest_stop(state)
        return self.required(speed) + metres + self._human_speed * (seconds + HORIZONS[0])

    def required(self, robot_speed: float) -> float:
        """Return the distance (metres) to keep from people at this speed of the gantry's (m/s).

        A law that looks ahead is asked for the gantry's top speed: it may be reached by then.
        """
        if is_of_speeds(self._law):
            return self._law.distance(self._human_speed, robot_speed) + MARGIN
        return self._at_top_speed + MARGIN

    def _share_to(self, pose: Pose) -> float:
        """Return the share of its speeds at which it moves to `pose`; 0 if it does not."""
        if self._under_way is None:
            return 0.0
        motion, target, share = self._under_way
        return share if motion is self._gantry.body.motion and target == pose else 0.0

    def _fastest(self, pose: Pose, share: float, people: Sequence[Sighting]) -> tuple[float, float]:
        """Return the greatest safe share of the top speeds, and the seconds for which it is safe.

        If none is safe: 0, and the seconds until the next look.
        """
        gantry = self._gantry
        if not gantry.disabled:
            for candidate in SHARES:
                motion = (
                    gantry.body.motion
                    if candidate == share
                    else gantry.preview(*pose, speed_share=candidate)
                )
                seconds = self.safe_for(motion, people)
                if seconds > 0.0:
                    return candidate, seconds
        nearest = min((math.dist(p.at, gantry.position[:2]) for p in people), default=math.inf)
        lacking = self.required(0.0) - nearest
        return 0.0, max(HORIZONS[0], lacking / self._human_speed)

    def _is_safe_until(self, t: float, motion: Motion, people: Sequence[Sighting]) -> bool:
        """Return True if `motion` is safe until `t` (seconds), and a stop from there on."""
        now = self._gantry.now
        if not self._keeps_away(motion, now, t, people):
            return False
        state = motion.state(t)
        seconds, metres = self._longest_stop(state)
        reach = self._human_speed * (t - now + seconds)
        room = self.required(state.speed) + metres + reach
        if all(math.dist(person.at, state.at) >= room for person in people):
            return True
        stop = self._gantry.stopping(state, t)
        return self._keeps_away(stop, t, stop.end, people)

    def _longest_stop(self, state: State) -> tuple[float, float]:
        """Return the seconds and metres that a stop takes at the most.

        That is along one axis, the slower one: the acceleration of the instant is taken back
        first; then it brakes as hard as it may.
        """
        axes = (self._gantry.gantry.x, self._gantry.gantry.y)
        braking = min(axis.max_acceleration for axis in axes)
        jerk = min(axis.max_jerk for axis in axes)
        acceleration = math.hypot(*state.acceleration[:2])
        easing = acceleration / jerk
        speed = state.speed + acceleration * easing / 2
        seconds = speed / braking + braking / jerk
        return easing + seconds, speed * (easing + seconds / 2)

    def _keeps_away(
        self, motion: Motion, begin: float, end: float, people: Sequence[Sighting]
    ) -> bool:
        """Return True if nobody can come too near to `motion` between two instants (seconds)."""
        strides = max(1, math.ceil((end - begin) / STRIDE))
        for k in range(strides + 1):
            t = begin + (end - begin) * k / strides
            state = motion.state(t)
            required = self.required(state.speed) + self._human_speed * (t - self._gantry.now)
            if any(math.dist(person.at, state.at) < required for person in people):
                return False
        return True
