"""Drives of vehicles through zones with a speed limit."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise

import shapely

from floorplan import Point, Zone
from navigation import Motion, Piece, VehicleLimits, vehicle_segment
from navigation.machines import AxisLimits, AxisState, along_line, to_position
from navigation.motion import State
from navigation.vehicles import through

from ...core.body import MachineShape
from ...core.entries import Pose
from ...core.speed_zones import SLIGHT, Stretch, extent, parts_between, slow_areas

HALVINGS = 40
"""Number of bisections of the interval of a speed."""


class SlowZones:
    """Zones that limit the speed of a vehicle while its footprint covers a part of them."""

    def __init__(self, zones: Iterable[Zone], shape: MachineShape) -> None:
        self.areas = slow_areas(zones, shape.name)
        self._shape = shape

    def path(
        self, current: State | Pose, poses: Sequence[Pose], start: float, limits: VehicleLimits
    ) -> Motion:
        """Return the motion of `vehicle_path` within the speed limits of the zones.

        `ValueError` if the vehicle does not move along the path.
        """
        return through(current, poses, start, limits, partial(self._drive, limits))

    def _drive(self, limits: VehicleLimits, state: State, to: Point, start: float) -> Motion:
        usual = vehicle_segment(state, to, start, limits=limits)
        (x, y, rotation), (vx, vy, _), (ax, ay, _) = state
        length = math.dist((x, y), to)
        c, s = (to[0] - x) / length, (to[1] - y) / length
        angle = math.atan2(s, c) - rotation
        axis = limits.along(math.cos(angle), math.sin(angle))
        parts = self._parts(state.position, to, axis.max_speed)
        if len(parts) == 1 and parts[0].top_speed == axis.max_speed:
            return usual
        now = AxisState(0.0, vx * c + vy * s, ax * c + ay * s)
        speeds = _speeds_between(parts, now.velocity, axis)
        pieces: list[Piece] = []
        t = start
        for (_, end, most), speed in zip(parts, speeds, strict=True):
            within = replace(axis, max_speed=most)
            there = AxisState(end, speed)
            (phases,) = to_position([now], [there], [within])
            pieces += along_line((x, y), (c, s), rotation, phases, t)
            t, now = pieces[-1].end, there
        motion = Motion(tuple(pieces))
        if any(_goes_back(motion.state(p.end), (c, s)) for p in pieces):
            slowest = min(speed for _, _, speed in parts)
            slow = limits.slower(min(1.0, slowest / axis.max_speed))
            return vehicle_segment(state, to, start, limits=slow)
        return motion

    def _parts(self, begin: Pose, to: Point, most: float) -> list[Stretch]:
        """Return the parts of a drive with their top speeds, in order."""
        (x, y, rotation), length = begin, math.dist(begin[:2], to)
        c, s = (to[0] - x) / length, (to[1] - y) / length
        here = self._shape.footprint((x, y), rotation)
        swept = shapely.union(here, self._shape.footprint(to, rotation)).convex_hull
        along = [(px - x) * c + (py - y) * s for px, py in here.exterior.coords]
        slow = [
            Stretch(span[0] - max(along), span[1] - min(along), speed)
            for area, speed in self.areas
            for span in [extent(area, swept, (x, y), (c, s))]
            if span is not None
        ]
        return parts_between(0.0, length, most, slow)


def _goes_back(state: State, direction: Point) -> bool:
    return state.velocity[0] * direction[0] + state.velocity[1] * direction[1] < -SLIGHT


def _speeds_between(parts: Sequence[Stretch], begin: float, axis: AxisLimits) -> list[float]:
    """Return the speed at the end of each part: 0 at the last one."""
    tops = [min(one.top_speed, other.top_speed) for one, other in pairwise(parts)]
    speeds = [begin, *tops, 0.0]
    for k in range(len(parts) - 1, 0, -1):
        length = parts[k].end - parts[k].begin
        speeds[k] = _reachable(speeds[k], speeds[k + 1], length, axis)
    for k in range(1, len(parts)):
        length = parts[k - 1].end - parts[k - 1].begin
        speeds[k] = _reachable(speeds[k], speeds[k - 1], length, axis)
    return speeds[1:]


def _reachable(speed: float, other: float, length: float, axis: AxisLimits) -> float:
    """Return the highest speed up to one that can change from, or to, another within a length."""
    if speed <= other or _distance(speed, other, axis) <= length:
        return speed
    low, high = other, speed
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        if _distance(middle, other, axis) <= length:
            low = middle
        else:
            high = middle
    return low


def _distance(speed: float, other: float, axis: AxisLimits) -> float:
    """Return a distance in which a speed can change to another without acceleration at its ends."""
    change = abs(speed - other)
    seconds = change / axis.max_acceleration + axis.max_acceleration / axis.max_jerk
    return (speed + other) / 2 * max(seconds, 2 * math.sqrt(change / axis.max_jerk))
