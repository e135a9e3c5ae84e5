"""Encounters of two motions: bounds on distance, speed and path length over intervals of time.

All solids here stand upright: a footprint between a bottom and a top. Their distance is √(p² + z²)
with p the distance of the footprints in the plane and z the gap between the heights. A footprint is
a disc or a rectangle that turns with the machine, whose point nearest to the person's axis is known
in closed form; p is less by the person's radius.
"""

from __future__ import annotations

import cmath
import itertools
import math
from collections.abc import MutableSequence, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import NamedTuple, TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray
from typing_extensions import Self

from floorplan import Gantry, Lane, Point

from .kernels.encounter import EncounterBounds, Gauge, PolygonGauge
from .kernels.numbers import room
from .kernels.odometer import PathLength, length
from .motion import Motion, Piece, shift

Floats = NDArray[np.float64]

PERSON_RADIUS = 0.30
"""Metres. A person's radius where nothing else is said."""

PERSON_HEIGHT = 1.75
"""Metres. A person's height where nothing else is said."""


def _require_solid(solid: Solid) -> None:
    for field in fields(solid):
        length = getattr(solid, field.name)
        if field.name == "footprint":
            continue
        if not (math.isfinite(length) and (length > 0 or (field.name == "bottom" and length == 0))):
            raise ValueError(f"{field.name} of a {type(solid).__name__} can't be {length} m")
    if solid.top <= solid.bottom:
        raise ValueError(f"top ({solid.top} m) must be above bottom ({solid.bottom} m)")


@dataclass(frozen=True, kw_only=True)
class Cylinder:
    """Upright cylinder around the axis of a body.

    Parameters
    ----------
    radius : float
        Radius in metres.
    bottom, top : float
        Heights above the floor in metres. The bottom is 0 by default.

    Raises
    ------
    ValueError
        If a value is not positive, or if `top` is not above `bottom`.
    """

    radius: float
    bottom: float = 0.0
    top: float

    def __post_init__(self) -> None:
        _require_solid(self)

    @classmethod
    def of_arm(cls, gantry: Gantry) -> Self:
        """Return the cylinder that a gantry's folded arm may cover, up to the top of its torso."""
        return cls(radius=gantry.arm_reach, bottom=gantry.arm_bottom, top=gantry.torso[3])

    @property
    def corners(self) -> tuple[tuple[float, float], ...]:
        """Points whose hull, grown by `rounding`, is the footprint."""
        return ((0.0, 0.0),)

    @property
    def rounding(self) -> float:
        """Radius around `corners` in metres."""
        return self.radius


@dataclass(frozen=True, kw_only=True)
class Box:
    """Upright box around the axis of a body that turns with it.

    Parameters
    ----------
    length, width : float
        Size along the heading and across it in metres.
    bottom, top : float
        Heights above the floor in metres. The bottom is 0 by default.

    Raises
    ------
    ValueError
        If a value is not positive, or if `top` is not above `bottom`.
    """

    length: float
    width: float
    bottom: float = 0.0
    top: float

    def __post_init__(self) -> None:
        _require_solid(self)

    @classmethod
    def of_torso(cls, gantry: Gantry) -> Self:
        """Return the torso of a gantry, which turns with its rotation."""
        length, width, bottom, top = gantry.torso
        return cls(length=length, width=width, bottom=bottom, top=top)

    @classmethod
    def of_agv(cls, lane: Lane) -> Self:
        """Return the box of the AGV of a lane with its load."""
        return cls(length=lane.length, width=lane.width, top=lane.height)

    def is_level_with(self, other: Box) -> bool:
        """Return whether the heights of both boxes overlap."""
        return self.bottom < other.top and other.bottom < self.top

    @property
    def corners(self) -> tuple[tuple[float, float], ...]:
        """Points whose hull, grown by `rounding`, is the footprint."""
        x, y = self.length / 2, self.width / 2
        return ((x, y), (-x, y), (-x, -y), (x, -y))

    @property
    def rounding(self) -> float:
        """Radius around `corners` in metres."""
        return 0.0


