"""Lookout of a yielding AGV: it stops before a person can come too close."""

from __future__ import annotations

from functools import partial

from navigation import Motion

from ...core.body import Body, MachineShape
from ...core.clock import Alarm, Turn
from ...core.events import AgvYielded
from ...core.stage import Stage
from ...safety.stopping_check import Pedestrian, Stoppable, StoppingCheck
from .drive import LaneDrive

LOOK = 0.1
"""Seconds. Minimum time between two checks."""

RESUME = 1.0
"""Seconds for which a run must be safe to begin. Shorter runs would make the AGV creep."""


class PedestrianWatch:
    """Lookout of a yielding AGV.

    It checks the people nearby often enough to stop before any of them can come too close, and
    resumes the run when the lane is clear.
    """

    def __init__(
        self, stage: Stage, drive: LaneDrive, shape: MachineShape, check: StoppingCheck
    ) -> None:
        self._stage = stage
        self._clock = stage.clock
        self._drive = drive
        self._shape = shape
        self._check = check
        self._people: list[tuple[Body, float]] = []
        self._hindered_by: Pedestrian | None = None
        """The person because of whom the last run was not permitted."""
        self._has_recorded = False
        """Whether the wait has been recorded since the last run began."""
        self._next_look = Alarm(stage.clock, self.look, Turn.MOTION_ENDS)
        self._awaited: tuple[Body, float, float] | None = None
        """A standing person in the way, the next time of a check, and the interval (s)."""
        drive.permits = self._permits
        drive.set_out = self._set_out

    def add(self, person: Body, top_speed: float) -> None:
        """Yield to a person, who walks at `top_speed` (m/s) at most."""
        self._people.append((person, top_speed))
        person.on_jump.append(self.look)
        person.on_change.append(partial(self._person_changed, person))

    def cancel(self) -> None:
        """Cancel the next check."""
        self._hindered_by = None
        self._look_at(None)

    def look(self) -> None:
        """Continue, stop, or start again, depending on the people nearby."""
        drive = self._drive
        if drive.to is None or drive.disabled:
            return
        if drive.is_on_move:
            self._hindered_by = self._hindered(drive.body.motion, LOOK)
        else:
            drive.retry()
        self.react()

    def react(self) -> None:
        """Stop and wait if the last run was not permitted."""
        person, self._hindered_by = self._hindered_by, None
        if person is not None:
            self._wait(person)

    def _set_out(self) -> None:
        """Wait if the new move was not permitted. A former run is safe until the next check."""
        if self._drive.is_on_move or not self._drive.runs:
            self.react()

    def _permits(self, motion: Motion) -> bool:
        """Return whether a run is safe. If so, it begins, and the next check is scheduled."""
        self._hindered_by = self._hindered(motion, LOOK if self._drive.runs else RESUME)
        if self._hindered_by is not None:
            return False
        self._has_recorded = False
        return True

    def _hindered(self, motion: Motion, minimum: float) -> Pedestrian | None:
        """Return the person who makes a motion unsafe within `minimum` seconds.

        If there is none, the next check is when the motion may become unsafe.
        """
        now = self._clock.now
        plan, people = Stoppable(motion, self._drive.stops), self._visible()
        until, person = self._check.safe_until(plan, people, now, minimum)
        if until == now and person is not None:
            return person
        self._look_at(until if person is not None else None)
        return None

    def _look_at(self, t: float | None) -> None:
        self._awaited = None
        self._next_look.set(t)

    def _person_changed(self, person: Body) -> None:
        """Check again if the AGV waits for this person, because checks were pointless before."""
        if self._awaited is not None and self._awaited[0] is person:
            _, t, interval = self._awaited
            # At the time of the next check if there had been one after each interval.
            while t < self._clock.now:
                t += interval
            self._look_at(t)

    def _visible(self) -> list[Pedestrian]:
        """Return the people, relative to the point to which distances are measured."""
        if self._stage.blind[self._shape.name]:
            return []
        dx, dy = self._stage.rules.measured_at(self._shape)
        return [
            Pedestrian(body.name, (x - dx, y - dy), top_speed)
            for body, top_speed in self._people
            for x, y in (body.at,)
        ]

    def _wait(self, person: Pedestrian) -> None:
        """Stop, and wait until the lane is clear."""
        now, drive = self._clock.now, self._drive
        drive.brake()
        state = drive.body.state
        if not self._has_recorded:
            self._has_recorded = True
            self._stage.record(
                AgvYielded(
                    agv=self._shape.name,
                    person=person.name,
                    distance=self._check.distance(person.at, state.position),
                    required=self._check.required(person.top_speed, state.speed),
                )
            )
        if state.speed > 0.0:
            self._look_at(now + LOOK)
            return
        plan = Stoppable(drive.run_to_goal(), drive.stops)
        interval = max(LOOK, self._check.hindered_for(plan, person, now, RESUME))
        self._look_at(now + interval)
        body = next(body for body, _ in self._people if body.name == person.name)
        if body.motion.end <= now:
            self._next_look.set(None)
            self._awaited = body, now + interval, interval
