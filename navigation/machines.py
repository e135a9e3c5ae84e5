"""Motions of machines: time-optimal profiles along axes with limits, the gantry and AGVs.

Ruckig: L. Berscheid and T. Kröger, "Jerk-limited Real-time Trajectory Generation with
Arbitrary Target States", Robotics: Science and Systems 2021.
"""

from __future__ import annotations

import math
import threading
from collections.abc import MutableSequence, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple, TypeAlias

import ruckig

from floorplan import Gantry, Lane
from floorplan.files.dataclass import dataclass

from .kernels.braking import AxisStops, LaneStops, stands
from .kernels.numbers import numbers
from .kernels.pieces import merge_axes, phases_of, scaled
from .kernels.walks import NOWHERE
from .motion import Cubic, Motion, Piece, State, Table, TablePieces


@dataclass(frozen=True)
class AxisLimits:
    """Limits of one axis in m/s, m/s² and m/s³, or in radians. Without a jerk limit it is inf."""

    max_speed: float
    max_acceleration: float
    max_jerk: float = math.inf

    def __post_init__(self) -> None:
        for name in ("max_speed", "max_acceleration", "max_jerk"):
            limit = getattr(self, name)
            if not limit > 0:
                raise ValueError(f"{name} must be more than 0, not {limit}")


@dataclass(frozen=True)
class AxisState:
    """State of one axis in metres (or radians) and seconds."""

    position: float
    velocity: float = 0.0
    acceleration: float = 0.0


_MOST_KEPT = 256
"""Maximum number of cached profiles from rest to rest."""

Phases = list[tuple[float, Cubic]]
"""Duration (seconds) and cubic of each phase of an axis."""

Rows = MutableSequence[float]
"""Phases of one axis as a row for kernels: duration and coefficients of each."""

States = tuple[Sequence[float], Sequence[float], Sequence[float]]
"""Positions, velocities and accelerations of axes."""


def to_position(
    current: Sequence[AxisState], target: Sequence[AxisState], limits: Sequence[AxisLimits]
) -> list[Phases]:
    """Return the fastest profiles from `current` to `target` that arrive together.

    `ValueError` if there are none.
    """
    rows = rows_to_position(_columns(current), _columns(target), limits)
    return [phases_in(axis) for axis in rows]


def rows_to_position(current: States, target: States, limits: Sequence[AxisLimits]) -> list[Rows]:
    """Return the profiles of `to_position` as rows: duration and coefficients of each phase."""
    place, velocity, acceleration = current
    under_way = any(velocity) or any(acceleration) or any(target[1]) or any(target[2])
    if not under_way and [*place] == [*target[0]]:
        return [numbers([0.0, at, 0.0, 0.0, 0.0]) for at in place]
    states = [
        # Ruckig would treat rounding of an axis at rest as a motion.
        [at, 0.0, 0.0] if stands(v, a) else [at, v, a]
        for at, v, a in zip(place, velocity, acceleration, strict=True)
    ]
    return _solve(states, target, limits)


def straight(
    current: Sequence[float], target: Sequence[float], limits: Sequence[AxisLimits]
) -> list[Rows]:
    """Return the fastest profiles from rest to rest along a straight line: see `rows_to_position`.

    The line is planned as one axis of the length of the longest span, with limits that all axes
    permit.
    """
    spans = [b - a for a, b in zip(current, target, strict=True)]
    length = max(abs(span) for span in spans)
    if length < NOWHERE:
        return [numbers([0.0, a, 0.0, 0.0, 0.0]) for a in current]
    # Each axis moves by a share of the longest one, and so do its speed and acceleration.
    shares = [span / length for span in spans]
    moving = [(abs(share), axis) for share, axis in zip(shares, limits, strict=True) if share]
    along = _from_rest(
        length,
        min(axis.max_speed / share for share, axis in moving),
        min(axis.max_acceleration / share for share, axis in moving),
        min(axis.max_jerk / share for share, axis in moving),
    )
    return [scaled(along, a, share) for a, share in zip(current, shares, strict=True)]


@lru_cache(_MOST_KEPT)
def _from_rest(length: float, speed: float, acceleration: float, jerk: float) -> Rows:
    """Return the rows of an axis from rest at 0 to rest at `length` within the limits.

    They are cached, because machines often repeat a move.
    """
    limits = AxisLimits(speed, acceleration, jerk)
    (along,) = rows_to_position(((0.0,), _REST, _REST), ((length,), _REST, _REST), [limits])
    return along