@dataclass(frozen=True, kw_only=True, repr=False)
class Prism:
    """Upright prism beside or around the axis of a body that turns with it.

    Parameters
    ----------
    footprint : tuple of (float, float)
        Points in metres from the axis, along the heading and to its left. The footprint is their
        convex hull.
    bottom, top : float
        Heights above the floor in metres. The bottom is 0 by default.

    Raises
    ------
    ValueError
        If the footprint has no area, or if `top` is not above `bottom`.
    """

    footprint: tuple[Point, ...]
    bottom: float = 0.0
    top: float

    def __repr__(self) -> str:
        return f"<Prism of {len(self.footprint)} points from {self.bottom:g} to {self.top:g} m>"

    def __post_init__(self) -> None:
        _require_solid(self)
        points = np.array(self.footprint, dtype=float).reshape(-1, 2)
        hull = shapely.MultiPoint(points).convex_hull if np.isfinite(points).all() else None
        if not isinstance(hull, shapely.Polygon):
            raise ValueError(f"footprint of a Prism must have an area, not {self.footprint}")

    @cached_property
    def corners(self) -> tuple[Point, ...]:
        """Corners of the footprint, counterclockwise."""
        hull = shapely.orient_polygons(shapely.MultiPoint(self.footprint).convex_hull)
        return tuple((x, y) for x, y in shapely.get_coordinates(hull)[:-1].tolist())

    @property
    def rounding(self) -> float:
        """Radius around `corners` in metres."""
        return 0.0


Solid: TypeAlias = Cylinder | Box | Prism
"""Part of a machine."""


@dataclass(frozen=True, kw_only=True)
class Shapes:
    """Solids of a person and a machine.

    Parameters
    ----------
    person : Cylinder, optional
        Cylinder around the person's position. By default its radius is 0.3 m and its height 1.75 m.
    machine : tuple of Cylinder, Box or Prism
        Solids of the machine, which move together.

    Raises
    ------
    ValueError
        If the person is no `Cylinder`, or if the machine has no solid.
    """

    person: Cylinder = Cylinder(radius=PERSON_RADIUS, top=PERSON_HEIGHT)
    machine: tuple[Solid, ...]

    def __post_init__(self) -> None:
        if not isinstance(self.person, Cylinder):
            raise ValueError(f"a person is a Cylinder, not {self.person!r}")
        if not self.machine:
            raise ValueError("a machine needs at least one solid")
        for part in self.machine:
            if not isinstance(part, Solid):
                raise ValueError(f"a machine is made of Cylinder, Box and Prism, not {part!r}")

    def __getstate__(self) -> dict[str, object]:
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @cached_property
    def gauges(self) -> tuple[Gauge, ...]:
        """Kernels that measure between the person and each solid of the machine."""
        return tuple(self._gauge(part) for part in self.machine)

    @property
    def reach(self) -> float:
        """Distance in metres from the machine's axis to the farthest point of its solids."""
        return max(
            math.hypot(x, y) + part.rounding for part in self.machine for x, y in part.corners
        )

    def distances(self, places: Floats, poses: Floats) -> Floats:
        """Return the distances between surfaces at many times.

        Parameters
        ----------
        places : ndarray, shape (N, 2)
            Positions of the person in metres.
        poses : ndarray, shape (N, 3)
            Poses of the machine: x, y in metres and rotation in radians.

        Returns
        -------
        ndarray, shape (N,)
            Distances in metres, 0 if surfaces overlap.
        """
        away = places - poses[:, :2]
        c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
        x, y = c * away[:, 0] + s * away[:, 1], c * away[:, 1] - s * away[:, 0]
        found = np.full(len(places), np.inf)
        for part in self.machine:
            level = _distances_to_hull(x, y, part.corners) - part.rounding - self.person.radius
            found = np.minimum(found, np.hypot(np.maximum(level, 0.0), self._above(part)))
        return found

    def _above(self, part: Solid) -> float:
        """Return the gap in metres between the heights of the person and a part."""
        return max(part.bottom - self.person.top, self.person.bottom - part.top, 0.0)

    def _gauge(self, part: Solid) -> Gauge:
        radius, height = self.person.radius, self._above(part)
        match part:
            case Cylinder():
                return Gauge(radius, height, 0.0, 0.0, part.radius)
            case Box():
                return Gauge(radius, height, part.length / 2, part.width / 2, 0.0)
        return PolygonGauge(radius, height, [c for corner in part.corners for c in corner])


def _distances_to_hull(x: Floats, y: Floats, corners: Sequence[Point]) -> Floats:
    """Return the distances (m) of points from a convex polygon with counterclockwise corners."""
    square = np.full(len(x), np.inf)
    inside = np.full(len(x), len(corners) > 2)
    for (ax, ay), (bx, by) in itertools.pairwise([*corners, corners[0]]):
        ex, ey, px, py = bx - ax, by - ay, x - ax, y - ay
        along = np.clip((px * ex + py * ey) / ((ex * ex + ey * ey) or 1.0), 0.0, 1.0)
        square = np.minimum(square, (px - along * ex) ** 2 + (py - along * ey) ** 2)
        inside &= ex * py >= ey * px
    return np.where(inside, 0.0, np.sqrt(square))


