"""Simulated time beside the wall clock."""

from __future__ import annotations


class Pace:
    """Simulated seconds at `speed` a second of the wall clock, from the last `resume` on."""

    def __init__(self, speed: float) -> None:
        self.speed = speed
        self._simulated = 0.0
        self._wall = 0.0

    def resume(self, simulated: float, wall: float) -> None:
        """At `wall` (seconds) it is `simulated` (seconds)."""
        self._simulated = simulated
        self._wall = wall

    def simulated_at(self, wall: float) -> float:
        """What simulated time it should be at `wall`, seconds."""
        return self._simulated + (wall - self._wall) * self.speed

    def wall_at(self, simulated: float) -> float:
        """When it should be `simulated`, seconds of the wall clock."""
        return self._wall + (simulated - self._simulated) / self.speed
