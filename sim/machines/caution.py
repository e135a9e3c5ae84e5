"""Motions of a machine that can always stop before it comes too close to people."""

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
"""Shares of the top speeds, fastest first."""

LEAST = 0.2
"""Seconds for which a motion must be safe to begin."""

AGAIN = 2.0
"""Seconds after which a machine on a slow motion tries a faster one."""

ARRIVED = 1e-6
"""Metres and radians. Tolerance of targets."""

INSTANT = 1e-6
"""Seconds. Shorter durations are rounding."""


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
        self._check = StoppingCheck(gantry.law, gantry.shape.top_speed, gantry.shapes)
        self._move: Event = gantry.stop()
        self._under_way: tuple[Motion, Pose, float] | None = None
        self._stuck: tuple[Motion, Pose, Sequence[Sighting]] | None = None
        """The standstill from which no motion was safe, with the target and the people."""
        self._hindered_by: str | None = None
        """The person because of whom the slowest motion was not safe."""
        self._has_recorded = False
        """Whether the wait has been recorded since the last motion."""
        self._people: tuple[Sighting, ...] = ()
        self._observed_at = -math.inf

    def look(self) -> Steps:
        """Observe the people, once at each time. Use it with `yield from`.

        Yields
        ------
        Event
            Waiting time.
        """
        if self._observed_at != self._gantry.now:
            people: tuple[Sighting, ...] = yield self._gantry.look()
            self._see(people)
        return self._people

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
            if end - gantry.now < INSTANT:
                return False
            share, safe = self._fastest(pose, people)
            if share == 0.0 and self._under_way is not None:
                gantry.stop()
                self._under_way = None
            elif share != self._share_to(pose):
                self._has_recorded = False
                self._move = gantry.move_to(*pose, speed_share=share, resume=False)
                self._under_way = (gantry.body.motion, pose, share)
            if share == 0.0 and not gantry.disabled:
                self.record_waiting(self._hindered_by, people)
            look = gantry.look(min(safe, end - gantry.now))
            yield look | self._move if share > 0.0 else look
            if look.processed:
                self._see(look.value or ())
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
        pedestrians = [Pedestrian(person.name, person.at, self._human_speed) for person in people]
        until, person = self._check.safe_until(plan, pedestrians, gantry.now, LEAST)
        self._hindered_by = None if person is None else person.name
        return until - gantry.now if person is not None else max(until - gantry.now, LEAST)

    def room_to_move(self, speed: float) -> float:
        """Return the distance in metres between centres at which motion is possible.

        Parameters
        ----------
        speed : float
            Speed of the gantry in m/s.
        """
        moving = State(self._gantry.position, (speed, 0.0, 0.0), (0.0, 0.0, 0.0))
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
        return self._check.required(self._human_speed, robot_speed)

    def required_between_centres(self, robot_speed: float) -> float:
        """Return a distance in metres between centres at which `required` is kept in any pose.

        Parameters
        ----------
        robot_speed : float
            Speed of the gantry in m/s.
        """
        return self.required(robot_speed) + self._check.around

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
        nearest = min(people, key=lambda other: (other.name != name, math.dist(other.at, here)))
        self._has_recorded = True
        self._gantry.record(
            GantryYielded(
                person=nearest.name,
                distance=self._check.distance(nearest.at, self._gantry.position),
                required=self.required(self._gantry.state.speed),
            )
        )

    def _see(self, people: tuple[Sighting, ...]) -> None:
        self._people, self._observed_at = people, self._gantry.now

    def _share_to(self, pose: Pose) -> float:
        """Return the speed share of the present motion to `pose`, or 0 if there is none."""
        if self._under_way is None:
            return 0.0
        motion, target, share = self._under_way
        return share if motion is self._gantry.body.motion and target == pose else 0.0

    def _fastest(self, pose: Pose, people: Sequence[Sighting]) -> tuple[float, float]:
        """Return the highest safe speed share, and the seconds for which it is safe.

        If none is safe: 0, and the seconds until the next look.
        """
        gantry = self._gantry
        if not gantry.disabled:
            motion = gantry.body.motion
            standstill = (motion, pose, people) if motion.end <= gantry.now else None
            # A motion that was unsafe from standstill stays unsafe until a person moves.
            if standstill is None or self._stuck != standstill:
                for candidate in SHARES:
                    motion = self.preview(pose, candidate)
                    seconds = self.safe_for(motion, people)
                    if seconds > 0.0:
                        return candidate, seconds if candidate == 1.0 else min(seconds, AGAIN)
                self._stuck = standstill
        distances = (self._check.distance(person.at, gantry.position) for person in people)
        nearest = min(distances, default=math.inf)
        lacking = self.required(0.0) - nearest
        return 0.0, max(LEAST, lacking / self._human_speed)
