"""Floorplans as immutable values.

Lengths are in metres, angles in radians, speeds in m/s. Heights are above the floor, and z points
up.
"""

import math
from collections.abc import Collection, Mapping
from dataclasses import field
from fnmatch import fnmatchcase
from functools import cached_property
from itertools import pairwise
from typing import Annotated, Any

import shapely
from pydantic import AfterValidator, model_validator
from shapely.geometry import Polygon
from typing_extensions import Self

from .files.dataclass import dataclass
from .files.fields import (
    Angle,
    ComposedKeys,
    Constrained,
    Flag,
    Number,
    Pair,
    Position,
    Positive,
    Range,
)
from .files.footprints import (
    Area,
    ArmBottom,
    ArmMount,
    ArmReach,
    Bottom,
    Footprint,
    High,
    Length,
    Low,
    Top,
    Torso,
    Width,
)
from .files.forms import ALIASED_KEYS, CALLED, KEYS, Alias, Written
from .files.problems import Problem, UserError
from .files.values import NamedField

DEFAULT_HEIGHT = 3.0
"""Metres. Height of obstacles from formats that have no heights."""

EVERYBODY = ("*",)
"""People and AGVs whom a zone concerns by default."""

Point = tuple[float, float]
"""Position on the floor: x, y in metres."""

Name = Annotated[str, Constrained(min_length=1)]
"""Text that is not empty."""

Called = Annotated[str, Alias(CALLED)]
"""Name of an entry, under which a file has its keys."""

Ends = Annotated[tuple[Pair, Pair], Alias("between")]
"""Ends (x, y) of a line in metres."""

Concerns = Annotated[
    tuple[str, ...],
    Written(Annotated[list[Name], Constrained(min_length=1)]),
    AfterValidator(tuple),
]
"""Names of people and AGVs, or patterns of names."""


def rectangle(centre: Point, direction: Point, length: float, width: float) -> Polygon:
    """Return a rectangle in any direction.

    Parameters
    ----------
    centre : Point
        Centre (x, y) in metres.
    direction : Point
        Unit vector along the rectangle.
    length, width : float
        Extent along `direction` and across it, in metres.

    Returns
    -------
    shapely.Polygon
        Rectangle with its corners counterclockwise.
    """
    (x, y), (c, s) = centre, direction
    corners = [
        (x + u * c - v * s, y + u * s + v * c)
        for u, v in (
            (-length / 2, -width / 2),
            (length / 2, -width / 2),
            (length / 2, width / 2),
            (-length / 2, width / 2),
        )
    ]
    return Polygon(corners)


def extent(shape: shapely.Geometry) -> str:
    """Return the size of a shape in words."""
    west, south, east, north = shape.bounds or (0, 0, 0, 0)
    return f"{east - west:.4g} x {north - south:.4g} m"


@dataclass(frozen=True, kw_only=True, repr=False)
class Obstacle(ComposedKeys):
    """Obstacle that stands on the floor or hangs above it.

    Parameters
    ----------
    name : str
        Unique name.
    footprint : shapely.Polygon
        Area on the floor in metres. It may have holes.
    bottom, top : float
        Heights above the floor in metres.
    """

    name: Called
    footprint: Footprint
    bottom: Bottom
    top: Top

    def __repr__(self) -> str:
        heights = f"from {self.bottom:g} to {self.top:g} m"
        return f"<Obstacle {self.name!r}: {extent(self.footprint)}, {heights}>"

    def overlaps(self, bottom: float, top: float) -> bool:
        """Return whether the obstacle has heights between `bottom` and `top` (metres)."""
        return self.bottom < top and bottom < self.top


@dataclass(frozen=True)
class Station:
    """Named place that people go to.

    Parameters
    ----------
    name : str
        Unique name.
    position : Point
        Position (x, y) in metres.
    """

    name: str
    position: Point


