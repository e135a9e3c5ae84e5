"""Collisions of machines: they are recorded, and the machines go on through each other."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import lru_cache, partial
from itertools import combinations

from navigation import Box, Condition, Not, Overlapping

from ..core.events import Collision
from ..core.machine import Machine
from ..core.stage import Stage
from .nearness import NearWatch

DEPTH = 1e-3
"""Metres. Boxes that overlap by no more only touch, as those of machines side by side may."""


@lru_cache(maxsize=1024)
def _conditions(box: Box, others: Box) -> tuple[Condition, Condition]:
    """Return when two boxes collide, and when they have parted."""
    return Overlapping(box, others, DEPTH), Not(Overlapping(box, others))


class Collisions:
    """Watches every two of some machines whose boxes are not above each other."""

    def __init__(self, stage: Stage, machines: Iterable[Machine]) -> None:
        self.count = 0
        """Number of times that two machines ran into each other."""
        self._stage = stage
        boxes = [(machine, machine.shape.box) for machine in machines]
        for (one, box), (other, others) in combinations(boxes, 2):
            if box.is_level_with(others):
                near, parted = _conditions(box, others)
                notify = partial(self._changed, one, other)
                NearWatch(stage, (one.body, other.body), near, parted, notify)

    def _changed(self, one: Machine, other: Machine, is_near: bool) -> None:
        if not is_near:
            return
        self.count += 1
        (vx, vy, _), (wx, wy, _) = one.body.state.velocity, other.body.state.velocity
        self._stage.record(
            Collision(machine=one.name, with_=other.name, speed=math.hypot(wx - vx, wy - vy))
        )
