"""Field sets that are long enough for a machine, as simple polygons."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely
from shapely import affinity
from shapely.geometry import Polygon

from floorplan import UserError
from floorplan.files.dataclass import dataclass

from .field_lengths import (
    STEP,
    FieldSupplements,
    Limits,
    directions,
    limits_along,
    on_arc,
    stopping_reach,
)
from .fields import UNBOUNDED, Corners, FieldSet, ProtectiveFields
from .motion import Array
from .vehicles import VehicleLimits

_STRAIGHT = 0.05
"""rad/s. Maximum turn rate of the sets for straight driving."""

_TURNS, _SHARES = (-1.0, -0.5, 0.5, 1.0), (0.25, 0.5, 1.0)
"""Shares of the maximum turn and of its arc at which the corners of a machine are evaluated."""

_SPARSE = 16
"""Only every so many directions have arcs."""

_BOX = 0.9
"""Share of a box's area above which the box replaces the octagon."""


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
        Two sets for each step, for straight driving and for turning. Sets of the first step are for
        both directions. Sets of a holonomic drive are for all directions.

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
    """Designer of the field sets of a machine."""

    footprint: Polygon
    limits: Limits
    response_time: float
    supplements: FieldSupplements
    warning_time: float

    def fields(self, parts: Sequence[tuple[str, float, float, bool]]) -> ProtectiveFields:
        """Return the sets for ranges of speed: name, minimum, maximum, and whether all around."""
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
        """Return a set with sufficiently long fields."""
        corners = shapely.get_coordinates(self.footprint.exterior)
        low, high = each.linear
        spin = 0.0
        # Above the first step, a machine in straight motion does not begin to turn.
        if isinstance(self.limits, VehicleLimits) and (low <= 0 <= high or not _is_straight(each)):
            axis = self.limits.turning
            fastest = min(each.theta[1], axis.max_speed)
            spin = stopping_reach(axis, fastest, self.response_time).distance
        area, warned = [_turned(corners, spin)], []
        ways = [(angle, speed) for angle, speed in ((0.0, high), (math.pi, -low)) if speed > 0]
        if each.direction is not None:
            ways = [(angle, high) for angle in directions(self.limits, *each.direction)]
        for angle, speed in ways:
            axis_along = limits_along(self.limits, angle)
            assert axis_along is not None  # a drive that is not holonomic has two ways
            reach = stopping_reach(axis_along, speed, self.response_time)
            length = reach.distance + self.supplements.length(reach)
            area.append(_driven(corners, angle, length, spin))
            warned.append(_driven(corners, angle, length + speed * self.warning_time, spin))
        if isinstance(self.limits, VehicleLimits):
            fastest = min(each.theta[1], self.limits.turn_speed)
            for (angle, speed), turn in itertools.product(ways[::_SPARSE], (-fastest, fastest)):
                area += self._on_arc(self.limits, corners, angle, speed, turn)
        protective = _octagon(np.concatenate(area), self.supplements.side)
        warning = _octagon(np.concatenate([protective, *warned]), self.supplements.side)
        return replace(each, protective=protective, warning=warning)

    def _on_arc(
        self, limits: VehicleLimits, corners: Array, angle: float, speed: float, turn: float
    ) -> list[Array]:
        """Return the corners on arcs at shares of a speed (m/s) and a turn rate (rad/s)."""
        axis = limits_along(limits, angle)
        speed = 0.0 if axis is None else min(speed, axis.max_speed)
        points = []
        for share, bend in itertools.product(_SHARES, _SHARES):
            drive = limits, angle, share * speed, bend * turn, self.response_time
            x, y, rotation = on_arc(*drive)
            places = _rotated(corners, rotation) + np.column_stack([x, y])[:, None]
            points.append(places.reshape(-1, 2))
        return points


def _is_straight(each: FieldSet) -> bool:
    return each.theta == (-_STRAIGHT, _STRAIGHT)


def _turned(corners: Array, spin: float) -> Array:
    """Return points (N, 2) whose hull contains the corners in all turns up to `spin` each way."""
    count = max(1, math.ceil(spin / STEP))
    # The chord between two rotations is closer to the centre than the arc by this share.
    share = 1 / math.cos(spin / count / 2)
    turns = _rotated(share * corners, spin * np.arange(-count, count + 1) / count)
    return np.concatenate([corners, turns.reshape(-1, 2)])


def _driven(corners: Array, angle: float, length: float, spin: float) -> Array:
    """Return the corners at the end of a drive, straight or on possible arcs: (N, 2)."""
    x, y = length * math.cos(angle), length * math.sin(angle)
    places: Array = corners + np.array([x, y])
    if not spin:
        return places
    turns, shares = spin * np.repeat(_TURNS, len(_SHARES)), np.tile(_SHARES, len(_TURNS))
    bends = turns * shares
    along, across = np.sin(bends) / turns, (1 - np.cos(bends)) / turns
    shifts = np.column_stack([x * along - y * across, y * along + x * across])
    on_arcs = _rotated(corners, bends) + shifts[:, None]
    return np.concatenate([places, on_arcs.reshape(-1, 2)])


def _rotated(points: Array, angles: Array | float) -> Array:
    """Return points (N, 2) rotated by each angle (rad): (..., N, 2)."""
    c, s = np.cos(angles), np.sin(angles)
    return np.asarray(points @ np.moveaxis(np.array([[c, s], [-s, c]]), (0, 1), (-2, -1)))


def _octagon(points: Array, margin: float) -> Corners:
    """Return the corners of an octagon with a margin (m) of at most 2 cm more around points.

    It is their box if the cut corners make little difference.
    """
    box = _box(points, margin)
    diamond = affinity.rotate(_box(_rotated(points, -math.pi / 4), margin), 45, origin=(0, 0))
    eight = box.intersection(diamond)
    chosen = box if eight.area > _BOX * box.area else eight
    corners = shapely.get_coordinates(chosen.exterior).tolist()[:-1]
    return tuple((round(x, 3), round(y, 3)) for x, y in corners)


def _box(points: Array, margin: float) -> Polygon:
    # One millimetre more, because corners are rounded to half of it.
    more = margin + 1e-3
    low, high = (points.min(0) - more).tolist(), (points.max(0) + more).tolist()
    ends = [math.floor(100 * value) / 100 for value in low]
    return shapely.box(*ends, *(math.ceil(100 * value) / 100 for value in high))