_ELLIPSE = 7.0
"""Sum of the half axes of the Bernstein ellipse in which speed must be analytic around a stretch
that is integrated with eight nodes: the error is then below 2e-13 of the stretch's length
(L. N. Trefethen, "Approximation Theory and Approximation Practice", theorem 19.3)."""


@dataclass(frozen=True, kw_only=True)
class Enclosure:
    """Value over an interval, within `slack` of `value` + `slope` u + `curve` u² / 2.

    u is the time since the middle of the interval in seconds. Custom laws return enclosures.

    Parameters
    ----------
    value : float
        Value in the middle, which is exact for a single time.
    slope, curve : float, optional
        First and second derivative.
    slack : float, optional
        Maximum deviation.
    """

    value: float
    slope: float = 0.0
    slack: float = 0.0
    curve: float = 0.0

    @staticmethod
    def between(low: float, high: float) -> Enclosure:
        """Return the enclosure of a value between two bounds."""
        return Enclosure(value=(low + high) / 2, slope=0.0, slack=(high - low) / 2)

    def range(self, half: float) -> tuple[float, float]:
        """Return minimum and maximum on an interval of twice `half` seconds."""
        around = (abs(self.slope) + abs(self.curve) * half / 2) * half + self.slack
        return self.value - around, self.value + around

    def __add__(self, other: Enclosure | float) -> Enclosure:
        if isinstance(other, Enclosure):
            return Enclosure(
                value=self.value + other.value,
                slope=self.slope + other.slope,
                slack=self.slack + other.slack,
                curve=self.curve + other.curve,
            )
        return Enclosure(
            value=self.value + other, slope=self.slope, slack=self.slack, curve=self.curve
        )

    def __mul__(self, factor: float) -> Enclosure:
        return Enclosure(
            value=self.value * factor,
            slope=self.slope * factor,
            slack=self.slack * abs(factor),
            curve=self.curve * factor,
        )


def enclosure_of(figures: tuple[float, float, float, float]) -> Enclosure:
    """Return the enclosure with this value, slope, slack and curve."""
    value, slope, slack, curve = figures
    return Enclosure(value=value, slope=slope, slack=slack, curve=curve)


class Odometer(PathLength):
    """Path length and speed of a motion at any time. Jumps add no length."""

    def __init__(self, motion: Motion) -> None:
        super().__init__(motion.table)
        self.motion = motion

    def ahead(self, begin: float, end: float, seconds: float) -> Enclosure:
        """Return the path length (m) in the `seconds` after each time from `begin` to `end`."""
        return enclosure_of(self.path_ahead(begin, end, seconds))

    def speed(self, begin: float, end: float) -> Enclosure:
        """Return the speed (m/s) from `begin` to `end`; at a change, the one after it."""
        return enclosure_of(self.speed_within(begin, end))

    def smooth_stretches(self) -> _Stretches:
        """Return the stretches in which the speed is smooth.

        They are kept with the motion: laws that look ahead ask for them at every instant.
        """
        kept: dict[str, _Stretches] = vars(self.motion)
        if _KEPT not in kept:
            kept[_KEPT] = _stretches(self.motion)
        return kept[_KEPT]


_KEPT = "_stretches"
"""The name by which a motion keeps its stretches."""

_Stretches = tuple[MutableSequence[float], MutableSequence[float], float]
"""A table of pieces, the lengths before each, and the whole length (metres)."""


def _stretches(motion: Motion) -> _Stretches:
    table, before, gone = room(0), room(0), 0.0
    for piece in motion.pieces:
        for u, w in itertools.pairwise(_smooth_cuts(piece)):
            table.extend((piece.begin + u, piece.begin + w))
            table.extend((*shift(piece.x, u), *shift(piece.y, u)))
            before.append(gone)
            gone += length(table, len(before) - 1, w - u)
    return table, before, gone


def _smooth_cuts(piece: Piece) -> list[float]:
    """Return cuts of a piece (seconds from its begin) between which its speed is smooth.

    The velocity as a complex number x' + i y' is a quadratic in time; speed is its modulus, and
    analytic but at its roots and their conjugates.
    """
    duration = piece.end - piece.begin
    roots = _velocity_roots(piece, duration)
    turns = sorted(root.real for root in roots if 0.0 < root.real < duration)
    cuts = [0.0, *turns, duration]
    # At a real root the body stands: the modulus has a corner there, and is smooth on both sides.
    corners = [root for root in roots if abs(root.imag) > 1e-12]
    undecided = [*itertools.pairwise(cuts)][::-1]
    smooth = [0.0]
    while undecided:
        low, high = undecided.pop()
        middle, half = (low + high) / 2, (high - low) / 2
        if half < 1e-9 or all(_ellipse((root - middle) / half) > _ELLIPSE for root in corners):
            smooth.append(high)
        else:
            undecided += [(middle, high), (low, middle)]
    return smooth


