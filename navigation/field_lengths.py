"""Required length of the fields of a machine: its travel until standstill, and supplements.

A field is as long as the travel of the machine from a contact to its standstill, plus supplements.
In ISO 13855:2024, S = (K × T) + D_DS + Z, these are K × T, the approach of a person, and Z.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import NamedTuple, TypeAlias

import numpy as np
import shapely
from shapely import affinity
from shapely.geometry import Polygon

from floorplan import UserError
from floorplan.files.dataclass import dataclass

from .fields import FieldSet, ProtectiveFields
from .kernels.braking import braking
from .machines import AxisLimits
from .motion import Array, State
from .vehicles import VehicleLimits, vehicle_twist

Limits: TypeAlias = VehicleLimits | AxisLimits
"""Limits of a vehicle, or of a machine that only moves ahead and back."""

STEP = math.radians(2.0)
"""Step of directions and rotations of areas in radians."""

_Way: TypeAlias = tuple[str, float, float, Polygon]
"""Travel of a set: name, speed, reach (both as in `ShortField`), and swept area."""

_EXACT = 1e-6
"""Metres. Tolerance for the length of a field."""

_POSES = 33
"""Number of poses of a drive on an arc. Usual arcs are within 1 mm of the chords between them."""


class Reach(NamedTuple):
    """Travel of a machine from a contact to its standstill.

    Distances are in metres, or radians for a turn: `response` until it brakes, and `braking`.
    `time` is in seconds since the contact.
    """

    response: float
    braking: float
    time: float

    @property
    def distance(self) -> float:
        """Sum of both distances."""
        return self.response + self.braking


@dataclass(frozen=True, kw_only=True)
class FieldSupplements:
    """Additions to the length and width of a field.

    Parameters
    ----------
    measurement : float, optional
        Measurement error of the sensor, m.
    reflectors : float, optional
        Error from reflectors behind the field, m.
    wear : float, optional
        Share of the braking distance, for brakes that are worn.
    ground_clearance : float, optional
        Reach of a foot below the machine, m.
    approach_speed : float, optional
        Speed K of a person towards the machine, m/s, while it responds and brakes. The default, 0,
        is a person who stands. ISO 13855 has 1.6 m/s for a person who walks.
    side : float, optional
        Addition on each side, m.

    Raises
    ------
    UserError
        If a value is negative or not finite.
    """

    measurement: float = 0.1
    reflectors: float = 0.0
    wear: float = 0.1
    ground_clearance: float = 0.15
    approach_speed: float = 0.0
    side: float = 0.1

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not 0 <= value < math.inf:
                raise UserError(f"{name} must be 0 or more, not {value}")

    def length(self, reach: Reach) -> float:
        """Return the addition to a machine's travel in metres."""
        fixed = self.measurement + self.reflectors + self.ground_clearance
        return fixed + self.wear * reach.braking + self.approach_speed * reach.time


class ShortField(NamedTuple):
    """Field set that is too short for its machine.

    Attributes
    ----------
    set : str
        Name of the set.
    missing : float
        Metres by which the machine leaves the protective field before it stops.
    travel : str
        "ahead", "backwards" or "sideways", with "on an arc to the left" or "right" if it turns
        too, or "turning left" or "turning right" on the spot.
    speed : float
        Highest speed of the set in this travel, m/s or rad/s.
    reach : float
        Travel of the machine from a contact to its standstill, m or rad.
    """

    set: str
    missing: float
    travel: str
    speed: float
    reach: float

    def __str__(self) -> str:
        unit = ("rad/s", "rad") if self.travel.startswith("turning") else ("m/s", "m")
        return (
            f"the protective field of {self.set!r} is {self.missing:.2f} m too short {self.travel}:"
            f" at {self.speed:g} {unit[0]} the machine stops after {self.reach:.2f} {unit[1]}"
        )


