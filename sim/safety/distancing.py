"""The rule of a distance between people, if one wants it: what breaks it is recorded."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from itertools import combinations

from navigation import Apart, FixedDistance, TooClose

from ..core.events import PeopleTooNear
from ..core.stage import Bystander, Stage
from .nearness import NearWatch

PARTED = 1e-3
"""Metres beyond the distance at which two have parted: rounding does not count twice."""


class Distancing:
    """Watches every two of some people, who have `radii` (m), for bodies nearer than `required`."""

    def __init__(
        self, stage: Stage, people: Sequence[Bystander], radii: Sequence[float], required: float
    ) -> None:
        self.count = 0
        """Number of times that two came too near to each other."""
        self._stage = stage
        self._required = required
        self._time = 0.0
        self._since: dict[tuple[Bystander, Bystander], float] = {}
        for (one, mine), (other, theirs) in combinations(zip(people, radii, strict=True), 2):
            near = required + mine + theirs
            NearWatch(
                stage,
                (one.body, other.body),
                TooClose(FixedDistance(near)),
                Apart(near + PARTED),
                partial(self._changed, one, other, near),
            )

    @property
    def time(self) -> float:
        """How long (s) people were too near until now, all pairs together."""
        now = self._stage.clock.now
        return self._time + sum(now - since for since in self._since.values())

    def _changed(self, one: Bystander, other: Bystander, near: float, is_near: bool) -> None:
        now = self._stage.clock.now
        if not is_near:
            self._time += now - self._since.pop((one, other))
            return
        self.count += 1
        self._since[one, other] = now
        # From surface to surface: `near` is between centres.
        apart = math.dist(one.body.at, other.body.at) - near + self._required
        self._stage.record(
            PeopleTooNear(
                person=one.name, other=other.name, distance=apart, required=self._required
            )
        )
