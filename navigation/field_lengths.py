"""How long the fields of a machine must be: its way while it responds and brakes, and supplements.

The length of a protective field is that of ISO 13855:2024, clause 5, S = (K × T) + D_DS + Z, with
the way of the machine added. See `docs/protective-fields.md` for the terms and their sources.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeAlias

import numpy as np
import shapely
from shapely import affinity
from shapely.geometry import Polygon

from floorplan import UserError

from .fields import UNBOUNDED, Corners, FieldSet, ProtectiveFields
from .kernels.braking import braking
from .machines import AxisLimits
from .motion import Array
from .vehicles import VehicleLimits

Limits: TypeAlias = VehicleLimits | AxisLimits
"""Limits of a vehicle, or of one that only goes straight ahead and back."""

WALKING_SPEED = 1.6
"""m/s. Speed K at which a person walks towards a machine, by ISO 13855."""

_STEP = math.radians(2.0)
"""Radians between directions, and between rotations, of which areas are made."""

_STRAIGHT = 0.05
"""rad/s. Turn rates up to this are those of the sets for straight driving."""

_EXACT = 1e-6
"""Metres. A field that lacks less is long enough."""

_BOX = 0.9
"""Share of a box above which its corners are not cut off."""

_TURNS, _SHARES = (-1.0, -0.5, 0.5, 1.0), (0.25, 0.5, 1.0)
"""Shares of the farthest turn, and of its arc, at which the corners of a machine are looked at."""

_STARTS = 33
"""Number of speeds of which the farthest stop is taken."""


class Reach(NamedTuple):
    """What a machine covers from a contact to its standstill.

    Distances are in metres, or in radians for a turn: `response` until it brakes, and `braking`.
    `time` is in seconds, from the contact on.
    """

    response: float
    braking: float
    time: float

    @property
    def distance(self) -> float:
        """The whole distance."""
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
        """Return what is added to a machine's way, m."""
        fixed = self.measurement + self.reflectors + self.ground_clearance
        return fixed + self.wear * reach.braking + self.approach_speed * reach.time