def along_line(
    origin: tuple[float, float],
    direction: tuple[float, float],
    heading: float,
    phases: Phases,
    start: float,
) -> list[Piece]:
    """Return the pieces of a motion along a line, from `start` (seconds) on.

    At position s of its `phases`, the body is s metres from `origin` in `direction` (a unit
    vector), and turned by `heading` (radians).
    """
    (x, y), (c, s) = origin, direction
    pieces: list[Piece] = []
    for duration, (q, v, a, j) in phases:
        end = start + duration
        along_x, along_y = (x + q * c, v * c, a * c, j * c), (y + q * s, v * s, a * s, j * s)
        pieces.append(Piece(start, end, along_x, along_y, (heading, 0.0, 0.0, 0.0)))
        start = end
    return pieces


_REST = (0.0,)
"""Velocity, or acceleration, of one axis at rest."""


class _Ruckig(threading.local):
    """Ruckig's solvers and parameters for each thread, because creating them is slow."""

    def __init__(self) -> None:
        self.solvers: dict[int, Any] = {}
        """Solvers by the number of axes."""
        self.tasks: dict[tuple[AxisLimits, ...], Any] = {}
        self.last: tuple[Sequence[AxisLimits], Any, Any] = ((), None, None)
        """Limits of the last request, with its solver and parameters."""

    def of(self, limits: Sequence[AxisLimits]) -> tuple[Any, Any]:
        """Return solver and parameters for axes with these limits."""
        last_limits, solver, task = self.last
        if limits is last_limits:
            return solver, task
        axes = tuple(limits)
        task = self.tasks.get(axes)
        if task is None:
            if len(self.tasks) >= _MOST_KEPT:
                self.tasks.clear()
            task = self.tasks[axes] = ruckig.InputParameter(len(axes))
            task.max_velocity = [axis.max_speed for axis in axes]
            task.max_acceleration = [axis.max_acceleration for axis in axes]
            task.max_jerk = [axis.max_jerk for axis in axes]
            if len(axes) not in self.solvers:
                self.solvers[len(axes)] = ruckig.Ruckig(len(axes))
        solver = self.solvers[len(axes)]
        self.last = (axes, solver, task)
        return solver, task


_RUCKIG = _Ruckig()

_SOFTER = (1e-12, 1e-11, 1e-10)
"""Shares by which the jerk is reduced in turn if Ruckig finds no profile."""


def _solve(
    states: list[list[float]],
    target: States,
    limits: Sequence[AxisLimits],
    softer: Sequence[float] = _SOFTER,
) -> list[Rows]:
    """Return Ruckig's profile of each axis in `states`, as rows for `merge_axes`.

    If two profiles tie, as for 2 a³ / j² metres from rest to rest, rounding may make Ruckig reject
    both (https://github.com/pantor/ruckig/issues/141). A slightly smaller jerk moves the tie. The
    motion still ends at `target`, and is within 1e-9 m of the fastest up to 10 m.
    """
    solver, task = _RUCKIG.of(limits)
    task.current_position, task.current_velocity, task.current_acceleration = zip(
        *states, strict=True
    )
    task.target_position, task.target_velocity, task.target_acceleration = target
    trajectory = ruckig.Trajectory(len(states))  # a reused one keeps old brake profiles
    try:
        result = solver.calculate(task, trajectory)
        why = result.name
    except (ruckig.RuckigError, ValueError) as error:  # its enumeration lacks some results
        result, why = ruckig.Result.Error, str(error)
    if result not in _FOUND:
        if softer:
            share = 1.0 - softer[0]
            limits = [replace(axis, max_jerk=axis.max_jerk * share) for axis in limits]
            return _solve(states, target, limits, softer[1:])
        raise ValueError(f"no motion within these limits: {why}")
    rows = []
    for profile, state in zip(trajectory.profiles[0], states, strict=True):
        brake = profile.brake
        if brake.duration > 0.0:  # brake phases precede the seven of the profile
            durations, jerks = brake.t + profile.t, brake.j + profile.j
            rows.append(phases_of(state, durations, brake.a + profile.a, jerks))
        else:
            rows.append(phases_of(state, profile.t, profile.a, profile.j))
    return rows


_FOUND = (ruckig.Result.Working, ruckig.Result.Finished)


