"""Distances between surfaces: people and machines as upright solids, measured by FCL.

All solids here stand upright: a footprint between a bottom and a top. Their distance is √(p² + z²)
with p the distance of the footprints in the plane and z the gap between the heights. FCL is asked
for the distance of the person's axis (a tiny sphere) from a box or a sphere that cuts the plane in
the machine's footprint; p is less by the person's radius. Of these FCL is exact to 1e-12 m; of a
cylinder and a box it would be wrong by up to 0.5 mm, because it iterates.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import cached_property
from typing import NamedTuple

import fcl
import numpy as np

from floorplan import Gantry, Lane

from .encounter import Encounter
from .motion import Piece, shift, value
from .odometer import Odometer

PERSON_RADIUS = 0.30
"""Metres. A person's radius where nothing else is said."""

PERSON_HEIGHT = 1.75
"""Metres. A person's height where nothing else is said."""

_POINT = 1e-6
"""Metres. The radius of the sphere that stands for a person's axis."""


def _require_solid(solid: Cylinder | Box) -> None:
    for field in fields(solid):
        length = getattr(solid, field.name)
        if not (math.isfinite(length) and (length > 0 or (field.name == "bottom" and length == 0))):
            raise ValueError(f"{field.name} of a {type(solid).__name__} can't be {length} m")
    if solid.top <= solid.bottom:
        raise ValueError(f"top ({solid.top} m) must be above bottom ({solid.bottom} m)")


@dataclass(frozen=True, kw_only=True)
class Cylinder:
    """An upright cylinder around a body's axis; metres, heights above the floor."""

    radius: float
    bottom: float = 0.0
    top: float

    def __post_init__(self) -> None:
        _require_solid(self)

    @property
    def corners(self) -> tuple[tuple[float, float], ...]:
        """The points whose hull, grown by `rounding`, is the footprint."""
        return ((0.0, 0.0),)

    @property
    def rounding(self) -> float:
        """See `corners`; metres."""
        return self.radius


@dataclass(frozen=True, kw_only=True)
class Box:
    """An upright box around a body's axis that turns with it; metres, heights above the floor.

    `length` is along the body's heading, `width` across.
    """

    length: float
    width: float
    bottom: float = 0.0
    top: float

    def __post_init__(self) -> None:
        _require_solid(self)

    @property
    def corners(self) -> tuple[tuple[float, float], ...]:
        """The points whose hull, grown by `rounding`, is the footprint."""
        x, y = self.length / 2, self.width / 2
        return ((x, y), (-x, y), (-x, -y), (x, -y))

    @property
    def rounding(self) -> float:
        """See `corners`; metres."""
        return 0.0


@dataclass(frozen=True, kw_only=True)
class Shapes:
    """The solids of a person and of a machine, whose parts move as one.

    A person has no front: the cylinder stands around the person's position. Use one `Shapes` in
    one thread at a time.
    """

    person: Cylinder = Cylinder(radius=PERSON_RADIUS, top=PERSON_HEIGHT)
    machine: tuple[Cylinder | Box, ...]

    def __post_init__(self) -> None:
        if not isinstance(self.person, Cylinder):
            raise ValueError(f"a person is a Cylinder, not {self.person!r}")
        if not self.machine:
            raise ValueError("a machine needs at least one solid")
        for part in self.machine:
            if not isinstance(part, Cylinder | Box):
                raise ValueError(f"a machine is made of Cylinder and Box, not {part!r}")

    def encounter(
        self,
        begin: float,
        end: float,
        pieces: tuple[Piece, Piece],
        odometers: tuple[Odometer, Odometer],
    ) -> SurfaceEncounter:
        """Return an `Encounter` that measures between these surfaces."""
        return SurfaceEncounter(begin, end, pieces, odometers, self._gauges)

    @cached_property
    def _gauges(self) -> tuple[_Gauge, ...]:
        # They are kept: python-fcl never gives back all of the memory of an object.
        return tuple(_Gauge(self.person, part) for part in self.machine)

    def __getstate__(self) -> dict[str, object]:
        return {"person": self.person, "machine": self.machine}  # FCL's objects can't be pickled


