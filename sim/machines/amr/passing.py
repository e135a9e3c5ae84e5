"""Passing places: free poses near a vehicle."""

from __future__ import annotations

import math
from collections.abc import Iterator

from navigation import VehiclePlanner

from ...core.entries import Pose

STEP = 0.5
"""Metres between candidates."""

REACH = 15.0
"""Metres. Largest distance of a candidate."""

APART = 1.0
"""Metres. Smallest distance between passing places."""

HEADINGS = (0.0, math.pi / 2, math.pi / 4, -math.pi / 4)
"""Headings of candidates relative to the vehicle, radians."""


def passing_places(planner: VehiclePlanner, here: Pose) -> Iterator[Pose]:
    """Yield poses at which the vehicle touches nothing, the nearest first."""
    x, y, rotation = here
    poses: list[Pose] = []
    for ring in range(1, math.ceil(REACH / STEP) + 1):
        radius = ring * STEP
        count = max(8, math.ceil(math.tau * radius / STEP))
        for k in range(count):
            angle = rotation + math.tau * k / count
            at = x + radius * math.cos(angle), y + radius * math.sin(angle)
            if any(math.dist(at, other[:2]) < APART for other in poses):
                continue
            for turned in HEADINGS:
                if planner.fits(pose := (*at, rotation + turned)):
                    poses.append(pose)
                    yield pose
                    break
