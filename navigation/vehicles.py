"""Motions of vehicles that drive freely: segments, turns on the spot, stops and twists.

Segments and turns on the spot are exact cubics of time. The position of a vehicle that drives and
turns at once is no polynomial. It becomes a spline of cubics within 0.01 mm of the arc. The heading
is always exact.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

from floorplan import Point, UserError
from floorplan.files.dataclass import dataclass

from .kernels.arcs import arc_table, twist_axis
from .kernels.braking import Stops, braking
from .kernels.pieces import state as state_in
from .machines import (
    AxisLimits,
    AxisState,
    Stop,
    along_line,
    longest_of_axis,
    phases_in,
    to_position,
)
from .motion import Motion, Piece, State, Table, TablePieces, still

Pose = tuple[float, float, float]
"""x, y in metres, rotation in radians."""

NO_TIME = 1e-12
"""Durations (s) and distances (m) below this are 0."""

_SLIP = 1e-2
"""m/s. Maximum sideways speed of a differential drive on the spline of an arc."""

SIDEWAYS = 1e-4
"""m/s and metres. Sideways motion of a differential drive below this is rounding."""

_ROUNDING = 1e-6
"""m/s². Error of an acceleration on a segment or in a turn."""

_SPLINE = 0.02
"""m/s². Error of an acceleration on the spline of an arc."""

_BESIDE = 1e-6
"""m/s². Sideways acceleration below which a vehicle moves straight."""


@dataclass(frozen=True, kw_only=True)
class VehicleLimits:
    """Limits of a vehicle along and across its heading, and of its turning.

    Parameters
    ----------
    speed, acceleration, jerk : float, optional
        m/s, m/s², m/s³. No jerk limit is inf.
    turn_speed, turn_acceleration, turn_jerk : float, optional
        rad/s, rad/s², rad/s³.
    side_speed : float, optional
        m/s across the heading, with the same acceleration and jerk. 0, the default, is a
        differential drive, and more than 0 a holonomic one.

    Raises
    ------
    UserError
        If a limit is not more than 0.
    """

    speed: float = 1.5
    acceleration: float = 0.7
    jerk: float = 3.0
    turn_speed: float = 1.0
    turn_acceleration: float = 1.5
    turn_jerk: float = 6.0
    side_speed: float = 0.0

    def __post_init__(self) -> None:
        for name, limit in vars(self).items():
            if not (limit > 0 or (name == "side_speed" and limit == 0)):
                raise UserError(f"{name} must be more than 0, not {limit}")

    @property
    def holonomic(self) -> bool:
        """Whether the vehicle can drive sideways."""
        return self.side_speed > 0

    @property
    def top_speed(self) -> float:
        """Maximum speed over the floor in m/s."""
        return math.hypot(self.speed, self.side_speed)

    @property
    def turning(self) -> AxisLimits:
        """Limits of turning in radians."""
        return _axis(self.turn_speed, self.turn_acceleration, self.turn_jerk)

    def slower(self, share: float) -> VehicleLimits:
        """Return these limits with a share of the speeds. `UserError` unless it is in (0, 1]."""
        if not 0 < share <= 1:
            raise UserError(f"speed_share must be more than 0 and at most 1, not {share}")
        if share == 1:
            return self
        return replace(
            self,
            speed=self.speed * share,
            turn_speed=self.turn_speed * share,
            side_speed=self.side_speed * share,
        )

    def along(self, cosine: float, sine: float) -> AxisLimits:
        """Return the limits in a direction, as cosine and sine of its angle to the heading."""
        shares = [(abs(cosine), self.speed)]
        if self.holonomic:
            shares.append((abs(sine), self.side_speed))
        shares = [(share, speed) for share, speed in shares if share > 1e-9]
        share = max(share for share, _ in shares)
        speed = min(speed / share for share, speed in shares)
        return _axis(speed, self.acceleration / share, self.jerk / share)

    @property
    def longest_stop(self) -> Stop:
        """Longest and farthest stop within these limits."""
        ahead = longest_of_axis(_axis(self.speed, self.acceleration, self.jerk))
        times, metres = [ahead.time, longest_of_axis(self.turning).time], [ahead.distance]
        if self.holonomic:
            limits = _axis(self.side_speed, self.acceleration, self.jerk)
            aside = longest_of_axis(limits)
            times.append(aside.time)
            metres.append(aside.distance)
        return Stop(max(times), math.hypot(*metres))


_SUDDEN = 1e3
"""1/s. Ratio of jerk to acceleration above which the jerk counts as unlimited."""


class Twist(NamedTuple):
    """Velocity of a vehicle: forwards and to the left (m/s), turn rate counterclockwise (rad/s)."""

    forwards: float
    sideways: float
    turning: float

    @classmethod
    def of(cls, values: Sequence[float]) -> Twist:
        """Return the twist from (v, ω) or (vx, vy, ω). `UserError` for other values."""
        try:
            numbers = [float(value) for value in values]
        except (TypeError, ValueError):
            numbers = []
        if len(numbers) not in (2, 3):
            raise UserError(f"a twist must be (v, ω) or (vx, vy, ω), not {values!r}")
        if not all(map(math.isfinite, numbers)):
            raise UserError(f"a twist must be finite, not {values!r}")
        return cls(numbers[0], numbers[1] if len(numbers) == 3 else 0.0, numbers[-1])

    def check(self, limits: VehicleLimits) -> None:
        """Raise `UserError` if the twist exceeds `limits`."""
        for name, value, limit, unit in (
            ("speed", self.forwards, limits.speed, "m/s"),
            ("side_speed", self.sideways, limits.side_speed, "m/s"),
            ("turn_speed", self.turning, limits.turn_speed, "rad/s"),
        ):
            if abs(value) > limit * (1 + 1e-9):
                raise UserError(
                    f"a twist of {value:g} {unit} is faster than {name}, {limit:g} {unit}"
                )


def vehicle_segment(
    current: Pose | State,
    to: Sequence[float],
    start: float = 0.0,
    *,
    limits: VehicleLimits | None = None,
) -> Motion:
    """Return the fastest straight drive to `to`, with a constant heading and a stop at the end.

    Parameters
    ----------
    current : Pose or State
        Pose (x, y, rotation) at rest, or the state of a vehicle that moves on the line.
    to : sequence of float
        x and y, metres.
    start : float, optional
        Start time in seconds.
    limits : VehicleLimits, optional
        Limits of the vehicle.

    Raises
    ------
    ValueError
        If a differential drive cannot reach the place in a straight line, or if the vehicle does
        not move on the line.
    """
    limits = limits or VehicleLimits()
    state = _state(current)
    (x, y, rotation), (vx, vy, turning) = state.position, state.velocity
    dx, dy = float(to[0]) - x, float(to[1]) - y
    length = math.hypot(dx, dy)
    if length < NO_TIME:
        return Motion((still(state.position, start, start),))
    if not limits.holonomic:
        across = dy * math.cos(rotation) - dx * math.sin(rotation)
        if abs(across) > SIDEWAYS:
            raise ValueError(
                f"a differential drive with the heading {rotation:g} can't drive straight from"
                f" ({x:g}, {y:g}) to ({to[0]:g}, {to[1]:g}): it must turn first"
            )
    c, s = dx / length, dy / length
    if abs(vy * c - vx * s) > SIDEWAYS or abs(turning) > SIDEWAYS:
        raise ValueError("the vehicle does not move along the segment: it must stop first")
    angle = math.atan2(dy, dx) - rotation
    axis = limits.along(math.cos(angle), math.sin(angle))
    ax, ay, _ = state.acceleration
    now = _within(AxisState(0.0, vx * c + vy * s, ax * c + ay * s), axis)
    (phases,) = to_position([now], [AxisState(length)], [axis])
    return Motion(tuple(along_line((x, y), (c, s), rotation, phases, float(start))))


def vehicle_turn(
    current: Pose | State,
    rotation: float,
    start: float = 0.0,
    *,
    limits: VehicleLimits | None = None,
) -> Motion:
    """Return the fastest turn on the spot to `rotation` (radians), with a stop at the end.

    The vehicle turns by the difference of both rotations, even by more than half a turn.

    Parameters
    ----------
    current : Pose or State
        Pose (x, y, rotation) at rest, or the state of a vehicle that turns on the spot.
    rotation : float
        Rotation at the end, radians.
    start : float, optional
        Start time in seconds.
    limits : VehicleLimits, optional
        Limits of the vehicle.

    Raises
    ------
    ValueError
        If the vehicle is driving.
    """
    limits = limits or VehicleLimits()
    state = _state(current)
    if state.speed > SIDEWAYS:
        raise ValueError("a vehicle that drives must stop before it turns on the spot")
    x, y, begin = state.position
    axis = AxisState(begin, state.velocity[2], state.acceleration[2])
    now = _within(axis, limits.turning)
    (phases,) = to_position([now], [AxisState(float(rotation))], [limits.turning])
    pieces, t = [], float(start)
    for duration, cubic in phases:
        pieces.append(Piece(t, t + duration, (x, 0.0, 0.0, 0.0), (y, 0.0, 0.0, 0.0), cubic))
        t += duration
    return Motion(tuple(pieces))


def vehicle_stop(
    current: State, start: float = 0.0, *, limits: VehicleLimits | None = None
) -> Motion:
    """Return the fastest stop from `current`, on the line or arc of the motion.

    Parameters
    ----------
    current : State
        State of the vehicle.
    start : float, optional
        Start time in seconds.
    limits : VehicleLimits, optional
        Limits of the vehicle.
    """
    limits = limits or VehicleLimits()
    (x, y, rotation), (vx, vy, turning), (ax, ay, spin) = current
    speed = math.hypot(vx, vy)
    if speed > 0 and not (turning or spin) and abs(ax * vy - ay * vx) <= _BESIDE * speed:
        # On a straight line, the axes of a holonomic drive brake in proportion.
        c, s = vx / speed, vy / speed
        angle = math.atan2(s, c) - rotation
        axis = limits.along(math.cos(angle), math.sin(angle))
        rows = braking(0.0, speed, ax * c + ay * s, axis.max_acceleration, axis.max_jerk)
        line = along_line((x, y), (c, s), rotation, phases_in(rows), float(start))
        return Motion(tuple(line))
    return vehicle_twist(current, (0.0, 0.0, 0.0), start, limits=limits)


def vehicle_twist(
    current: Pose | State,
    twist: Sequence[float],
    start: float = 0.0,
    *,
    seconds: float = 0.0,
    limits: VehicleLimits | None = None,
) -> Motion:
    """Return the motion that changes to a twist as fast as possible, and stops after a time.

    Parameters
    ----------
    current : Pose or State
        Pose (x, y, rotation) at rest, or the state of a vehicle that moves.
    twist : sequence of float
        (v, ω), or (vx, vy, ω) for a holonomic drive, in m/s forwards and to the left, and rad/s.
    start : float, optional
        Start time in seconds.
    seconds : float, optional
        Time after which the vehicle brakes, s.
    limits : VehicleLimits, optional
        Limits of the vehicle.

    Raises
    ------
    UserError
        If the twist is not finite, or faster than the limits.

    Notes
    -----
    While the vehicle drives and turns at once, its position is a spline within 0.01 mm of the arc.
    A twist uses at most 99.99 % of the top speeds, so that no speed on the spline exceeds them.
    """
    state, wanted = _state(current), Twist.of(twist)
    if not 0 <= seconds < math.inf:
        raise UserError(f"seconds must be a finite number of at least 0, not {seconds}")
    course = TwistCourse(state, wanted, limits or VehicleLimits())
    return course.motion(state.position, float(start), float(seconds))


class TwistCourse:
    """Change of a vehicle to a twist: velocities of its axes, without an end.

    `UserError` if the twist exceeds the limits.
    """

    def __init__(self, state: State, twist: Twist, limits: VehicleLimits) -> None:
        twist.check(limits)
        self._top_speed = limits.top_speed
        self._axes = [
            (now.velocity, now.acceleration, target, axis)
            for now, target, axis in zip(
                _body_axes(state, limits), twist, _axes(limits), strict=True
            )
        ]

    def motion(self, pose: Pose, start: float, until: float, since: float = 0.0) -> Motion:
        """Return the motion from `pose` at `start` (s) on, which stops after `until`.

        `since` and `until` are relative to the begin of the course (s).
        """
        axes = [
            twist_axis(
                velocity,
                acceleration,
                target,
                until,
                axis.max_speed,
                axis.max_acceleration,
                axis.max_jerk,
            )
            for velocity, acceleration, target, axis in self._axes
        ]
        if table := arc_table(axes, since, *pose, start, self._top_speed):
            return Motion(TablePieces(table))
        return Motion((still(pose, start, start),))


def vehicle_path(
    current: Pose | State,
    poses: Iterable[Sequence[float]],
    start: float = 0.0,
    *,
    limits: VehicleLimits | None = None,
) -> Motion:
    """Return the motion through `poses`, with a stop at each: by turns on the spot and segments.

    Parameters
    ----------
    current : Pose or State
        Pose (x, y, rotation) at rest, or the state of a moving vehicle. It must move on the segment
        to the first of the poses, or turn on the spot to it.
    poses : iterable of sequence of float
        x, y (metres) and rotation (radians). Each differs from the previous one in its place or in
        its rotation.
    start : float, optional
        Start time in seconds.
    limits : VehicleLimits, optional
        Limits of the vehicle.

    Raises
    ------
    ValueError
        See `vehicle_segment` and `vehicle_turn`.
    """
    limits = limits or VehicleLimits()
    return through(current, poses, start, limits, partial(vehicle_segment, limits=limits))


def through(
    current: Pose | State,
    poses: Iterable[Sequence[float]],
    start: float,
    limits: VehicleLimits,
    drive: Callable[[State, Point, float], Motion],
) -> Motion:
    """Return `vehicle_path` with straight drives from `drive(state, to, start)`."""
    state, t = _state(current), float(start)
    pieces: list[Piece] = []
    for x, y, rotation in poses:
        here = state.position
        if math.dist(here[:2], (x, y)) > NO_TIME:
            part = drive(state, (x, y), t)
        else:
            part = vehicle_turn(state, rotation, t, limits=limits)
        pieces += part.pieces
        t, state = part.end, _state((float(x), float(y), part.state(part.end).position[2]))
    if not pieces:
        pieces = [still(state.position, t, t)]
    return Motion(tuple(pieces))


class VehicleStops(Stops):
    """Fastest stops of a vehicle within its limits."""

    limits: VehicleLimits

    def table(self, motion: Table, t: float) -> Table:
        """Return the table of the stop from a motion at `t` (seconds)."""
        return vehicle_stop(State(*state_in(motion, t)), t, limits=self.limits).table


def stops_of(limits: VehicleLimits) -> VehicleStops:
    """Return the stops of a vehicle with these limits."""
    stops = VehicleStops()
    stops.limits = limits
    return stops


def _axis(speed: float, acceleration: float, jerk: float) -> AxisLimits:
    """Return the limits of an axis. Ruckig fails for jerks that have no effect."""
    return AxisLimits(speed, acceleration, math.inf if jerk > _SUDDEN * acceleration else jerk)


def _state(current: Pose | State) -> State:
    if isinstance(current, State):
        return current
    x, y, rotation = map(float, current)
    return State((x, y, rotation), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def _axes(limits: VehicleLimits) -> tuple[AxisLimits, AxisLimits, AxisLimits]:
    """Return the limits forwards, sideways and of turning."""
    aside = limits.side_speed or limits.speed  # at rest, for a differential drive
    return (
        _axis(limits.speed, limits.acceleration, limits.jerk),
        _axis(aside, limits.acceleration, limits.jerk),
        limits.turning,
    )


def _body_axes(state: State, limits: VehicleLimits) -> list[AxisState]:
    """Return velocity and acceleration forwards, sideways and of turning."""
    c, s = math.cos(state.position[2]), math.sin(state.position[2])
    (vx, vy, turning), (ax, ay, spin) = state.velocity, state.acceleration
    ahead, aside = vx * c + vy * s, vy * c - vx * s
    # The axes turn with the vehicle, so part of the acceleration only changes the direction.
    pull, push = ax * c + ay * s + turning * aside, ay * c - ax * s - turning * ahead
    if not limits.holonomic:
        if abs(aside) > _SLIP:
            raise ValueError(f"a differential drive can't move sideways, by {aside:g} m/s")
        aside = push = 0.0
    states = [(ahead, pull), (aside, push), (turning, spin)]
    return [
        _within(AxisState(0.0, *state), axis, _SPLINE)
        for state, axis in zip(states, _axes(limits), strict=True)
    ]


def _within(state: AxisState, limits: AxisLimits, error: float = _ROUNDING) -> AxisState:
    """Return a state without an acceleration that exceeds the top speed by at most `error`.

    A higher acceleration is that of a higher top speed, and ends within the jerk limit.
    """
    v, a, jerk = state.velocity, state.acceleration, limits.max_jerk
    if jerk == math.inf or v * a <= 0:
        return state
    allowed = math.sqrt(2 * jerk * max(limits.max_speed - abs(v), 0.0))
    if not allowed < abs(a) <= allowed + error:
        return state
    return replace(state, acceleration=math.copysign(allowed, a))
