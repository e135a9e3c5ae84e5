"""How far apart a person and a machine must stay."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Protocol


class Law(Protocol):
    """Any rule for the distance that must be kept.

    `distance` must not shrink when either speed grows: the monitor relies on it to judge whole
    intervals of time at once.
    """

    def distance(self, human_speed: float, robot_speed: float) -> float:
        """The required distance in metres for these speeds in m/s."""
        ...


@dataclass(frozen=True, kw_only=True)
class SeparationLaw:
    """The protective separation distance of speed and separation monitoring, linear form.

    d = k_H (t1 + t2) + k_R t1 + B + δ with k_H the human's speed, k_R the robot's, `t1` the
    time to sense and react, `t2` the time to stop (seconds), B the distance covered while
    `stopping` and δ the `intrusion` allowance (metres).

    Source: ISO/TS 15066:2016, clause 5.5.4; linear form as in J. A. Marvel and R. Norcross,
    "Implementing speed and separation monitoring in collaborative robot workcells", Robotics
    and Computer-Integrated Manufacturing 44, 2017. `ValueError` if a term is negative.
    """

    t1: float
    t2: float
    stopping: float = 0.0
    intrusion: float = 0.0

    def __post_init__(self) -> None:
        for term in fields(self):
            _require_length(term.name, getattr(self, term.name))

    def distance(self, human_speed: float, robot_speed: float) -> float:
        """The required distance in metres for these speeds in m/s."""
        return (
            human_speed * (self.t1 + self.t2)
            + robot_speed * self.t1
            + self.stopping
            + self.intrusion
        )


@dataclass(frozen=True)
class FixedDistance:
    """The same distance at any speed, in metres."""

    metres: float

    def __post_init__(self) -> None:
        _require_length("metres", self.metres)

    def distance(self, human_speed: float, robot_speed: float) -> float:
        """The required distance in metres, whatever the speeds."""
        return self.metres


@dataclass(frozen=True)
class Scaled:
    """`factor` times another law, at most `cap` metres: when people notice a machine."""

    law: Law
    factor: float
    cap: float = math.inf

    def __post_init__(self) -> None:
        _require_length("factor", self.factor)
        if not self.cap >= 0:
            raise ValueError(f"cap must be at least 0, not {self.cap}")

    def distance(self, human_speed: float, robot_speed: float) -> float:
        """The scaled distance in metres for these speeds in m/s."""
        return min(self.factor * self.law.distance(human_speed, robot_speed), self.cap)


def _require_length(name: str, length: float) -> None:
    if not (math.isfinite(length) and length >= 0):
        raise ValueError(f"{name} must be a number of at least 0, not {length}")