@dataclass(frozen=True, kw_only=True)
class Door:
    """Door between two points. A closed door is a wall.

    Parameters
    ----------
    name : str
        Unique name.
    ends : tuple of Point
        Both ends (x, y) in metres.
    is_open : bool, optional
        State of the door unless a trial sets it.
    thickness, height : float, optional
        Thickness of the closed door and its height in metres.
    """

    __pydantic_config__ = ALIASED_KEYS

    name: Called
    ends: Ends
    is_open: Annotated[Flag, Alias("open")] = True
    thickness: Positive = 0.1
    height: Positive = DEFAULT_HEIGHT

    @property
    def footprint(self) -> Polygon:
        """Rectangle of the closed door."""
        (ax, ay), (bx, by) = self.ends
        width = math.dist(*self.ends)
        direction = ((bx - ax) / width, (by - ay) / width)
        return rectangle(((ax + bx) / 2, (ay + by) / 2), direction, width, self.thickness)

    @property
    def closed(self) -> Obstacle:
        """Obstacle of the closed door."""
        return Obstacle(name=self.name, footprint=self.footprint, bottom=0.0, top=self.height)


ALONG = 0.2
"""Sine of the angle (11.5°) within which a side of a one-way zone runs along its direction."""


@dataclass(frozen=True, kw_only=True, repr=False)
class Zone(ComposedKeys):
    """Area with a rule for some people and AGVs.

    Parameters
    ----------
    name : str
        Unique name.
    area : shapely.Polygon
        Area on the floor in metres.
    max_speed : float, optional
        Speed limit in m/s.
    forbidden : bool, optional
        True if those concerned must not enter.
    concerns : tuple of str, optional
        Names of people and AGVs, or patterns with `*` and `?`. By default all.
    one_way : Point, optional
        Direction (x, y). People enter over the side that faces against it, and leave over the
        opposite side.
    """

    name: Called
    area: Area
    max_speed: Positive | None = None
    forbidden: Flag = False
    concerns: Concerns = EVERYBODY
    one_way: Pair | None = None

    @model_validator(mode="after")
    def _one_rule(self) -> Self:
        if fault := self.rule_fault:
            raise UserError(fault)
        return self

    @property
    def rule_fault(self) -> str:
        """Reason why the zone has no rule, or contradictory ones, or an empty text."""
        if self.forbidden != (self.max_speed is not None or self.one_way is not None):
            return ""
        return "give forbidden: true, or max_speed (m/s) and one_way (x, y)"

    def __repr__(self) -> str:
        rule = ["forbidden"] if self.forbidden else []
        rule += [f"at most {self.max_speed:g} m/s"] if self.max_speed is not None else []
        rule += ["one-way"] if self.one_way is not None else []
        return f"<Zone {self.name!r}: {', '.join([extent(self.area), *rule])}>"

    def is_about(self, name: str) -> bool:
        """Return whether the rule concerns the person or AGV called `name`."""
        return _is_one_of(name, self.concerns)

    @property
    def gates(self) -> "tuple[Gate, ...]":
        """Sides of a one-way zone across its direction, as gates."""
        if self.one_way is None or not any(self.one_way):
            return ()
        ring = shapely.orient_polygons(self.area).exterior.coords
        c, s = (part / math.hypot(*self.one_way) for part in self.one_way)
        gates = []
        for (ax, ay), (bx, by) in pairwise(at[:2] for at in ring):
            width = math.dist((ax, ay), (bx, by))
            # The ring is counterclockwise, so (dy, -dx) of a side points outwards. People leave the
            # zone where that is along the direction, and enter where it is against it.
            outwards = (by - ay) * c - (bx - ax) * s
            if abs(outwards) > ALONG * width:
                towards = ((ax + bx) / 2 + c, (ay + by) / 2 + s)
                name = f"{self.name} ({'exit' if outwards > 0 else 'entry'})"
                gates.append(
                    Gate(
                        name=name,
                        ends=((ax, ay), (bx, by)),
                        towards=towards,
                        concerns=self.concerns,
                    )
                )
        return tuple(gates)


