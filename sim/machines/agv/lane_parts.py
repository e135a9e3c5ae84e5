"""Parts of a lane: those that an obstacle closes, and those where an AGV drives slowly."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np
import shapely

from floorplan import Gate, Lane, Zone, rectangle
from navigation import AxisState, Motion, agv_run, agv_stop, lane_state, paced

MARGIN = 0.1
"""Metres. An AGV stops so far from what is in its way."""

SLIGHT = 1e-6
"""Metres, and m/s. What is less than this counts as nothing."""

Part = tuple[float, float]
"""Lane positions from the least to the greatest, metres."""


def part_within(lane: Lane, area: shapely.Geometry) -> Part | None:
    """Return the lane positions at which the AGV covers some of `area`, if there are any."""
    low, high = lane.limits
    middle = lane.position((low + high) / 2)
    # All that the AGV ever covers on its lane: from half a length before its first place to half a
    # length behind its last.
    swept = rectangle(middle, lane.direction, high - low + lane.length, lane.width)
    shared = shapely.intersection(area, swept)
    if shared.area <= SLIGHT**2:
        return None
    (x, y), (c, s) = lane.origin, lane.direction
    corners = shapely.get_coordinates(shared) - (x, y)
    along = corners @ np.array([c, s])
    return float(along.min()) - lane.length / 2, float(along.max()) + lane.length / 2


def part_behind(lane: Lane, gate: Gate, at: float, to: float) -> Part | None:
    """Return the lane positions that `gate` closes to a run from `at` to `to`, if there are any.

    Those with the centre on its far side at which the AGV stands on its line: none to a run in its
    direction.
    """
    (nx, ny), (c, s) = gate.normal, lane.direction
    ahead = nx * c + ny * s
    if ahead * (to - at) >= 0:
        return None
    course = shapely.linestrings([lane.position(q) for q in lane.limits])
    crossing = shapely.intersection(course, shapely.linestrings(gate.ends))
    if crossing.is_empty:
        return None
    (x, y), (ox, oy) = shapely.get_coordinates(crossing)[0], lane.origin
    q = float((x - ox) * c + (y - oy) * s)
    # As a box at an angle to the line: half its length, and half its width times the tangent of the
    # angle between lane and gate's direction.
    reach = (lane.length + abs(ny * c - nx * s) / abs(ahead) * lane.width) / 2
    return (q, q + reach) if ahead > 0 else (q - reach, q)


def last_before(part: Part, at: float, to: float) -> float | None:
    """Return the last lane position before `part` on a run from `at` to `to`; None if it is clear.

    Who is in the part already stays.
    """
    low, high = part
    if to >= at:
        return None if high <= at or to <= low else max(at, low - MARGIN)
    return None if low >= at or to >= high else min(at, high + MARGIN)


def run_slowly(
    lane: Lane, state: AxisState, to: float, start: float, slow: Iterable[tuple[Part, float]]
) -> Motion:
    """Return a run on `lane` to the position `to`, begun at `start` (seconds).

    It is no faster than the speed (m/s) of each of the parts that are driven `slow`ly. One that
    has to turn back, or is too fast for a part, brakes first.
    """
    at, speed = state.position, state.velocity
    way = 1.0 if to >= at else -1.0
    low, high = sorted((at, to))
    ahead = [(part, limit) for part, limit in slow if part[0] < high and low < part[1]]
    if not ahead:
        return agv_run(lane, state, to, start)
    edges = {e for part, _ in ahead for e in part if low + SLIGHT < e < high - SLIGHT}
    points = sorted({at, to, *edges}, reverse=way < 0)
    if speed * way >= 0.0 and len(points) > 1:
        motion = paced(
            [lane.position(q) for q in points],
            start,
            initial_speed=abs(speed),
            top_speed=[_limit(lane, sum(leg) / 2, ahead) for leg in pairwise(points)],
            max_speed=lane.max_speed,
            max_acceleration=lane.max_acceleration,
        )
        if motion is not None:
            return _looking_along(lane, motion)
    if abs(speed) < SLIGHT:
        return agv_run(lane, state, to, start)
    stop = agv_stop(lane, state, start)
    rested = lane_state(lane, stop.state(stop.end))
    # From rest there is nothing to brake for, so this calls itself once at most.
    onwards = run_slowly(lane, AxisState(rested.position), to, stop.end, ahead)
    return Motion((*stop.pieces, *onwards.pieces))


def slow_parts(lane: Lane, zones: Sequence[Zone]) -> list[tuple[Part, float]]:
    """Return the parts of a lane that lie in zones with a speed limit (m/s) for its AGV."""
    return [
        (part, zone.max_speed)
        for zone in zones
        if zone.max_speed is not None and zone.is_about(lane.name)
        for part in [part_within(lane, zone.area)]
        if part is not None
    ]


def _limit(lane: Lane, q: float, slow: Iterable[tuple[Part, float]]) -> float:
    return min([lane.max_speed, *(limit for (low, high), limit in slow if low <= q <= high)])


def _looking_along(lane: Lane, motion: Motion) -> Motion:
    """Return `motion` with the rotation that an AGV has on its lane at all times."""
    rotation = (lane.heading, 0.0, 0.0, 0.0)
    return Motion(tuple(piece._replace(rotation=rotation) for piece in motion.pieces))