class ShortField(NamedTuple):
    """Field set that is too short for its machine.

    Attributes
    ----------
    set : str
        Name of the set.
    missing : float
        Metres by which the machine leaves the protective field before it stands.
    travel : str
        "ahead", "backwards", "sideways", "turning left" or "turning right".
    speed : float
        Highest speed of the set in this travel, m/s or rad/s.
    reach : float
        What the machine covers from a contact to its standstill, m or rad.
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
    """Return how far a machine gets that may be as fast as `speed` when a person is detected.

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
        The farthest: the machine may accelerate until it brakes, as far as its limits let it.

    Notes
    -----
    Machines are taken to come from rest. One that reverses without a stop may get farther by what
    its acceleration adds at a low speed.
    """
    speed = min(speed, limits.max_speed)
    starts = (speed * k / (_STARTS - 1) for k in range(_STARTS))
    return max((_reach(limits, one, response_time) for one in starts), key=lambda r: r.distance)


def _reach(limits: AxisLimits, speed: float, response_time: float) -> Reach:
    """Return how far a machine gets that accelerates from a speed, and started from rest."""
    most, jerk, top = limits.max_acceleration, limits.max_jerk, limits.max_speed
    if jerk == math.inf:
        rises, begins = 0.0, most
    else:
        # An acceleration a takes a² / (2 j) to build up, and the same to be let off.
        begins = min(most, math.sqrt(2 * jerk * speed), math.sqrt(2 * jerk * (top - speed)))
        rises = min(response_time, (most - begins) / jerk)
    jerked = 0.0 if rises == 0 else jerk * rises
    # First the acceleration rises, then it stays.
    faster = speed + rises * (begins + jerked / 2)
    covered = rises * (speed + rises * (begins / 2 + jerked / 6))
    ends, rest = begins + jerked, response_time - rises
    covered += rest * (faster + rest * ends / 2)
    fast = min(faster + rest * ends, top)
    left = 0.0 if jerk == math.inf else min(ends, math.sqrt(2 * jerk * (top - fast)))
    rows = braking(0.0, fast, left, most, jerk)
    duration, distance, slope, bend, change = list(rows)[-5:]
    far = distance + duration * (slope + duration * (bend + duration * change))
    return Reach(min(covered, top * response_time), far, response_time + sum(rows[::5]))


def short_fields(
    fields: ProtectiveFields, footprint: Polygon, limits: Limits
) -> tuple[ShortField, ...]:
    """Return the sets whose protective field a machine leaves before it has stopped.

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
        At most one of each set and travel.

    Notes
    -----
    The swept area of straight travel at the highest speed of the set, and of turning on the spot if
    the set applies at rest, must be within the field. Supplements are not included.
    """
    found: list[ShortField] = []
    for each in fields.sets:
        worst: dict[str, ShortField] = {}
        field = Polygon(each.protective).buffer(_EXACT)
        for travel, speed, reach, area in _swept(each, footprint, limits, fields.response_time):
            if (outside := area.difference(field)).is_empty:
                continue
            missing = float(shapely.hausdorff_distance(outside.union(field), field, 0.1))
            if travel not in worst or worst[travel].missing < missing:
                worst[travel] = ShortField(each.name, missing, travel, speed, reach.distance)
        found += worst.values()
    return tuple(found)


def _swept(
    each: FieldSet, footprint: Polygon, limits: Limits, response_time: float
) -> Iterator[tuple[str, float, Reach, Polygon]]:
    """Yield each travel of a set: its name, its speed, its reach, and the area that it covers."""
    low, high = each.linear
    if each.direction is None:
        ways = [("ahead", 0.0, high), ("backwards", math.pi, -low)]
        if isinstance(limits, VehicleLimits) and limits.holonomic:
            ways += [("sideways", side * math.pi / 2, limits.side_speed) for side in (1, -1)]
    else:
        ways = [(_travel(angle), angle, high) for angle in _angles(*each.direction)]
    for travel, angle, fastest in ways:
        axis = _along(limits, angle)
        if axis is None or fastest <= 0 or (each.direction and low > axis.max_speed):
            continue
        if low > axis.max_speed or high < -axis.max_speed:
            continue  # the machine is never that fast
        speed = min(fastest, axis.max_speed)
        reach = stopping_reach(axis, speed, response_time)
        yield travel, speed, reach, swept_straight(footprint, angle, reach.distance)
    if isinstance(limits, VehicleLimits) and low <= 0 <= high:
        for travel, sign, fastest in (
            ("turning left", 1, each.theta[1]),
            ("turning right", -1, -each.theta[0]),
        ):
            if fastest > 0:
                speed = min(fastest, limits.turn_speed)
                reach = stopping_reach(limits.turning, speed, response_time)
                yield travel, speed, reach, swept_turn(footprint, sign * reach.distance)


def _along(limits: Limits, angle: float) -> AxisLimits | None:
    """Return the limits in a direction of travel, or None if the machine cannot go there."""
    c, s = math.cos(angle), math.sin(angle)
    if isinstance(limits, AxisLimits):
        return limits if abs(s) < 1e-9 else None
    return limits.along(c, s) if limits.holonomic or abs(s) < 1e-9 else None


def _travel(angle: float) -> str:
    ahead = math.cos(angle)
    return "ahead" if ahead > 0.7 else "backwards" if ahead < -0.7 else "sideways"


def _angles(first: float, last: float) -> list[float]:
    """Return directions from first to last, no more than a step apart, and those of the axes."""
    count = math.ceil((last - first) / _STEP)
    steps = {first + (last - first) * k / count for k in range(count + 1)}
    quarters = range(math.ceil(first / (math.pi / 2)), math.floor(last / (math.pi / 2)) + 1)
    return sorted(steps | {k * math.pi / 2 for k in quarters})


def swept_straight(footprint: Polygon, angle: float, distance: float) -> Polygon:
    """Return the area that a footprint covers on a way of `distance` (m) in a direction."""
    dx, dy = distance * math.cos(angle), distance * math.sin(angle)
    parts = [footprint, affinity.translate(footprint, dx, dy)]
    for (ax, ay), (bx, by) in itertools.pairwise(footprint.exterior.coords):
        edge = Polygon([(ax, ay), (bx, by), (bx + dx, by + dy), (ax + dx, ay + dy)])
        parts.append(edge.convex_hull)
    return shapely.union_all([part for part in parts if part.geom_type == "Polygon"])


def swept_turn(footprint: Polygon, angle: float) -> Polygon:
    """Return an area that contains all that a footprint covers in a turn about (0, 0), radians.

    It is larger by a share of 0.02 % of the distance from (0, 0) at most.
    """
    count = max(1, math.ceil(abs(angle) / _STEP))
    # The chord between two rotations is nearer to the centre than the arc, by this share.
    share = 1 / math.cos(angle / count / 2)
    larger = affinity.scale(footprint, share, share, origin=(0, 0))
    turned = [
        affinity.rotate(larger, angle * k / count, origin=(0, 0), use_radians=True)
        for k in range(count + 1)
    ]
    return shapely.union_all([a.union(b).convex_hull for a, b in itertools.pairwise(turned)])


def needed_fields(
    footprint: Polygon,
    limits: Limits,
    speeds: Sequence[float],
    *,
    response_time: float,
    supplements: FieldSupplements | None = None,
    warning_time: float = 1.0,
    backwards: bool = True,
) -> ProtectiveFields:
    """Return field sets that are long enough for a machine, one step of speed after another.

    Parameters
    ----------
    footprint : shapely.Polygon
        Footprint in the frame of the machine, metres.
    limits : VehicleLimits or AxisLimits
        Limits of the machine.
    speeds : sequence of float
        Highest speed of each step, m/s, rising.
    response_time : float
        Time from a contact to the begin of braking, s.
    supplements : FieldSupplements, optional
        Additions to the length and width.
    warning_time : float, optional
        Time for which the warning field is longer than the protective field, s.
    backwards : bool, optional
        Whether there are sets for driving backwards faster than in the first step.

    Returns
    -------
    ProtectiveFields
        Two sets of each step, for straight driving and for turning. Those of the first step are for
        both ways. Sets of a holonomic drive are for all directions.

    Raises
    ------
    UserError
        If speeds do not rise or are not positive, or a time is negative or not finite.
    """
    if not speeds or any(not a < b < math.inf for a, b in itertools.pairwise([0.0, *speeds])):
        raise UserError(f"speeds must be positive and rise, not {', '.join(map(str, speeds))}")
    for name, value in (("response_time", response_time), ("warning_time", warning_time)):
        if not 0 <= value < math.inf:
            raise UserError(f"{name} must be 0 or more, not {value}")
    sizes = supplements or FieldSupplements()
    maker = _FieldMaker(footprint, limits, response_time, sizes, warning_time)
    steps = [*itertools.pairwise([0.0, *speeds])]
    if isinstance(limits, VehicleLimits) and limits.holonomic:
        return maker.fields([(f"{b:g} m/s", a, b, True) for a, b in steps])
    parts = [(f"{speeds[0]:g} m/s", -speeds[0], speeds[0], False)]
    for a, b in steps[1:]:
        parts.append((f"{b:g} m/s", a, b, False))
        if backwards:
            parts.append((f"{b:g} m/s backwards", -b, -a, False))
    return maker.fields(parts)


@dataclass(frozen=True)
class _FieldMaker:
    """What makes the sets of a machine."""

    footprint: Polygon
    limits: Limits
    response_time: float
    supplements: FieldSupplements
    warning_time: float

    def fields(self, parts: Sequence[tuple[str, float, float, bool]]) -> ProtectiveFields:
        """Return the sets of ranges of speed: name, minimum, maximum, and whether all around."""
        sets = []
        for name, low, high, around in parts:
            ways = (-math.pi, math.pi) if around else None
            turns = [(name, UNBOUNDED)]
            if isinstance(self.limits, VehicleLimits):
                straight = (-_STRAIGHT, _STRAIGHT)
                turns = [(name, straight), (f"{name} turning", UNBOUNDED)]
            for title, theta in turns:
                each = FieldSet(
                    name=title,
                    protective=tuple(self.footprint.exterior.coords),
                    linear=(low, high),
                    theta=theta,
                    direction=ways,
                )
                sets.append(self._set(each))
        return ProtectiveFields(sets=tuple(sets), response_time=self.response_time)

    def _set(self, each: FieldSet) -> FieldSet:
        """Return a set with fields that are long enough."""
        corners = shapely.get_coordinates(self.footprint.exterior)
        low, high = each.linear
        spin = 0.0
        # Above the first step, a machine that drives straight does not begin to turn.
        if isinstance(self.limits, VehicleLimits) and (low <= 0 <= high or not _is_straight(each)):
            axis = self.limits.turning
            fastest = min(each.theta[1], axis.max_speed)
            spin = stopping_reach(axis, fastest, self.response_time).distance
        area, warned = [_turned(corners, spin)], []
        ways = [(angle, speed) for angle, speed in ((0.0, high), (math.pi, -low)) if speed > 0]
        if each.direction is not None:
            ways = [(angle, high) for angle in _angles(*each.direction)]
        for angle, speed in ways:
            axis_along = _along(self.limits, angle)
            assert axis_along is not None  # a drive that is not holonomic has two ways
            reach = stopping_reach(axis_along, speed, self.response_time)
            length = reach.distance + self.supplements.length(reach)
            area.append(_driven(corners, angle, length, spin))
            warned.append(_driven(corners, angle, length + speed * self.warning_time, spin))
        protective = _octagon(np.concatenate(area), self.supplements.side)
        warning = _octagon(np.concatenate([protective, *warned]), self.supplements.side)
        return replace(each, protective=protective, warning=warning)


def _is_straight(each: FieldSet) -> bool:
    return each.theta == (-_STRAIGHT, _STRAIGHT)


def _turned(corners: Array, spin: float) -> Array:
    """Return points (N, 2) whose hull contains the corners in all turns up to `spin` each way."""
    count = max(1, math.ceil(spin / _STEP))
    # The chord between two rotations is nearer to the centre than the arc, by this share.
    share = 1 / math.cos(spin / count / 2)
    turns = [_rotated(share * corners, spin * k / count) for k in range(-count, count + 1)]
    return np.concatenate([corners, *turns])


def _driven(corners: Array, angle: float, length: float, spin: float) -> Array:
    """Return the corners at the end of a way, straight or on the arcs that may be: (N, 2)."""
    ahead = length * np.array([math.cos(angle), math.sin(angle)])
    places = [corners + ahead]
    for turn, share in itertools.product(_TURNS if spin else (), _SHARES):
        bent, radius = spin * turn * share, 1 / (spin * turn)
        on_arc = np.array([radius * math.sin(bent), radius * (1 - math.cos(bent))])
        x, y = ahead
        shift = np.array([x * on_arc[0] - y * on_arc[1], y * on_arc[0] + x * on_arc[1]])
        places.append(_rotated(corners, bent) + shift)
    return np.concatenate(places)


def _rotated(points: Array, angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return points @ np.array([[c, s], [-s, c]])


def _octagon(points: Array, margin: float) -> Corners:
    """Return the corners of an octagon that keeps a margin (metres) from points, at most 2 cm more.

    It is their box if cutting off its corners makes little difference.
    """
    box = _box(points, margin)
    diamond = affinity.rotate(_box(_rotated(points, -math.pi / 4), margin), 45, origin=(0, 0))
    eight = box.intersection(diamond)
    chosen = box if eight.area > _BOX * box.area else eight
    corners = shapely.get_coordinates(chosen.exterior).tolist()[:-1]
    return tuple((round(x, 3), round(y, 3)) for x, y in corners)


def _box(points: Array, margin: float) -> Polygon:
    # A millimetre more, for the corners are rounded to half of it.
    more = margin + 1e-3
    low, high = (points.min(0) - more).tolist(), (points.max(0) + more).tolist()
    ends = [math.floor(100 * value) / 100 for value in low]
    return shapely.box(*ends, *(math.ceil(100 * value) / 100 for value in high))