@dataclass(frozen=True, kw_only=True)
class Gate:
    """Line from wall to wall that people cross in one direction only.

    Parameters
    ----------
    name : str
        Unique name.
    ends : tuple of Point
        Both ends (x, y) in metres.
    towards : Point
        Point (x, y) on the side to which people may cross, in metres.
    concerns : tuple of str, optional
        Names of people and AGVs, or patterns with `*` and `?`. By default all.
    """

    __pydantic_config__ = ALIASED_KEYS

    name: Called
    ends: Ends
    towards: Position
    concerns: Concerns = EVERYBODY

    def is_about(self, name: str) -> bool:
        """Return whether the gate concerns the person or AGV called `name`."""
        return _is_one_of(name, self.concerns)

    @property
    def normal(self) -> Point:
        """Unit normal of the line that points to the side of `towards`."""
        (ax, ay), (bx, by) = self.ends
        width = math.dist(*self.ends)
        x, y = (ay - by) / width, (bx - ax) / width
        ahead = (self.towards[0] - ax) * x + (self.towards[1] - ay) * y
        return (x, y) if ahead > 0 else (-x, -y)


def _is_one_of(name: str, patterns: tuple[str, ...]) -> bool:
    return any(fnmatchcase(name, pattern) for pattern in patterns)


@dataclass(frozen=True)
class SafeZone:
    """Start of people, and their position after a violation.

    Parameters
    ----------
    position : Point
        Position (x, y) in metres.
    heading : float, optional
        Heading in radians.
    """

    __pydantic_config__ = ALIASED_KEYS

    position: Annotated[Position, Alias("at")]
    heading: Angle = 0.0


@dataclass(frozen=True, kw_only=True)
class Human:
    """Measures of the people on a floor, unless a trial sets others.

    Parameters
    ----------
    radius, height : float, optional
        Radius and height of a person in metres.
    max_speed, max_acceleration : float, optional
        Limits in m/s and m/s².
    goal_tolerance : float, optional
        Distance in metres at which a person has reached a goal.
    """

    __pydantic_config__ = KEYS

    radius: Positive = 0.3
    height: Positive = 1.75
    max_speed: Positive = 1.0
    max_acceleration: Positive = 2.5
    goal_tolerance: Positive = 0.25


OF_ONE_LANE: dict[str, Any] = {"origin": ..., "heading": 0.0, "serves": {}}
"""Keys of a lane that AGVs do not share, with their defaults."""


@dataclass(frozen=True, kw_only=True, repr=False)
class Lane(ComposedKeys):
    """Straight lane of an AGV.

    Parameters
    ----------
    name : str
        Name of the AGV.
    origin : Point
        Centre of the AGV (x, y) at lane position 0, in metres.
    heading : float
        Direction of the lane in radians.
    limits : tuple of float
        Range of lane positions in metres.
    locations : mapping of str to float
        Lane positions by name, in metres.
    start : str
        Location at the start of a trial.
    length, width, height : float
        Size of the AGV in metres. The length is along the lane.
    max_speed, max_acceleration : float
        Limits in m/s and m/s².
    serves : mapping of str to str, optional
        Locations by the names that orders use.
    """

    name: Called
    origin: Position
    heading: Angle
    limits: Range
    locations: Annotated[Mapping[str, float], Written(dict[str, Number])]
    start: str
    length: Length
    width: Width
    height: Positive
    max_speed: Positive
    max_acceleration: Positive
    serves: Annotated[Mapping[str, str], Written(dict[str, str])] = field(default_factory=dict)

    def __repr__(self) -> str:
        low, high = self.limits
        return f"<Lane {self.name!r} from {low:g} to {high:g} m: {', '.join(self.locations)}>"

    @cached_property
    def direction(self) -> Point:
        """Unit vector along the lane. It is exact if the lane is parallel to an axis."""
        return (round(math.cos(self.heading), 15), round(math.sin(self.heading), 15))

    def position(self, q: float) -> Point:
        """Return the centre of the AGV (x, y) at lane position `q`, in metres."""
        (x, y), (c, s) = self.origin, self.direction
        return (x + q * c, y + q * s)

    def along(self, at: Point) -> float:
        """Return the position along the line of the lane of the nearest point to `at`, in metres.

        Parameters
        ----------
        at : Point
            Point in metres.
        """
        (x, y), (c, s) = self.origin, self.direction
        return (at[0] - x) * c + (at[1] - y) * s

    def lane_position(self, to: str | float) -> float:
        """Return a lane position in metres.

        Parameters
        ----------
        to : str or float
            Location, a name that it serves, or a lane position in metres.

        Returns
        -------
        float
            Lane position in metres.

        Raises
        ------
        UserError
            If there is no such location, or if the position is outside the limits.
        """
        if isinstance(to, str):
            location = self.serves.get(to, to)
            if location not in self.locations:
                names = ", ".join([*self.locations, *self.serves])
                raise UserError(f"{self.name} has no location {to!r} (there are: {names})")
            return self.locations[location]
        low, high = self.limits
        if not low <= to <= high:
            raise UserError(
                f"{self.name} can't be at {to:g} m: its lane runs from {low:g} to {high:g}"
            )
        return to

    def footprint(self, q: float) -> Polygon:
        """Return the rectangle of the AGV at lane position `q` (metres)."""
        cached: tuple[float, Polygon] | None = vars(self).get("_footprint")  # usually repeated
        if cached is None or cached[0] != q:
            cached = q, rectangle(self.position(q), self.direction, self.length, self.width)
            vars(self)["_footprint"] = cached
        return cached[1]


