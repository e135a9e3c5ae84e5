"""Distances between surfaces: people and machines as upright solids.

All solids here stand upright: a footprint between a bottom and a top. Their distance is √(p² + z²)
with p the distance of the footprints in the plane and z the gap between the heights. A footprint is
a disc or a rectangle that turns with the machine, whose point nearest to the person's axis is known
in closed form; p is less by the person's radius.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from floorplan import Gantry, Lane

from .kernels.gauge import Gauge

PERSON_RADIUS = 0.30
"""Metres. A person's radius where nothing else is said."""

PERSON_HEIGHT = 1.75
"""Metres. A person's height where nothing else is said."""


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

    def is_level_with(self, other: Box) -> bool:
        """Return whether their heights overlap: neither is above the other."""
        return self.bottom < other.top and other.bottom < self.top

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

    A person has no front: the cylinder stands around the person's position.
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

    @property
    def gauges(self) -> tuple[Gauge, ...]:
        """What measures between the person and each part of the machine."""
        return tuple(_gauge(self.person, part) for part in self.machine)


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


def _gauge(person: Cylinder, part: Cylinder | Box) -> Gauge:
    height = max(part.bottom - person.top, person.bottom - part.top, 0.0)
    if isinstance(part, Cylinder):
        return Gauge(person.radius, height, 0.0, 0.0, part.radius)
    return Gauge(person.radius, height, part.length / 2, part.width / 2, 0.0)
