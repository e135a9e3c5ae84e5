"""Motions of machines: the gantry on its rails, and AGVs on their lanes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple, TypeAlias

from floorplan import Gantry, Lane

from .kernels.braking import AxisStops, LaneStops
from .kernels.numbers import numbers
from .kernels.pieces import merge_axes
from .motion import Motion, Piece, State, Table, TablePieces
from .profiles import (
    AxisLimits,
    AxisState,
    Phases,
    along_line,
    rows_to_position,
    straight,
    to_position,
)

GantryLimits = tuple[AxisLimits, AxisLimits, AxisLimits]
"""Limits of the gantry's x, y and rotation."""

ARIAC_GANTRY: GantryLimits = (
    AxisLimits(1.0, 0.5, 2.0),
    AxisLimits(1.0, 0.5, 2.0),
    AxisLimits(math.pi / 4, 0.5, 2.0),
)
"""The ceiling robot of ARIAC 2023; its jerk limits are our choice, none are published."""

Machine: TypeAlias = Gantry | Lane | GantryLimits
"""A machine beside people: a gantry, the lane of an AGV, or the limits of a gantry's axes."""


class Stop(NamedTuple):
    """The end of a motion, from the instant at which braking begins."""

    time: float
    """Seconds to standstill."""
    distance: float
    """Metres from where braking begins to where the machine stands."""


def gantry_limits(gantry: Gantry) -> GantryLimits:
    """Return the limits of the gantry on a floorplan."""
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
    """Return the fastest move to `target` (x, y in metres, rotation in radians), to end at rest.

    `current` is where the gantry stands, or its `State` if it moves: position, velocity and
    acceleration go on without a jump. The axes arrive together, and from rest go straight. The
    move begins at `start` (seconds), and keeps within `limits`.
    """
    target = _plain(target)
    if not isinstance(current, State):
        return _along_axes(straight(_plain(current), target, limits), start)
    if not (any(current.velocity) or any(current.acceleration)):
        return _along_axes(straight(current.position, target, limits), start)
    return _along_axes(rows_to_position(current, (target, _STILL, _STILL), limits), start)


def gantry_stop(current: State, start: float, *, limits: GantryLimits = ARIAC_GANTRY) -> Motion:
    """Return the fastest stop from `current` within `limits`; it begins at `start` (seconds)."""
    state = numbers([*current.position, *current.velocity, *current.acceleration])
    return Motion(TablePieces(gantry_stops(limits).after(state, float(start))))


@lru_cache
def gantry_stops(limits: GantryLimits = ARIAC_GANTRY) -> AxisStops:
    """Return how a gantry with these `limits` stops: each axis by itself, as fast as it can."""
    return AxisStops([c for axis in limits for c in (axis.max_acceleration, axis.max_jerk)])


def agv_run(lane: Lane, current: AxisState, target: str | float, start: float = 0.0) -> Motion:
    """Return a run along `lane` from the lane position in `current` to `target`, to end at rest.

    `target` is a lane position in metres or the name of a location; `ValueError` if the lane has
    no such place. The run begins at `start` (seconds).
    """
    limits = AxisLimits(lane.max_speed, lane.max_acceleration)
    (phases,) = to_position([current], [AxisState(lane.lane_position(target))], [limits])
    return _along_lane(lane, phases, start)


def agv_stop(lane: Lane, current: AxisState, start: float = 0.0) -> Motion:
    """The fastest stop on `lane` from the lane position in `current`, begun at `start` (s)."""
    state = (current.position, current.velocity, current.acceleration)
    return Motion(TablePieces(agv_stops(lane).after(*state, float(start))))


def agv_stops(lane: Lane) -> LaneStops:
    """Return how an AGV stops on `lane`, as fast as it can."""
    return LaneStops(
        *lane.origin, *lane.direction, lane.heading, *lane.limits, lane.max_acceleration
    )


def lane_state(lane: Lane, state: State) -> AxisState:
    """Return the lane position of an AGV in `state`, and its motion along the lane.

    It is on the lane, whatever rounding says.
    """
    (low, high), (c, s) = lane.limits, lane.direction
    (x, y), (vx, vy, _), (ax, ay, _) = state.at, state.velocity, state.acceleration
    q = (x - lane.origin[0]) * c + (y - lane.origin[1]) * s
    return AxisState(min(max(q, low), high), vx * c + vy * s, ax * c + ay * s)


def longest_stop(machine: Machine) -> Stop:
    """Return the longest and the farthest stop that the limits of `machine` leave it.

    A gantry brakes each axis by itself. It stands when the slowest axis does, rotation included,
    and goes farthest if x and y both do. An AGV brakes along its lane, without a limit of jerk.
    `TypeError` for anything else.
    """
    if isinstance(machine, Lane):
        return _longest_of_axis(AxisLimits(machine.max_speed, machine.max_acceleration))
    limits = gantry_limits(machine) if isinstance(machine, Gantry) else machine
    if not (
        isinstance(limits, tuple)
        and len(limits) == 3
        and all(isinstance(axis, AxisLimits) for axis in limits)
    ):
        raise TypeError(f"expected a Gantry, a Lane or GantryLimits, found {machine!r}")
    x, y, rotation = (_longest_of_axis(axis) for axis in limits)
    return Stop(max(x.time, y.time, rotation.time), math.hypot(x.distance, y.distance))


def _plain(pose: Sequence[float]) -> tuple[float, float, float]:
    """Return x, y and rotation as plain floats, of which arrays have none."""
    try:
        x, y, rotation = map(float, pose)
    except (TypeError, ValueError):
        raise ValueError(f"a pose is x, y and a rotation, found {pose!r}") from None
    return (x, y, rotation)


def _along_lane(lane: Lane, phases: Phases, start: float) -> Motion:
    pieces = along_line(lane.origin, lane.direction, lane.heading, phases, float(start))
    return Motion(tuple(pieces))


_STILL = (0.0, 0.0, 0.0)
"""Velocity, or acceleration, of all axes at rest."""


def _along_axes(axes: list[Table], start: float) -> Motion:
    """Return three axes with phases of their own as one motion, cut where one of them changes."""
    start = float(start)
    if not (table := merge_axes(axes, start)):
        x, y, rotation = ((rows[1], rows[2], rows[3], rows[4]) for rows in axes)
        return Motion((Piece(start, start, x, y, rotation),))
    return Motion(TablePieces(table))


def _longest_of_axis(limits: AxisLimits) -> Stop:
    """Return the longest stop of one axis.

    From speed v, and no acceleration, the jerk-limited profile takes T = v / a + a / j and covers
    v T / 2; where a is never reached, since v j < a², T = 2 √(v / j). Source: L. Biagiotti and
    C. Melchiorri, "Trajectory Planning for Automatic Machines and Robots", 2008, section 3.4.

    The longest stop begins when the axis still accelerates, by a₀, and can just stay within its
    top speed v: it reaches it a₀ / j later and v a₀ / j - a₀³ / (6 j²) farther on.
    """
    v, a, j = limits.max_speed, limits.max_acceleration, limits.max_jerk
    # v j < a²: the acceleration is let off again before it has come to its limit.
    braking = v / a + a / j if v * j >= a * a else 2 * math.sqrt(v / j)
    # a₀² / (2 j) is gained while an acceleration a₀ ends at jerk j: more than v can't be.
    accelerating = min(a, math.sqrt(2 * j * v))
    easing = accelerating / j
    return Stop(easing + braking, v * (easing + braking / 2) - accelerating * easing**2 / 6)