def _velocity_roots(piece: Piece, duration: float) -> list[complex]:
    (_, x1, x2, x3), (_, y1, y2, y3) = piece.x, piece.y
    a, b, c = complex(3 * x3, 3 * y3), complex(2 * x2, 2 * y2), complex(x1, y1)
    if abs(a) * duration**2 > 1e-14 * (abs(b) * duration + abs(c)):
        # With the sign for which b and the root add up, nothing cancels in q; the roots are then
        # q / a and c / q (W. H. Press et al., "Numerical Recipes", 3rd edition 2007, 5.6).
        root = cmath.sqrt(b * b - 4 * a * c)
        q = -(b + (root if (b.conjugate() * root).real >= 0 else -root)) / 2
        return [q / a, c / q] if q else [0j]
    if abs(b) * duration > 1e-14 * abs(c):
        return [-c / b]
    return []


def _ellipse(z: complex) -> float:
    """Return the sum of the half axes of the ellipse with foci ±1 through `z`."""
    return abs(z + cmath.sqrt(z - 1) * cmath.sqrt(z + 1))


SURFACE_ROUNDING = 1e-12
"""Metres by which distances between surfaces may be off, so that ties may be none."""


class Bounds(NamedTuple):
    """Bounds throughout an interval: metres and m/s. At an instant, low equals high."""

    distance_low: float
    distance_high: float
    human_low: float
    human_high: float
    robot_low: float
    robot_high: float


class Encounter(EncounterBounds):
    """Time span in which the motions of a person and a machine are one cubic each.

    It gives custom conditions and laws bounds on distances and speeds. Distances are between
    centres on the floor, or between surfaces.

    Parameters
    ----------
    person, machine : Motion
        Motions.
    gauges : sequence of Gauge, optional
        Kernels that measure between surfaces: see `Shapes.gauges`.
    """

    def __init__(self, person: Motion, machine: Motion, gauges: Sequence[Gauge] = ()) -> None:
        super().__init__(
            person.table, machine.table, [*gauges], SURFACE_ROUNDING if gauges else 0.0
        )
        self._motions = person, machine

    @property
    def begin(self) -> float:
        """Begin of the time span in seconds."""
        return self.stretch()[0]

    @property
    def end(self) -> float:
        """End of the time span in seconds."""
        return self.stretch()[1]

    @cached_property
    def human(self) -> Odometer:
        """Path length and speed of the person's whole motion."""
        return Odometer(self._motions[0])

    @cached_property
    def robot(self) -> Odometer:
        """Path length and speed of the machine's whole motion."""
        return Odometer(self._motions[1])

    def odometers(self) -> tuple[Odometer, Odometer]:
        """Return `human` and `robot`."""
        return self.human, self.robot

    def distance(self, t: float) -> float:
        """Return the distance at `t` in metres, 0 if surfaces overlap."""
        return self.bounds_apart(t, t, 0.0, 0.0)[0]

    def closing(self, begin: float, end: float) -> tuple[float, float]:
        """Return bounds on the derivative of half the squared distance in m²/s.

        It is negative while the centres approach each other.
        """
        return self.bounds_closing(begin, end)

    def bounds(self, begin: float, end: float) -> Bounds:
        """Return bounds on distance and speeds from `begin` to `end`, within this time span."""
        return Bounds(*self.all_bounds(begin, end))

    def apart(
        self, begin: float, end: float, slope: float = 0.0, curve: float = 0.0
    ) -> tuple[float, float, float]:
        """Return bounds on distance − `slope` u − `curve` u² / 2, u from the interval's middle.

        Slope (m/s) and curve (m/s²) are derivatives of a required distance. The third value is a
        time near the minimum.
        """
        return self.bounds_apart(begin, end, slope, curve)

    def human_speed(self, begin: float, end: float) -> Enclosure:
        """Return the human's speed in m/s over an interval within this time span."""
        return enclosure_of(self.speed_of(False, begin, end))

    def robot_speed(self, begin: float, end: float) -> Enclosure:
        """Return the robot's speed in m/s over an interval within this time span."""
        return enclosure_of(self.speed_of(True, begin, end))