def torso_box(gantry: Gantry) -> Box:
    """Return the torso of a gantry, which turns with its rotation."""
    length, width, bottom, top = gantry.torso
    return Box(length=length, width=width, bottom=bottom, top=top)


def folded_arm(gantry: Gantry) -> Cylinder:
    """The cylinder that a gantry's folded arm may sweep as it turns, up to its torso's top."""
    return Cylinder(radius=gantry.arm_reach, bottom=gantry.arm_bottom, top=gantry.torso[3])


def agv_box(lane: Lane) -> Box:
    """Return the box of the AGV of a lane, with its load."""
    return Box(length=lane.length, width=lane.width, top=lane.height)


class _Course(NamedTuple):
    """Motion of a person in the frame that the machine has at an instant.

    Place, velocity and half the acceleration (m, m/s, m/s²), and how fast the machine turns
    (rad/s). For `half` seconds before and after, the person stays within `bend` (m) of place and
    velocity, and within `jolt` (m) if the acceleration counts too; the machine stays within
    `twist` (rad) and turns by no more than `swing` (rad).
    """

    x: float
    y: float
    vx: float
    vy: float
    ax: float
    ay: float
    spin: float
    half: float
    bend: float
    jolt: float
    twist: float
    swing: float


class _Gauge:
    """Measures between a person and one part of a machine, in the machine's frame."""

    def __init__(self, person: Cylinder, part: Cylinder | Box) -> None:
        self._height = max(part.bottom - person.top, person.bottom - part.top, 0.0)
        self._radius = person.radius
        self._grown = person.radius + part.rounding
        self._corners = part.corners
        self._reach = max(math.hypot(*corner) for corner in part.corners)
        self._farthest = self._reach + part.rounding
        self._axis = fcl.CollisionObject(fcl.Sphere(_POINT))
        footprint = (
            fcl.Sphere(part.radius)
            if isinstance(part, Cylinder)
            else fcl.Box(part.length, part.width, 1.0)
        )
        self._footprint = fcl.CollisionObject(footprint)
        self._request = fcl.DistanceRequest(enable_nearest_points=True)

    def distance(self, x: float, y: float) -> float:
        """Return the metres between the surfaces for a person at (x, y), 0 if they overlap."""
        return self._over(self._away(x, y)[0])

    def range(self, course: _Course, slope: float, curve: float) -> tuple[float, float]:
        """Return bounds on distance − `slope` u − `curve` u² / 2 for the instants u of a course.

        The lower bound is that of a plane that separates the two at the middle: one that keeps its
        normal, or one that turns with the machine (better beside a wall that turns). Along the
        normal, the person and the corners of the footprint move at a known rate. The upper bound
        is the distance from the person to the part's point that is nearest at the middle and moves
        with it. Both are off by second order in the course's `half`.
        """
        x, y, vx, vy, ax, ay, spin, half, bend, jolt, twist, swing = course
        away, (at_x, at_y) = self._away(x, y)
        turned = twist + swing * swing / 2
        moved = math.hypot(vx, vy) * half + bend
        if away == 0.0:
            around = (abs(slope) + abs(curve) / 2 * half) * half
            return self._height - around, self._over(moved + self._farthest * swing) + around
        dx, dy = x - at_x, y - at_y
        distance = self._over(away)
        wx, wy, rise = (vx + spin * at_y) * half, (vy - spin * at_x) * half, slope * half
        bow = abs(curve) / 2 * half * half
        bent = bend + self._farthest * turned
        high = max(
            self._over(math.hypot(dx + wx, dy + wy) + bent) - rise,
            self._over(math.hypot(dx - wx, dy - wy) + bent) + rise,
        )
        if away <= self._radius:
            return distance - abs(rise) - bow, high + bow
        level = (away - self._radius) / distance
        nx, ny = dx / away * level, dy / away * level
        towards = nx * vx + ny * vy - slope
        inside = [(nx * (x - cx) + ny * (y - cy), nx * cy - ny * cx) for cx, cy in self._corners]
        low = min(apart - abs(towards + spin * lever) * half for apart, lever in inside)
        low -= abs(nx * ax + ny * ay - curve / 2) * half * half
        low -= level * (jolt + self._reach * turned)
        if swing > 0.0 and self._reach > 0.0:
            turning = min(apart for apart, _ in inside) - bow
            turning -= abs(towards + spin * (nx * y - ny * x)) * half
            turning -= level * (
                bend + math.hypot(x, y) * turned + moved * (swing + swing * swing / 2)
            )
            low = max(low, turning)
        low += self._height * self._height / distance - level * self._grown
        return (low if slope or curve else max(low, self._height)), high + bow

    def _over(self, away: float) -> float:
        """The distance from the part to a person whose axis is `away` metres from its footprint."""
        return math.hypot(max(away - self._radius, 0.0), self._height)

    def _away(self, x: float, y: float) -> tuple[float, tuple[float, float]]:
        """Return the metres from the footprint to a point, and the footprint's point nearest to it.

        0 within the footprint, and then the point is of no use.
        """
        self._axis.setTranslation(np.array([x, y, 0.0]))
        result = fcl.DistanceResult()
        gap = fcl.distance(self._footprint, self._axis, self._request, result)
        if gap <= 0.0:
            return 0.0, (x, y)
        at_x, at_y, _ = result.nearest_points[0].tolist()
        return gap + _POINT, (at_x, at_y)


