"""Noticing the gantry from samples: what the referee does, for an agent that only hears states."""

from __future__ import annotations

import math
from typing import Literal

from ..core.rules import Notice


class SampledNotice:
    """Tells once per approach that the gantry is inside the noticing distance and getting closer.

    An approach is over when the two have parted by `rule.parting` metres from where they were
    nearest, or `rule.every` seconds after the telling.
    """

    def __init__(self, rule: Notice) -> None:
        self._rule = rule
        self._stage: Literal["alert", "closing", "parting"] = "alert"
        self._silent_until = -math.inf
        self._before = math.inf
        self._nearest = math.inf

    def see(self, t: float, distance: float, human_speed: float, robot_speed: float) -> bool:
        """Whether to tell of it at `t` (s), at that distance (m) and those speeds (m/s)."""
        approaching, self._before = distance < self._before, distance
        if self._stage == "alert":
            inside = distance < self._rule.law.distance(human_speed, robot_speed)
            if not (inside and approaching and t >= self._silent_until):
                return False
            if self._rule.every is None:
                self._stage, self._nearest = "closing", distance
            else:
                self._silent_until = t + self._rule.every
            return True
        if self._stage == "closing" and approaching:
            self._nearest = distance
        elif distance < self._nearest:
            self._stage, self._nearest = "closing", distance
        elif distance > self._nearest + self._rule.parting:
            self._stage = "alert"
        else:
            self._stage = "parting"
        return False

    def start_over(self, t: float) -> None:
        """Begin anew at `t` (s), after `rule.silent` seconds: they start, or were put elsewhere."""
        self._stage = "alert"
        self._silent_until = max(self._silent_until, t + self._rule.silent)
        self._before = math.inf
