"""Bounds on the distance and the speeds of two motions over an interval."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

from .kernels import encounter as kernel
from .kernels.gauge import Gauge
from .motion import Motion
from .odometer import Enclosure, Odometer

_ROUNDING = 1e-12
"""Metres by which distances between surfaces may be off, so that ties may be none."""


class Bounds(NamedTuple):
    """Bounds throughout an interval: metres and m/s. At an instant, low equals high."""

    distance_low: float
    distance_high: float
    human_low: float
    human_high: float
    robot_low: float
    robot_high: float


class Encounter(kernel.Encounter):
    """A stretch of time in which the motions of a person and a machine are one cubic each.

    Distances are those between the two on the floor, or between surfaces, by `gauges`.
    """

    def __init__(self, person: Motion, machine: Motion, gauges: Sequence[Gauge] = ()) -> None:
        super().__init__(person.table, machine.table, [*gauges], _ROUNDING if gauges else 0.0)
        self._motions = person, machine

    @property
    def begin(self) -> float:
        """The instant at which the stretch begins, seconds."""
        return self.stretch()[0]

    @property
    def end(self) -> float:
        """The instant at which the stretch ends, seconds."""
        return self.stretch()[1]

    @cached_property
    def human(self) -> Odometer:
        """The odometer of the person's whole motion."""
        return Odometer(self._motions[0])

    @cached_property
    def robot(self) -> Odometer:
        """The odometer of the machine's whole motion."""
        return Odometer(self._motions[1])

    def odometers(self) -> tuple[Odometer, Odometer]:
        """Return those of the person and of the machine."""
        return self.human, self.robot

    def distance(self, t: float) -> float:
        """Return the distance between the two at `t` (metres), 0 where surfaces overlap."""
        return self.bounds_apart(t, t, 0.0, 0.0)[0]

    def closing(self, begin: float, end: float) -> tuple[float, float]:
        """Return bounds on the rate of half the squared distance from `begin` to `end` (m²/s).

        Negative while the two places come closer, positive while they part.
        """
        return self.bounds_closing(begin, end)

    def bounds(self, begin: float, end: float) -> Bounds:
        """Return the bounds from `begin` to `end`, an interval within this stretch."""
        return Bounds(*self.all_bounds(begin, end))

    def apart(
        self, begin: float, end: float, slope: float = 0.0, curve: float = 0.0
    ) -> tuple[float, float, float]:
        """Bounds on distance − `slope` u − `curve` u² / 2 over an interval, u from its middle.

        Slope (m/s) and curve (m/s²) are those of a required distance that changes while the two
        move. The third number is an instant at which the figure is near the low.
        """
        return self.bounds_apart(begin, end, slope, curve)

    def human_speed(self, begin: float, end: float) -> Enclosure:
        """Return the human's speed over an interval within this stretch, m/s."""
        return Enclosure(*self.speed_of(False, begin, end).numbers())

    def robot_speed(self, begin: float, end: float) -> Enclosure:
        """Return the robot's speed over an interval within this stretch, m/s."""
        return Enclosure(*self.speed_of(True, begin, end).numbers())