def _columns(states: Sequence[AxisState]) -> States:
    """Return the states of axes as columns."""
    return (
        [state.position for state in states],
        [state.velocity for state in states],
        [state.acceleration for state in states],
    )


def phases_in(rows: Rows) -> Phases:
    """Return the rows of one axis as phases."""
    return [
        (rows[k], (rows[k + 1], rows[k + 2], rows[k + 3], rows[k + 4]))
        for k in range(0, len(rows), 5)
    ]


GantryLimits = tuple[AxisLimits, AxisLimits, AxisLimits]
"""Limits of the gantry's x, y and rotation."""

ARIAC_GANTRY: GantryLimits = (
    AxisLimits(1.0, 0.5, 2.0),
    AxisLimits(1.0, 0.5, 2.0),
    AxisLimits(math.pi / 4, 0.5, 2.0),
)
"""The ceiling robot of ARIAC 2023. Its jerk limits are assumptions, because none are published."""

Machine: TypeAlias = Gantry | Lane | GantryLimits
"""Machine beside people: a gantry, the lane of an AGV, or the limits of a gantry's axes."""


class Stop(NamedTuple):
    """End of a motion, from the begin of braking."""

    time: float
    """Seconds to standstill."""
    distance: float
    """Metres from the begin of braking to standstill."""


def gantry_limits(gantry: Gantry) -> GantryLimits:
    """Return the limits of the gantry of a floorplan."""
    x, y, rotation = (
        AxisLimits(axis.max_speed, axis.max_acceleration, axis.max_jerk) for axis in gantry.axes
    )
    return (x, y, rotation)


def gantry_move(
    current: tuple[float, float, float] | State,
    target: tuple[float, float, float],
    start: float = 0.0,
    *,
    limits: Gantry | GantryLimits = ARIAC_GANTRY,
) -> Motion:
    """Return the fastest motion of a gantry to a target, where it stops.

    All axes arrive together. From rest they move along a straight line.

    Parameters
    ----------
    current : tuple of float or State
        Present x and y in metres and rotation in radians, or the present state of a moving gantry.
    target : tuple of float
        x and y in metres, and the rotation in radians.
    start : float, optional
        Start time in seconds.
    limits : Gantry or tuple of AxisLimits, optional
        Limits of the axes, by default those of ARIAC's gantry.

    Returns
    -------
    Motion
        Motion without a jump in position or velocity.

    Raises
    ------
    ValueError
        If a pose is invalid, or if no motion exists within the limits.

    Notes
    -----
    Ruckig computes the profiles: L. Berscheid and T. Kröger, "Jerk-limited Real-time Trajectory
    Generation with Arbitrary Target States", Robotics: Science and Systems 2021.
    """
    target = _plain(target)
    limits = gantry_limits(limits) if isinstance(limits, Gantry) else limits
    if not isinstance(current, State):
        return _along_axes(straight(_plain(current), target, limits), start)
    if not (any(current.velocity) or any(current.acceleration)):
        return _along_axes(straight(current.position, target, limits), start)
    return _along_axes(rows_to_position(current, (target, _STILL, _STILL), limits), start)


def gantry_stop(
    current: State, start: float, *, limits: Gantry | GantryLimits = ARIAC_GANTRY
) -> Motion:
    """Return the fastest stop of a gantry.

    Parameters
    ----------
    current : State
        Present state.
    start : float
        Start time in seconds.
    limits
        See `gantry_move`.

    Returns
    -------
    Motion
        Motion in which each axis stops independently.
    """
    limits = gantry_limits(limits) if isinstance(limits, Gantry) else limits
    state = [*map(float, (*current.position, *current.velocity, *current.acceleration))]
    return Motion(TablePieces(gantry_stops(limits).after(state, float(start))))


@lru_cache
def gantry_stops(limits: GantryLimits = ARIAC_GANTRY) -> AxisStops:
    """Return the stops of a gantry with these `limits`, each axis independently."""
    return AxisStops([c for axis in limits for c in (axis.max_acceleration, axis.max_jerk)])


