"""Parts of a lane: where an AGV covers an area, and runs past slow parts."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

import shapely

from floorplan import Gate, Lane, rectangle
from navigation import Motion, agv_run, agv_stop, walk
from navigation.machines import AxisState, lane_state

from ...core.speed_zones import SLIGHT, Stretch, extent, parts_between

MARGIN = 0.1
"""Metres. Distance at which an AGV stops before an obstacle."""

Span = tuple[float, float]
"""Lowest and highest lane position, metres."""


def part_within(lane: Lane, area: shapely.Geometry) -> Span | None:
    """Return the lane positions at which the AGV covers some of `area`, if there are any."""
    low, high = lane.limits
    middle = lane.position((low + high) / 2)
    # From half a length before the lowest position to half a length behind the highest.
    swept = rectangle(middle, lane.direction, high - low + lane.length, lane.width)
    span = extent(area, swept, lane.origin, lane.direction)
    return None if span is None else (span[0] - lane.length / 2, span[1] + lane.length / 2)


def part_behind(lane: Lane, gate: Gate, at: float, to: float) -> Span | None:
    """Return the lane positions that `gate` closes to a run from `at` to `to`, if there are any.

    At these, the centre is on the far side and the AGV covers the line of the gate. A run in the
    direction of the gate has none.
    """
    (nx, ny), (c, s) = gate.normal, lane.direction
    ahead = nx * c + ny * s
    if ahead * (to - at) >= 0:
        return None
    course = shapely.linestrings([lane.position(q) for q in lane.limits])
    crossing = shapely.intersection(course, shapely.linestrings(gate.ends))
    if crossing.is_empty:
        return None
    q = float(lane.along(shapely.get_coordinates(crossing)[0]))
    # A box at an angle to a line reaches it by half its length, and by half its width times the
    # tangent of the angle between the lane and the direction of the gate.
    reach = (lane.length + abs(ny * c - nx * s) / abs(ahead) * lane.width) / 2
    return (q, q + reach) if ahead > 0 else (q - reach, q)


def last_before(part: Span, at: float, to: float) -> float | None:
    """Return the last lane position before `part` on a run from `at` to `to`, or None if clear.

    An AGV inside the part stays where it is.
    """
    low, high = part
    if to >= at:
        return None if high <= at or to <= low else max(at, low - MARGIN)
    return None if low >= at or to >= high else min(at, high + MARGIN)


def run_slowly(
    lane: Lane, state: AxisState, to: float, start: float, slow: Sequence[Stretch]
) -> Motion:
    """Return a run on `lane` from `start` (s) to the position `to`, within the limits of `slow`.

    An AGV that must turn back, or is too fast for a part, brakes first.
    """
    at, speed = state.position, state.velocity
    sign = 1.0 if to >= at else -1.0
    low, high = sorted((at, to))
    parts = parts_between(low, high, lane.max_speed, slow)
    if all(part.top_speed == lane.max_speed for part in parts):
        return agv_run(lane, state, to, start)
    if sign < 0:
        parts.reverse()
    if speed * sign >= 0.0 and low < high:
        ends = [part.end if sign > 0 else part.begin for part in parts]
        with suppress(ValueError):  # too fast for a part
            motion = walk(
                [lane.position(q) for q in (at, *ends)],
                start,
                initial_speed=abs(speed),
                top_speed=[part.top_speed for part in parts],
                max_speed=lane.max_speed,
                max_acceleration=lane.max_acceleration,
            )
            return _with_heading(lane, motion)
    if abs(speed) < SLIGHT:
        return agv_run(lane, state, to, start)
    stop = agv_stop(lane, state, start)
    rest = lane_state(lane, stop.state(stop.end))
    # The recursion ends here, because an AGV at rest does not brake first.
    onwards = run_slowly(lane, AxisState(rest.position), to, stop.end, slow)
    return Motion((*stop.pieces, *onwards.pieces))


def _with_heading(lane: Lane, motion: Motion) -> Motion:
    """Return `motion` with the rotation of the lane."""
    rotation = (lane.heading, 0.0, 0.0, 0.0)
    return Motion(tuple(piece._replace(rotation=rotation) for piece in motion.pieces))