class SurfaceEncounter(Encounter):
    """An encounter in which distances are those between surfaces."""

    __slots__ = ("_gauges", "_rotation")

    rounding = 1e-12

    def __init__(
        self,
        begin: float,
        end: float,
        pieces: tuple[Piece, Piece],
        odometers: tuple[Odometer, Odometer],
        gauges: tuple[_Gauge, ...],
    ) -> None:
        super().__init__(begin, end, pieces, odometers)
        machine = pieces[1]
        self._rotation = shift(machine.rotation, begin - machine.begin)
        self._gauges = gauges

    def distance(self, t: float) -> float:
        """Return the distance between the surfaces at `t` (metres), 0 where they overlap."""
        return self._distance(t - self.begin, 0.0, 0.0, 0.0)[0]

    def _distance(
        self, middle: float, half: float, slope: float, curve: float
    ) -> tuple[float, float, float]:
        """See `Encounter`. Exact to second order in `half`, so it converges as fast."""
        turn = value(self._rotation, middle)
        c, s = math.cos(turn), math.sin(turn)
        x, y = -value(self._x, middle), -value(self._y, middle)
        x, y = c * x + s * y, c * y - s * x
        if half == 0.0:
            distance = min(gauge.distance(x, y) for gauge in self._gauges)
            return distance, distance, 0.0
        _, vx, ax, jx = shift(self._x, middle)
        _, vy, ay, jy = shift(self._y, middle)
        _, spin, spin_up, spin_jerk = shift(self._rotation, middle)
        jolt = half * half * half * math.hypot(jx, jy)
        twist = half * half * (abs(spin_up) + half * abs(spin_jerk))
        course = _Course(
            x,
            y,
            -(c * vx + s * vy),
            s * vx - c * vy,
            -(c * ax + s * ay),
            s * ax - c * ay,
            spin,
            half,
            half * half * math.hypot(ax, ay) + jolt,
            jolt,
            twist,
            abs(spin) * half + twist,
        )
        ranges = [gauge.range(course, slope, curve) for gauge in self._gauges]
        return min(low for low, _ in ranges), min(high for _, high in ranges), 0.0