def stopping_reach(limits: AxisLimits, speed: float, response_time: float) -> Reach:
    """Return the maximum travel of a machine whose speed is at most `speed` at a contact.

    Parameters
    ----------
    limits : AxisLimits
        Limits of the machine in its direction of travel.
    speed : float
        Highest speed of the field set, m/s or rad/s.
    response_time : float
        Time from the contact to the begin of braking, s.

    Returns
    -------
    Reach
        Maximum travel. The machine may accelerate until it brakes, within its limits.

    Notes
    -----
    Machines start from rest. After a reversal without a stop, a machine may travel farther, by the
    effect of its acceleration at a low speed.
    """
    speed = min(speed, limits.max_speed)
    starts = (speed, min(speed, _worst_start(limits, response_time)))
    return max((_reach(limits, one, response_time) for one in starts), key=lambda r: r.distance)


def _worst_start(limits: AxisLimits, response_time: float) -> float:
    """Return the speed (m/s) at which an accelerating machine must reduce its acceleration.

    Below it, a higher speed travels farther. Above it, less acceleration remains at braking.
    """
    jerk, top = limits.max_jerk, limits.max_speed
    peak = min(limits.max_acceleration, math.sqrt(jerk * top))
    builds_up = peak**2 / (2 * jerk)  # m/s, and the same again until the acceleration is 0
    before = response_time - (top - 2 * builds_up) / peak
    if before <= 0:
        return top - builds_up - peak * response_time
    return max(0.0, peak - jerk * before) ** 2 / (2 * jerk)


def _reach(limits: AxisLimits, speed: float, response_time: float) -> Reach:
    """Return the travel of a machine that accelerates from a speed, after a start from rest."""
    top_acceleration, jerk, top = limits.max_acceleration, limits.max_jerk, limits.max_speed
    if jerk == math.inf:
        rises, begins = 0.0, top_acceleration
    else:
        # An acceleration a changes the speed by a² / (2 j) each while it rises and while it falls.
        begins = min(
            top_acceleration, math.sqrt(2 * jerk * speed), math.sqrt(2 * jerk * (top - speed))
        )
        rises = min(response_time, (top_acceleration - begins) / jerk)
    jerked = 0.0 if rises == 0 else jerk * rises
    # First the acceleration rises, then it is constant.
    faster = speed + rises * (begins + jerked / 2)
    covered = rises * (speed + rises * (begins / 2 + jerked / 6))
    ends, rest = begins + jerked, response_time - rises
    covered += rest * (faster + rest * ends / 2)
    fast = min(faster + rest * ends, top)
    left = 0.0 if jerk == math.inf else min(ends, math.sqrt(2 * jerk * (top - fast)))
    rows = braking(0.0, fast, left, top_acceleration, jerk)
    duration, distance, slope, bend, change = list(rows)[-5:]
    far = distance + duration * (slope + duration * (bend + duration * change))
    return Reach(min(covered, top * response_time), far, response_time + sum(rows[::5]))


def short_fields(
    fields: ProtectiveFields, footprint: Polygon, limits: Limits
) -> tuple[ShortField, ...]:
    """Return the sets whose protective field a machine leaves before it stops.

    Parameters
    ----------
    fields : ProtectiveFields
        Fields of the machine, with their response time.
    footprint : shapely.Polygon
        Footprint in the frame of the machine, metres.
    limits : VehicleLimits or AxisLimits
        Limits of the machine.

    Returns
    -------
    tuple of ShortField
        At most one for each set and travel.

    Notes
    -----
    The swept area of straight travel at the highest speed of the set, and of turning on the spot if
    the set applies at rest, must be within the field. So must that of arcs at the ends of the
    ranges of speed and turn rate, with constant rates until braking. Arcs are reported if more is
    missing than in the other travels of the set. Velocities at which a previous set applies do not
    count. Supplements are not included.
    """
    short: list[ShortField] = []
    for each in fields.sets:
        worst: dict[str, ShortField] = {}
        field = Polygon(each.protective).buffer(_EXACT)
        parts = fields.remaining(each.name, *velocities(limits, each))
        for part in parts:
            for drive in _swept(part, footprint, limits, fields.response_time):
                _note(worst, each, field, drive)
        missing = max((one.missing for one in worst.values()), default=0.0)
        for part in parts:
            for drive in _swept_on_arcs(part, footprint, limits, fields.response_time):
                _note(worst, each, field, drive, missing)
        short += worst.values()
    return tuple(short)