def agv_run(
    lane: Lane, current: float | State | AxisState, target: str | float, start: float = 0.0
) -> Motion:
    """Return the fastest motion of an AGV along its lane to a target, where it stops.

    Parameters
    ----------
    lane : Lane
        Lane of the AGV.
    current : float, State or AxisState
        Present lane position in metres, or the present state of a moving AGV.
    target : str or float
        Location, or lane position in metres.
    start : float, optional
        Start time in seconds.

    Returns
    -------
    Motion
        Motion along the lane.

    Raises
    ------
    floorplan.UserError
        If the lane has no such position.
    """
    limits = AxisLimits(lane.max_speed, lane.max_acceleration)
    begin, end = _on_lane(lane, current), AxisState(lane.lane_position(target))
    (phases,) = to_position([begin], [end], [limits])
    return _along_lane(lane, phases, start)


def agv_stop(lane: Lane, current: State | AxisState, start: float = 0.0) -> Motion:
    """Return the fastest stop of an AGV on its lane.

    Parameters
    ----------
    lane : Lane
        Lane of the AGV.
    current : State or AxisState
        Present state.
    start : float, optional
        Start time in seconds.

    Returns
    -------
    Motion
        Motion along the lane.
    """
    now = _on_lane(lane, current)
    state = (now.position, now.velocity, now.acceleration)
    return Motion(TablePieces(agv_stops(lane).after(*state, float(start))))


def _on_lane(lane: Lane, current: float | State | AxisState) -> AxisState:
    if isinstance(current, State):
        return lane_state(lane, current)
    return current if isinstance(current, AxisState) else AxisState(float(current))


def agv_stops(lane: Lane) -> LaneStops:
    """Return the stops of an AGV on `lane`."""
    return LaneStops(
        *lane.origin, *lane.direction, lane.heading, *lane.limits, lane.max_acceleration
    )


def lane_state(lane: Lane, state: State) -> AxisState:
    """Return the lane position of an AGV in `state` and its motion along the lane.

    The position is within the limits of the lane.
    """
    (low, high), (c, s) = lane.limits, lane.direction
    (vx, vy, _), (ax, ay, _) = state.velocity, state.acceleration
    return AxisState(min(max(lane.along(state.at), low), high), vx * c + vy * s, ax * c + ay * s)


def longest_stop(machine: Machine) -> Stop:
    """Return the longest and farthest stop of a machine within its limits.

    The axes of a gantry stop independently. Its time is that of the slowest axis, and its distance
    that of x and y together. An AGV has no jerk limit. `TypeError` for anything else.
    """
    if isinstance(machine, Lane):
        return longest_of_axis(AxisLimits(machine.max_speed, machine.max_acceleration))
    limits = gantry_limits(machine) if isinstance(machine, Gantry) else machine
    if not (
        isinstance(limits, tuple)
        and len(limits) == 3
        and all(isinstance(axis, AxisLimits) for axis in limits)
    ):
        raise TypeError(f"expected a Gantry, a Lane or GantryLimits, found {machine!r}")
    x, y, rotation = (longest_of_axis(axis) for axis in limits)
    return Stop(max(x.time, y.time, rotation.time), math.hypot(x.distance, y.distance))


def _plain(pose: Sequence[float]) -> tuple[float, float, float]:
    """Return x, y and rotation as Python floats, also from arrays."""
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
    """Return three axes with separate phases as one motion, divided where an axis changes."""
    start = float(start)
    if not (table := merge_axes(axes, start)):
        x, y, rotation = ((rows[1], rows[2], rows[3], rows[4]) for rows in axes)
        return Motion((Piece(start, start, x, y, rotation),))
    return Motion(TablePieces(table))


def longest_of_axis(limits: AxisLimits) -> Stop:
    """Return the longest stop of one axis.

    From speed v without acceleration, the jerk-limited profile takes T = v / a + a / j and covers
    v T / 2. If a is never reached, because v j < a², T = 2 √(v / j). Source: L. Biagiotti and
    C. Melchiorri, "Trajectory Planning for Automatic Machines and Robots", 2008, section 3.4.

    The longest stop begins while the axis accelerates with a₀, and can just stay within its top
    speed v. It reaches v after a₀ / j and v a₀ / j - a₀³ / (6 j²) metres.
    """
    v, a, j = limits.max_speed, limits.max_acceleration, limits.max_jerk
    # If v j < a², the acceleration decreases before it reaches its limit.
    braking = v / a + a / j if v * j >= a * a else 2 * math.sqrt(v / j)
    # a₀² / (2 j) is gained while an acceleration a₀ ends at jerk j. It is at most v.
    accelerating = min(a, math.sqrt(2 * j * v))
    easing = accelerating / j
    return Stop(easing + braking, v * (easing + braking / 2) - accelerating * easing**2 / 6)