ROUNDING = 1e-9
"""Metres or radians. Tolerance of limits."""


@dataclass(frozen=True, kw_only=True)
class Axis(ComposedKeys):
    """Axis of the gantry: its range and its limits.

    Parameters
    ----------
    low, high : float
        Range in metres, or in radians for the rotation.
    max_speed, max_acceleration, max_jerk : float
        Limits in m/s, m/s² and m/s³, or in radians.
    """

    low: Low
    high: High
    max_speed: Positive
    max_acceleration: Positive
    max_jerk: Positive = 2.0

    def reaches(self, value: float) -> bool:
        """Return whether `value` is within the range, apart from rounding."""
        return self.low - ROUNDING <= value <= self.high + ROUNDING


FULL_TURNS = Axis(low=-math.tau, high=math.tau, max_speed=math.pi / 4, max_acceleration=0.5)
"""Rotation of a gantry by default."""


@dataclass(frozen=True, kw_only=True, repr=False)
class Gantry(ComposedKeys):
    """Overhead robot: a bridge (x), a trolley (y) and a torso that rotates about z.

    Parameters
    ----------
    x, y, rotation : Axis
        Axes.
    start : tuple of float
        Initial x and y in metres, and rotation in radians.
    torso : tuple of float
        Box around the axis: length, width, bottom and top in metres.
    arm_mount : tuple of float
        Distance of the shoulder from the axis, and its height, in metres.
    arm_reach, arm_bottom : float
        Radius around the axis and lower end of the folded arm, in metres.
    rail_height, tray_height : float
        Heights of the rails and of a carried tray in metres. They do not affect results.
    """

    x: Axis
    y: Axis
    rotation: Axis = FULL_TURNS
    start: tuple[Number, Number, Number]
    torso: Torso
    arm_mount: ArmMount
    arm_reach: ArmReach
    arm_bottom: ArmBottom
    rail_height: Positive
    tray_height: Positive

    def __repr__(self) -> str:
        x, y = self.x, self.y
        return f"<Gantry over x = {x.low:g} … {x.high:g} m, y = {y.low:g} … {y.high:g} m>"

    def faults(self, target: tuple[float, float, float]) -> list[str]:
        """Return a message for each of x, y and rotation of `target` that is out of range."""
        x, y, rotation = target
        if self.x.reaches(x) and self.y.reaches(y) and self.rotation.reaches(rotation):
            return []
        return [
            f"{name} = {value:g} is outside the gantry's range {axis.low:g} … {axis.high:g}"
            for name, axis, value in zip(("x", "y", "rotation"), self.axes, target, strict=True)
            if not axis.reaches(value)
        ]

    @property
    def axes(self) -> tuple[Axis, Axis, Axis]:
        """Axes x, y and rotation."""
        return (self.x, self.y, self.rotation)


