"""Topics and services of machines, and joint trajectories of the gantry.

Points are joined by cubics, as ros2_control's joint_trajectory_controller does for a trajectory
that has positions and velocities.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from typing import Any

from floorplan import Gantry, UserError
from navigation import Motion, Piece
from navigation.motion import Cubic, State

from ..machines.agv.agv import Agv
from ..machines.gantry.robot import GantryRobot
from .client import Client
from .exchange import Admit, Exchange, RefusedError, Values
from .messages import JOINTS, LOCATIONS, agv_status, joint_state, joint_values, pose_of

TOLERANCE = 0.01
"""Share of a limit by which a trajectory may exceed it; metres or radians it may begin off."""

JointValues = tuple[float, ...]
"""A value of each joint: m, rad, or m/s, rad/s."""


class TrajectoryError(UserError):
    """A trajectory that the gantry can't follow, with the joint or point and the reason."""


def target_of(gantry: Gantry, message: dict[str, Any]) -> tuple[float, float, float] | None:
    """Return the target (x, y, rotation) of a trajectory of one point without a time, or None."""
    points, order = message["points"], _order(message["joint_names"])
    if len(points) != 1 or _seconds(points[0]) or points[0]["velocities"]:
        return None
    return pose_of(gantry, _ordered(points[0], "positions", order, 0))


def trajectory_motion(
    gantry: Gantry, current: State, now: float, message: dict[str, Any]
) -> Motion:
    """Return the motion along a trajectory that begins at `now` (seconds) in the state `current`.

    `TrajectoryError` where it asks for other joints, jumps, leaves the gantry's range, is faster or
    accelerates more than the gantry can, or does not end at rest.
    """
    pieces = []
    times, positions, velocities = _knots(gantry, current, message)
    for a, b in itertools.pairwise(range(len(times))):
        cubics = [
            _cubic(times[b] - times[a], *ends)
            for ends in zip(positions[a], velocities[a], positions[b], velocities[b], strict=True)
        ]
        piece = Piece(now + times[a], now + times[b], *_in_the_world(gantry, cubics))
        _require_possible(gantry, piece, times[a])
        pieces.append(piece)
    return Motion(tuple(pieces))


def _knots(
    gantry: Gantry, current: State, message: dict[str, Any]
) -> tuple[list[float], list[JointValues], list[JointValues]]:
    """Return times, positions and velocities of the start and of the points after it."""
    order, points = _order(message["joint_names"]), message["points"]
    if not points:
        raise TrajectoryError("a trajectory without points")
    times: list[float] = [0.0]
    positions: list[JointValues] = [joint_values(gantry, current.position)]
    given: list[JointValues | None] = [joint_values(gantry, current.velocity, origin=False)]
    for k, point in enumerate(points):
        time, at = _seconds(point), _ordered(point, "positions", order, k)
        speeds = _ordered(point, "velocities", order, k) if point["velocities"] else None
        if k == 0 and time == 0.0:
            # A controller that repeats where the gantry is means no jump, but knows the place only
            # nearly.
            off = max(abs(a - b) for a, b in zip(positions[0], at, strict=True))
            if off > TOLERANCE:
                raise TrajectoryError(
                    f"it begins {off:.3f} m or rad from where the gantry is; give its first point"
                    " a time_from_start to get there"
                )
            continue
        if not time > times[-1]:
            raise TrajectoryError(f"points[{k}] comes at {time:g} s, not after {times[-1]:g} s")
        times.append(time)
        positions.append(at)
        given.append(speeds)
    if len(times) == 1:
        raise TrajectoryError("a trajectory that ends where it begins")
    if any(abs(v) > TOLERANCE for v in given[-1] or ()):
        raise TrajectoryError("it does not end at rest")
    given[-1] = (0.0,) * len(JOINTS)
    velocities = [
        _towards_neighbours(times, positions, k) if known is None else known
        for k, known in enumerate(given)
    ]
    return times, positions, velocities


def _towards_neighbours(
    times: Sequence[float], positions: Sequence[JointValues], k: int
) -> JointValues:
    """Velocities from the point before to the point after, none for a joint that turns round."""
    duration = times[k + 1] - times[k - 1]
    return tuple(
        (c - a) / duration if (b - a) * (c - b) > 0 else 0.0
        for a, b, c in zip(*positions[k - 1 : k + 2], strict=True)
    )


def _order(names: list[str]) -> list[int]:
    """Return the index in a message of each joint of the gantry."""
    if sorted(names) != sorted(JOINTS):
        raise TrajectoryError(f"joint_names should be {', '.join(JOINTS)}, in any order")
    return [names.index(name) for name in JOINTS]


def _ordered(point: dict[str, Any], field: str, order: list[int], k: int) -> JointValues:
    values = point[field]
    if len(values) != len(order):
        raise TrajectoryError(f"points[{k}] has {len(values)} {field} for {len(order)} joints")
    return tuple(values[j] for j in order)


def _seconds(point: dict[str, Any]) -> float:
    duration = point["time_from_start"]
    return float(duration["sec"] + duration["nanosec"] / 1e9)


def _cubic(duration: float, p: float, v: float, q: float, w: float) -> Cubic:
    """Return the Hermite cubic from position `p` and velocity `v` to `q` and `w`."""
    slope = (q - p) / duration
    return (p, v, (3 * slope - 2 * v - w) / duration, (v + w - 2 * slope) / duration**2)


