"""Machines moving: the gantry on its rails, and AGVs on their lanes."""

from __future__ import annotations

import itertools
import math
from bisect import bisect_right
from collections.abc import Sequence

from floorplan import Gantry, Lane

from .motion import Cubic, Motion, Piece, State, shift
from .profiles import AxisLimits, AxisState, Phases, straight, to_position, to_rest

GantryLimits = tuple[AxisLimits, AxisLimits, AxisLimits]
"""What the gantry's x, y and rotation can do."""

ARIAC_GANTRY: GantryLimits = (
    AxisLimits(1.0, 0.5, 2.0),
    AxisLimits(1.0, 0.5, 2.0),
    AxisLimits(math.pi / 4, 0.5, 2.0),
)
"""The ceiling robot of ARIAC 2023; its jerk limits are our choice, none are published."""


def gantry_limits(gantry: Gantry) -> GantryLimits:
    """The limits of the gantry on a floorplan."""
    x, y, rotation = (
        AxisLimits(axis.max_speed, axis.max_acceleration, axis.max_jerk) for axis in gantry.axes
    )
    return (x, y, rotation)


def gantry_move(
    current: tuple[float, float, float] | State,
    target: tuple[float, float, float],
    start: float = 0.0,
    *,
    limits: GantryLimits = ARIAC_GANTRY,
) -> Motion:
    """The fastest move to `target` (x, y in metres, rotation in radians), to end at rest.

    `current` is where the gantry stands, or its `State` if it moves: position, velocity and
    acceleration go on without a jump. The axes arrive together, and from rest go straight. The
    move begins at `start` (seconds), and keeps within `limits`.
    """
    target = _plain(target)
    if not isinstance(current, State):
        return _along_axes(straight(_plain(current), target, limits), start)
    if not (any(current.velocity) or any(current.acceleration)):
        return _along_axes(straight(current.position, target, limits), start)
    targets = [AxisState(c) for c in target]
    return _along_axes(to_position(_axis_states(current), targets, limits), start)


def gantry_stop(current: State, start: float, *, limits: GantryLimits = ARIAC_GANTRY) -> Motion:
    """The fastest stop from `current` within `limits`; it begins at `start` (seconds)."""
    return _along_axes(to_rest(_axis_states(current), limits), start)


def agv_run(lane: Lane, current: AxisState, target: str | float, start: float = 0.0) -> Motion:
    """A run along `lane` from the lane position in `current` to `target`, to end at rest.

    `target` is a lane position in metres or the name of a location; `ValueError` if the lane has
    no such place. The run begins at `start` (seconds).
    """
    limits = AxisLimits(lane.max_speed, lane.max_acceleration)
    (phases,) = to_position([current], [AxisState(lane.lane_position(target))], [limits])
    return _along_lane(lane, phases, start)


def agv_stop(lane: Lane, current: AxisState, start: float = 0.0) -> Motion:
    """The fastest stop on `lane` from the lane position in `current`, begun at `start` (s)."""
    limits = AxisLimits(lane.max_speed, lane.max_acceleration)
    (phases,) = to_rest([current], [limits])
    return _along_lane(lane, phases, start)


def lane_state(lane: Lane, state: State) -> AxisState:
    """Where on its lane an AGV in `state` is, and how it moves along it.

    At the ends of the lane, rounding does not take it off.
    """
    (low, high), (c, s) = lane.limits, lane.direction
    (x, y), (vx, vy, _), (ax, ay, _) = state.at, state.velocity, state.acceleration
    q = (x - lane.origin[0]) * c + (y - lane.origin[1]) * s
    return AxisState(min(max(q, low), high), vx * c + vy * s, ax * c + ay * s)


def _plain(pose: Sequence[float]) -> tuple[float, float, float]:
    """Return x, y and rotation as plain floats, of which arrays have none."""
    x, y, rotation = map(float, pose)
    return (x, y, rotation)


def _along_lane(lane: Lane, phases: Phases, start: float) -> Motion:
    (x0, y0), (c, s) = lane.origin, lane.direction
    heading: Cubic = (lane.heading, 0.0, 0.0, 0.0)
    pieces: list[Piece] = []
    t = float(start)
    for duration, (q, v, a, j) in phases:
        along_x: Cubic = (x0 + q * c, v * c, a * c, j * c)
        along_y: Cubic = (y0 + q * s, v * s, a * s, j * s)
        pieces.append(Piece(t, t + duration, along_x, along_y, heading))
        t += duration
    return Motion(tuple(pieces))


def _axis_states(current: State) -> list[AxisState]:
    return [AxisState(*axis) for axis in zip(*current, strict=True)]


def _along_axes(axes: list[Phases], start: float) -> Motion:
    """Three axes with phases of their own as one motion, cut wherever one of them changes."""
    start = float(start)
    begins: list[list[float]] = []
    for phases in axes:
        at = 0.0
        begins.append([])
        for duration, _ in phases:
            begins[-1].append(at)
            at += duration
    ends = [begin[-1] + phases[-1][0] for begin, phases in zip(begins, axes, strict=True)]
    cuts = sorted({t for begin in begins for t in begin} | set(ends))
    pieces: list[Piece] = []
    for lower, upper in itertools.pairwise(cuts):
        if upper - lower < 1e-12 and len(pieces) > 0:
            continue
        x, y, rotation = (
            _phase_at(phases, begin, end, lower)
            for phases, begin, end in zip(axes, begins, ends, strict=True)
        )
        begin = pieces[-1].end if pieces else start + lower
        pieces.append(Piece(begin, start + upper, x, y, rotation))
    if not pieces:
        x, y, rotation = (phases[0][1] for phases in axes)
        pieces.append(Piece(start, start, x, y, rotation))
    return Motion(tuple(pieces))


def _phase_at(phases: Phases, begins: list[float], end: float, t: float) -> Cubic:
    """The cubic of one axis from `t` on; at rest once its phases are over."""
    if t >= end:
        duration, cubic = phases[-1]
        return (shift(cubic, duration)[0], 0.0, 0.0, 0.0)
    k = bisect_right(begins, t) - 1
    return shift(phases[k][1], t - begins[k])