LEFT_OUT_IF_EMPTY = ("doors", "zones", "gates")
"""Fields of a floor that recordings omit if they are empty."""


@dataclass(frozen=True, kw_only=True)
class Floor:
    """Data of a floor: see `Floorplan`, which adds the formats of files."""

    name: str
    boundary: Polygon
    obstacles: NamedField[Obstacle] = NamedField()
    stations: NamedField[Station] = NamedField()
    patrol: tuple[str, ...] | None = None
    safe_zone: SafeZone | None = None
    human: Human = Human()
    lanes: NamedField[Lane] = NamedField()
    gantry: Gantry | None = None
    doors: NamedField[Door] = NamedField()
    zones: NamedField[Zone] = NamedField()
    gates: NamedField[Gate] = NamedField()
    title: str = ""
    source: str = ""
    notices: tuple[Problem, ...] = field(default=(), compare=False)

    @cached_property
    def middles(self) -> dict[str, Point]:
        """Centroids of obstacles by name (x, y in metres)."""
        centroids = ((one.name, one.footprint.centroid) for one in self.obstacles)
        return {name: (middle.x, middle.y) for name, middle in centroids}

    @cached_property
    def one_ways(self) -> tuple[Gate, ...]:
        """All gates, and the ends of one-way zones."""
        return (*self.gates, *(gate for zone in self.zones for gate in zone.gates))

    @classmethod
    def of_area(cls, name: str, source: str, area: Polygon) -> Self:
        """Return the floor bounded by `area` (metres), with its holes as obstacles."""
        holes = [Polygon(ring) for ring in area.interiors]
        return cls(
            name=name,
            source=source,
            boundary=Polygon(area.exterior),
            obstacles=[
                Obstacle(name=f"obstacle{k}", footprint=hole, bottom=0.0, top=DEFAULT_HEIGHT)
                for k, hole in enumerate(holes, start=1)
            ],
        )

    def __repr__(self) -> str:
        parts = [extent(self.boundary), f"{len(self.obstacles)} obstacles"]
        parts += [f"{len(self.stations)} stations", f"{len(self.lanes)} lanes"]
        parts += ["a gantry"] if self.gantry is not None else []
        return f"<{type(self).__name__} {self.name!r}: {', '.join(parts)}>"

    @property
    def patrolled(self) -> tuple[Station, ...]:
        """Return the stations of the patrol in its order. `KeyError` for an unknown name."""
        if self.patrol is None:
            return self.stations
        return tuple(self.station(name) for name in self.patrol)

    def station(self, name: str) -> Station:
        """Return the station called `name`, like `stations[name]`."""
        return self.stations[name]

    def lane(self, name: str) -> Lane:
        """Return the lane of the AGV called `name`, like `lanes[name]`."""
        return self.lanes[name]

    def obstacle(self, name: str) -> Obstacle:
        """Return the obstacle called `name`, like `obstacles[name]`."""
        return self.obstacles[name]

    def free(self, bottom: float, top: float) -> Polygon:
        """Return the free area at some heights.

        Parameters
        ----------
        bottom, top : float
            Range of heights in metres.

        Returns
        -------
        shapely.Geometry
            Boundary without the obstacles in this range.
        """
        return free_area(self.boundary, self.blocked(bottom, top))

    def blocked(self, bottom: float, top: float) -> list[Polygon]:
        """Return the footprints of obstacles with heights between `bottom` and `top` (metres)."""
        return [o.footprint for o in self.obstacles if o.overlaps(bottom, top)]


def free_area(boundary: Polygon, blocked: Collection[Polygon]) -> Polygon:
    """Return the part of `boundary` outside the footprints `blocked`."""
    return boundary.difference(shapely.union_all(blocked))