def _in_the_world(gantry: Gantry, cubics: Sequence[Cubic]) -> tuple[Cubic, Cubic, Cubic]:
    """x, y and rotation in the world from those of the joints."""
    starts = pose_of(gantry, [cubic[0] for cubic in cubics])
    signs = pose_of(gantry, (1.0, 1.0, 1.0), origin=False)
    x, y, rotation = (
        (start, sign * cubic[1], sign * cubic[2], sign * cubic[3])
        for start, sign, cubic in zip(starts, signs, cubics, strict=True)
    )
    return x, y, rotation


def _require_possible(gantry: Gantry, piece: Piece, begin: float) -> None:
    """Check speeds, accelerations and the range, at the points and between them."""
    duration = piece.end - piece.begin
    cubics = (piece.x, piece.y, piece.rotation)
    for name, axis, cubic in zip(JOINTS, gantry.axes, cubics, strict=True):
        unit = "rad" if name.endswith("rotation_joint") else "m"
        speed = _derivative(cubic)
        for rate, limit, verb, per in (
            (speed, axis.max_speed, "move at", f"{unit}/s"),
            (_derivative(speed), axis.max_acceleration, "accelerate by", f"{unit}/s²"),
        ):
            for u in _extremes(rate, duration):
                if abs(_value(rate, u)) > limit * (1 + TOLERANCE):
                    raise TrajectoryError(
                        f"{name} would {verb} {abs(_value(rate, u)):.3g} {per} at"
                        f" {begin + u:.3g} s; {limit:.3g} {per} is the most"
                    )
    for u in (u for cubic in cubics for u in _extremes(cubic, duration)):
        x, y, rotation = (_value(cubic, u) for cubic in cubics)
        faults = gantry.faults((x, y, rotation))
        if faults:
            raise TrajectoryError(faults[0])


def _value(c: Cubic, u: float) -> float:
    return c[0] + u * (c[1] + u * (c[2] + u * c[3]))


def _derivative(c: Cubic) -> Cubic:
    return (c[1], 2 * c[2], 3 * c[3], 0.0)


def _extremes(cubic: Cubic, duration: float) -> Iterator[float]:
    """Yield the times at which a cubic may have an extremum: its ends and its stationary points."""
    yield 0.0
    yield duration
    _, b, c, d = cubic
    turns: list[float] = []
    if d:
        # Zeros of b + 2 c u + 3 d u²: (-c ± √(c² - 3 b d)) / (3 d).
        root = c * c - 3 * b * d
        turns = [(-c + sign * math.sqrt(root)) / (3 * d) for sign in (1, -1) if root >= 0]
    elif c:
        turns = [-b / (2 * c)]
    yield from (u for u in turns if 0 < u < duration)


TRAJECTORY = "/gantry_controller/joint_trajectory"
"""The topic that a controller publishes on."""


class GantryTopics:
    """Publishes the joints of `gantry` and whether it may move.

    If it is `driven` from outside, it follows the trajectories that clients publish.
    """

    def __init__(
        self, gantry: GantryRobot, exchange: Exchange, admit: Admit, *, driven: bool
    ) -> None:
        self._gantry = gantry
        self._exchange = exchange
        self._admit = admit
        self._joints = exchange.advertise("/joint_states", "sensor_msgs/JointState")
        self._health = exchange.advertise("/ariac/robot_health", "ariac_msgs/Robots")
        if driven:
            exchange.listen(TRAJECTORY, "trajectory_msgs/JointTrajectory", self._follow)

    def publish(self, now: float) -> None:
        """Publish the state at `now` (seconds)."""
        gantry = self._gantry
        if self._joints.is_needed:
            self._exchange.publish(self._joints, joint_state(now, gantry.gantry, gantry.state))
        health = {"floor_robot": True, "ceiling_robot": not gantry.disabled}
        self._exchange.publish(self._health, health)

    def _follow(self, message: Values) -> None:
        self._admit(TRAJECTORY)
        gantry = self._gantry
        if gantry.disabled:
            raise RefusedError("the gantry is disabled")
        try:
            target = target_of(gantry.gantry, message)
            if target is not None:
                gantry.move_to(*target, resume=False)
            else:
                gantry.follow(trajectory_motion(gantry.gantry, gantry.state, gantry.now, message))
        except TrajectoryError as why:
            raise RefusedError(str(why)) from None
        except ValueError as why:
            raise RefusedError(f"out of range: {why}") from None


class AgvTopics:
    """Publishes the states of AGVs, and sends them to the locations that clients ask for."""

    def __init__(self, agvs: Iterable[Agv], exchange: Exchange, admit: Admit) -> None:
        self._exchange = exchange
        self._admit = admit
        self._status = {}
        for agv in agvs:
            name = agv.lane.name
            topic = exchange.advertise(f"/ariac/{name}_status", "ariac_msgs/AGVStatus")
            self._status[agv] = topic
            move, request = partial(self._move, agv), {"location": "int8"}
            exchange.provide(f"/ariac/move_{name}", "ariac_msgs/MoveAGV", move, request)

    def publish(self) -> None:
        """Publish the present state."""
        for agv, topic in self._status.items():
            if topic.is_needed:
                self._exchange.publish(topic, agv_status(agv.lane, agv.body.state))

    def _move(self, agv: Agv, _: Client, request: Values) -> Values:
        name, number = agv.lane.name, request["location"]
        known = {k: place for k, place in enumerate(LOCATIONS) if place in agv.lane.locations}
        if number not in known:
            there = ", ".join(f"{k} {place}" for k, place in known.items())
            message = f"{name} has no location {number} (there are: {there})"
            return {"success": False, "message": message}
        self._admit(f"move_{name}")
        agv.drive(known[number])
        return {"success": True, "message": f"on its way to {known[number]}"}