def velocities(limits: Limits, each: FieldSet) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the ranges of a machine's speed and turn rate, in the terms of a set."""
    if isinstance(limits, AxisLimits):
        top, turn = limits.max_speed, math.inf
    else:
        top = limits.speed if each.direction is None else limits.top_speed
        turn = limits.turn_speed
    return (-top if each.direction is None else 0.0, top), (-turn, turn)


def _note(
    worst: dict[str, ShortField], each: FieldSet, field: Polygon, drive: _Way, more: float = 0.0
) -> None:
    """Add the missing length in a travel to the `worst`, if it exceeds `more` metres."""
    travel, speed, reach, area = drive
    if (outside := area.difference(field)).is_empty:
        return
    missing = float(shapely.hausdorff_distance(outside.union(field), field, 0.1))
    if missing > max(more, worst[travel].missing if travel in worst else 0.0):
        worst[travel] = ShortField(each.name, missing, travel, speed, reach)


def _swept(
    each: FieldSet, footprint: Polygon, limits: Limits, response_time: float
) -> Iterator[_Way]:
    """Yield straight travel at the highest speed of a set, and turns on the spot."""
    low, high = each.linear
    if each.direction is None:
        ways = [("ahead", 0.0, high), ("backwards", math.pi, -low)]
        if isinstance(limits, VehicleLimits) and limits.holonomic:
            ways += [("sideways", side * math.pi / 2, limits.side_speed) for side in (1, -1)]
    else:
        ways = [(_travel(angle), angle, high) for angle in directions(limits, *each.direction)]
    for travel, angle, fastest in ways:
        axis = limits_along(limits, angle)
        if axis is None or fastest <= 0 or (each.direction and low > axis.max_speed):
            continue
        if low > axis.max_speed or high < -axis.max_speed:
            continue  # the machine is never that fast
        speed = min(fastest, axis.max_speed)
        reach = stopping_reach(axis, speed, response_time).distance
        yield travel, speed, reach, swept_straight(footprint, angle, reach)
    if isinstance(limits, VehicleLimits) and low <= 0 <= high:
        for travel, sign, fastest in (
            ("turning left", 1, each.theta[1]),
            ("turning right", -1, -each.theta[0]),
        ):
            if fastest > 0:
                speed = min(fastest, limits.turn_speed)
                reach = stopping_reach(limits.turning, speed, response_time).distance
                yield travel, speed, reach, swept_turn(footprint, sign * reach)


def _swept_on_arcs(
    each: FieldSet, footprint: Polygon, limits: Limits, response_time: float
) -> Iterator[_Way]:
    """Yield drives on arcs at the ends of the ranges of speed and turn rate of a set."""
    if not isinstance(limits, VehicleLimits):
        return
    u, v = shapely.get_coordinates(footprint.exterior).T
    limit = limits.turn_speed
    turns = {min(max(rate, -limit), limit) for rate in each.theta} - {0.0}
    if each.direction is None:
        ways = [(0.0, speed) for speed in each.linear]
    else:
        first, last = each.direction
        ways = [
            *itertools.product({first, last, *main_directions(limits, first, last)}, each.linear)
        ]
    for (angle, wanted), turn in itertools.product(sorted(ways), sorted(turns)):
        heading = angle if wanted >= 0 else angle + math.pi
        axis = limits_along(limits, heading)
        if axis is None or wanted == 0:
            continue
        if each.linear[0] > axis.max_speed or each.linear[1] < -axis.max_speed:
            continue  # the machine is never that fast
        fastest = min(abs(wanted), axis.max_speed)
        x, y, rotation = on_arc(limits, heading, fastest, turn, response_time)
        c, s = np.cos(rotation), np.sin(rotation)
        at = np.stack([np.outer(c, u) - np.outer(s, v), np.outer(s, u) + np.outer(c, v)], axis=2)
        poses = at + np.column_stack([x, y])[:, None]
        pairs = np.concatenate([poses[:-1], poses[1:]], axis=1)
        area = shapely.union_all(shapely.convex_hull(shapely.multipoints(pairs)))
        side = "left" if turn > 0 else "right"
        covered = float(np.hypot(np.diff(x), np.diff(y)).sum())
        yield f"{_travel(heading)} on an arc to the {side}", fastest, covered, area


