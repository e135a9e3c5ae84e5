"""Motion of a machine that can always stop before it is too near to people."""

from __future__ import annotations

import math
from collections.abc import Sequence

from simpy.events import Event

from navigation import Motion
from navigation.motion import State

from ..core.entries import Pose
from ..core.events import GantryYielded
from ..safety.stopping_check import Pedestrian, Stoppable, StoppingCheck
from .commanded import CommandedMachine, Sighting
from .commanding import Steps

SHARES = (1.0, 0.5, 0.25, 0.1)
"""The shares of its top speeds that a machine chooses from."""

LEAST = 0.2
"""Seconds for which a motion must be safe to be commanded."""

AGAIN = 2.0
"""Seconds after which it looks for a faster motion than that under way."""

ARRIVED = 1e-6
"""Metres and radians. Nearer than this is there."""

INSTANT = 1e-6
"""Seconds. Less than this is no time at all."""


class Caution:
    """Motion of a machine that keeps the protective separation distance from people.

    Each commanded motion is safe until the next observation, and so is a stop from there.

    Parameters
    ----------
    gantry : GantryRobot
        The gantry.
    """

    def __init__(self, gantry: CommandedMachine) -> None:
        self._gantry = gantry
        self._human_speed = gantry.human_speed
        self._foresight = StoppingCheck(gantry.law, gantry.shape.top_speed, gantry.shapes)
        self._move: Event = gantry.stop()
        self._under_way: tuple[Motion, Pose, float] | None = None
        self._stuck: tuple[Motion, Pose, Sequence[Sighting]] | None = None
        """The standstill, and what it was before it, from which no motion was safe."""
        self._hindered_by: str | None = None
        """The person for whom the slowest motion was not safe."""
        self._has_recorded = False
        """Whether it has recorded that it waits, since it last moved."""
        self._seen: tuple[Sighting, ...] = ()
        self._seen_at = -math.inf

    def look(self) -> Steps:
        """Observe the people, once at each time. Use it with `yield from`.

        Yields
        ------
        Event
            Waiting time.
        """
        if self._seen_at != self._gantry.now:
            people: tuple[Sighting, ...] = yield self._gantry.look()
            self._take_note(people)
        return self._seen

    def go(self, pose: Pose, *, seconds: float = math.inf) -> Steps:
        """Move to a pose as fast as is safe. Use it with `yield from`.

        If no motion is safe, the gantry stops and waits until one is.

        Parameters
        ----------
        pose : (float, float, float)
            x and y in metres and rotation in radians.
        seconds : float, optional
            Maximum duration in seconds. The current motion continues after it.

        Yields
        ------
        Event
            Waiting time.

        Returns
        -------
        bool
            Whether the gantry has reached the pose.
        """
        gantry = self._gantry
        end = gantry.now + seconds
        people = yield from self.look()
        while not self._is_at(pose) or gantry.now < gantry.body.motion.end:
            # Less than this is what rounding leaves of the time it was given.
            if end - gantry.now < INSTANT:
                return False
            share = self._share_to(pose)
            found, safe = self._fastest(pose, people)
            if found == 0.0 and self._under_way is not None:
                gantry.stop()
                self._under_way = None
            elif found != share:
                self._has_recorded = False
                self._move = gantry.move_to(*pose, speed_share=found, resume=False)
                self._under_way = (gantry.body.motion, pose, found)
            if found == 0.0 and not gantry.disabled:
                self.record_waiting(self._hindered_by, people)
            # For `safe` seconds nobody can matter, so it looks no sooner.
            look = gantry.look(min(safe, end - gantry.now))
            yield look | self._move if found > 0.0 else look
            if look.processed:
                self._take_note(look.value or ())
            people = yield from self.look()
        return True

    def _is_at(self, pose: Pose) -> bool:
        here = self._gantry.position
        turn = math.remainder(here[2] - pose[2], math.tau)
        return math.dist((*here[:2], turn), (*pose[:2], 0.0)) <= ARRIVED

    def preview(self, pose: Pose, share: float = 1.0) -> Motion:
        """Return the motion to a pose without moving. It is the current motion if that leads there.

        Parameters
        ----------
        pose : (float, float, float)
            x and y in metres and rotation in radians.
        share : float, optional
            Share of the top speeds to use.
        """
        gantry = self._gantry
        under_way = share == self._share_to(pose)
        return gantry.body.motion if under_way else gantry.preview(*pose, speed_share=share)

    def safe_for(self, motion: Motion, people: Sequence[Sighting]) -> float:
        """Return the duration in seconds for which a motion and a stop after it are safe, or 0.

        Parameters
        ----------
        motion : Motion
            Motion that begins now.
        people : sequence of Sighting
            Observed people.
        """
        gantry = self._gantry
        plan = Stoppable(motion, gantry.stops)
        seen = [Pedestrian(person.name, person.at, self._human_speed) for person in people]
        until, who = self._foresight.safe_until(plan, seen, gantry.now, LEAST)
        self._hindered_by = None if who is None else who.name
        return until - gantry.now if who is not None else max(until - gantry.now, LEAST)

    def room_to_move(self, speed: float) -> float:
        """Return the distance in metres between centres at which motion is possible.

        Parameters
        ----------
        speed : float
            Speed of the gantry in m/s.
        """
        moving = State(self._gantry.position, (speed, 0.0, 0.0), (0.0, 0.0, 0.0))
        # What the stop from that speed takes, in metres and in seconds, in which people come
        # nearer.
        stop = self._gantry.stopping(moving, 0.0)
        metres = math.dist(stop.state(0.0).at, stop.state(stop.end).at)
        required = self.required_between_centres(speed)
        return required + metres + self._human_speed * (stop.end + LEAST)

    def required(self, robot_speed: float) -> float:
        """Return the required distance in metres from people, as the rules measure.

        Laws of motions are evaluated at the top speed of the gantry, which it may reach.

        Parameters
        ----------
        robot_speed : float
            Speed of the gantry in m/s.
        """
        return self._foresight.required(self._human_speed, robot_speed)

    def required_between_centres(self, robot_speed: float) -> float:
        """Return a distance in metres between centres at which `required` is kept in any pose.

        Parameters
        ----------
        robot_speed : float
            Speed of the gantry in m/s.
        """
        return self.required(robot_speed) + self._foresight.around

    def record_waiting(self, name: str | None, people: Sequence[Sighting]) -> None:
        """Record that the gantry waits for a person, once until it moves again.

        Parameters
        ----------
        name : str or None
            Name of the person, or None for the nearest one.
        people : sequence of Sighting
            Observed people.
        """
        if self._has_recorded or not people:
            return
        here = self._gantry.position[:2]
        nearest = min(people, key=lambda one: (one.name != name, math.dist(one.at, here)))
        self._has_recorded = True
        self._gantry.record(
            GantryYielded(
                person=nearest.name,
                distance=self._foresight.distance(nearest.at, self._gantry.position),
                required=self.required(self._gantry.state.speed),
            )
        )

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
        distances = (self._foresight.distance(p.at, gantry.position) for p in people)
        nearest = min(distances, default=math.inf)
        lacking = self.required(0.0) - nearest
        return 0.0, max(LEAST, lacking / self._human_speed)
