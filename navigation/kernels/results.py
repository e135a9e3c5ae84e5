"""Results of kernels with several values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple


@dataclass(frozen=True, kw_only=True)
class Enclosure:
    """Value over an interval, within `slack` of `value` + `slope` u + `curve` u² / 2.

    u is the time since the middle of the interval in seconds. Custom laws return enclosures.

    Parameters
    ----------
    value : float
        Value in the middle, which is exact for a single time.
    slope, curve : float, optional
        First and second derivative.
    slack : float, optional
        Maximum deviation.
    """

    value: float
    slope: float = 0.0
    slack: float = 0.0
    curve: float = 0.0

    @staticmethod
    def between(low: float, high: float) -> Enclosure:
        """Return the enclosure of a value between two bounds."""
        return Enclosure(value=(low + high) / 2, slope=0.0, slack=(high - low) / 2)

    def range(self, half: float) -> tuple[float, float]:
        """Return minimum and maximum on an interval of twice `half` seconds."""
        around = (abs(self.slope) + abs(self.curve) * half / 2) * half + self.slack
        return self.value - around, self.value + around

    def __add__(self, other: Enclosure | float) -> Enclosure:
        if isinstance(other, Enclosure):
            return Enclosure(
                value=self.value + other.value,
                slope=self.slope + other.slope,
                slack=self.slack + other.slack,
                curve=self.curve + other.curve,
            )
        return Enclosure(
            value=self.value + other, slope=self.slope, slack=self.slack, curve=self.curve
        )

    def __mul__(self, factor: float) -> Enclosure:
        return Enclosure(
            value=self.value * factor,
            slope=self.slope * factor,
            slack=self.slack * abs(factor),
            curve=self.curve * factor,
        )


class Bounds(NamedTuple):
    """Bounds throughout an interval: metres and m/s. At an instant, low equals high."""

    distance_low: float
    distance_high: float
    human_low: float
    human_high: float
    robot_low: float
    robot_high: float


class DistanceBounds(NamedTuple):
    """Bounds on a distance over an interval (metres), and a time near its minimum (seconds)."""

    low: float
    high: float
    t: float


class NearestDiscs(NamedTuple):
    """Indices of the nearest two discs, index of the time, and their distance (metres)."""

    one: int
    other: int
    time: int
    distance: float
