"""Stopping check: whether a machine can still stop for people in the worst case.

Somebody of top speed v is within v t of where they were seen for t seconds, in whatever direction
they set out. A motion is safe if all along it, and along a stop from its end, the machine keeps
the distance that the law asks for from somebody of that speed, and v t in addition (speed and
separation monitoring, ISO/TS 15066:2016, clause 5.5.4). It is solved for, not sampled.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from floorplan import Point
from navigation import Motion, Shapes
from navigation.kernels.braking import Stops
from navigation.monitor import StoppingHorizon
from navigation.separation import AnyLaw, is_of_speeds, required_at_speeds

from ..core.entries import Pose

# A machine that commands only motions that are safe until its next look is safe for good, by
# induction: if nothing is safe at that look, the stop that was tested with the motion is what it
# does. No forecast of people is needed but their top speed. The law's distance covers what follows
# the instant for which it is asked (the person's approach, the machine's reaction and its stop).


MARGIN = 0.01
"""Metres. Kept beyond the required distance, so that rounding can't decide."""


class Stoppable(NamedTuple):
    """A motion, and how the machine stops from it at any instant."""

    motion: Motion
    stops: Stops


class Pedestrian(NamedTuple):
    """Somebody seen at a place (x, y in metres) who walks at `top_speed` (m/s) at most."""

    name: str
    at: tuple[float, float]
    top_speed: float


@dataclass(frozen=True)
class StoppingCheck:
    """The test for one machine, to which `law` applies and which is no faster than `top_speed`.

    Distances are measured between centres, or between the surfaces of `shapes`.
    """

    law: AnyLaw
    top_speed: float
    shapes: Shapes | None = None

    def distance(self, person: Point, pose: Pose) -> float:
        """Return the distance (metres) between somebody at a place and the machine at a pose."""
        if self.shapes is None:
            return math.dist(person, pose[:2])
        return float(self.shapes.distances(np.array([person]), np.array([pose]))[0])

    @property
    def around(self) -> float:
        """Metres by which centres are farther apart than surfaces at most."""
        return 0.0 if self.shapes is None else self.shapes.reach + self.shapes.person.radius

    def required(self, human_speed: float, robot_speed: float) -> float:
        """Return the distance (metres) to keep from somebody at these speeds (m/s)."""
        # A law that looks ahead is asked for the top speed: it may be reached by then.
        speed = robot_speed if is_of_speeds(self.law) else self.top_speed
        return required_at_speeds(self.law, human_speed, speed) + MARGIN

    def safe_until(
        self, plan: Stoppable, people: Sequence[Pedestrian], now: float, least: float
    ) -> tuple[float, Pedestrian | None]:
        """Return an instant (seconds) until which `plan` may be followed, and who ends it.

        It is found by doubling the time, from `least` seconds on; `now` if not even those are safe.
        None if nobody ends it before the end of the motion.
        """
        until, k = self._lookout.safe_until(
            plan.motion.table, plan.stops, self._rows(people), now, least
        )
        return until, people[k] if k >= 0 else None

    def hindered_for(self, plan: Stoppable, person: Pedestrian, now: float, least: float) -> float:
        """Return seconds for which `person` hinders `plan` for certain, begun at rest.

        They need them to walk as far as the machine would come too close, at two instants: after
        `least` seconds of it, and at the end of the stop from there.
        """
        rows = self._rows([person])
        lacking = self._lookout.lacking(plan.motion.table, plan.stops, rows, now, least)
        return lacking / person.top_speed

    @cached_property
    def _lookout(self) -> StoppingHorizon:
        return StoppingHorizon(self.law, MARGIN, self.shapes)

    @cached_property
    def _fixed(self) -> dict[float, float]:
        """What a law that looks ahead asks for, by people's top speeds."""
        return {}

    def _rows(self, people: Sequence[Pedestrian]) -> list[float]:
        """Return people as rows of the lookout's."""
        rows: list[float] = []
        for person in people:
            top_speed = person.top_speed
            fixed = self._fixed.get(top_speed)
            if fixed is None:
                known = is_of_speeds(self.law)
                fixed = -1.0 if known else self.required(top_speed, self.top_speed)
                self._fixed[top_speed] = fixed
            rows += (*person.at, top_speed, fixed)
        return rows
