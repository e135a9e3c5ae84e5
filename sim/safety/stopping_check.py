"""Stopping check: whether a machine can still stop for people in the worst case.

After t seconds, a person of top speed v is within v t of the position where they were seen. A
motion is safe if the machine always keeps the distance that the law requires at that speed, plus
v t, on the motion and on a stop from its end (speed and separation monitoring, ISO/TS 15066:2016,
clause 5.5.4). The times are solved for, not sampled.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from floorplan import Point
from floorplan.files.dataclass import dataclass
from navigation import Motion, Shapes
from navigation.kernels.braking import Stops
from navigation.monitor import StoppingHorizon
from navigation.separation import AnyLaw, is_of_speeds, required_at_speeds

from ..core.entries import Pose

# A machine that commands only motions that are safe until its next check is always safe, by
# induction. If no motion is safe at that check, the machine makes the stop that was tested with the
# last motion. The only forecast of people is their top speed. The law covers the person's approach,
# the machine's reaction and its stop after that time.


MARGIN = 0.01
"""Distance beyond the required one, so that rounding cannot decide, m."""


class Stoppable(NamedTuple):
    """A motion, and the stops of the machine that begin during it."""

    motion: Motion
    stops: Stops


class Pedestrian(NamedTuple):
    """A person at a position (x, y in metres) who walks at `top_speed` (m/s) at most."""

    name: str
    at: tuple[float, float]
    top_speed: float


@dataclass(frozen=True)
class StoppingCheck:
    """Test for one machine with this `law` and `top_speed` (m/s).

    Distances are measured between centres, or between the surfaces of `shapes`.
    """

    law: AnyLaw
    top_speed: float
    shapes: Shapes | None = None

    def distance(self, person: Point, pose: Pose) -> float:
        """Return the distance between a person at a position and the machine at a pose (m)."""
        if self.shapes is None:
            return math.dist(person, pose[:2])
        return float(self.shapes.distances(np.array([person]), np.array([pose]))[0])

    @property
    def around(self) -> float:
        """Maximum difference between the distances of centres and of surfaces, m."""
        return 0.0 if self.shapes is None else self.shapes.reach + self.shapes.person.radius

    def required(self, human_speed: float, robot_speed: float) -> float:
        """Return the required distance at these speeds (m/s), in m."""
        # A predictive law gets the top speed, because the machine may reach it by then.
        speed = robot_speed if is_of_speeds(self.law) else self.top_speed
        return required_at_speeds(self.law, human_speed, speed) + MARGIN

    def safe_until(
        self, plan: Stoppable, people: Sequence[Pedestrian], now: float, least: float
    ) -> tuple[float, Pedestrian | None]:
        """Return the time (s) until which `plan` is safe, and the person who limits it, if any.

        The search doubles the time from `least` seconds on. If these are unsafe, the result is
        `now`.
        """
        until, k = self._lookout.safe_until(
            plan.motion.table, plan.stops, self._rows(people), now, least
        )
        return until, people[k] if k >= 0 else None

    def hindered_for(self, plan: Stoppable, person: Pedestrian, now: float, least: float) -> float:
        """Return the minimum time (s) for which `person` blocks `plan`, which begins at rest.

        The person needs it to walk away as far as the machine would come too close after `least`
        seconds, and at the end of the stop from there.
        """
        rows = self._rows([person])
        lacking = self._lookout.lacking(plan.motion.table, plan.stops, rows, now, least)
        return lacking / person.top_speed

    @cached_property
    def _lookout(self) -> StoppingHorizon:
        return StoppingHorizon(self.law, MARGIN, self.shapes)

    @cached_property
    def _fixed(self) -> dict[float, float]:
        """Required distances of a predictive law, by top speed of the person."""
        return {}

    def _rows(self, people: Sequence[Pedestrian]) -> list[float]:
        """Return people as rows of the horizon: position, top speed, required distance or -1."""
        rows: list[float] = []
        for person in people:
            top_speed = person.top_speed
            fixed = self._fixed.get(top_speed)
            if fixed is None:
                varies = is_of_speeds(self.law)
                fixed = -1.0 if varies else self.required(top_speed, self.top_speed)
                self._fixed[top_speed] = fixed
            rows += (*person.at, top_speed, fixed)
        return rows