def on_arc(
    limits: VehicleLimits, angle: float, speed: float, turn: float, response_time: float
) -> tuple[Array, Array, Array]:
    """Return the poses x, y, rotation (N,) of a drive on an arc from a contact to standstill.

    The vehicle moves in the direction `angle` of its frame at the contact.
    """
    c, s = math.cos(angle), math.sin(angle)
    twist = (speed * c, speed * s, turn) if limits.holonomic else (speed * c, turn)
    begin = State((0.0, 0.0, 0.0), (speed * c, speed * s, turn), (0.0, 0.0, 0.0))
    drive = vehicle_twist(begin, twist, seconds=response_time, limits=limits)
    instants = np.linspace(drive.start, drive.end, _POSES)
    x, y = drive.position(instants).T
    return x, y, drive.rotation(instants)


def limits_along(limits: Limits, angle: float) -> AxisLimits | None:
    """Return the limits in a direction of travel, or None if the machine cannot move there."""
    c, s = math.cos(angle), math.sin(angle)
    if isinstance(limits, AxisLimits):
        return limits if abs(s) < 1e-9 else None
    return limits.along(c, s) if limits.holonomic or abs(s) < 1e-9 else None


def _travel(angle: float) -> str:
    ahead = math.cos(angle)
    return "ahead" if ahead > 0.7 else "backwards" if ahead < -0.7 else "sideways"


def directions(limits: Limits, first: float, last: float) -> list[float]:
    """Return directions from first to last, at most one step apart, and all `main_directions`."""
    count = max(1, math.ceil((last - first) / STEP))
    steps = {first + (last - first) * k / count for k in range(count + 1)}
    return sorted(steps | main_directions(limits, first, last))


def main_directions(limits: Limits, first: float, last: float) -> set[float]:
    """Return the directions of the axes and of the highest speed, from first to last."""
    fastest = 0.0
    if isinstance(limits, VehicleLimits):
        fastest = math.atan2(limits.side_speed, limits.speed)
    return {
        angle + k * math.pi
        for angle in (0.0, fastest, math.pi / 2, math.pi - fastest)
        for k in range(
            math.ceil((first - angle) / math.pi), math.floor((last - angle) / math.pi) + 1
        )
    }


def swept_straight(footprint: Polygon, angle: float, distance: float) -> Polygon:
    """Return the swept area of a footprint over `distance` (m) in a direction."""
    dx, dy = distance * math.cos(angle), distance * math.sin(angle)
    parts = [footprint, affinity.translate(footprint, dx, dy)]
    if footprint.convex_hull.equals(footprint):
        return shapely.multipolygons(parts).convex_hull
    for (ax, ay), (bx, by) in itertools.pairwise(footprint.exterior.coords):
        edge = Polygon([(ax, ay), (bx, by), (bx + dx, by + dy), (ax + dx, ay + dy)])
        parts.append(edge.convex_hull)
    return shapely.union_all([part for part in parts if part.geom_type == "Polygon"])


def swept_turn(footprint: Polygon, angle: float) -> Polygon:
    """Return an area that contains the swept area of a footprint in a turn about (0, 0), radians.

    It is larger by at most 0.02 % of the distance from (0, 0).
    """
    count = max(1, math.ceil(abs(angle) / STEP))
    # The chord between two rotations is closer to the centre than the arc by this share.
    share = 1 / math.cos(angle / count / 2)
    larger = affinity.scale(footprint, share, share, origin=(0, 0))
    turned = [
        affinity.rotate(larger, angle * k / count, origin=(0, 0), use_radians=True)
        for k in range(count + 1)
    ]
    return shapely.union_all([a.union(b).convex_hull for a, b in itertools.pairwise(turned)])
