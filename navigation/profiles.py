"""Time-optimal motion along axes with limits, by Ruckig, as cubics of time.

Ruckig: L. Berscheid and T. Kröger, "Jerk-limited Real-time Trajectory Generation with
Arbitrary Target States", Robotics: Science and Systems 2021.
"""

from __future__ import annotations

import math
import threading
from collections.abc import MutableSequence, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import ruckig

from .kernels.braking import stands
from .kernels.numbers import numbers
from .kernels.pieces import phases_of, scaled
from .kernels.walks import NOWHERE
from .motion import Cubic, Piece


@dataclass(frozen=True)
class AxisLimits:
    """Limits of one axis: m/s, m/s², m/s³ (or the same in radians). No jerk limit is inf."""

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
    """State of one axis: metres (or radians) and seconds."""

    position: float
    velocity: float = 0.0
    acceleration: float = 0.0


_MOST_KEPT = 256
"""Number of profiles from rest to rest that are kept."""

Phases = list[tuple[float, Cubic]]
"""The duration of each phase of one axis (seconds), and its cubic."""

Rows = MutableSequence[float]
"""The phases of one axis as numbers of the kernels: of each its duration and coefficients."""

States = tuple[Sequence[float], Sequence[float], Sequence[float]]
"""Positions, velocities and accelerations of some axes."""


def to_position(
    current: Sequence[AxisState], target: Sequence[AxisState], limits: Sequence[AxisLimits]
) -> list[Phases]:
    """Return the fastest profiles from `current` to `target`, all axes arriving together.

    `ValueError` if there are none.
    """
    rows = rows_to_position(_columns(current), _columns(target), limits)
    return [_phases(axis) for axis in rows]


def rows_to_position(current: States, target: States, limits: Sequence[AxisLimits]) -> list[Rows]:
    """Return `to_position`'s profiles: for each phase of an axis its duration and coefficients."""
    place, velocity, acceleration = current
    under_way = any(velocity) or any(acceleration) or any(target[1]) or any(target[2])
    if not under_way and [*place] == [*target[0]]:
        return [numbers([0.0, at, 0.0, 0.0, 0.0]) for at in place]  # as Ruckig has it
    states = [
        # An axis at rest but for rounding is taken for one in motion by Ruckig.
        [at, 0.0, 0.0] if stands(v, a) else [at, v, a]
        for at, v, a in zip(place, velocity, acceleration, strict=True)
    ]
    return _solve(states, target, limits)


def straight(
    current: Sequence[float], target: Sequence[float], limits: Sequence[AxisLimits]
) -> list[Rows]:
    """Return the fastest profiles from rest to rest with all axes in step: a straight line.

    They are rows as those of `rows_to_position`.

    The line is planned as one axis, as long as the longest span, with the limits that all axes
    leave it.
    """
    spans = [b - a for a, b in zip(current, target, strict=True)]
    length = max(abs(span) for span in spans)
    if length < NOWHERE:
        return [numbers([0.0, a, 0.0, 0.0, 0.0]) for a in current]
    # Of metres along the longest axis each other axis goes a share; so do speed and the rest.
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
    """Return the rows of an axis from rest at 0 to rest at `length`, within these limits.

    Machines ask again and again: for the same way, or standing where they have stood before.
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

    At position s of its `phases` the body is s metres from `origin` in `direction` (a unit
    vector), turned by `heading` (radians).
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
    """Ruckig and what it is asked within some limits, kept for each thread.

    To make them takes longer than an answer.
    """

    def __init__(self) -> None:
        self.solvers: dict[int, Any] = {}
        """By the number of axes."""
        self.tasks: dict[tuple[AxisLimits, ...], Any] = {}
        self.last: tuple[Sequence[AxisLimits], Any, Any] = ((), None, None)
        """The limits that were asked for last, a tuple, and the answer."""

    def of(self, limits: Sequence[AxisLimits]) -> tuple[Any, Any]:
        """Return both for axes with these limits."""
        known, solver, task = self.last
        if limits is known:
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


def _solve(states: list[list[float]], target: States, limits: Sequence[AxisLimits]) -> list[Rows]:
    """Return Ruckig's answer: of each axis, in one of `states`, the rows of `merge_axes`."""
    solver, task = _RUCKIG.of(limits)
    task.current_position, task.current_velocity, task.current_acceleration = zip(
        *states, strict=True
    )
    task.target_position, task.target_velocity, task.target_acceleration = target
    trajectory = ruckig.Trajectory(len(states))  # one used before keeps figures of its brakes
    try:
        result = solver.calculate(task, trajectory)
    except ruckig.RuckigError as why:
        raise ValueError(f"no motion within these limits: {why}") from None
    if result not in _FOUND:
        raise ValueError(f"no motion within these limits ({result.name})")
    rows = []
    for profile, state in zip(trajectory.profiles[0], states, strict=True):
        brake = profile.brake
        if brake.duration > 0.0:  # its phases come before the seven of the profile
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


def _phases(rows: Rows) -> Phases:
    """Return the rows of one axis as phases."""
    return [
        (rows[k], (rows[k + 1], rows[k + 2], rows[k + 3], rows[k + 4]))
        for k in range(0, len(rows), 5)
    ]
